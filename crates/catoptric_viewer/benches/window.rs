//! The time of a frame of the window where the processor draws it: 1280 x 720 pixels with all panels, once with a
//! picture of as many pixels as the window shows and once with a draft.
//!
//! ```sh
//! cargo bench -p catoptric_viewer --bench window
//! ```

#![expect(clippy::print_stdout, reason = "a bench prints")]

use catoptric_viewer::app::{Start, StudioThread, Viewer};
use catoptric_viewer::studio::order::Source;
use egui::epaint::{ImageDelta, Primitive};
use egui::{ClippedPrimitive, Color32, ColorImage, Context, Pos2, RawInput, Rect, TextureOptions, TexturesDelta, vec2};
use softbuffer_painter::Painter;
use std::hint::black_box;
use std::time::{Duration, Instant};

const SIZE: [usize; 2] = [1280, 720];
const FRAMES: usize = 200;

fn main() {
    let start = Start {
        source: Source::Builtin("sphere_room".into()),
        method: "auto".into(),
        settings: toml::Table::new(),
        against: None,
        samples: 4,
        order: Some(2),
        opening: Default::default(),
        view: Default::default(),
        panels: true,
        bakes: Vec::new(),
        program: None,
    };
    let mut viewer = Viewer::new(Box::new(StudioThread::start(None, Box::new(|| ()))), None, start);
    let context = Context::default();
    let mut painter = Painter::default();
    let mut pixels = vec![0; SIZE[0] * SIZE[1]];
    while !viewer.is_sharp() {
        frame(&context, &mut viewer, &mut painter);
        std::thread::sleep(Duration::from_millis(10));
    }
    let mut times = [const { Vec::new() }; 3];
    let mut primitives = Vec::new();
    for _ in 0..FRAMES {
        let made = frame(&context, &mut viewer, &mut painter);
        let begin = Instant::now();
        painter.paint(&mut pixels, SIZE, 1.0, &made.2);
        times[0].push(made.0);
        times[1].push(made.1);
        times[2].push(begin.elapsed());
        primitives = made.2;
    }
    let [widgets, meshes, sharp] = times.map(middle_ms);
    println!("widgets {widgets:.2} ms, meshes {meshes:.2} ms, painter {sharp:.2} ms");
    // The same with a picture of 0.38 of the width.
    let mut delta = TexturesDelta::default();
    for id in primitives.iter().filter_map(picture) {
        let draft = ColorImage::filled([372, 264], Color32::from_rgb(90, 120, 30));
        delta.push(id, ImageDelta::full(draft, TextureOptions::LINEAR));
    }
    painter.update(&delta);
    println!("{} texture replaced", delta.set.len());
    delta.clear();
    let mut drafts = Vec::new();
    for _ in 0..FRAMES {
        let begin = Instant::now();
        painter.paint(&mut pixels, SIZE, 1.0, &primitives);
        drafts.push(begin.elapsed());
    }
    println!("with a draft: painter {:.2} ms", middle_ms(drafts));
    black_box(&pixels);
}

/// The texture of a mesh that shows no letters.
fn picture(primitive: &ClippedPrimitive) -> Option<egui::TextureId> {
    let Primitive::Mesh(mesh) = &primitive.primitive else { return None };
    Some(mesh.texture_id).filter(|id| *id != egui::TextureId::default())
}

/// A frame: the times of its widgets and its meshes, and these.
fn frame(context: &Context, viewer: &mut Viewer, painter: &mut Painter) -> (Duration, Duration, Vec<ClippedPrimitive>) {
    let screen = Rect::from_min_size(Pos2::ZERO, vec2(SIZE[0] as f32, SIZE[1] as f32));
    let begin = Instant::now();
    let input = RawInput { screen_rect: Some(screen), ..Default::default() };
    let mut output = context.run_ui(input, |ui| viewer.show(ui));
    let widgets = begin.elapsed();
    let begin = Instant::now();
    let primitives = context.tessellate(output.shapes, output.pixels_per_point);
    let meshes = begin.elapsed();
    painter.update(&output.textures_delta);
    painter.free(&output.textures_delta);
    output.textures_delta.clear();
    (widgets, meshes, primitives)
}

fn middle_ms(mut times: Vec<Duration>) -> f64 {
    times.sort_unstable();
    times[times.len() / 2].as_secs_f64() * 1e3
}
