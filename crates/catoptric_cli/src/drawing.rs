//! Draws the frames of one method and takes their times.

use crate::args::{DrawArgs, Motion, SceneArgs, Sequence, Shadows, ViewArgs, turn_about};
use crate::backend::{Gpu, processor};
use crate::baked;
use crate::failure::{Failure, memory};
use crate::parse::Order;
use crate::scene_source;
use crate::settings::{self, Chosen};
use catoptric::framebuffer::Framebuffer;
use catoptric::methods::budget::Budgeted;
use catoptric::methods::{self, Choice, Method, MethodInfo, Prepared, Quality, Report};
use catoptric::progress::{Progress, Silent, Stage};
use catoptric::raster::SAMPLE_COUNTS;
use catoptric::scene::roles::RoleRule;
use catoptric::scene::{Camera, Model, PoseMemory, Projection, Scene, View};
use catoptric_bake::Shelf;
use catoptric_options::DEFAULT_FOV_DEG;
use clap::ArgMatches;
use glam::{DVec3, Vec3};
use std::collections::BTreeMap;
use std::f32::consts::TAU;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Instant;
use toml::Table;

const ORBIT_STEP_DEG: f32 = 1.0;
/// The reference's time is estimated by a picture so many times smaller in both directions.
const ESTIMATE_SCALE: u32 = 8;

/// Roles over the scene's own, whether its lights cast shadows, and the time of the first frame.
pub(crate) type Moment = (Vec<RoleRule>, Shadows, f32);

/// The scene, quality and frames to be drawn, the same for every method.
pub(crate) struct Shot<'a> {
    pub(crate) model: Model,
    /// The scene of the first frame.
    pub(crate) scene: Arc<Scene>,
    pub(crate) quality: Quality,
    pub(crate) frames: u32,
    pub(crate) motion: Motion,
    pub(crate) sequence: Sequence,
    pub(crate) budget_ms: Option<u32>,
    /// Times of loading, before any method.
    pub(crate) setup_ms: Vec<(String, f64)>,
    pub(crate) bakes: Shelf,
    pub(crate) gpu: Option<Gpu>,
    roles: Vec<RoleRule>,
    shadows: Shadows,
    time: f32,
    view: &'a ViewArgs,
}

/// Takes a frame that has been drawn, by its number from 0, and tells whether to go on.
pub(crate) type Taker<'t> = dyn FnMut(u32, &Drawing) -> Result<ControlFlow<()>, Failure> + 't;

/// The result of drawing with one method.
pub(crate) struct Drawing {
    /// The last frame.
    pub(crate) picture: Framebuffer,
    /// The view of the last frame.
    pub(crate) view: View,
    /// The scene of the last frame.
    pub(crate) scene: Arc<Scene>,
    /// The method, prepared for that scene.
    pub(crate) prepared: Box<dyn Prepared>,
    pub(crate) processor: Processor,
    pub(crate) setup_ms: Vec<(String, f64)>,
    pub(crate) frame_ms: Vec<f64>,
    /// Times of each stage, frame by frame, in order.
    pub(crate) stages_ms: Vec<(String, Vec<f64>)>,
    /// Times of the first frame's stages.
    pub(crate) first_stages_ms: Vec<(String, f64)>,
    /// Counts of the last frame and of the preparation.
    pub(crate) counts: BTreeMap<&'static str, u64>,
    pub(crate) fallbacks: BTreeMap<&'static str, u64>,
    pub(crate) bytes: BTreeMap<&'static str, u64>,
    pub(crate) warnings: Vec<String>,
    /// Ways to draw reflectors that the method has chosen.
    pub(crate) choices: Vec<Choice>,
    /// The largest error of accepted approximations of the last frame, in pixels.
    pub(crate) error_px: Option<f64>,
    /// The standard error of a pixel of the last frame by sampling.
    pub(crate) noise: Option<f64>,
}

/// The processor that has drawn.
#[derive(Clone, Debug)]
pub(crate) struct Processor {
    /// `cpu` or `gpu`.
    pub(crate) backend: &'static str,
    /// The processor's name.
    pub(crate) device: String,
}

