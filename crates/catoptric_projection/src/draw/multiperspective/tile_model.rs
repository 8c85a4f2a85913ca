//! How tiles draw.

/// How tiles draw.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TileModel {
    /// The most that bundles may miss their rays by.
    pub(crate) accuracy_px: f32,
    /// Every pixel has its own ray: bundles tell candidates alone.
    pub(crate) by_rays: bool,
    /// Normal maps turn rays, and pixels that show such surfaces have their own.
    pub(crate) turns_normals: bool,
}
