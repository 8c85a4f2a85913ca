//! One side of the picture: a method, prepared for the scene.

use super::gpu::Gpu;
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
use catoptric::scene::Scene;
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
    prepared: Box<dyn Prepared>,
    processor: String,
    warnings: Vec<String>,
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
            // The reference takes any number: one is enough for a draft.
            Fineness::Draft if drawn.method == "reference" => Quality { samples: 1, ..drawn.quality },
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
            Fineness::Draft => self.pace.scale(wish.size, wish.sides.len()),
            Fineness::Whole { .. } => 1.0,
        };
        let [width, height] = scaled(wish.size, scale);
        let view = scene.view(&wish.camera, width, height);
        let of_frame = Stopwatch::new();
        let frame = prepared.prepared.frame(&view, &drawing)?;
        let mut linear = Framebuffer::new(width, height);
        report.add(frame.report().clone());
        report.add(frame.draw(&mut linear, &drawing)?);
        drop(frame);
        self.pace.note(u64::from(width) * u64::from(height), of_frame.elapsed_ms());
        report.warnings.splice(0..0, prepared.warnings.iter().cloned());
        Ok(Picture {
            side,
            wish: wish.clone(),
            is_whole: (width, height) == (wish.size[0], wish.size[1]) && quality.samples >= drawn.quality.samples,
            samples: quality.samples,
            rgba: linear.to_srgba8(),
            linear: Arc::new(linear),
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
            known.prepared.update(scene, quality, progress)?;
            (known.scene, known.quality, known.drawn) = (scene.clone(), quality, drawn.clone());
            return Ok(known.prepared.report().clone());
        }
        // What was prepared makes room first.
        *self = Self::default();
        let (prepared, processor, warnings) = prepare_somewhere(drawn, scene, quality, gpu, progress)?;
        let report = prepared.report().clone();
        let (drawn, scene) = (drawn.clone(), scene.clone());
        self.prepared = Some(PreparedSide { drawn, quality, scene, prepared, processor, warnings });
        Ok(report)
    }

    /// Forgets everything.
    pub(in crate::studio) fn clear(&mut self) {
        *self = Self::default();
    }
}

/// A method ready to draw, the processor's name, and what the user should know.
type Ready = (Box<dyn Prepared>, String, Vec<String>);

/// A method prepared on the GPU where there is one that can draw it, else on the processor.
fn prepare_somewhere(
    drawn: &Drawn,
    scene: &Arc<Scene>,
    quality: Quality,
    gpu: Option<&Gpu>,
    progress: &dyn Progress,
) -> Result<Ready, RenderError> {
    let mut warnings = Vec::new();
    if let Some(gpu) = gpu
        && let Some(method) = gpu.method(&drawn.method, &drawn.settings)?
    {
        match method.prepare(scene, quality, None, progress) {
            Ok(prepared) => return Ok((prepared, gpu.name(), warnings)),
            Err(RenderError::Limit { problem, .. }) => warnings.push(format!("drawn on the CPU: {problem}")),
            Err(other) => return Err(other),
        }
    }
    let method = methods::create(&drawn.method, &drawn.settings)?;
    Ok((method.prepare(scene, quality, None, progress)?, "CPU".into(), warnings))
}
