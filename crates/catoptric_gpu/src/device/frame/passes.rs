//! Passes that compute, and the bands of a picture that they work on.

/// Pixels along a side of a workgroup that shades, and cells of one that gathers.
pub(crate) const WORKGROUP: u32 = 8;

/// Begins a pass whose time may be taken.
pub(crate) fn begin<'a>(
    encoder: &'a mut wgpu::CommandEncoder,
    timestamp_writes: Option<wgpu::ComputePassTimestampWrites<'_>>,
) -> wgpu::ComputePass<'a> {
    encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: None, timestamp_writes })
}

/// Rows of a picture that are drawn at a time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Band {
    /// The place of its record.
    pub(crate) record: u32,
    /// Columns and rows of cells.
    pub(crate) cells: [u32; 2],
    /// Rows of pixels.
    pub(crate) rows: u32,
}
