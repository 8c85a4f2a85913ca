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

/// The largest errors of one picture against the reference, over the pixels that show reflectors and lenses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorLimit {
    /// Share of pixels with an sRGB channel off by more than 0.1.
    pub over_0_1: f64,
    /// Mean FLIP.
    pub flip: f64,
}

/// The limits on a built-in scene at orders 1 and 2.
pub const fn scene(scene: &'static str, orders: [ErrorLimit; 2]) -> SceneLimits {
    SceneLimits { scene, orders }
}

/// The largest errors of a picture.
pub const fn below(over_0_1: f64, flip: f64) -> ErrorLimit {
    ErrorLimit { over_0_1, flip }
}
