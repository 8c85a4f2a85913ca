//! How tiles draw.

/// The accuracy of tiles, and how they model rays.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TileModel {
    /// The most that bundles may miss their rays by.
    pub(crate) accuracy_px: f32,
    /// True if every pixel has its own ray, and bundles are used to find candidates only.
    pub(crate) by_rays: bool,
    /// Normal maps turn rays, and pixels that show such surfaces have their own.
    pub(crate) turns_normals: bool,
}
