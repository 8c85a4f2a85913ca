//! One side of the picture: a method, prepared for the scene.

use super::gpu::Gpu;
use super::means::{Begun, Canvas, Means, PreparedSide};
use super::pace::{Pace, scaled};
use crate::studio::interrupt::{EndedBy, Interrupt};
use crate::studio::mailbox::Mailbox;
use crate::studio::news::{News, Picture};
use crate::studio::order::{Drawn, Wish};
use catoptric::clock::Stopwatch;
use catoptric::error::RenderError;
use catoptric::methods::{self, Prepared, Quality, Report};
use catoptric::progress::{Cancelled, Progress};
use catoptric::scene::Scene;
use catoptric_bake::{BakeChoice, Shelf};
use catoptric_gpu::{Pixels, Reading};
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

/// True for methods whose drafts are drawn with one sample a pixel: those that need nothing new for that. In the time
/// of four samples their drafts have twice the width.
fn drafts_are_cheaper(drawn: &Drawn) -> bool {
    ["auto", "multiperspective", "planar_mirror", "reference"].contains(&drawn.method.as_str())
}

/// One side of the picture: its method made ready, and the scale of its drafts.
#[derive(Default)]
pub(in crate::studio) struct Side {
    prepared: Option<PreparedSide>,
    pace: Pace,
    /// The same side on the CPU, which draws until the device has drawn its first picture.
    meanwhile: Option<Box<Side>>,
}

/// A side's picture, or the promise of one.
pub(in crate::studio) enum Outcome {
    /// A picture.
    Picture(Box<Picture>),
    /// A device draws it, and nothing waits for that.
    OnItsWay(Box<OnItsWay>),
}

/// A picture that a device is drawing.
pub(in crate::studio) struct OnItsWay {
    pub(in crate::studio) plan: Plan,
    reading: Reading,
}

impl OnItsWay {
    /// True once it can be received.
    pub(in crate::studio) fn is_ready(&self) -> bool {
        self.reading.is_ready()
    }
}

/// A picture's task: all that is known before it is drawn.
pub(in crate::studio) struct Plan {
    pub(in crate::studio) wish: Arc<Wish>,
    pub(in crate::studio) side: usize,
    pub(in crate::studio) fineness: Fineness,
    quality: Quality,
    scale: f32,
    size: [u32; 2],
    /// The report of the preparation.
    report: Report,
    /// Since the preparation, and since the frame began.
    watches: [Stopwatch; 2],
}

