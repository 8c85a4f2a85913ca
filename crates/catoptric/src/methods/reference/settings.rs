//! The reference's settings.

use catoptric_engine::light::path_tracer::PathModel;
use catoptric_engine::method::{declare_choices, declare_settings};

declare_choices! {
    /// The paths that are followed at refracting surfaces.
    pub enum Paths {
        /// Both children at every surface.
        Tree = "tree",
        /// Both children at the first surface, then the one with the larger Fresnel coefficient (Hakura, Snyder 2001,
        /// section 3).
        TwoPath = "two_path",
    }
}

impl From<Paths> for PathModel {
    fn from(paths: Paths) -> Self {
        match paths {
            Paths::Tree => Self::Tree,
            Paths::TwoPath => Self::TwoPath,
        }
    }
}

declare_choices! {
    /// The places of the samples in a pixel.
    pub enum SamplePlacement {
        /// The rasteriser's for 1, 2, 4, 8 and 16 samples, so that edges are antialiased alike; else as `random`.
        Pattern = "pattern",
        /// Jittered in the cells of a grid, differently in every pixel.
        Random = "random",
    }
}

declare_settings! {
    /// Settings of the reference.
    pub struct ReferenceSettings of "reference" {
        /// The paths that are followed at refracting surfaces.
        paths: Paths = Paths::Tree;
        /// The places of the samples in a pixel.
        samples: SamplePlacement = SamplePlacement::Pattern;
        /// Rays that leave a rough mirror where a path first meets one.
        rough_rays: u32 = 16, range(1.0, 4096.0);
        /// Seed of the jitter, and of rays that leave rough mirrors.
        seed: u64 = 0;
        /// Reports the tests of rays against triangles and surfaces, which takes longer.
        count_tests: bool = false;
    }
}
