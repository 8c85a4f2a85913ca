//! Methods drawn on a device.

use super::context::Context;
use super::failure::failed;
use super::frame::{self, DeviceFields, DeviceLayers, DeviceMaps, DeviceMirrors, Drawing, DrawnScene, Found, Geometry};
use super::frame::{OnDevice, Reflections, Search, Sight, Timer, VertexAppearance};
use super::projection::{PreparedProjection, Projection};
use super::readback::Readback;
use super::reading::{Encoding, Reading};
use super::scene::DeviceScene;
use crate::error::GpuError;
use crate::tables::Moved;
use catoptric::clock::Stopwatch;
use catoptric::error::RenderError;
use catoptric::framebuffer::Framebuffer;
use catoptric::light::bodies::bodies_meet;
use catoptric::methods::bake::Baked;
use catoptric::methods::lookup::environment_map::{self, EnvironmentMapSettings};
use catoptric::methods::lookup::layered_environment_map::{LayeredEnvironmentMapSettings, LayeredMaps};
use catoptric::methods::lookup::light_field::{Background, Layout, LightFieldSettings, LightFields, Transfer};
use catoptric::methods::path_query::PathSearch;
use catoptric::methods::projection::explosion_map::{ExplosionMapSettings, Variant, VirtualVertex};
use catoptric::methods::projection::planar_mirror::PlanarMirrorSettings;
use catoptric::methods::projection::reflector_search::{Refine, ReflectorSearchSettings, Search as SearchOfPictures};
use catoptric::methods::projector::VertexProjector;
use catoptric::methods::{self, Choice, Frame, Method, MethodInfo, Prepared, Quality, Report, Settings};
use catoptric::progress::{Progress, Stage};
use catoptric::scene::{AlphaMode, Lobes, Material, Scene, View};
use catoptric::tone::Display;
use glam::{DVec3, Vec3};
use std::sync::Arc;

/// The method with this id and these settings on a device; `None` for methods that draw on the processor alone
/// ([`MethodInfo::gpu`]).
///
/// # Errors
/// As [`methods::create`].
pub fn create(context: &Arc<Context>, id: &str, settings: &toml::Table) -> Result<Option<DeviceMethod>, RenderError> {
    let info = methods::find(id)?;
    // Checks the settings.
    (info.effective)(settings)?;
    let way = match id {
        ENVIRONMENT_MAP => Way::LookUp(EnvironmentMapSettings::from_table(settings)?),
        LIGHT_FIELD => Way::Fields(LightFieldSettings::from_table(settings)?),
        LAYERED_MAP => Way::Layers(LayeredEnvironmentMapSettings::from_table(settings)?),
        PLANAR_MIRROR => Way::Mirror(PlanarMirrorSettings::from_table(settings)?),
        MULTIPERSPECTIVE | AUTO => Way::Follow,
        _ => Way::Project((info.create)(settings)?.into(), search_on_device(id, settings)?),
    };
    Ok(info.gpu.then(|| DeviceMethod { context: context.clone(), info, way }))
}

/// How a device itself finds the virtual geometry of a method; `None` for methods and settings that are the processor's
/// alone: on the device every point gets its place by Newton's method, however it is looked for.
fn search_on_device(id: &str, settings: &toml::Table) -> Result<Option<Search>, RenderError> {
    Ok(match id {
        REFLECTOR_SEARCH => {
            let settings = ReflectorSearchSettings::from_table(settings)?;
            let ReflectorSearchSettings { edge_error_px, piece_px, .. } = settings;
            let search = Search { map_size: None, edge_error_px, piece_px };
            let is_newton = settings.search == SearchOfPictures::Cells;
            (is_newton && settings.refine == Refine::Corrected).then_some(search)
        }
        EXPLOSION_MAP => {
            let settings = ExplosionMapSettings::from_table(settings)?;
            let ExplosionMapSettings { edge_error_px, piece_px, map_size, .. } = settings;
            let search = Search { map_size: Some(map_size), edge_error_px, piece_px };
            let is_exact = settings.variant == Variant::Subdivision;
            (is_exact && settings.virtual_vertex == VirtualVertex::Corrected).then_some(search)
        }
        _ => None,
    })
}

