//! Counts and times of the drawing of a picture.

/// The rasteriser's counts and times.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RasterReport {
    /// Triangles in all lists.
    pub triangles: u64,
    /// Triangles that were cut at the near plane or at the guard band.
    pub clipped: u64,
    /// Pairs of a triangle (or a piece of a clipped one) and a tile that it may touch.
    pub binned: u64,
    /// Fragments that were shaded.
    pub fragments: u64,
    /// Time for setting up and sorting triangles and for finding what samples show; 0 where there is no clock, like
    /// the others. Tiles are drawn side by side, each in all three stages: of their time together each stage has the
    /// share that it has of the threads' time.
    pub raster_ms: f64,
    /// Time for the colours of fragments.
    pub shade_ms: f64,
    /// Time for finding the fragments of pixels from their samples, and for adding them up.
    pub resolve_ms: f64,
}
