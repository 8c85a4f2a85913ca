//! Where paths split and end, and how they leave rough mirrors.

/// Paths that carry less than this share of the light are ended. Chosen far below a step of eight bits, not measured.
pub const MIN_THROUGHPUT: f32 = 1e-5;

/// Surfaces that a path passes straight on, at most.
pub(super) const MOST_PASSAGES: u8 = 64;

/// A lobe that can add no more than this share of the light before it is not followed: half a step of eight bits at
/// half of the brightest.
pub(super) const LEAST_SHARE: f32 = 1.0 / 1024.0;

/// Paths at refracting surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PathModel {
    /// Both children at every surface.
    #[default]
    Tree,
    /// Both children at the first, then the one with the larger Fresnel coefficient (Hakura, Snyder 2001, section 3).
    TwoPath,
}

/// How rough mirrors are sampled.
#[derive(Clone, Copy, Debug)]
pub(super) struct RoughRays {
    /// Rays where a path first meets a rough mirror; further ones get one each.
    pub(super) count: u32,
    /// The seed of the numbers that choose them.
    pub(super) seed: u64,
    /// The share of a pixel's side that a path stands for.
    pub(super) footprint_scale: f32,
    /// Which of so many paths of a pixel is followed.
    pub(super) part: u32,
    pub(super) parts: u32,
}

impl Default for RoughRays {
    fn default() -> Self {
        Self { count: 16, seed: 0, footprint_scale: 1.0, part: 0, parts: 1 }
    }
}