/// How light at mirrors and glass is found.
#[derive(Clone)]
enum Way {
    /// Rays are followed.
    Follow,
    /// Light is looked up in environment maps.
    LookUp(EnvironmentMapSettings),
    /// Light is looked up in light fields.
    Fields(LightFieldSettings),
    /// Light is looked up in layers.
    Layers(LayeredEnvironmentMapSettings),
    /// The scene is mirrored in flat mirrors.
    Mirror(PlanarMirrorSettings),
    /// Geometry is drawn where the processor's method says that it appears.
    /// A device finds that itself where reflectors let it, if a search is given.
    Project(Arc<dyn Method>, Option<Search>),
}

/// The id of the method that looks light up in environment maps.
const ENVIRONMENT_MAP: &str = "environment_map";
/// The id of the one that looks light up in light fields.
const LIGHT_FIELD: &str = "light_field";
/// The id of the one that looks light up in layers.
const LAYERED_MAP: &str = "layered_environment_map";
/// The id of the method that mirrors the scene in flat mirrors.
const PLANAR_MIRROR: &str = "planar_mirror";

/// The ids of the methods whose virtual geometry devices themselves can find.
const REFLECTOR_SEARCH: &str = "reflector_search";
const EXPLOSION_MAP: &str = "explosion_map";

/// The ids of the methods that follow rays; the second one chooses others on the processor.
const MULTIPERSPECTIVE: &str = "multiperspective";
const AUTO: &str = "auto";

/// A method that draws on a device: into pictures of the processor's, as all methods do, or with a
/// [`Renderer`](super::Renderer) into textures.
#[derive(Clone)]
pub struct DeviceMethod {
    context: Arc<Context>,
    info: &'static MethodInfo,
    way: Way,
}

impl std::fmt::Debug for DeviceMethod {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("DeviceMethod").field("id", &self.info.id).finish_non_exhaustive()
    }
}

/// A scene on a device, ready for any view.
pub(crate) struct PreparedScene {
    pub(crate) method: DeviceMethod,
    scene: Arc<Scene>,
    quality: Quality,
    drawn_scene: DrawnScene,
    /// The light fields, where the method looks light up in these.
    fields: Option<LightFields>,
    /// The layers of the views so far.
    layers: Option<LayeredMaps>,
    bake: Option<Arc<dyn Baked>>,
    /// The processor's part of methods that project.
    projection: Option<PreparedProjection>,
    report: Report,
}

/// One view.
pub(crate) struct DeviceFrame<'a> {
    method: &'a DeviceMethod,
    scene: &'a Scene,
    quality: Quality,
    drawn_scene: &'a DrawnScene,
    /// Where the device finds virtual geometry.
    found: Option<Found>,
    projection: Projection<'a>,
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
        Ok(Box::new(self.prepare_scene(scene, quality, bake, progress)?))
    }
}

impl DeviceMethod {
    /// The device that it draws on.
    pub fn context(&self) -> &Arc<Context> {
        &self.context
    }

    pub(crate) fn prepare_scene(
        &self,
        scene: &Arc<Scene>,
        quality: Quality,
        bake: Option<Arc<dyn Baked>>,
        progress: &dyn Progress,
    ) -> Result<PreparedScene, RenderError> {
        if bake.is_some() && !matches!(self.way, Way::Fields(_) | Way::Layers(_) | Way::Project(..)) {
            return Err(self.refuse("on the GPU it uses no baked files"));
        }
        let Loaded { drawn_scene, fields, layers, mut report } =
            self.load(scene, quality, bake.as_ref(), None, progress)?;
        let projection = match &self.way {
            Way::Project(method, _) => Some(method.prepare(scene, quality, bake.clone(), progress)?),
            _ => None,
        };
        report.add(projection.as_ref().map(|projection| projection.report().clone()).unwrap_or_default());
        let projection = projection.map(PreparedProjection::new);
        let (method, scene) = (self.clone(), scene.clone());
        Ok(PreparedScene { method, scene, quality, drawn_scene, fields, layers, bake, projection, report })
    }
}

