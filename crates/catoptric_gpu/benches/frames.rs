//! Frames a second into a texture, without reading back, as a window draws them; with the times of stages by the
//! device's clock, and the error beside them.
//!
//! ```sh
//! cargo bench -p catoptric_gpu --features wgpu --bench frames -- vase car --method multiperspective --size 1440x960
//! ```

use catoptric::framebuffer::Framebuffer;
use catoptric::light::visibility::{cast_shadows, cast_shadows_as};
use catoptric::methods::{self, Method, Quality};
use catoptric::progress::Silent;
use catoptric::scene::model::Model;
use catoptric::scene::{PoseMemory, PoseOptions, Scene, View};
use catoptric_gpu::{Context, Renderer};
use catoptric_scenes::{builtin, import};
use catoptric_testkit::scenes::moved;
use clap::{Parser, ValueEnum};
use glam::{Affine3A, Quat, Vec3};
use std::error::Error;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;
/// Frames a second of animations.
const FRAMES_PER_SECOND: f32 = 60.0;
/// How far the eye swings to either side, seen from what it looks at.
const SWING_DEG: f32 = 10.0;
/// Pixels are wrong where a channel is off by more.
const WRONG: f32 = 0.1;

/// Frames a second of the device, by scene and method.
#[derive(Parser)]
struct Arguments {
    /// Built-in scenes with their parameters (`vase?tess=256`), or files.
    #[arg(default_values_t = ["sphere_room".to_owned(), "vase".to_owned(), "dish".to_owned()])]
    scenes: Vec<String>,
    /// Methods.
    #[arg(long, value_delimiter = ',', default_values_t = ["multiperspective".to_owned()])]
    method: Vec<String>,
    /// Settings of the method, as TOML.
    #[arg(long, default_value = "")]
    set: String,
    /// Width and height.
    #[arg(long, default_value = "1440x960")]
    size: String,
    #[arg(long, default_value_t = 4)]
    samples: u32,
    #[arg(long, default_value_t = 2)]
    order: u32,
    /// Frames that are timed.
    #[arg(long, default_value_t = 100)]
    frames: u32,
    /// Frames before these.
    #[arg(long, default_value_t = 60)]
    warm_up: u32,
    /// The things that move beside the eye.
    #[arg(long, value_enum, default_value_t = Motion::Eye)]
    motion: Motion,
    /// A part of the adapter's name.
    #[arg(long)]
    adapter: Option<String>,
    /// Compares a picture of a quarter of the size with the reference.
    #[arg(long)]
    error: bool,
    /// Passed by `cargo bench`; ignored.
    #[arg(long, hide = true)]
    bench: bool,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Motion {
    /// Nothing.
    Eye,
    /// Nodes that the scene's animations move.
    Animation,
    /// Every node.
    Everything,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    let context = Context::new(arguments.adapter.as_deref())?;
    say(context.adapter().map_or("", |adapter| &adapter.name));
    for scene in &arguments.scenes {
        for method in &arguments.method {
            if let Err(error) = measure(&context, scene, method, &arguments) {
                say(&format!("{scene} {method}: {error}"));
            }
        }
    }
    Ok(())
}

fn say(line: &str) {
    let mut out = std::io::stdout().lock();
    // Nobody reads on if this fails.
    let _ = std::io::Write::write_fmt(&mut out, format_args!("{line}\n"));
}

fn measure(context: &Arc<Context>, name: &str, id: &str, arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let size = arguments.size.split_once('x').ok_or("--size: width and height, as 1440x960")?;
    let size = [size.0.parse::<u32>()?, size.1.parse::<u32>()?];
    let quality = Quality { samples: arguments.samples, order: arguments.order };
    let model = match Path::new(name).exists() {
        true => import::load(Path::new(name))?,
        false => builtin::parse(name)?,
    };
    let mut memory = PoseMemory::default();
    let scene = pose(&model, 0.0, None, &mut memory)?;
    let settings = arguments.set.parse::<toml::Table>()?;
    let method = catoptric_gpu::create(context, id, &settings)?.ok_or("it draws on the processor alone")?;
    let start = Instant::now();
    let renderer = Renderer::new(&method, &scene, quality, None, &Silent)?;
    let loading_ms = milliseconds(start);
    let times = Film { model, memory, scene: scene.clone(), size, quality, renderer }.times(context, arguments)?;
    let (stages, counts) = stages(&method, &scene, size, quality)?;
    say(&format!(
        "{name} {id} {}x{} {} samples order {}: {times}; loading {loading_ms:.0} ms",
        size[0], size[1], quality.samples, quality.order,
    ));
    say(&format!("    {stages}; {counts}"));
    if arguments.error {
        say(&format!("    {}", error(&method, id, &settings, &scene, size, quality)?));
    }
    Ok(())
}

/// A scene that is drawn again and again.
struct Film {
    model: Model,
    memory: PoseMemory,
    scene: Arc<Scene>,
    size: [u32; 2],
    quality: Quality,
    renderer: Renderer,
}

impl Film {
    /// Submits a frame, and says how long the processor took.
    fn frame(&mut self, context: &Context, number: u32, target: &wgpu::TextureView) -> Result<f64, Box<dyn Error>> {
        let start = Instant::now();
        let mut encoder = context.device().create_command_encoder(&Default::default());
        let view = view(&self.scene, self.size, number);
        self.renderer.draw(&mut encoder, &view, (target, FORMAT), &Silent)?;
        context.queue().submit([encoder.finish()]);
        Ok(milliseconds(start))
    }

