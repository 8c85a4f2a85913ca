//! Pictures on their way from a device.

use super::context::Context;
use super::failure::failed;
use super::frame::{Drawing, Timer};
use super::readback::Readback;
use crate::error::GpuError;
use bytemuck::Pod;
use catoptric::clock::Stopwatch;
use catoptric::error::RenderError;
use catoptric::framebuffer::Framebuffer;
use catoptric::methods::{MethodInfo, Report};
use std::sync::Arc;

/// How pictures are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// Linear colours, 16 bytes a pixel.
    Linear,
    /// 8-bit sRGB, 4 bytes a pixel: for what is shown and not compared.
    Srgba8,
}

/// A picture that was read.
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
        self.readback.has_arrived(&self.context.device)
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