/// A scene that has been loaded.
struct Loaded {
    drawn_scene: DrawnScene,
    fields: Option<LightFields>,
    layers: Option<LayeredMaps>,
    report: Report,
}

/// The choices that `auto` reports on a device: one method for all mirrors and glass.
fn choices(scene: &Scene) -> Vec<Choice> {
    let choice = |object: u32| Choice {
        object: scene.objects[object as usize].name.clone(),
        method: "multiperspective",
        reason: "the one on the GPU".into(),
    };
    scene.specular_objects().into_iter().map(choice).collect()
}

/// The first property of lobes in a scene that no shader draws, if there is one.
fn undrawn_lobes(scene: &Scene, quality: Quality) -> Option<&'static str> {
    let all = || scene.materials.iter().filter_map(|material| Some((material, material.lobes()?)));
    let any = |has: fn(&Material, &Lobes) -> bool| all().any(|(material, lobes)| has(material, lobes));
    let problems = [
        (
            any(|material, _| material.has_inside()) && bodies_meet(scene),
            "clear bodies that touch each other need the CPU",
        ),
        (any(|_, lobes| lobes.sheen != Vec3::ZERO), "surfaces with a sheen need the CPU"),
        (any(|_, lobes| lobes.anisotropy > 0.0), "brushed surfaces need the CPU"),
        (any(|_, lobes| lobes.film.is_some()), "thin films need the CPU"),
        (any(|_, lobes| lobes.diffuse_transmission > 0.0), "surfaces that scatter light through need the CPU"),
        (any(|_, lobes| lobes.dispersion > 0.0), "glass that disperses light needs the CPU"),
        (
            quality.order == 0 && any(|material, _| material.alpha_mode == AlphaMode::Blend),
            "surfaces that blend need the CPU where paths end at once",
        ),
    ];
    problems.into_iter().find_map(|(is_there, problem)| is_there.then_some(problem))
}

impl DeviceMethod {
    fn refuse(&self, problem: &str) -> RenderError {
        RenderError::Limit { method: self.info.id, problem: problem.into() }
    }