/// The tools that a side draws with.
#[derive(Clone, Copy)]
pub(in crate::studio) struct Tools<'a> {
    pub(in crate::studio) mailbox: &'a Mailbox,
    pub(in crate::studio) tell: &'a (dyn Fn(News) + Send + Sync),
    pub(in crate::studio) gpu: Option<&'a Gpu>,
    pub(in crate::studio) bakes: &'a Shelf,
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
    ) -> Result<Outcome, RenderError> {
        let drawn = &wish.sides[side];
        let quality = match fineness {
            Fineness::Draft if drafts_are_cheaper(drawn) && !self.draws_on_device(drawn, tools) => {
                Quality { samples: 1, ..drawn.quality }
            }
            Fineness::Draft => drawn.quality,
            Fineness::Whole { samples } => Quality { samples, ..drawn.quality },
        };
        let is_draft = fineness == Fineness::Draft;
        let ended_by = if is_draft { EndedBy::OtherWork } else { EndedBy::Anything };
        let preparing = Interrupt::new(tools.mailbox, tools.tell, (wish, side), EndedBy::OtherWork);
        let drawing = Interrupt::new(tools.mailbox, tools.tell, (wish, side), ended_by);
        let of_all = Stopwatch::new();
        let report = self.prepare(drawn, scene, quality, tools, &preparing)?;
        let Some(prepared) = &mut self.prepared else { return Err(Cancelled.into()) };
        let scale = if is_draft { self.pace.scale(wish.sides.len()) } else { 1.0 };
        let size = scaled(wish.size, scale);
        let view = scene.view(&wish.camera, size[0], size[1]);
        let watches = [of_all, Stopwatch::new()];
        let plan = Plan { wish: wish.clone(), side, fineness, quality, scale, size, report, watches };
        match prepared.means.draw(&view, (is_draft, wish.display), &drawing) {
            Ok(Begun::Done(canvas, report)) => Ok(Outcome::Picture(Box::new(self.complete(plan, canvas, report)))),
            Ok(Begun::OnItsWay(reading)) => Ok(Outcome::OnItsWay(Box::new(OnItsWay { plan, reading }))),
            Err(RenderError::Limit { problem, .. }) if matches!(prepared.means, Means::Gpu(_)) => {
                // The device cannot draw this: the processor does from now on.
                let on_cpu = Tools { gpu: None, ..tools };
                self.prepare_anew(drawn, scene, quality, (on_cpu, &preparing))?;
                if let Some(prepared) = &mut self.prepared {
                    prepared.warnings.push(format!("drawn on the CPU: {problem}"));
                }
                self.draw((wish, side), scene, fineness, tools)
            }
            Err(other) => Err(other),
        }
    }

    /// The picture that a device has drawn.
    ///
    /// # Errors
    /// [`RenderError::Limit`] where the device has failed.
    pub(in crate::studio) fn receive(&mut self, on_its_way: OnItsWay) -> Result<Picture, RenderError> {
        let OnItsWay { plan, reading } = on_its_way;
        let (pixels, report) = reading.finish()?;
        let canvas = match pixels {
            Pixels::Linear(linear) => Canvas::Linear(linear),
            Pixels::Srgba8(bytes) => Canvas::Srgba8(bytes),
        };
        // The first time says nothing about others: shaders became programs in it.
        let was_cold = self.prepared.as_mut().is_some_and(|prepared| std::mem::take(&mut prepared.is_cold));
        let before = self.pace.clone();
        let picture = self.complete(plan, canvas, report);
        if was_cold {
            self.pace = before;
        }
        self.meanwhile = None;
        Ok(picture)
    }

    /// A draft by the processor, where a device has not drawn anything yet and its method needs no preparation there.
    ///
    /// # Errors
    /// As [`Self::draw`].
    pub(in crate::studio) fn draw_meanwhile(
        &mut self,
        (wish, side): (&Arc<Wish>, usize),
        scene: &Arc<Scene>,
        tools: Tools<'_>,
    ) -> Result<Option<Picture>, RenderError> {
        let is_cold = self.prepared.as_ref().is_some_and(|prepared| prepared.is_cold);
        if !is_cold || !drafts_are_cheaper(&wish.sides[side]) {
            return Ok(None);
        }
        let meanwhile = self.meanwhile.get_or_insert_default();
        match meanwhile.draw((wish, side), scene, Fineness::Draft, Tools { gpu: None, ..tools })? {
            Outcome::Picture(picture) => Ok(Some(*picture)),
            Outcome::OnItsWay(_) => Ok(None),
        }
    }

    /// True if a device draws a method, or will.
    fn draws_on_device(&self, drawn: &Drawn, tools: Tools<'_>) -> bool {
        let known = self.prepared.as_ref().filter(|known| known.does(drawn));
        let could = || tools.gpu.is_some() && methods::find(&drawn.method).is_ok_and(|info| info.gpu);
        known.map_or_else(could, |known| matches!(known.means, Means::Gpu(_)))
    }

    /// A picture of what was drawn.
    fn complete(&mut self, plan: Plan, canvas: Canvas, of_view: Report) -> Picture {
        let Plan { wish, side, fineness, quality, scale, size, mut report, watches: [of_all, of_frame] } = plan;
        report.add(of_view);
        // Pictures of other numbers of samples say nothing about drafts.
        if fineness == Fineness::Draft || !drafts_are_cheaper(&wish.sides[side]) {
            self.pace.note(scale, of_frame.elapsed_ms());
        }
        let mut processor = String::new();
        if let Some(prepared) = &self.prepared {
            report.warnings.splice(0..0, prepared.warnings.iter().cloned());
            processor.clone_from(&prepared.processor);
        }
        let (rgba, linear, texture) = match canvas {
            Canvas::Linear(linear) => {
                let rgba = wish.display.of(&linear).to_srgba8();
                (rgba, Some(Arc::new(linear)), None)
            }
            Canvas::Srgba8(bytes) => (bytes, None, None),
            Canvas::Texture(texture) => (Vec::new(), None, Some(texture)),
        };
        let is_whole = size == wish.size && quality.samples >= wish.sides[side].quality.samples;
        let (samples, frame_ms) = (quality.samples, of_all.elapsed_ms());
        Picture { side, wish, is_whole, samples, rgba, linear, texture, size, report, frame_ms, processor }
    }

    /// Makes the method ready for a scene: anew, or by an update.
    fn prepare(
        &mut self,
        drawn: &Drawn,
        scene: &Arc<Scene>,
        quality: Quality,
        tools: Tools<'_>,
        progress: &dyn Progress,
    ) -> Result<Report, RenderError> {
        if let Some(known) = self.prepared.as_mut().filter(|known| known.does(drawn)) {
            let is_same = Arc::ptr_eq(&known.scene, scene);
            if is_same && known.quality == quality {
                return Ok(Report::default());
            }
            // Another scene may be one that a bake fits, or fits no more.
            if is_same || !tools.bakes.has(&drawn.method) {
                let report = known.means.update(scene, quality, progress)?;
                (known.scene, known.quality, known.drawn) = (scene.clone(), quality, drawn.clone());
                return Ok(report);
            }
        }
        self.prepare_anew(drawn, scene, quality, (tools, progress))
    }

    /// Makes the method ready for a scene: on the device if there is one that can draw it, else on the CPU.
    fn prepare_anew(
        &mut self,
        drawn: &Drawn,
        scene: &Arc<Scene>,
        quality: Quality,
        (tools, progress): (Tools<'_>, &dyn Progress),
    ) -> Result<Report, RenderError> {
        // The old preparation is dropped first, for its memory. The same method in another pose will take about as
        // long.
        let keeps_pace = self.prepared.as_ref().is_some_and(|known| known.does(drawn));
        let pace = if keeps_pace { std::mem::take(&mut self.pace) } else { Pace::default() };
        *self = Self { pace, ..Self::default() };
        let choice = tools.bakes.choose(methods::find(&drawn.method)?, &drawn.settings, scene, quality)?;
        let mut warnings: Vec<String> = choice.problem.iter().map(ToString::to_string).collect();
        let mut device = None;
        if let Some(gpu) = tools.gpu {
            match gpu.prepare(&drawn.method, &choice, scene, quality, progress) {
                Ok(Some(ready)) => {
                    let report = ready.renderer.report().clone();
                    device = Some((Means::Gpu(Box::new(ready)), gpu.name(), report));
                }
                Ok(None) => {}
                Err(RenderError::Limit { problem, .. }) => warnings.push(format!("drawn on the CPU: {problem}")),
                Err(other) => return Err(other),
            }
        }
        let BakeChoice { settings, bake, .. } = choice;
        let is_baked = bake.is_some();
        let (means, mut processor, report) = match device {
            Some(device) => device,
            None => {
                let prepared = methods::create(&drawn.method, &settings)?.prepare(scene, quality, bake, progress)?;
                let report = prepared.report().clone();
                (Means::Cpu(prepared), "CPU".into(), report)
            }
        };
        if is_baked {
            processor += ", baked";
        }
        let (drawn, scene) = (drawn.clone(), scene.clone());
        let is_cold = matches!(means, Means::Gpu(_));
        self.prepared = Some(PreparedSide { drawn, quality, scene, means, processor, warnings, is_cold });
        Ok(report)
    }

    /// The side's method on the CPU, if that is ready for this scene and this quality.
    pub(super) fn on_cpu(&mut self, drawn: &Drawn, scene: &Arc<Scene>) -> Option<&mut dyn Prepared> {
        let known = self.prepared.as_mut().filter(|known| Arc::ptr_eq(&known.scene, scene) && known.drawn == *drawn)?;
        match &mut known.means {
            Means::Cpu(prepared) if known.quality == drawn.quality => Some(&mut **prepared),
            _ => None,
        }
    }

    /// Forgets everything.
    pub(in crate::studio) fn clear(&mut self) {
        *self = Self::default();
    }
}