impl Processor {
    fn cpu() -> Self {
        Self { backend: "cpu", device: processor() }
    }
}

/// Refuses numbers of samples that a method cannot take.
pub(crate) fn check_samples(samples: u32, method: &MethodInfo) -> Result<(), Failure> {
    let counts: Vec<String> = SAMPLE_COUNTS.iter().map(ToString::to_string).collect();
    method.check_samples(samples).map_err(|_| {
        let (id, counts) = (method.id, counts.join(", "));
        Failure::usage(format!("--samples {samples}: method `{id}` takes {counts}; `reference` takes any number"))
    })
}

impl<'a> Shot<'a> {
    pub(crate) fn load(
        args: &SceneArgs,
        options: &ArgMatches,
        view: &'a ViewArgs,
        draw: &DrawArgs,
        sequence: impl Into<Sequence>,
        progress: &dyn Progress,
    ) -> Result<Self, Failure> {
        let sequence = sequence.into();
        if view.eye.is_some() && view.eye == view.target {
            return Err(Failure::usage("--eye and --target are the same point: move one of them"));
        }
        memory::check_picture(view.size)?;
        let gpu = Gpu::open(draw)?;
        let start = Instant::now();
        let bakes = baked::open(&draw.baked)?;
        let bake_open_ms = milliseconds(start);
        let roles = scene_source::roles(args, options)?;
        let start = Instant::now();
        let mut model = scene_source::load(&args.scene, &args.pose.choice, &args.environment, !roles.is_empty())?;
        scene_source::check_strictly(draw, &model)?;
        let remark = scene_source::remark_on_glass(draw, &mut model);
        model.warnings.extend(remark);
        scene_source::choose_glass(draw, &mut model);
        scene_source::choose_animation(&args.pose.choice, &mut model)?;
        model.ends_in_environment = draw.order == Order::Auto;
        let load_ms = milliseconds(start);
        let start = Instant::now();
        let moment = (roles, args.shadows, args.pose.time);
        // The order is known once the scene is.
        let quality = Quality { samples: draw.samples, order: 0 };
        let plays = sequence.plays_animation && !model.animations.is_empty();
        let motion = if plays { Motion::Animation } else { draw.motion };
        let mut shot = Self::of(model, moment, (view, motion, sequence), quality, bakes, progress)?;
        shot.quality.order = match draw.order {
            Order::Exact(order) => order,
            // Bakes have order 2 where none is named.
            Order::Auto if !draw.baked.is_empty() => 2,
            Order::Auto => shot.scene.order_needed(),
        };
        scene_source::remark_on_bodies(&mut shot.model, &shot.scene);
        let remark = scene_source::remark_on_time(&shot.model, args.pose.time);
        shot.model.warnings.extend(remark);
        let mut setup_ms = vec![("load".into(), load_ms), ("pose".into(), milliseconds(start))];
        if !draw.baked.is_empty() {
            setup_ms.push(("bake_open".into(), bake_open_ms));
        }
        Ok(Self { budget_ms: draw.budget_ms, setup_ms, gpu, ..shot })
    }