    /// Loads a scene; of another moment of it, if that is given, what holds is kept.
    fn load(
        &self,
        scene: &Arc<Scene>,
        quality: Quality,
        bake: Option<&Arc<dyn Baked>>,
        old: Option<&PreparedScene>,
        progress: &dyn Progress,
    ) -> Result<Loaded, RenderError> {
        let Self { context, info, way } = self;
        let refuse = |error: GpuError| failed(info, &error);
        frame::check_quality(quality).map_err(refuse)?;
        if let Way::Fields(settings) = way {
            match settings {
                LightFieldSettings { transfer: Transfer::Stored, .. } => {
                    return Err(self.refuse("transfer = \"stored\" is for the CPU; on the GPU use \"traced\""));
                }
                LightFieldSettings { layout: Layout::Box, .. } => {
                    return Err(self.refuse("layout = \"box\" is for the CPU; on the GPU use \"slabs\""));
                }
                LightFieldSettings { background: Background::Slabs, .. } => {
                    return Err(self.refuse("background = \"slabs\" is for the CPU; on the GPU use \"scene\""));
                }
                _ => {}
            }
        }
        let follows_lobes = matches!(way, Way::Follow);
        if let Some(problem) = undrawn_lobes(scene, quality).filter(|_| follows_lobes) {
            return Err(self.refuse(problem));
        }
        let mut report = Report::default();
        // Before anything is captured, which takes longer: what cannot be drawn is refused here.
        let stage = Stage::begin(progress, "loading the scene into the GPU", 1)?;
        let watch = Stopwatch::new();
        let mut reflections = match way {
            Way::Mirror(settings) => {
                let (mirrors, of_mirrors) = DeviceMirrors::new(context, scene, settings).map_err(refuse)?;
                report = of_mirrors;
                Reflections::Mirrored(mirrors)
            }
            Way::Project(..) => Reflections::Projected(None),
            // Maps, light fields and layers are captured below.
            Way::Follow | Way::LookUp(_) | Way::Fields(_) | Way::Layers(_) => Reflections::Followed,
        };
        let before = old.map(|old| &old.drawn_scene.resident);
        let shows = |triangle| reflections.show(triangle);
        let narrowed = |features| reflections.narrowed(features);
        let resident = DeviceScene::new(context, scene, before, (shows, follows_lobes), narrowed).map_err(refuse)?;
        let mut bytes = resident.byte_count;
        if let Way::Project(_, Some(search)) = way {
            let on_device = OnDevice::new(context, scene, &resident, *search).map_err(refuse)?;
            reflections = Reflections::Projected(on_device);
        }
        report.stages_ms.push(("upload", watch.elapsed_ms()));
        stage.advance(1)?;
        if let Way::LookUp(settings) = way {
            let (captured, of_maps) = environment_map::capture(settings, scene, quality.order, progress)?;
            let loaded = DeviceMaps::new(context, &captured).map_err(refuse)?;
            let upload = std::mem::replace(&mut report, of_maps);
            report.stages_ms.extend(upload.stages_ms);
            bytes += loaded.byte_count;
            reflections = Reflections::LookedUp(loaded);
        }
        let mut fields = None;
        if let Way::Fields(settings) = way {
            let before = old.and_then(|old| old.fields.as_ref());
            let (captured, of_fields) = LightFields::new(settings, scene, quality, bake, before, progress)?;
            let watch = Stopwatch::new();
            let traces = settings.transfer == Transfer::Traced;
            let before = old.and_then(|old| old.drawn_scene.reflections.fields());
            let loaded = DeviceFields::new(context, scene, &resident, (&captured, traces), before).map_err(refuse)?;
            report.add(of_fields);
            report.stages_ms.push(("upload_fields", watch.elapsed_ms()));
            bytes += loaded.byte_count;
            reflections = Reflections::Fields(loaded);
            fields = Some(captured);
        }
        let mut layers = None;
        if let Way::Layers(settings) = way {
            let made = LayeredMaps::new(settings, scene, quality, bake.cloned(), progress)?;
            report.add(made.report().clone());
            layers = Some(made);
        }
        report.bytes.insert("gpu", bytes);
        if info.id == AUTO {
            report.choices = choices(scene);
        }
        let drawn_scene = DrawnScene::new(resident, reflections, old.map(|old| &old.drawn_scene));
        Ok(Loaded { drawn_scene, fields, layers, report })
    }
}

impl PreparedScene {
    /// Infers the layers that a view looks up, where there are any, and loads them.
    fn load_layers(&mut self, view: &View, progress: &dyn Progress) -> Result<Report, RenderError> {
        let Self { method, scene, drawn_scene: DrawnScene { resident, reflections, .. }, layers, .. } = self;
        let Some(layers) = layers else { return Ok(Report::default()) };
        let mut report = layers.infer(view, progress)?;
        let refuse = |error: GpuError| failed(method.info, &error);
        let watch = Stopwatch::new();
        if let Reflections::Layers(loaded) = reflections {
            loaded.update(&method.context, layers, view).map_err(refuse)?;
        } else {
            let loaded = DeviceLayers::new(&method.context, scene, resident, layers, view).map_err(refuse)?;
            report.bytes.insert("gpu_layers", loaded.byte_count);
            *reflections = Reflections::Layers(Box::new(loaded));
        }
        report.stages_ms.push(("upload_layers", watch.elapsed_ms()));
        Ok(report)
    }
}

