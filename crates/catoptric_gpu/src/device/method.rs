//! Methods drawn on a device.

use super::context::Context;
use super::frame;
use super::frame::maps::DeviceMaps;
use super::frame::mirrors::DeviceMirrors;
use super::upload::DeviceScene;
use crate::error::GpuError;
use catoptric::clock::Stopwatch;
use catoptric::error::RenderError;
use catoptric::framebuffer::Framebuffer;
use catoptric::methods::bake::Baked;
use catoptric::methods::lookup::environment_map::{self, EnvironmentMapSettings};
use catoptric::methods::projection::planar_mirror::PlanarMirrorSettings;
use catoptric::methods::{self, Choice, Frame, Method, MethodInfo, Prepared, Quality, Report, Settings};
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
    let way = match id {
        ENVIRONMENT_MAP => Way::LookUp(EnvironmentMapSettings::from_table(settings)?),
        PLANAR_MIRROR => Way::Mirror(PlanarMirrorSettings::from_table(settings)?),
        _ => Way::Follow,
    };
    Ok(info.gpu.then(|| Box::new(DeviceMethod { context: context.clone(), info, way }) as Box<dyn Method>))
}

/// What becomes of light at mirrors and glass.
#[derive(Clone, Debug)]
enum Way {
    /// Rays are followed.
    Follow,
    /// Light is looked up in environment maps.
    LookUp(EnvironmentMapSettings),
    /// The scene is mirrored in flat mirrors.
    Mirror(PlanarMirrorSettings),
}

/// The method that looks light up in environment maps.
const ENVIRONMENT_MAP: &str = "environment_map";
/// And that which mirrors the scene.
const PLANAR_MIRROR: &str = "planar_mirror";

/// The method that chooses others.
const AUTO: &str = "auto";

#[derive(Clone)]
struct DeviceMethod {
    context: Arc<Context>,
    info: &'static MethodInfo,
    way: Way,
}

/// A scene on a device, ready for any view.
struct PreparedScene {
    method: DeviceMethod,
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
        Ok(Box::new(PreparedScene::new(self, scene, quality, None, progress)?))
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
        method: &DeviceMethod,
        scene: &Arc<Scene>,
        quality: Quality,
        old: Option<&Self>,
        progress: &dyn Progress,
    ) -> Result<Self, RenderError> {
        let DeviceMethod { context, info, way } = method;
        let refuse = |error: GpuError| failed(info, &error);
        frame::check_quality(quality).map_err(refuse)?;
        let mut report = Report::default();
        let mut maps = None;
        // Before anything is captured, which takes longer: what cannot be drawn is refused here.
        let stage = Stage::begin(progress, "loading the scene into the GPU", 1)?;
        let watch = Stopwatch::new();
        let mirrors = match way {
            Way::Mirror(settings) => {
                let (mirrors, of_mirrors) = DeviceMirrors::new(context, scene, settings).map_err(refuse)?;
                report = of_mirrors;
                Some(mirrors)
            }
            _ => None,
        };
        let old = old.map(|old| &old.resident);
        let mut resident = DeviceScene::new(context, scene, old, mirrors).map_err(refuse)?;
        report.stages_ms.push(("upload", watch.elapsed_ms()));
        stage.advance(1)?;
        if let Way::LookUp(settings) = way {
            let (captured, of_maps) = environment_map::capture(settings, scene, quality.order, progress)?;
            let loaded = DeviceMaps::new(context, &captured).map_err(refuse)?;
            let upload = std::mem::replace(&mut report, of_maps);
            report.stages_ms.extend(upload.stages_ms);
            maps = Some(loaded);
        }
        let of_maps = maps.as_ref().map_or(0, |maps| maps.byte_count);
        report.bytes.insert("gpu", resident.byte_count + of_maps);
        resident.maps = maps;
        if info.id == AUTO {
            report.choices = choices(scene);
        }
        Ok(Self { method: method.clone(), scene: scene.clone(), quality, resident, report })
    }
}

impl Prepared for PreparedScene {
    fn report(&self) -> &Report {
        &self.report
    }

    fn update(&mut self, scene: &Arc<Scene>, quality: Quality, progress: &dyn Progress) -> Result<(), RenderError> {
        *self = Self::new(&self.method, scene, quality, Some(self), progress)?;
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
        let PreparedScene { method, scene, quality, resident, .. } = self.prepared;
        let DeviceMethod { context, info, .. } = method;
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
        let mut report = drawn.report;
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
