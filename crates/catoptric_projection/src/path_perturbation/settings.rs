//! The perturbation method's settings.

use crate::draw::work_limit::{BeyondWork, WORK_A_PIXEL, WORK_ALONE, WorkLimit};
use crate::find::ray_map::Approximation;
use catoptric_engine::method::{declare_choices, declare_settings};

declare_choices! {
    /// The part of the Taylor expansion that is used.
    pub enum ExpansionOrder {
        /// As much as the estimated remainder needs.
        Auto = "auto",
        /// None: the nearest sample as it is.
        Nearest = "nearest",
        /// The path Jacobian.
        Linear = "linear",
        /// The path Jacobian and Hessian.
        Quadratic = "quadratic",
    }
}

impl ExpansionOrder {
    /// The order if it is forced.
    pub(super) fn forced(self) -> Option<Approximation> {
        match self {
            Self::Auto => None,
            Self::Nearest => Some(Approximation::Nearest),
            Self::Linear => Some(Approximation::Linear),
            Self::Quadratic => Some(Approximation::Quadratic),
        }
    }
}

declare_choices! {
    /// The sample rays that are tried for a point.
    pub enum Candidates {
        /// The rays whose expansions reach the point and that lead to different places in the picture.
        InReach = "in_reach",
        /// The paper's: of the five nearest rays, one for each group by direction and reflection point.
        Nearest = "nearest",
    }
}

declare_choices! {
    /// A set of values that the other settings start from.
    pub enum Preset {
        /// Samples in reach, paths made exact by the solver.
        Balanced = "balanced",
        /// As in the paper: a sample every 16 pixels, the nearest rays, expanded to second order however far that
        /// leads.
        Faithful = "faithful",
    }
}

/// Distance of the paper's samples (section IV: 40 x 30 of them for 640 x 480).
const FAITHFUL_SPACING_PX: f32 = 16.0;

declare_settings! {
    /// Settings of the perturbation method.
    pub struct PathPerturbationSettings of "path_perturbation" {
        /// The set of values that the other settings start from.
        preset: Preset = Preset::Balanced;
        /// Spacing of the sample rays.
        spacing_px: f32 = 8.0, range(1.0, 256.0), unit("pixels");
        /// Where neighbouring rays disagree, they are sampled down to this spacing; `spacing_px` for a regular grid,
        /// which is the most that is allowed.
        finest_px: f32 = 2.0, range(0.25, 256.0), unit("pixels");
        /// Neighbouring rays disagree if they predict each other with a larger error than this.
        accuracy_px: f32 = 0.5, range(1e-3, 1e3), unit("pixels");
        /// The most sample rays of a view.
        max_samples: u32 = 60_000, range(1.0, 4e6);
        /// The part of the Taylor expansion that is used.
        expansion: ExpansionOrder = ExpansionOrder::Auto;
        /// The sample rays that are tried for a point.
        candidates: Candidates = Candidates::InReach;
        /// Without `polish`: expansions are drawn however far they lead, as the paper's are; else those are left out
        /// whose next order is as large as their reach, or whose place shows another part of the surface.
        any_reach: bool = false;
        /// The most steps of the solver on the specular constraint after the expansion; 0: none, the paper's method.
        polish: u32 = 40, range(0.0, 100.0);
        /// Edges of virtual geometry are divided until they are this near to where they belong; without `polish` at
        /// least 1.
        edge_error_px: f32 = 0.25, range(0.01, 100.0), unit("pixels");
        /// Pieces that appear in part are divided down to this size; without `polish` at least 3.
        piece_px: f32 = 0.75, range(0.1, 100.0), unit("pixels");
        /// Work that finding a picture's virtual points may take, in units of about 100 ns of one core, for every pixel
        /// of 720 x 480 or more.
        work: f32 = WORK_A_PIXEL, range(0.0, 1e6);
        /// The way to draw paths that are not done with that work.
        beyond_work: BeyondWork = BeyondWork::Tiles;
        /// Objects so far from a reflector that a look-up by the direction alone misplaces them by at most this are
        /// drawn from an environment map about its centre; 0: none.
        far_px: f32 = 0.0, range(0.0, 1000.0), unit("pixels");
        /// Side of a face of these maps.
        far_size: u32 = 512, range(4.0, 4096.0), unit("texels");
    }

    fn start(&self) -> Self {
        Self::preset(self.preset)
    }

    fn check_rules(&self) -> Result<(), String> {
        match self.finest_px > self.spacing_px {
            true => Err(format!("finest_px = {} is larger than spacing_px = {}", self.finest_px, self.spacing_px)),
            false => Ok(()),
        }
    }
}

impl PathPerturbationSettings {
    /// The limit of a frame's work.
    pub(super) fn work_limit(&self) -> WorkLimit {
        WorkLimit { a_pixel: self.work, beyond: self.beyond_work }
    }

    /// True if expansions are drawn however far they lead: what the solver finds from them is where it is.
    pub(super) fn draws_any_reach(&self) -> bool {
        self.any_reach && self.polish == 0
    }

    /// The settings of a preset.
    pub fn preset(preset: Preset) -> Self {
        let balanced = Self { preset, ..Self::default() };
        match preset {
            Preset::Balanced => balanced,
            Preset::Faithful => Self {
                spacing_px: FAITHFUL_SPACING_PX,
                finest_px: FAITHFUL_SPACING_PX,
                expansion: ExpansionOrder::Quadratic,
                candidates: Candidates::Nearest,
                any_reach: true,
                polish: 0,
                work: WORK_ALONE,
                beyond_work: BeyondWork::Coarse,
                ..balanced
            },
        }
    }
}
