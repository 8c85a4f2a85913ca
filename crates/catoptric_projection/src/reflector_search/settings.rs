//! The settings of the search in pictures of reflectors.

use crate::draw::work_limit::{BeyondWork, WORK_A_PIXEL, WORK_ALONE, WorkLimit};
use catoptric_engine::method::{declare_choices, declare_settings};

declare_choices! {
    /// The pictures of a reflector that are searched.
    pub enum Images {
        /// The paper's: one from the eye, made anew for every view; after the first bounce as `cube`.
        Eye = "eye",
        /// Cube maps around the reflector, made once.
        Cube = "cube",
    }
}

declare_choices! {
    /// The way in which a picture is searched.
    pub enum Search {
        /// Newton's method from cell to cell of four texels, to where normal and half vector agree.
        Cells = "cells",
        /// The paper's: uphill to where the product of normal and half vector is greatest, with smaller and smaller
        /// strides.
        Maximum = "maximum",
    }
}

declare_choices! {
    /// The place of a virtual vertex, given a found reflection point.
    pub enum Refine {
        /// On the view ray through the point, after one step of Newton's method with the curvature of the mesh.
        Corrected = "corrected",
        /// The paper's: mirrored in the tangent plane there.
        Texel = "texel",
    }
}

declare_choices! {
    /// A set of values that the other settings start from.
    pub enum Preset {
        /// Cells, and virtual vertices corrected by the curvature of the mesh.
        Balanced = "balanced",
        /// As in the paper: one picture from the eye, the greatest product of normal and half vector in it, and virtual
        /// vertices mirrored in the tangent plane there.
        Faithful = "faithful",
    }
}

declare_settings! {
    /// Settings of the search in pictures of reflectors.
    pub struct ReflectorSearchSettings of "reflector_search" {
        /// The set of values that the other settings start from.
        preset: Preset = Preset::Balanced;
        /// The pictures of a reflector that are searched.
        images: Images = Images::Eye;
        /// The way in which they are searched.
        search: Search = Search::Cells;
        /// The place of a virtual vertex, given a found reflection point.
        refine: Refine = Refine::Corrected;
        /// The longer side of a picture; a side of a cube map has half as many.
        map_size: u32 = 400, range(16.0, 4096.0), unit("texels");
        /// The most steps of the solver that makes appearances exact; 0: none.
        polish: u32 = 0, range(0.0, 100.0);
        /// Edges of virtual geometry are divided until they are this near to where they belong.
        edge_error_px: f32 = 0.5, range(0.01, 100.0), unit("pixels");
        /// Pieces that appear in part are divided down to this size.
        piece_px: f32 = 3.0, range(0.1, 100.0), unit("pixels");
        /// Work that finding a picture's virtual points may take, in units of about 100 ns of one core, for every pixel
        /// of 720 x 480 or more.
        work: f32 = WORK_A_PIXEL, range(0.0, 1e6);
        /// The way to draw paths that are not done with that work.
        beyond_work: BeyondWork = BeyondWork::Tiles;
    }

    fn start(&self) -> Self {
        Self::preset(self.preset)
    }
}

impl ReflectorSearchSettings {
    /// The limit of a frame's work.
    pub(super) fn work_limit(&self) -> WorkLimit {
        WorkLimit { a_pixel: self.work, beyond: self.beyond_work }
    }

    /// The settings of a preset.
    pub fn preset(preset: Preset) -> Self {
        let balanced = Self { preset, ..Self::default() };
        match preset {
            Preset::Balanced => balanced,
            Preset::Faithful => Self {
                search: Search::Maximum,
                refine: Refine::Texel,
                work: WORK_ALONE,
                beyond_work: BeyondWork::Coarse,
                ..balanced
            },
        }
    }
}
