//! Records of paths on a device, for what is drawn where a picture shows something.

use bytemuck::Pod;
use std::num::NonZeroU64;
use wgpu::util::{BufferInitDescriptor, DeviceExt};
use wgpu::{BindingResource, Buffer, BufferBinding, BufferUsages};

/// From record to record: offsets of uniform buffers are multiples of 256.
const STRIDE: usize = 256;
/// Numbers of paths have 16 bits.
pub(super) const MOST_PATHS: usize = 65_535;

/// A record for each path on a device.
pub(super) struct PathRecords {
    buffer: Buffer,
    /// Bytes of one record.
    size: u64,
}

impl PathRecords {
    pub(super) fn new<T: Pod>(device: &wgpu::Device, records: impl IntoIterator<Item = T>) -> Self {
        let mut bytes = Vec::new();
        for record in records {
            bytes.extend_from_slice(bytemuck::bytes_of(&record));
            bytes.resize(bytes.len().next_multiple_of(STRIDE), 0);
        }
        bytes.resize(bytes.len().max(STRIDE), 0);
        let (label, usage) = (Some("paths"), BufferUsages::UNIFORM);
        let buffer = device.create_buffer_init(&BufferInitDescriptor { label, contents: &bytes, usage });
        Self { buffer, size: size_of::<T>() as u64 }
    }

    /// The first record; others by their offsets.
    pub(super) fn binding(&self) -> BindingResource<'_> {
        let size = NonZeroU64::new(self.size);
        BindingResource::Buffer(BufferBinding { buffer: &self.buffer, offset: 0, size })
    }

    /// The dynamic offset of a record.
    pub(super) fn offset(index: usize) -> u32 {
        (index * STRIDE) as u32
    }
}