    /// A shot of a scene that is known already, without times.
    pub(crate) fn of(
        model: Model,
        (roles, shadows, time): Moment,
        (view, motion, sequence): (&'a ViewArgs, Motion, Sequence),
        quality: Quality,
        bakes: Shelf,
        progress: &dyn Progress,
    ) -> Result<Self, Failure> {
        let first_time = if motion == Motion::Animation { sequence.time_of(sequence.first, time) } else { time };
        let scene = Arc::new(scene_source::pose(&model, first_time, &roles, shadows, None, progress)?);
        let shot = Self {
            model,
            scene,
            quality,
            frames: sequence.count,
            motion,
            sequence,
            budget_ms: None,
            setup_ms: Vec::new(),
            bakes,
            gpu: None,
            roles,
            shadows,
            time,
            view,
        };
        // A camera that does not exist is found before any work.
        shot.frame_view(&shot.scene, sequence.first)?;
        Ok(shot)
    }

    /// The method with this id, with the scene's settings and `given` over them; settings that neither gives are those
    /// of the method's bake.
    pub(crate) fn choose(&self, id: &str, given: &Table) -> Result<Chosen, Failure> {
        let info = methods::find(id).map_err(Failure::usage)?;
        let settings = settings::merged(info, &self.model, given);
        let choice = self.bakes.choose(info, &settings, &self.scene, self.quality);
        settings::made_of(info, choice.map_err(Failure::usage)?)
    }

    /// From now on the eye sees black where nothing stands before it.
    pub(crate) fn hide_background(&mut self) {
        self.model.backdrop = Some(Vec3::ZERO);
        Arc::make_mut(&mut self.scene).backdrop = Some(Vec3::ZERO);
    }

    /// The scene of a frame.
    pub(crate) fn scene_of_frame(&self, frame: u32) -> Result<Arc<Scene>, Failure> {
        match self.motion {
            Motion::None | Motion::Eye => Ok(self.scene.clone()),
            Motion::Animation => {
                let time = self.sequence.time_of(frame, self.time);
                let scene = scene_source::pose(&self.model, time, &self.roles, self.shadows, None, &Silent)?;
                Ok(Arc::new(scene))
            }
        }
    }

    /// A frame by itself, whatever was drawn before: on the CPU, so many times smaller in both directions.
    pub(crate) fn draw_frame(
        &self,
        chosen: &Chosen,
        frame: u32,
        smaller: u32,
        progress: &dyn Progress,
    ) -> Result<Framebuffer, Failure> {
        if let Some(unfit) = &chosen.unfit {
            return Err(Failure::input(unfit));
        }
        let scene = self.scene_of_frame(frame)?;
        let mut view = self.frame_view(&scene, frame)?;
        (view.width, view.height) = ((view.width / smaller).max(1), (view.height / smaller).max(1));
        let mut prepared = chosen.method.prepare(&scene, self.quality, chosen.bake.clone(), progress)?;
        let mut picture = Framebuffer::new(view.width, view.height);
        prepared.frame(&view, progress)?.draw(&mut picture, progress)?;
        Ok(picture)
    }

    /// Prepares the method and draws all frames, within the budget if there is one.
    pub(crate) fn draw(&self, chosen: &Chosen, progress: &dyn Progress) -> Result<Drawing, Failure> {
        self.draw_frames(chosen, None, progress)
    }

    /// The same; each frame is given to `take` when it is there, and progress is that of all frames.
    pub(crate) fn draw_each(
        &self,
        chosen: &Chosen,
        take: &mut Taker<'_>,
        progress: &dyn Progress,
    ) -> Result<Drawing, Failure> {
        self.draw_frames(chosen, Some(take), progress)
    }

    fn draw_frames(
        &self,
        chosen: &Chosen,
        mut take: Option<&mut Taker<'_>>,
        progress: &dyn Progress,
    ) -> Result<Drawing, Failure> {
        if let Some(gpu) = &self.gpu
            && let Some(method) = gpu.method(chosen)?
        {
            let on_gpu = Processor { backend: "gpu", device: gpu.name() };
            let mut are_some_taken = false;
            let mut take_noted = take.as_mut().map(|take| {
                |frame: u32, drawing: &Drawing| {
                    are_some_taken = true;
                    take(frame, drawing)
                }
            });
            let noted = take_noted.as_mut().map(|take| take as &mut Taker<'_>);
            match self.draw_with(&*method, on_gpu, (chosen, noted), progress) {
                // Only the CPU can draw this.
                Err(Failure::Input(problem)) if !gpu.is_wanted && !are_some_taken => {
                    let mut drawing = self.draw_on_cpu(chosen, take, progress)?;
                    drawing.warnings.push(format!("drawn on the CPU: {problem}"));
                    return Ok(drawing);
                }
                drawn => return drawn,
            }
        }
        self.draw_on_cpu(chosen, take, progress)
    }

    fn draw_on_cpu(
        &self,
        chosen: &Chosen,
        take: Option<&mut Taker<'_>>,
        progress: &dyn Progress,
    ) -> Result<Drawing, Failure> {
        let budgeted = self.budget_ms.map(|budget_ms| Budgeted::new(&*chosen.method, budget_ms.into()));
        let method = budgeted.as_ref().map_or(&*chosen.method, |budgeted| budgeted as &dyn Method);
        self.draw_with(method, Processor::cpu(), (chosen, take), progress)
    }

    /// The same on the CPU and without any budget.
    pub(crate) fn draw_whole(&self, chosen: &Chosen, progress: &dyn Progress) -> Result<Drawing, Failure> {
        self.draw_with(&*chosen.method, Processor::cpu(), (chosen, None), progress)
    }

    fn draw_with(
        &self,
        method: &dyn Method,
        processor: Processor,
        (chosen, mut take): (&Chosen, Option<&mut Taker<'_>>),
        progress: &dyn Progress,
    ) -> Result<Drawing, Failure> {
        if let Some(unfit) = &chosen.unfit {
            return Err(Failure::input(unfit));
        }
        let prepared = method.prepare(&self.scene, self.quality, chosen.bake.clone(), progress)?;
        let mut setup_ms = self.setup_ms.clone();
        setup_ms.extend(prepared.report().stages_ms.iter().map(|(name, time)| ((*name).to_owned(), *time)));
        let [width, height] = self.view.size;
        let mut drawing = Drawing {
            picture: Framebuffer::new(width, height),
            view: self.frame_view(&self.scene, self.sequence.first)?,
            scene: self.scene.clone(),
            prepared,
            processor,
            setup_ms,
            frame_ms: Vec::with_capacity(self.frames as usize),
            stages_ms: Vec::new(),
            first_stages_ms: Vec::new(),
            counts: BTreeMap::new(),
            fallbacks: BTreeMap::new(),
            bytes: BTreeMap::new(),
            warnings: Vec::new(),
            choices: Vec::new(),
            error_px: None,
            noise: None,
        };
        drawing.note(&drawing.prepared.report().clone());
        let mut memory = PoseMemory::default();
        let stage = take.is_some().then(|| Stage::begin(progress, "frames", self.frames as usize)).transpose()?;
        let progress = if take.is_some() { &Silent as &dyn Progress } else { progress };
        for frame in self.sequence.frames() {
            let start = Instant::now();
            let mut stages = Vec::new();
            if self.motion == Motion::Animation {
                let time = self.sequence.time_of(frame, self.time);
                let before = Some((&*drawing.scene, &mut memory));
                let scene = scene_source::pose(&self.model, time, &self.roles, self.shadows, before, progress)?;
                stages.push(("pose", milliseconds(start)));
                drawing.scene = Arc::new(scene);
                drawing.prepared.update(&drawing.scene, self.quality, progress)?;
                let report = drawing.prepared.report().clone();
                stages.extend(report.stages_ms.iter().copied());
                drawing.note(&report);
            }
            drawing.view = self.frame_view(&drawing.scene, frame)?;
            let built = drawing.prepared.frame(&drawing.view, progress)?;
            let mut report = built.report().clone();
            report.add(built.draw(&mut drawing.picture, progress)?);
            drop(built);
            drawing.frame_ms.push(milliseconds(start));
            stages.extend(report.stages_ms.iter().copied());
            drawing.note(&report);
            drawing.note_stages(&stages);
            if let Some(take) = &mut take
                && take(frame, &drawing)?.is_break()
            {
                break;
            }
            if let Some(stage) = &stage {
                stage.advance(1)?;
            }
        }
        Ok(drawing)
    }

    /// The time in milliseconds that the reference would take for a frame, about: from a small picture of it.
    pub(crate) fn reference_ms(&self, progress: &dyn Progress) -> Result<f64, Failure> {
        let mut view = self.frame_view(&self.scene, self.sequence.first)?;
        let pixels = f64::from(view.width) * f64::from(view.height);
        (view.width, view.height) = ((view.width / ESTIMATE_SCALE).max(1), (view.height / ESTIMATE_SCALE).max(1));
        let method = methods::create("reference", &Table::new())?;
        let mut prepared = method.prepare(&self.scene, self.quality, None, progress)?;
        let mut picture = Framebuffer::new(view.width, view.height);
        let start = Instant::now();
        prepared.frame(&view, progress)?.draw(&mut picture, progress)?;
        Ok(milliseconds(start) * pixels / (f64::from(view.width) * f64::from(view.height)))
    }

    /// The view of a frame.
    pub(crate) fn frame_view(&self, scene: &Scene, frame: u32) -> Result<View, Failure> {
        let [width, height] = self.view.size;
        let up = self.view.up.and_then(Vec3::try_normalize).unwrap_or(Vec3::Y);
        let is_placed = self.view.eye.is_some() || self.view.camera.is_some();
        let mut camera = match self.sequence.turn {
            Some(_) if !is_placed => scene.framing_all_round(width as f32 / height as f32, self.view.fov),
            _ => camera(self.view, scene)?,
        };
        if let Some(count) = self.sequence.turn {
            let angle = TAU * frame as f32 / count as f32;
            let turn = turn_about(scene.bounds.center(), up, angle);
            camera.world_from_camera = turn * camera.world_from_camera;
        } else if self.motion == Motion::Eye {
            let angle = (frame as f32 * ORBIT_STEP_DEG).to_radians();
            let target = self.view.target.map(|target| (target - scene.origin).as_vec3());
            let pivot = target.unwrap_or_else(|| camera.point_looked_at(&scene.bounds));
            camera.world_from_camera = turn_about(pivot, up, angle) * camera.world_from_camera;
        }
        Ok(scene.view(&camera, width, height))
    }
}

impl Drawing {
    fn note(&mut self, report: &Report) {
        self.counts.extend(&report.counts);
        self.fallbacks.extend(&report.fallbacks);
        self.bytes.extend(&report.bytes);
        if !report.choices.is_empty() {
            self.choices.clone_from(&report.choices);
        }
        self.error_px = report.error_px.or(self.error_px);
        self.noise = report.noise.or(self.noise);
        for warning in &report.warnings {
            if !self.warnings.contains(warning) {
                self.warnings.push(warning.clone());
            }
        }
    }

    fn note_stages(&mut self, stages: &[(&'static str, f64)]) {
        let mut frame: Vec<(&str, f64)> = Vec::new();
        for (name, time) in stages {
            match frame.iter_mut().find(|(known, _)| known == name) {
                Some((_, sum)) => *sum += time,
                None => frame.push((name, *time)),
            }
        }
        if self.stages_ms.is_empty() {
            self.first_stages_ms = frame.iter().map(|(name, time)| ((*name).to_owned(), *time)).collect();
        }
        for (name, time) in frame {
            match self.stages_ms.iter_mut().find(|(known, _)| known == name) {
                Some((_, times)) => times.push(time),
                None => self.stages_ms.push((name.into(), vec![time])),
            }
        }
    }
}

/// The camera that the options name.
pub(crate) fn camera(args: &ViewArgs, scene: &Scene) -> Result<Camera, Failure> {
    if let Some(eye) = args.eye {
        let up = args.up.unwrap_or(Vec3::Y);
        let about_origin = |point: DVec3| (point - scene.origin).as_vec3();
        let (eye, target) = (about_origin(eye), args.target.map_or(scene.bounds.center(), about_origin));
        return Ok(Camera::look_at("command line", eye, target, up, args.fov.unwrap_or(DEFAULT_FOV_DEG)));
    }
    let [width, height] = args.size;
    let mut camera = scene.camera(args.camera.as_deref(), width as f32 / height as f32).map_err(|error| {
        let remedy = match scene.cameras.is_empty() {
            true => "the file has no camera: leave --camera out, or give --eye and --target".into(),
            false => error.to_string(),
        };
        Failure::input(format!("{}: --camera: {remedy}", scene.name))
    })?;
    if let Some(degrees) = args.fov {
        match &mut camera.projection {
            Projection::Perspective { fov_y } => *fov_y = degrees.to_radians(),
            Projection::Orthographic { .. } => {
                let problem = format!(
                    "{}: --fov: camera `{}` is orthographic and has no field of view; leave --fov out, or give --eye \
                     and --target",
                    scene.name, camera.name
                );
                return Err(Failure::input(problem));
            }
        }
    }
    Ok(camera)
}

fn milliseconds(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e3
}
