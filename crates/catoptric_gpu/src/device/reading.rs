//! Pictures and numbers on their way from a device.

use super::context::Context;
use super::frame::Drawing;
use super::frame::timer::Timer;
use super::method::failed;
use crate::error::GpuError;
use bytemuck::Pod;
use catoptric::clock::Stopwatch;
use catoptric::error::RenderError;
use catoptric::framebuffer::Framebuffer;
use catoptric::methods::{MethodInfo, Report};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use wgpu::{Buffer, BufferUsages};

/// The most bytes of a part of a picture: devices have no buffers of more than 256 MiB.
const BYTES_OF_A_PART: u32 = 1 << 26;

/// What a part is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Label {
    /// Rows of a picture, of so many bytes, followed by some that mean nothing.
    Rows { used: u32, stride: u32 },
    /// Times of passes.
    Times,
    /// What tiles did.
    Tiles,
    /// What virtual geometry was found.
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
    fn part(&mut self, context: &Context, label: Label, size: u64) -> Buffer {
        let buffer = context.device.create_buffer(&wgpu::BufferDescriptor {
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
        context: &Context,
        encoder: &mut wgpu::CommandEncoder,
        label: Label,
        (source, offset, size): (&Buffer, u64, u64),
    ) {
        encoder.copy_buffer_to_buffer(source, offset, &self.part(context, label, size), 0, size);
    }

    /// Adds the copying of a picture, of so many bytes a pixel.
    pub(crate) fn picture(
        &mut self,
        context: &Context,
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
            let buffer = self.part(context, Label::Rows { used, stride }, u64::from(rows * stride));
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
            // What has failed is told when it is read.
            buffer.map_async(wgpu::MapMode::Read, .., move |_| {
                arrived.fetch_add(1, Ordering::AcqRel);
            });
        }
    }

    /// True once everything can be read: in browsers not before the program has returned to them.
    pub(crate) fn has_arrived(&self, context: &Context) -> bool {
        // Drivers of machines do their part when they are asked; what fails is told when it is read.
        let _ = context.device.poll(wgpu::PollType::Poll);
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
    fn rows(&self, target: &mut [u8]) -> Result<(), GpuError> {
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

/// How pictures are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// Linear colours, 16 bytes a pixel.
    Linear,
    /// 8-bit sRGB, 4 bytes a pixel: for what is shown and not compared.
    Srgba8,
}

/// What was read.
#[derive(Clone, Debug)]
pub enum Pixels {
    /// Linear colours.
    Linear(Framebuffer),
    /// Red, green, blue and 255 a pixel, rows from the top.
    Srgba8(Vec<u8>),
}

/// A picture on its way from the device: the work has been submitted, and nothing waits for it. For programs that must
/// not wait, as in browsers.
#[derive(Debug)]
pub struct Reading {
    pub(crate) context: Arc<Context>,
    pub(crate) info: &'static MethodInfo,
    pub(crate) readback: Readback,
    pub(crate) timer: Timer,
    pub(crate) drawing: Drawing,
    pub(crate) encoding: Encoding,
    pub(crate) size: [u32; 2],
    pub(crate) watch: Stopwatch,
}

impl Reading {
    /// True once [`Self::finish`] need not wait. In browsers that is never so before the program has returned to them.
    pub fn is_ready(&self) -> bool {
        self.readback.has_arrived(&self.context)
    }

    /// The picture, with times and counts. Waits for it where programs can; in browsers, what is not ready fails.
    ///
    /// # Errors
    /// [`RenderError::Limit`] where the device fails.
    pub fn finish(self) -> Result<(Pixels, Report), RenderError> {
        let [width, height] = self.size;
        Ok(match self.encoding {
            Encoding::Linear => {
                let mut picture = Framebuffer::new(width, height);
                let report = self.fill(&mut picture.pixels)?;
                (Pixels::Linear(picture), report)
            }
            Encoding::Srgba8 => {
                let mut picture = vec![[0; 4]; width as usize * height as usize];
                let report = self.fill(&mut picture)?;
                (Pixels::Srgba8(picture.into_flattened()), report)
            }
        })
    }

    /// Puts the pixels, which are of the picture's encoding, into memory for all of them.
    pub(crate) fn fill<T: Pod>(self, pixels: &mut [T]) -> Result<Report, RenderError> {
        let refuse = |error: GpuError| failed(self.info, &error);
        if !self.is_ready() {
            self.context.wait().map_err(refuse)?;
        }
        self.context.check().map_err(refuse)?;
        self.readback.rows(bytemuck::cast_slice_mut(pixels)).map_err(refuse)?;
        let mut report = self.drawing.report.clone();
        report.stages_ms.push(("gpu", self.watch.elapsed_ms()));
        self.drawing.count(&self.readback, &mut report).map_err(refuse)?;
        report.stages_ms.extend(self.timer.stages_ms(&self.context, &self.readback).map_err(refuse)?);
        Ok(report)
    }
}