    /// Moves what moves, and says how long it took to pose the scene and to bring the device's there.
    fn advance(&mut self, number: u32, motion: Motion) -> Result<[f64; 2], Box<dyn Error>> {
        let start = Instant::now();
        match motion {
            Motion::Eye => return Ok([0.0; 2]),
            Motion::Animation => {}
            Motion::Everything => move_all(&mut self.model, number),
        }
        self.scene = pose(&self.model, number as f32 / FRAMES_PER_SECOND, Some(&self.scene), &mut self.memory)?;
        let pose_ms = milliseconds(start);
        self.renderer.update(&self.scene, self.quality, &Silent)?;
        Ok([pose_ms, milliseconds(start) - pose_ms])
    }

    /// The times of its frames, as text.
    fn times(mut self, context: &Context, arguments: &Arguments) -> Result<String, Box<dyn Error>> {
        let target = target(context.device(), self.size);
        let start = Instant::now();
        self.frame(context, 0, &target)?;
        wait(context)?;
        let first_ms = milliseconds(start);
        // Drivers may go on optimising a shader for a while.
        for number in 0..arguments.warm_up {
            self.frame(context, number, &target)?;
            wait(context)?;
        }
        let (mut frame_ms, mut processor_ms, mut moving_ms) = (Vec::new(), 0.0, [0.0; 2]);
        let mut before: Option<wgpu::SubmissionIndex> = None;
        let start = Instant::now();
        let mut last = start;
        for number in 1..=arguments.frames {
            let moved = self.advance(number, arguments.motion)?;
            moving_ms = [moving_ms[0] + moved[0], moving_ms[1] + moved[1]];
            processor_ms += self.frame(context, number, &target)?;
            // No more than two frames are on the way, as in a window.
            if let Some(submission_index) = before.replace(context.queue().submit([])) {
                let waiting = wgpu::PollType::Wait { submission_index: Some(submission_index), timeout: None };
                context.device().poll(waiting)?;
            }
            frame_ms.push(milliseconds(last));
            last = Instant::now();
        }
        wait(context)?;
        let frames = f64::from(arguments.frames.max(1));
        let wall_ms = milliseconds(start) / frames;
        frame_ms.sort_by(f64::total_cmp);
        let at =
            |share: usize| frame_ms.get((frame_ms.len() * share / 100).min(frame_ms.len().saturating_sub(1))).copied();
        let [late, slowest] = [95, 100].map(|share| at(share).unwrap_or_default());
        Ok(format!(
            "{:.0} fps ({wall_ms:.2} ms, 95 % within {late:.2}, all within {slowest:.2}); processor {:.2} ms a frame, \
             pose {:.2} ms, update {:.2} ms; first frame {first_ms:.0} ms",
            1e3 / wall_ms,
            processor_ms / frames,
            moving_ms[0] / frames,
            moving_ms[1] / frames,
        ))
    }
}

/// The median and the longest time of each stage in frames of the whole swing, by the device's clock, and counts of the
/// slowest of them.
fn stages(
    method: &dyn Method,
    scene: &Arc<Scene>,
    size: [u32; 2],
    quality: Quality,
) -> Result<(String, String), Box<dyn Error>> {
    const FRAMES: u32 = 12;
    let mut prepared = method.prepare(scene, quality, None, &Silent)?;
    let mut stages: Vec<(&str, Vec<f64>)> = Vec::new();
    let mut picture = Framebuffer::new(size[0], size[1]);
    let (mut counts, mut slowest) = (String::new(), 0.0);
    for number in 0..FRAMES {
        // All around the circle of the sine.
        let built = prepared.frame(&view(scene, size, number * 11), &Silent)?;
        let mut report = built.report().clone();
        report.add(built.draw(&mut picture, &Silent)?);
        for (stage, time) in &report.stages_ms {
            match stages.iter_mut().find(|(known, _)| known == stage) {
                Some((_, times)) => times.push(*time),
                None => stages.push((stage, vec![*time])),
            }
        }
        let of_device = |(stage, _): &&(&str, f64)| *stage != "gpu";
        let whole: f64 = report.stages_ms.iter().filter(of_device).map(|(_, time)| time).sum();
        if whole > slowest {
            slowest = whole;
            counts = report.counts.iter().map(|(name, count)| format!("{name} {count}, ")).collect();
        }
    }
    let median = |(stage, times): &mut (&str, Vec<f64>)| {
        times.sort_by(f64::total_cmp);
        format!("{stage} {:.3} to {:.3}", times[times.len() / 2], times[times.len() - 1])
    };
    Ok((stages.iter_mut().map(median).collect::<Vec<_>>().join(", "), counts))
}

/// How far a smaller picture is from the reference, beside the processor's.
fn error(
    method: &dyn Method,
    id: &str,
    settings: &toml::Table,
    scene: &Arc<Scene>,
    size: [u32; 2],
    quality: Quality,
) -> Result<String, Box<dyn Error>> {
    let size = size.map(|side| (side / 4).max(1));
    let draw = |method: &dyn Method| -> Result<Framebuffer, Box<dyn Error>> {
        let mut picture = Framebuffer::new(size[0], size[1]);
        let mut prepared = method.prepare(scene, quality, None, &Silent)?;
        prepared.frame(&view(scene, size, 0), &Silent)?.draw(&mut picture, &Silent)?;
        Ok(picture)
    };
    let truth = draw(&*methods::create("reference", &toml::Table::new())?)?;
    let share = |picture: &Framebuffer, other: &Framebuffer| {
        let is_right = |(a, b): &(&[f32; 4], &[f32; 4])| (0..3).all(|channel| (a[channel] - b[channel]).abs() <= WRONG);
        let right = picture.pixels.iter().zip(&other.pixels).filter(is_right).count();
        100.0 * (picture.pixels.len() - right) as f64 / picture.pixels.len() as f64
    };
    let (device, processor) = (draw(method)?, draw(&*methods::create(id, settings)?)?);
    Ok(format!(
        "off by more than {WRONG}: {:.4} % from the reference (processor {:.4} %), {:.4} % from the processor",
        share(&device, &truth),
        share(&processor, &truth),
        share(&device, &processor),
    ))
}

fn pose(
    model: &Model,
    time: f32,
    before: Option<&Scene>,
    memory: &mut PoseMemory,
) -> Result<Arc<Scene>, Box<dyn Error>> {
    let mut scene = model.pose_again(&PoseOptions { time, ..PoseOptions::default() }, memory)?;
    match before {
        Some(before) => cast_shadows_as(before, &mut scene),
        None => cast_shadows(&mut scene),
    }
    Ok(Arc::new(scene))
}

/// Moves every node a little to and fro.
fn move_all(model: &mut Model, number: u32) {
    for (index, node) in model.nodes.iter_mut().enumerate() {
        let angle = 0.1 * number as f32 + index as f32;
        let step = Vec3::new(angle.sin(), 0.0, angle.cos()) * 0.001;
        node.local = moved(&node.local, step);
    }
}

/// The view of a frame: the eye swings about the point that the camera looks at.
fn view(scene: &Scene, [width, height]: [u32; 2], number: u32) -> View {
    let mut view = scene.default_view(width, height);
    let (eye, forward) = (view.eye(), -Vec3::from(view.world_from_view.matrix3.z_axis));
    let depth = (scene.bounds.center() - eye).dot(forward);
    let pivot = eye + forward * if depth > 0.0 { depth } else { scene.bounds.diagonal() };
    let angle = SWING_DEG.to_radians() * (0.05 * number as f32).sin();
    let turn = Affine3A::from_translation(pivot)
        * Affine3A::from_quat(Quat::from_axis_angle(Vec3::Y, angle))
        * Affine3A::from_translation(-pivot);
    view.world_from_view = turn * view.world_from_view;
    view
}

fn target(device: &wgpu::Device, [width, height]: [u32; 2]) -> wgpu::TextureView {
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("picture"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: FORMAT,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    texture.create_view(&Default::default())
}

fn wait(context: &Context) -> Result<(), Box<dyn Error>> {
    context.device().poll(wgpu::PollType::wait_indefinitely())?;
    Ok(context.check()?)
}

fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}
