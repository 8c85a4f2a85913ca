//! Methods drawn on a device.

use super::context::Context;
use super::frame;
use super::upload::DeviceScene;
use crate::error::GpuError;
use catoptric::clock::Stopwatch;
use catoptric::error::RenderError;
use catoptric::framebuffer::Framebuffer;
use catoptric::methods::bake::Baked;
use catoptric::methods::{self, Choice, Frame, Method, MethodInfo, Prepared, Quality, Report};
use catoptric::progress::{Progress, Stage};
use catoptric::scene::{Scene, View};
use std::sync::Arc;

/// The method with this id and these settings on a device; `None` for methods that draw on the processor alone
/// ([`MethodInfo::gpu`]).
///
/// # Errors
/// As [`methods::create`].
pub fn create(
    context: &Arc<Context>,
    id: &str,
    settings: &toml::Table,
) -> Result<Option<Box<dyn Method>>, RenderError> {
    let info = methods::find(id)?;
    // Checks the settings.
    (info.effective)(settings)?;
    Ok(info.gpu.then(|| Box::new(DeviceMethod { context: context.clone(), info }) as Box<dyn Method>))
}

/// The method that chooses others.
const AUTO: &str = "auto";

struct DeviceMethod {
    context: Arc<Context>,
    info: &'static MethodInfo,
}

/// A scene on a device, ready for any view.
struct PreparedScene {
    context: Arc<Context>,
    info: &'static MethodInfo,
    scene: Arc<Scene>,
    quality: Quality,
    resident: DeviceScene,
    report: Report,
}

/// One view.
struct DeviceFrame<'a> {
    prepared: &'a PreparedScene,
    view: View,
    report: Report,
}

impl Method for DeviceMethod {
    fn info(&self) -> &'static MethodInfo {
        self.info
    }

    fn prepare(
        &self,
        scene: &Arc<Scene>,
        quality: Quality,
        bake: Option<Arc<dyn Baked>>,
        progress: &dyn Progress,
    ) -> Result<Box<dyn Prepared>, RenderError> {
        if bake.is_some() {
            return Err(RenderError::Limit {
                method: self.info.id,
                problem: "on the GPU it uses no baked files".into(),
            });
        }
        Ok(Box::new(PreparedScene::new(&self.context, self.info, scene, quality, None, progress)?))
    }
}

/// What `auto` chooses on a device.
fn choices(scene: &Scene) -> Vec<Choice> {
    let choice = |object: u32| Choice {
        object: scene.objects[object as usize].name.clone(),
        method: "multiperspective",
        reason: "the one on the GPU".into(),
    };
    scene.specular_objects().into_iter().map(choice).collect()
}

/// A failure of the device as that of a method.
fn failed(info: &'static MethodInfo, error: &GpuError) -> RenderError {
    RenderError::Limit { method: info.id, problem: error.to_string() }
}

impl PreparedScene {
    fn new(
        context: &Arc<Context>,
        info: &'static MethodInfo,
        scene: &Arc<Scene>,
        quality: Quality,
        old: Option<&Self>,
        progress: &dyn Progress,
    ) -> Result<Self, RenderError> {
        frame::check_quality(quality).map_err(|error| failed(info, &error))?;
        let stage = Stage::begin(progress, "loading the scene into the GPU", 1)?;
        let watch = Stopwatch::new();
        let resident =
            DeviceScene::new(context, scene, old.map(|old| &old.resident)).map_err(|error| failed(info, &error))?;
        let mut report = Report::default();
        report.stages_ms.push(("upload", watch.elapsed_ms()));
        report.bytes.insert("gpu", resident.byte_count);
        if info.id == AUTO {
            report.choices = choices(scene);
        }
        stage.advance(1)?;
        Ok(Self { context: context.clone(), info, scene: scene.clone(), quality, resident, report })
    }
}

impl Prepared for PreparedScene {
    fn report(&self) -> &Report {
        &self.report
    }

    fn update(&mut self, scene: &Arc<Scene>, quality: Quality, progress: &dyn Progress) -> Result<(), RenderError> {
        *self = Self::new(&self.context, self.info, scene, quality, Some(self), progress)?;
        Ok(())
    }

    fn frame<'a>(&'a mut self, view: &View, _progress: &dyn Progress) -> Result<Box<dyn Frame + 'a>, RenderError> {
        Ok(Box::new(DeviceFrame { prepared: self, view: view.clone(), report: Report::default() }))
    }
}

impl Frame for DeviceFrame<'_> {
    fn report(&self) -> &Report {
        &self.report
    }

    fn draw(&self, target: &mut Framebuffer, progress: &dyn Progress) -> Result<Report, RenderError> {
        let PreparedScene { context, info, scene, quality, resident, .. } = self.prepared;
        let view = &self.view;
        let pixels = view.width as usize * view.height as usize;
        if (target.width, target.height) != (view.width, view.height) || target.pixels.len() != pixels {
            let problem = format!("the view has {} x {} pixels, the target others", view.width, view.height);
            return Err(RenderError::Limit { method: info.id, problem });
        }
        let stage = Stage::begin(progress, "drawing on the GPU", 1)?;
        let watch = Stopwatch::new();
        let drawn = frame::draw(context, resident, scene, view, *quality, &mut target.pixels);
        let drawn = drawn.map_err(|error| failed(info, &error))?;
        stage.advance(1)?;
        let mut report = Report::default();
        let counts = drawn.counts;
        report.counts.extend([
            ("tiles", u64::from(counts.tiles)),
            ("blocks_traced", u64::from(counts.traced_blocks)),
            ("candidates", u64::from(counts.candidates)),
            ("pairs", u64::from(counts.pairs)),
        ]);
        report.stages_ms.push(("gpu", watch.elapsed_ms()));
        report.stages_ms.extend(drawn.stages_ms);
        Ok(report)
    }
}
