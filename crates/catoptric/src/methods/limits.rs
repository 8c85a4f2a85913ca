//! Errors that methods must not exceed on built-in scenes; `tests/registry/matrix.rs` draws the pictures.

/// The limits of a method.
#[derive(Clone, Copy, Debug)]
pub struct ErrorLimits {
    /// Settings of the pictures, lines of TOML: as coarse as a small picture allows.
    pub settings: &'static str,
    /// One for each built-in scene.
    pub scenes: &'static [SceneLimits],
}

/// The limits on one built-in scene.
#[derive(Clone, Copy, Debug)]
pub struct SceneLimits {
    /// Name of the scene.
    pub scene: &'static str,
    /// At orders 1 and 2.
    pub orders: [ErrorLimit; 2],
}

/// The limit of one picture, over the pixels that show reflectors and lenses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ErrorLimit {
    /// The largest errors against the reference.
    Below {
        /// Share of pixels with an sRGB channel off by more than 0.1.
        over_0_1: f64,
        /// Mean FLIP.
        flip: f64,
    },
    /// The picture is not drawn.
    Skipped {
        /// The obstacle.
        reason: &'static str,
    },
}

/// The limits on a built-in scene at orders 1 and 2.
pub(crate) const fn scene(scene: &'static str, orders: [ErrorLimit; 2]) -> SceneLimits {
    SceneLimits { scene, orders }
}

/// The largest errors of a picture.
pub(crate) const fn below(over_0_1: f64, flip: f64) -> ErrorLimit {
    ErrorLimit::Below { over_0_1, flip }
}

/// A picture that is not drawn.
pub(crate) const fn skipped(reason: &'static str) -> ErrorLimit {
    ErrorLimit::Skipped { reason }
}
