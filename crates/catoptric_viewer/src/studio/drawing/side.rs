//! One side of the picture: a method, prepared for the scene.

use super::gpu::{DeviceScene, Gpu};
use super::pace::{Pace, scaled};
use crate::studio::interrupt::{EndedBy, Interrupt};
use crate::studio::mailbox::Mailbox;
use crate::studio::news::{News, Picture};
use crate::studio::order::{Drawn, Wish};
use catoptric::clock::Stopwatch;
use catoptric::error::RenderError;
use catoptric::framebuffer::Framebuffer;
use catoptric::methods::{self, Prepared, Quality, Report};
use catoptric::progress::Progress;
use catoptric::scene::{Scene, View};
use std::sync::Arc;

/// Samples a pixel with which the reference ends, where fewer were wished for.
const REFERENCE_SAMPLES: u32 = 16;

/// How fine a picture is to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::studio) enum Fineness {
    /// As many pixels as keep it moving.
    Draft,
    /// All pixels, with so many samples.
    Whole {
        /// Samples a pixel.
        samples: u32,
    },
}

/// The steps by which a side's picture becomes sharp, from coarse to fine.
pub(in crate::studio) fn steps(drawn: &Drawn) -> Vec<Fineness> {
    let wanted = drawn.quality.samples;
    let mut steps = vec![Fineness::Draft];
    if drawn.method == "reference" {
        steps.extend([1, wanted, REFERENCE_SAMPLES.max(wanted)].map(|samples| Fineness::Whole { samples }));
    } else {
        steps.push(Fineness::Whole { samples: wanted });
    }
    steps.dedup();
    steps
}

/// Whether drafts are drawn with one sample a pixel: of methods that need nothing new for that. In the time of four
/// samples their drafts have twice the width.
fn drafts_are_cheaper(drawn: &Drawn) -> bool {
    ["auto", "multiperspective", "planar_mirror", "reference"].contains(&drawn.method.as_str())
}

/// What draws a side.
#[derive(Default)]
pub(in crate::studio) struct Side {
    prepared: Option<PreparedSide>,
    pace: Pace,
}

struct PreparedSide {
    drawn: Drawn,
    /// Of the last update.
    quality: Quality,
    scene: Arc<Scene>,
    means: Means,
    processor: String,
    warnings: Vec<String>,
}

/// The processor that draws, with all that it needs.
enum Means {
    Cpu(Box<dyn Prepared>),
    Gpu(Box<DeviceScene>),
}

/// What is drawn.
enum Canvas {
    /// Linear colours.
    Linear(Framebuffer),
    /// A texture of the window's device.
    Texture(wgpu::Texture),
}

impl Means {
    fn update(&mut self, scene: &Arc<Scene>, quality: Quality, progress: &dyn Progress) -> Result<Report, RenderError> {
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

    /// Draws a view: of drafts on the window's device a texture alone.
    fn draw(&mut self, view: &View, is_draft: bool, progress: &dyn Progress) -> Result<(Canvas, Report), RenderError> {
        if let (Self::Gpu(device), true) = (&mut *self, is_draft) {
            let (texture, report) = device.texture(view, progress)?;
            return Ok((Canvas::Texture(texture), report));
        }
        let mut linear = Framebuffer::new(view.width, view.height);
        let report = match self {
            Self::Cpu(prepared) => {
                let frame = prepared.frame(view, progress)?;
                let mut report = frame.report().clone();
                report.add(frame.draw(&mut linear, progress)?);
                report
            }
            Self::Gpu(device) => device.read(view, &mut linear, progress)?,
        };
        Ok((Canvas::Linear(linear), report))
    }
}

/// The tools that a side draws with.
#[derive(Clone, Copy)]
pub(in crate::studio) struct Tools<'a> {
    pub(in crate::studio) mailbox: &'a Mailbox,
    pub(in crate::studio) tell: &'a (dyn Fn(News) + Send + Sync),
    pub(in crate::studio) gpu: Option<&'a Gpu>,
}

