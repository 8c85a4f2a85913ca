//! Copies of what lies on a device, on their way from it.

use crate::error::GpuError;
use bytemuck::Pod;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use wgpu::{Buffer, BufferUsages};

/// The most bytes of a part of a picture: devices have no buffers of more than 256 MiB.
const BYTES_OF_A_PART: u32 = 1 << 26;

/// The content of a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Label {
    /// Rows of a picture, of so many bytes, followed by some that mean nothing.
    Rows { used: u32, stride: u32 },
    /// Times of passes.
    Times,
    /// Counts of what tiles did.
    Tiles,
    /// Counts of the virtual geometry that was found.
    VirtualGeometry,
    /// Other records.
    Records,
}

/// Copies of what lies on a device, which can be read once they have arrived.
#[derive(Debug, Default)]
pub(crate) struct Readback {
    parts: Vec<(Label, Buffer)>,
    /// Parts that have arrived, or never will.
    arrived: Arc<AtomicUsize>,
}

impl Readback {
    /// A place for a part of so many bytes.
    fn part(&mut self, device: &wgpu::Device, label: Label, size: u64) -> Buffer {
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("to be read"),
            size,
            usage: BufferUsages::COPY_DST | BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        self.parts.push((label, buffer.clone()));
        buffer
    }

    /// Adds the copying of so many bytes of a buffer, from an offset, to other work.
    pub(crate) fn buffer(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        label: Label,
        (source, offset, size): (&Buffer, u64, u64),
    ) {
        encoder.copy_buffer_to_buffer(source, offset, &self.part(device, label, size), 0, size);
    }

    /// Adds the copying of a picture, of so many bytes a pixel.
    pub(crate) fn picture(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        (picture, bytes): (&wgpu::Texture, u32),
    ) {
        let (width, height) = (picture.width(), picture.height());
        let used = width * bytes;
        // Rows of buffers start at multiples of 256 bytes.
        let stride = used.next_multiple_of(256);
        let rows = (BYTES_OF_A_PART / stride).clamp(1, height);
        for first_row in (0..height).step_by(rows as usize) {
            let rows = rows.min(height - first_row);
            let buffer = self.part(device, Label::Rows { used, stride }, u64::from(rows * stride));
            let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(stride), rows_per_image: None };
            encoder.copy_texture_to_buffer(
                wgpu::TexelCopyTextureInfo {
                    origin: wgpu::Origin3d { x: 0, y: first_row, z: 0 },
                    ..picture.as_image_copy()
                },
                wgpu::TexelCopyBufferInfo { buffer: &buffer, layout },
                wgpu::Extent3d { width, height: rows, depth_or_array_layers: 1 },
            );
        }
    }

    /// Asks for everything, once the work has been submitted.
    pub(crate) fn begin(&self) {
        for (_, buffer) in &self.parts {
            let arrived = self.arrived.clone();
            // A failure is told when the part is read.
            buffer.map_async(wgpu::MapMode::Read, .., move |_| {
                arrived.fetch_add(1, Ordering::AcqRel);
            });
        }
    }

    /// True once everything can be read: in browsers not before the program has returned to them.
    pub(crate) fn has_arrived(&self, device: &wgpu::Device) -> bool {
        // Drivers of machines do their part when they are asked; what fails is told when it is read.
        let _ = device.poll(wgpu::PollType::Poll);
        self.arrived.load(Ordering::Acquire) >= self.parts.len()
    }

    /// All records of a label.
    pub(crate) fn records<T: Pod>(&self, label: Label) -> Result<Vec<T>, GpuError> {
        let mut all = Vec::new();
        for (_, buffer) in self.parts.iter().filter(|(known, _)| *known == label) {
            all.extend(bytemuck::pod_collect_to_vec::<u8, T>(&mapped(buffer)?));
        }
        Ok(all)
    }

    /// The rows of a picture, from its top, into memory without gaps.
    pub(super) fn rows(&self, target: &mut [u8]) -> Result<(), GpuError> {
        let mut left = target;
        for (label, buffer) in &self.parts {
            let Label::Rows { used, stride } = *label else { continue };
            for row in mapped(buffer)?.chunks_exact(stride as usize) {
                let Some((place, rest)) = left.split_at_mut_checked(used as usize) else { return Ok(()) };
                place.copy_from_slice(&row[..used as usize]);
                left = rest;
            }
        }
        Ok(())
    }
}

fn mapped(buffer: &Buffer) -> Result<wgpu::BufferView, GpuError> {
    buffer.get_mapped_range(..).map_err(|error| GpuError::Device { problem: error.to_string() })
}
