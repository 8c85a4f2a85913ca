//! Records of the tables, alike on CPU and GPU.

use bytemuck::{Pod, Zeroable};

/// One entry of the table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct {{type}}Texel {
    /// Radiance, and its weight.
    pub radiance: [f32; 4],
}
