//! The program in a window of the desktop.

use catoptric::methods::{self, Quality};
use catoptric_viewer::app::{Start, StudioThread, Viewer};
use catoptric_viewer::studio::Gpu;
use catoptric_viewer::studio::order::Source;
use clap::{Parser, ValueEnum};
use eframe::egui;
use eframe::egui_wgpu::{RenderState, WgpuSetup};
use std::process::ExitCode;
use std::sync::Arc;

/// A scene in a window: drag a mirror ball, and compare methods with the ray-traced truth.
#[derive(Parser)]
#[command(version, max_term_width = 100)]
#[command(after_help = "Examples:\n  catoptric_viewer scene.glb\n  catoptric_viewer builtin:vase --against reference")]
struct Args {
    /// A .glb, .gltf, .obj or .toml file, or builtin:NAME[?key=value&...]
    #[arg(value_name = "SCENE", default_value = "builtin:sphere_room")]
    scene: String,
    /// The method
    #[arg(long, value_name = "ID", default_value = "auto")]
    method: String,
    /// A second method to compare with, in a split view
    #[arg(long, value_name = "ID")]
    against: Option<String>,
    /// A camera of the scene, by name or index
    #[arg(long, value_name = "NAME or INDEX")]
    camera: Option<String>,
    /// Antialiasing samples a pixel
    #[arg(long, value_name = "N", default_value = "4", value_parser = samples)]
    samples: u32,
    /// Highest number of reflections and refractions on a path
    #[arg(long, value_name = "K", default_value = "2", value_parser = clap::value_parser!(u32).range(0..=16))]
    order: u32,
    /// Processor that draws
    #[arg(long, value_enum, default_value = "auto")]
    backend: BackendChoice,
    /// The GPU, by a part of its name [default: the best]
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum BackendChoice {
    /// A real GPU, else the CPU
    Auto,
    Cpu,
    /// A GPU, or a driver that draws on the processor
    Gpu,
}

fn samples(text: &str) -> Result<u32, String> {
    let counts = catoptric::raster::SAMPLE_COUNTS;
    let count = text.parse().ok().filter(|count| counts.contains(count));
    count.ok_or_else(|| format!("allowed are {}", counts.map(|count| count.to_string()).join(", ")))
}

/// Reads the command line and shows the window.
pub(super) fn main() -> ExitCode {
    let args = Args::parse();
    for id in [Some(&args.method), args.against.as_ref()].into_iter().flatten() {
        if let Err(error) = methods::find(id) {
            eprintln!("error: {error}");
            return ExitCode::from(2);
        }
    }
    match run(args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            eprintln!("error: {problem}");
            ExitCode::FAILURE
        }
    }
}

fn run(args: Args) -> Result<(), String> {
    let Args { scene, method, against, camera, samples, order, backend, adapter } = args;
    let start = Start {
        source: Source::of_word(&scene),
        method,
        against,
        quality: Quality { samples, order },
        camera,
        panels: true,
    };
    let mut options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default().with_inner_size([1440.0, 860.0]).with_title("catoptric"),
        ..Default::default()
    };
    if let (Some(name), WgpuSetup::CreateNew(setup)) = (adapter, &mut options.wgpu_options.wgpu_setup) {
        let select = move |adapters: &[wgpu::Adapter], _: Option<&wgpu::Surface<'_>>| named(adapters, &name);
        setup.native_adapter_selector = Some(Arc::new(select));
    }
    let make = move |context: &eframe::CreationContext<'_>| {
        let device = context.wgpu_render_state.clone().filter(|device| draws(backend, device));
        let gpu = device
            .as_ref()
            .map(|RenderState { adapter, device, queue, .. }| Gpu::of_window(adapter, device.clone(), queue.clone()));
        let window = context.egui_ctx.clone();
        let studio = StudioThread::start(gpu.transpose()?, Box::new(move || window.request_repaint()));
        Ok(Box::new(Viewer::new(Box::new(studio), device, start)) as Box<dyn eframe::App>)
    };
    eframe::run_native("catoptric", options, Box::new(make)).map_err(|error| match error {
        eframe::Error::Wgpu(problem) => format!(
            "the window cannot be drawn: {problem}. It needs a graphics driver, if only one that draws on the \
             processor (Debian: apt-get install mesa-vulkan-drivers libvulkan1); `catoptric render` needs none"
        ),
        other => other.to_string(),
    })
}

/// The adapter whose name has a part.
fn named(adapters: &[wgpu::Adapter], name: &str) -> Result<wgpu::Adapter, String> {
    let is_named = |adapter: &&wgpu::Adapter| adapter.get_info().name.to_lowercase().contains(&name.to_lowercase());
    let known = || adapters.iter().map(|adapter| adapter.get_info().name).collect::<Vec<_>>().join(", ");
    let found = adapters.iter().find(is_named).cloned();
    found.ok_or_else(|| format!("--adapter: no adapter is named `{name}`; there are: {}", known()))
}

/// Whether the window's device is to draw the scene: of itself, only a real GPU does.
fn draws(backend: BackendChoice, device: &RenderState) -> bool {
    match backend {
        BackendChoice::Cpu => false,
        BackendChoice::Gpu => true,
        BackendChoice::Auto => device.adapter.get_info().device_type != wgpu::DeviceType::Cpu,
    }
}
