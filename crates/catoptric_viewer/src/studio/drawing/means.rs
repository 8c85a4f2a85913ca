//! The processor that draws, with all that it needs.

use super::gpu::DeviceScene;
use crate::studio::order::Drawn;
use catoptric::error::RenderError;
use catoptric::framebuffer::Framebuffer;
use catoptric::methods::{Prepared, Quality, Report};
use catoptric::progress::Progress;
use catoptric::scene::{Scene, View};
use catoptric::tone::Display;
use catoptric_gpu::{Encoding, Reading};
use std::sync::Arc;

/// A method made ready for a scene.
pub(super) struct PreparedSide {
    pub(super) drawn: Drawn,
    /// The quality of the last update.
    pub(super) quality: Quality,
    pub(super) scene: Arc<Scene>,
    pub(super) means: Means,
    pub(super) processor: String,
    pub(super) warnings: Vec<String>,
    /// Nothing has come from its device yet, which may still make programs of its shaders.
    pub(super) is_cold: bool,
}

impl PreparedSide {
    /// True if this was made ready for the method and the settings of `drawn`.
    pub(super) fn does(&self, drawn: &Drawn) -> bool {
        (&self.drawn.method, &self.drawn.settings) == (&drawn.method, &drawn.settings)
    }
}

/// The processor that draws.
pub(super) enum Means {
    Cpu(Box<dyn Prepared>),
    Gpu(Box<DeviceScene>),
}

/// A picture as its processor leaves it.
pub(super) enum Canvas {
    /// Linear colours.
    Linear(Framebuffer),
    /// 8-bit sRGB, four bytes a pixel.
    Srgba8(Vec<u8>),
    /// A texture of the window's device.
    Texture(wgpu::Texture),
}

/// A picture that is done, or that a device has begun.
pub(super) enum Begun {
    /// The picture, with times and counts.
    Done(Canvas, Report),
    /// A device is at it.
    OnItsWay(Reading),
}

impl Means {
    pub(super) fn update(
        &mut self,
        scene: &Arc<Scene>,
        quality: Quality,
        progress: &dyn Progress,
    ) -> Result<Report, RenderError> {
        match self {
            Self::Cpu(prepared) => {
                prepared.update(scene, quality, progress)?;
                Ok(prepared.report().clone())
            }
            Self::Gpu(device) => {
                device.renderer.update(scene, quality, progress)?;
                Ok(device.renderer.report().clone())
            }
        }
    }

    /// Draws a view, or begins to: of drafts on the window's device a texture alone.
    pub(super) fn draw(
        &mut self,
        view: &View,
        (is_draft, display): (bool, Display),
        progress: &dyn Progress,
    ) -> Result<Begun, RenderError> {
        if let Self::Gpu(device) = self {
            device.renderer.set_display(display);
        }
        let picture = || Framebuffer::new(view.width, view.height);
        Ok(match self {
            Self::Gpu(device) if !device.waits => {
                let encoding = if is_draft { Encoding::Srgba8 } else { Encoding::Linear };
                Begun::OnItsWay(device.renderer.begin_reading(view, encoding, progress)?)
            }
            Self::Gpu(device) if is_draft => {
                let (texture, report) = device.texture(view, progress)?;
                Begun::Done(Canvas::Texture(texture), report)
            }
            Self::Gpu(device) => {
                let mut linear = picture();
                let report = device.renderer.read(view, &mut linear, progress)?;
                Begun::Done(Canvas::Linear(linear), report)
            }
            Self::Cpu(prepared) => {
                let mut linear = picture();
                let frame = prepared.frame(view, progress)?;
                let mut report = frame.report().clone();
                report.add(frame.draw(&mut linear, progress)?);
                Begun::Done(Canvas::Linear(linear), report)
            }
        })
    }
}
