//! Everything moves: many frames without a failure of the device.

use catoptric::framebuffer::Framebuffer;
use catoptric::light::visibility::cast_shadows;
use catoptric::methods::{self, Method, Prepared, Quality};
use catoptric::progress::Silent;
use catoptric::scene::Camera;
use catoptric::scene::model::Model;
use catoptric_gpu::Context;
use catoptric_scenes::builtin;
use catoptric_testkit::scenes::moved;
use glam::Vec3;
use libtest_mimic::{Failed, Trial};
use std::sync::Arc;

const SIZE: [u32; 2] = [48, 32];

/// Methods, and how many frames they draw.
const METHODS: [(&str, u32); 7] = [
    ("multiperspective", 200),
    ("planar_mirror", 60),
    ("environment_map", 60),
    ("path_perturbation", 40),
    ("reflector_search", 40),
    ("light_field", 24),
    ("layered_environment_map", 24),
];

pub(crate) fn trials(context: &Arc<Context>) -> Vec<Trial> {
    let trial = |(id, frames): (&'static str, u32)| {
        let context = context.clone();
        Trial::test(format!("{id}: {frames} frames with everything moving"), move || draw(&context, id, frames))
    };
    let in_place = |scene: &'static str| {
        let context = context.clone();
        Trial::test(format!("moved in place: {scene}"), move || compare_moved(&context, scene))
    };
    METHODS
        .map(trial)
        .into_iter()
        .chain(["planar_mirror", "brushed", "rippled", "glass_sphere"].map(in_place))
        .collect()
}

/// Objects that move one after the other, whose tables change in place: the pictures are those of scenes that are
/// loaded as they have become. A few pixels may show the other one of two surfaces at the same place.
fn compare_moved(context: &Arc<Context>, scene: &str) -> Result<(), Failed> {
    const MOST_OTHERS: usize = 8;
    let mut model = builtin::parse(scene)?;
    let method = catoptric_gpu::create(context, "multiperspective", &Default::default())?.ok_or("drawn on the CPU")?;
    let quality = Quality { samples: 4, order: 2 };
    let [width, height] = [96, 64];
    let mut prepared: Option<Box<dyn Prepared>> = None;
    for frame in 0..5 {
        let count = model.nodes.len();
        for (index, node) in model.nodes.iter_mut().enumerate().filter(|(index, _)| index % 5 == frame || frame == 4) {
            node.local = moved(&node.local, Vec3::new(0.03, 0.02, -0.05) * (index as f32 / count as f32 + 0.5));
        }
        let mut scene = model.pose(&Default::default())?;
        cast_shadows(&mut scene);
        let scene = Arc::new(scene);
        let mut fresh = method.prepare(&scene, quality, None, &Silent)?;
        let followed = match &mut prepared {
            None => prepared.insert(method.prepare(&scene, quality, None, &Silent)?),
            Some(prepared) => {
                prepared.update(&scene, quality, &Silent)?;
                prepared
            }
        };
        let view = scene.default_view(width, height);
        let mut pictures = [Framebuffer::new(width, height), Framebuffer::new(width, height)];
        fresh.frame(&view, &Silent)?.draw(&mut pictures[0], &Silent)?;
        followed.frame(&view, &Silent)?.draw(&mut pictures[1], &Silent)?;
        let is_other = |(a, b): &(&[f32; 4], &[f32; 4])| (0..3).any(|channel| (a[channel] - b[channel]).abs() > 1e-3);
        let others = pictures[0].pixels.iter().zip(&pictures[1].pixels).filter(is_other).count();
        if others > MOST_OTHERS {
            return Err(format!("frame {frame}: {others} pixels differ from those of the scene loaded anew").into());
        }
    }
    context.check()?;
    Ok(())
}

fn draw(context: &Arc<Context>, id: &str, frames: u32) -> Result<(), Failed> {
    // A room with flat mirrors and the headlight, and one with lights, shadows, highlights and exact mirrors.
    let rooms = ["planar_mirror", "highlights"].map(builtin::parse);
    let mut rooms: Vec<Model> = rooms.into_iter().collect::<Result<_, _>>()?;
    let settings = methods::find(id)?.limits.settings.parse::<toml::Table>()?;
    let method = catoptric_gpu::create(context, id, &settings)?.ok_or("drawn on the CPU")?;
    let mut prepared = None;
    for frame in 0..frames {
        let room = usize::from(frame % 40 >= 30);
        for (index, node) in rooms[room].nodes.iter_mut().enumerate() {
            let step = Vec3::new((index as f32).sin(), 0.0, (index as f32).cos()) * 0.002;
            node.local = moved(&node.local, step);
        }
        let mut scene = rooms[room].pose(&Default::default())?;
        cast_shadows(&mut scene);
        let scene = Arc::new(scene);
        let quality = Quality { samples: [1, 4][(frame / 10 % 2) as usize], order: 1 + frame % 3 };
        let prepared = match &mut prepared {
            None => prepared.insert(method.prepare(&scene, quality, None, &Silent)?),
            Some(prepared) => {
                prepared.update(&scene, quality, &Silent)?;
                prepared
            }
        };
        let angle = frame as f32 * 0.03;
        let center = scene.bounds.center();
        let eye = center + Vec3::new(angle.cos(), 0.3, angle.sin()) * (0.3 * scene.bounds.diagonal());
        let view = scene.view(&Camera::look_at("", eye, center, Vec3::Y, 50.0), SIZE[0], SIZE[1]);
        let mut picture = Framebuffer::new(SIZE[0], SIZE[1]);
        prepared.frame(&view, &Silent)?.draw(&mut picture, &Silent)?;
        if !picture.pixels.iter().flatten().all(|value| value.is_finite()) {
            return Err(format!("frame {frame} has pixels that are no numbers").into());
        }
    }
    context.check()?;
    Ok(())
}