impl Side {
    /// Draws a side of a wish. What is prepared is kept for the next one.
    ///
    /// # Errors
    /// [`RenderError::Cancelled`] where something newer waits; else the reason why the method cannot draw.
    pub(in crate::studio) fn draw(
        &mut self,
        (wish, side): (&Arc<Wish>, usize),
        scene: &Arc<Scene>,
        fineness: Fineness,
        tools: Tools<'_>,
    ) -> Result<Picture, RenderError> {
        let drawn = &wish.sides[side];
        let quality = match fineness {
            Fineness::Draft if tools.gpu.is_none() && drafts_are_cheaper(drawn) => {
                Quality { samples: 1, ..drawn.quality }
            }
            Fineness::Draft => drawn.quality,
            Fineness::Whole { samples } => Quality { samples, ..drawn.quality },
        };
        let ended_by = if fineness == Fineness::Draft { EndedBy::OtherWork } else { EndedBy::Anything };
        let preparing = Interrupt::new(tools.mailbox, tools.tell, (wish, side), EndedBy::OtherWork);
        let drawing = Interrupt::new(tools.mailbox, tools.tell, (wish, side), ended_by);
        let watch = Stopwatch::new();
        let mut report = self.prepare(drawn, scene, quality, tools.gpu, &preparing)?;
        let Some(prepared) = &mut self.prepared else { return Err(catoptric::progress::Cancelled.into()) };
        let scale = match fineness {
            Fineness::Draft => self.pace.scale(wish.sides.len()),
            Fineness::Whole { .. } => 1.0,
        };
        let [width, height] = scaled(wish.size, scale);
        let view = scene.view(&wish.camera, width, height);
        let of_frame = Stopwatch::new();
        let drawn_view = prepared.means.draw(&view, fineness == Fineness::Draft, &drawing);
        let (canvas, of_view) = match drawn_view {
            Err(RenderError::Limit { problem, .. }) if matches!(prepared.means, Means::Gpu(_)) => {
                // What the device could not do, the processor does from now on.
                self.prepare_on_cpu(drawn, scene, quality, vec![format!("drawn on the CPU: {problem}")], &preparing)?;
                return self.draw((wish, side), scene, fineness, tools);
            }
            other => other?,
        };
        report.add(of_view);
        // Pictures of other numbers of samples say nothing about drafts.
        if fineness == Fineness::Draft || !drafts_are_cheaper(drawn) {
            self.pace.note(scale, of_frame.elapsed_ms());
        }
        report.warnings.splice(0..0, prepared.warnings.iter().cloned());
        let (rgba, linear, texture) = match canvas {
            Canvas::Linear(linear) => (linear.to_srgba8(), Some(Arc::new(linear)), None),
            Canvas::Texture(texture) => (Vec::new(), None, Some(texture)),
        };
        Ok(Picture {
            side,
            wish: wish.clone(),
            is_whole: (width, height) == (wish.size[0], wish.size[1]) && quality.samples >= drawn.quality.samples,
            samples: quality.samples,
            rgba,
            linear,
            texture,
            size: [width, height],
            report,
            frame_ms: watch.elapsed_ms(),
            processor: prepared.processor.clone(),
        })
    }

    /// Makes the method ready for a scene: anew, or by an update.
    fn prepare(
        &mut self,
        drawn: &Drawn,
        scene: &Arc<Scene>,
        quality: Quality,
        gpu: Option<&Gpu>,
        progress: &dyn Progress,
    ) -> Result<Report, RenderError> {
        let is_same =
            |known: &PreparedSide| known.drawn.method == drawn.method && known.drawn.settings == drawn.settings;
        if let Some(known) = self.prepared.as_mut().filter(|known| is_same(known)) {
            if Arc::ptr_eq(&known.scene, scene) && known.quality == quality {
                return Ok(Report::default());
            }
            let report = known.means.update(scene, quality, progress)?;
            (known.scene, known.quality, known.drawn) = (scene.clone(), quality, drawn.clone());
            return Ok(report);
        }
        // What was prepared makes room first.
        self.clear();
        let mut warnings = Vec::new();
        if let Some(gpu) = gpu {
            match gpu.prepare((&drawn.method, &drawn.settings), scene, quality, progress) {
                Ok(Some(device)) => {
                    let report = device.renderer.report().clone();
                    let (means, processor) = (Means::Gpu(Box::new(device)), gpu.name());
                    self.keep(drawn, scene, quality, means, processor, warnings);
                    return Ok(report);
                }
                Ok(None) => {}
                Err(RenderError::Limit { problem, .. }) => warnings.push(format!("drawn on the CPU: {problem}")),
                Err(other) => return Err(other),
            }
        }
        self.prepare_on_cpu(drawn, scene, quality, warnings, progress)
    }

    fn prepare_on_cpu(
        &mut self,
        drawn: &Drawn,
        scene: &Arc<Scene>,
        quality: Quality,
        warnings: Vec<String>,
        progress: &dyn Progress,
    ) -> Result<Report, RenderError> {
        self.clear();
        let method = methods::create(&drawn.method, &drawn.settings)?;
        let prepared = method.prepare(scene, quality, None, progress)?;
        let report = prepared.report().clone();
        self.keep(drawn, scene, quality, Means::Cpu(prepared), "CPU".into(), warnings);
        Ok(report)
    }

    fn keep(
        &mut self,
        drawn: &Drawn,
        scene: &Arc<Scene>,
        quality: Quality,
        means: Means,
        processor: String,
        warnings: Vec<String>,
    ) {
        let (drawn, scene) = (drawn.clone(), scene.clone());
        self.prepared = Some(PreparedSide { drawn, quality, scene, means, processor, warnings });
    }

    /// Forgets everything.
    pub(in crate::studio) fn clear(&mut self) {
        *self = Self::default();
    }
}