impl PreparedScene {
    /// Where vertices appear, if the device finds that.
    pub(crate) fn vertex_appearances(&self, view: &View) -> Result<Option<Vec<VertexAppearance>>, RenderError> {
        let Self { method: DeviceMethod { context, info, .. }, scene, quality, drawn_scene, .. } = self;
        let found = Found::new(context, drawn_scene, scene, view).map_err(|error| failed(info, &error))?;
        let look = |found: Found| frame::vertex_appearances(context, drawn_scene, (scene, view, *quality), &found);
        found.map(look).transpose().map_err(|error| failed(info, &error))
    }

    /// Follows the scene in place.
    fn move_to(&mut self, scene: &Arc<Scene>, moved: &Moved) -> Result<(), RenderError> {
        let DeviceMethod { context, info, .. } = &self.method;
        let watch = Stopwatch::new();
        self.drawn_scene.resident.move_to(context, scene, moved).map_err(|error| failed(info, &error))?;
        let mut report = Report { stages_ms: vec![("upload", watch.elapsed_ms())], ..Report::default() };
        report.bytes.insert("gpu", self.drawn_scene.resident.byte_count);
        if info.id == AUTO {
            report.choices = choices(scene);
        }
        self.report = report;
        Ok(())
    }

    /// One view, ready to be drawn.
    pub(crate) fn device_frame(
        &mut self,
        view: &View,
        progress: &dyn Progress,
    ) -> Result<DeviceFrame<'_>, RenderError> {
        let of_layers = self.load_layers(view, progress)?;
        let Self { method, scene, quality, drawn_scene, projection, .. } = self;
        let found =
            Found::new(&method.context, drawn_scene, scene, view).map_err(|error| failed(method.info, &error))?;
        let mut projection = Projection::new(projection.as_mut());
        if found.is_none() {
            projection.build(view, progress)?;
        }
        let mut report = projection.frame().map(|frame| frame.report().clone()).unwrap_or_default();
        report.add(of_layers);
        let (quality, view) = (*quality, view.clone());
        Ok(DeviceFrame { method, scene, quality, drawn_scene, found, projection, view, report })
    }
}

impl Prepared for PreparedScene {
    fn report(&self) -> &Report {
        &self.report
    }

    fn update(&mut self, scene: &Arc<Scene>, quality: Quality, progress: &dyn Progress) -> Result<(), RenderError> {
        frame::check_quality(quality).map_err(|error| failed(self.method.info, &error))?;
        let changes_in_place = matches!(self.method.way, Way::Follow | Way::Project(..));
        let moved = if changes_in_place { self.drawn_scene.resident.moved_to(scene) } else { None };
        // Steps that may be refused come first, and changes in place last.
        let loaded = match &moved {
            Some(_) => None,
            None => Some(self.method.load(scene, quality, self.bake.as_ref(), Some(self), progress)?),
        };
        let mut of_projection = Report::default();
        if let Some(projection) = &mut self.projection {
            projection.update_later(scene, quality);
            let drawn_scene = loaded.as_ref().map_or(&self.drawn_scene, |loaded| &loaded.drawn_scene);
            if matches!(drawn_scene.reflections, Reflections::Projected(None)) {
                of_projection = projection.updated(progress)?.report().clone();
            }
        }
        if let Some(Loaded { drawn_scene, fields, layers, report }) = loaded {
            (self.drawn_scene, self.fields, self.layers, self.report) = (drawn_scene, fields, layers, report);
        }
        if let Some(moved) = moved {
            self.move_to(scene, &moved)?;
        }
        (self.scene, self.quality) = (scene.clone(), quality);
        self.report.add(of_projection);
        Ok(())
    }

    fn frame<'a>(&'a mut self, view: &View, progress: &dyn Progress) -> Result<Box<dyn Frame + 'a>, RenderError> {
        Ok(Box::new(self.device_frame(view, progress)?))
    }
}

