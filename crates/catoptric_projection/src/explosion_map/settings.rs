//! The settings of explosion maps.

use crate::draw::work_limit::{BeyondWork, WORK_A_PIXEL, WORK_ALONE, WorkLimit};
use crate::find::virtual_objects::Recursion;
use crate::virtual_object_method::LONGEST_EDGE;
use catoptric_engine::method::{declare_choices, declare_settings};

declare_choices! {
    /// The way in which a point's place on the reflector is found.
    pub enum Variant {
        /// The paper's approximation: by the id buffers of spheres.
        Map = "map",
        /// The paper's exact one: the cell of reflected rays that holds the point, by walking from the map's answer.
        Subdivision = "subdivision",
    }
}

declare_choices! {
    /// The place of a virtual vertex, given its foot on the reflector.
    pub enum VirtualVertex {
        /// On the view ray through the foot, after one step of Newton's method with the curvature of the mesh.
        Corrected = "corrected",
        /// The paper's: the mirror image in the tangent plane at the foot; between two spheres the blend of both
        /// spheres' images.
        Mirrored = "mirrored",
    }
}

declare_choices! {
    /// A set of values that the other settings start from.
    pub enum Preset {
        /// The reflection subdivision.
        Balanced = "balanced",
        /// Maps of four spheres, corrected.
        Fast = "fast",
        /// As in the paper: maps of two spheres, virtual vertices mirrored in the tangent plane.
        Faithful = "faithful",
        /// As balanced, and every vertex made exact by the solver.
        Exact = "exact",
    }
}

declare_settings! {
    /// Settings of explosion maps.
    pub struct ExplosionMapSettings of "explosion_map" {
        /// The set of values that the other settings start from.
        preset: Preset = Preset::Balanced;
        /// The way in which a point's place on the reflector is found.
        variant: Variant = Variant::Subdivision;
        /// The place of a virtual vertex, given its foot on the reflector.
        virtual_vertex: VirtualVertex = VirtualVertex::Corrected;
        /// Side of the id buffers.
        map_size: u32 = 200, range(4.0, 4096.0), unit("texels");
        /// Spheres about a reflector; 2 are the paper's, with more the reflector itself is one more. Points between two
        /// of them blend the answers of both.
        spheres: u32 = 4, range(2.0, 16.0);
        /// Edges of reflectors longer than this share of their radius are halved.
        longest_edge: f32 = LONGEST_EDGE, range(0.01, 10.0);
        /// The most steps of the solver that makes appearances exact; 0: none.
        polish: u32 = 0, range(0.0, 100.0);
        /// Edges of virtual geometry are divided until they are this near to where they belong.
        edge_error_px: f32 = 0.25, range(0.01, 100.0), unit("pixels");
        /// Pieces that appear in part are divided down to this size.
        piece_px: f32 = 1.0, range(0.1, 100.0), unit("pixels");
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

impl ExplosionMapSettings {
    /// The limit of a frame's work.
    pub(super) fn work_limit(&self) -> WorkLimit {
        WorkLimit { a_pixel: self.work, beyond: self.beyond_work }
    }

    /// The point of a bounce that is an object for the bounce before.
    pub(super) fn recursion(&self) -> Recursion {
        match self.virtual_vertex {
            // The solver starts at reflection points that obey the law as well as the mesh does.
            VirtualVertex::Mirrored if self.polish == 0 => Recursion::VirtualPoints,
            _ => Recursion::ReflectionPoints,
        }
    }

    /// The settings of a preset.
    pub fn preset(preset: Preset) -> Self {
        let balanced = Self { preset, ..Self::default() };
        match preset {
            Preset::Balanced => balanced,
            Preset::Fast => Self { variant: Variant::Map, edge_error_px: 1.0, piece_px: 3.0, ..balanced },
            Preset::Faithful => Self {
                variant: Variant::Map,
                virtual_vertex: VirtualVertex::Mirrored,
                spheres: 2,
                edge_error_px: 1.0,
                piece_px: 3.0,
                work: WORK_ALONE,
                beyond_work: BeyondWork::Coarse,
                ..balanced
            },
            Preset::Exact => Self { polish: 8, ..balanced },
        }
    }
}
