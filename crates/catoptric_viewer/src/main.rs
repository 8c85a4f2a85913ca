//! The program `catoptric_viewer`: a scene in a window.

use catoptric::methods::{self, Quality};
use catoptric_viewer::app::{Link, Start, Viewer};
use catoptric_viewer::studio::order::Source;
use catoptric_viewer::studio::{Backend, Gpu};
use clap::{Parser, ValueEnum};
use eframe::egui;
use std::process::ExitCode;

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

fn main() -> ExitCode {
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
    let backend = match (args.backend, args.adapter) {
        (BackendChoice::Cpu, _) => Backend::Cpu,
        (BackendChoice::Gpu, name) => Backend::Gpu(name),
        (BackendChoice::Auto, Some(name)) => Backend::Gpu(Some(name)),
        (BackendChoice::Auto, None) => Backend::Auto,
    };
    let gpu = Gpu::open(&backend).map_err(|error| format!("--backend gpu: {error}"))?;
    let start = Start {
        source: Source::of_word(&args.scene),
        method: args.method,
        against: args.against,
        quality: Quality { samples: args.samples, order: args.order },
        camera: args.camera,
    };
    let options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default().with_inner_size([1440.0, 860.0]).with_title("catoptric"),
        ..Default::default()
    };
    let make = move |context: &eframe::CreationContext<'_>| {
        let window = context.egui_ctx.clone();
        let link = Link::start(gpu, Box::new(move || window.request_repaint()));
        Ok(Box::new(Viewer::new(link, start)) as Box<dyn eframe::App>)
    };
    eframe::run_native("catoptric", options, Box::new(make)).map_err(|error| error.to_string())
}