impl DeviceFrame<'_> {
    /// A failure of the device as that of the method.
    pub(crate) fn failed(&self, error: &GpuError) -> RenderError {
        failed(self.method.info, error)
    }

    /// Adds the drawing of the view, which has pixels, to other work.
    pub(crate) fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        timer: &mut Timer,
        progress: &dyn Progress,
    ) -> Result<Drawing, RenderError> {
        let Self { method: DeviceMethod { context, .. }, scene, quality, drawn_scene, found, projection, view, .. } =
            self;
        let lists = projection.frame().filter(|_| found.is_none());
        let lists = lists.map(|frame| frame.path_lists(progress)).transpose()?.flatten();
        let of_lists = lists.as_ref().map(|lists| lists.report.clone());
        let geometry = found.as_ref().map(Geometry::OnDevice).or(lists.as_ref().map(Geometry::Lists));
        let sight = Sight { scene, view, quality: *quality, geometry };
        let drawing = frame::encode(context, drawn_scene, sight, encoder, timer);
        let mut drawing = drawing.map_err(|error| self.failed(&error))?;
        let of_drawing = std::mem::replace(&mut drawing.report, of_lists.unwrap_or_default());
        drawing.report.add(of_drawing);
        Ok(drawing)
    }

    /// Begins to draw the view, which has pixels, and to read it; what is read as bytes is displayed.
    pub(crate) fn begin_reading(
        &self,
        (encoding, display): (Encoding, Display),
        progress: &dyn Progress,
    ) -> Result<Reading, RenderError> {
        let Self { method: DeviceMethod { context, info, .. }, view, .. } = self;
        let context = context.clone();
        let mut encoder = context.device.create_command_encoder(&Default::default());
        let mut timer = Timer::new(&context);
        let drawing = self.encode(&mut encoder, &mut timer, progress)?;
        let watch = Stopwatch::new();
        let mut readback = Readback::default();
        match encoding {
            Encoding::Linear => readback.picture(&context.device, &mut encoder, (drawing.colors(), 16)),
            Encoding::Srgba8 => {
                let picture = drawing.shown(&context, &mut encoder, display);
                readback.picture(&context.device, &mut encoder, (&picture, 4));
            }
        }
        drawing.copy_counts(&context, &mut encoder, &mut readback);
        timer.copy(&context, &mut encoder, &mut readback);
        context.queue.submit([encoder.finish()]);
        readback.begin();
        let size = [view.width, view.height];
        Ok(Reading { context, info, readback, timer, drawing, encoding, size, watch })
    }
}

impl Frame for DeviceFrame<'_> {
    fn report(&self) -> &Report {
        &self.report
    }

    fn draw(&self, target: &mut Framebuffer, progress: &dyn Progress) -> Result<Report, RenderError> {
        let Self { method: DeviceMethod { info, .. }, view, .. } = self;
        let pixels = view.width as usize * view.height as usize;
        if (target.width, target.height) != (view.width, view.height) || target.pixels.len() != pixels {
            let problem = format!("the view has {} x {} pixels, the target others", view.width, view.height);
            return Err(RenderError::Limit { method: info.id, problem });
        }
        if pixels == 0 {
            return Ok(Report::default());
        }
        let stage = Stage::begin(progress, "drawing on the GPU", 1)?;
        let report = self.begin_reading((Encoding::Linear, Display::default()), progress)?.fill(&mut target.pixels)?;
        stage.advance(1)?;
        Ok(report)
    }

    fn projector(&self) -> Option<Box<dyn VertexProjector + '_>> {
        self.projection.frame_of(&self.view).ok()??.projector()
    }

    fn path_search(&self, eye: DVec3, objects: &[u32]) -> Result<Option<Box<dyn PathSearch + '_>>, RenderError> {
        match self.projection.frame_of(&self.view) {
            Err(error) => Err(RenderError::Limit { method: self.method.info.id, problem: error.to_string() }),
            Ok(Some(projection)) => projection.path_search(eye, objects),
            Ok(None) => Ok(None),
        }
    }
}
