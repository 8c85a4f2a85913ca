//! Figures and a table of the light field that are made by library calls: what rays of a picture are in slabs, and
//! frames by the scene's size.

use crate::panels::{beside_of_width, save_small};
use crate::repository::root;
use crate::stage::{median, print, rgb, timed};
use anyhow::{Context, Result};
use catoptric::framebuffer::Framebuffer;
use catoptric::light::tracer::Tracer;
use catoptric::math::Aabb;
use catoptric::methods::Quality;
use catoptric::methods::lookup::light_field::{LightFieldSettings, SlabCoordinates, Slabs};
use catoptric::progress::Silent;
use catoptric::scene::shade::SurfacePoint;
use catoptric::scene::{PoseOptions, Scene, View};
use catoptric_scenes::builtin;
use catoptric_testkit::Session;
use glam::{Vec2, Vec3};
use image::{Rgb, RgbImage};

/// Colours of the six slabs: +x, -x, +y, -y, +z, -z.
const COLORS: [[u8; 3]; 6] =
    [[214, 69, 65], [240, 180, 60], [120, 180, 70], [60, 150, 160], [70, 110, 200], [160, 90, 170]];

/// Triangles of the hall in the table of scenes.
const HALLS: [u32; 4] = [10_000, 100_000, 1_000_000, 5_000_000];

/// The number of frames of a median.
const FRAMES: usize = 15;

/// The method of those frames and its settings.
const WAYS: [(&str, &str); 3] =
    [("light_field", "st = 8\nuv = 32\nbackground = \"slabs\""), ("light_field", "st = 8\nuv = 32"), ("reference", "")];

const QUALITY: Quality = Quality { samples: 4, order: 1 };

const WHITE: Rgb<u8> = Rgb([255; 3]);

fn posed(name: &str) -> Result<Scene> {
    Ok(builtin::parse(name)?.pose(&PoseOptions::default())?)
}

/// A method's picture.
fn picture(scene: &Scene, view: &View, method: &str, settings: &str) -> Result<RgbImage> {
    rgb(&Session::new(method, settings, scene, QUALITY)?.draw(view)?.picture)
}

/// The kinds of first reflections on a scene's reflectors, as colours.
fn of_first_hits(
    scene: &Scene,
    view: &View,
    slabs: &Slabs,
    color: impl Fn(&SurfacePoint, SlabCoordinates) -> Vec3,
) -> RgbImage {
    let mirrors = scene.specular_objects();
    let tracer = Tracer::build(scene, |object| mirrors.contains(&object));
    RgbImage::from_fn(view.width, view.height, |x, y| {
        let ray = view.ray(x as f32 + 0.5, y as f32 + 0.5);
        let Some(hit) = tracer.first_hit(scene, &ray, 0.0) else { return WHITE };
        let point = tracer.encounter(scene, &ray, &hit, None).point;
        let reflected = ray.direction - point.normal * (2.0 * ray.direction.dot(point.normal));
        let Some(found) = slabs.coordinates(point.position, reflected) else { return WHITE };
        Rgb(color(&point, found).to_array().map(|value| (value * 255.0).round() as u8))
    })
}

/// The slabs about a scene's reflectors; they need to hold no more than where rays are in them.
fn slabs_about(scene: &Scene) -> Result<(Aabb, Slabs)> {
    let boxes = scene.specular_objects().into_iter().map(|object| scene.objects[object as usize].bounds);
    let region = boxes.reduce(|all, one| all.union(one)).context("the scene has a reflector")?;
    let settings = LightFieldSettings { st: 2, uv: 4, ..LightFieldSettings::default() };
    Ok((region, Slabs::capture(&settings, scene, region, 0, &Silent)?))
}

/// Figure 5: positions, normals, s and t, u and v, and the picture that they lead to.
pub(crate) fn coordinates() -> Result<()> {
    let scene = posed("teapot")?;
    let view = scene.default_view(480, 360);
    let (region, slabs) = slabs_about(&scene)?;
    let pair = |at: Vec2, most: f32| (at / most).extend(0.3);
    let panels = [
        of_first_hits(&scene, &view, &slabs, |point, _| (point.position - region.min) / region.size()),
        of_first_hits(&scene, &view, &slabs, |point, _| point.normal * 0.5 + 0.5),
        of_first_hits(&scene, &view, &slabs, |_, found| pair(found.view, 1.0)),
        of_first_hits(&scene, &view, &slabs, |_, found| pair(found.pixel, 3.0)),
        picture(&scene, &view, "light_field", "preset = \"small\"")?,
    ];
    save_small(&beside_of_width(&panels, 260), &root().join("docs/pictures/light_field-5.png"))
}

/// Figure 7 (d): which slab each pixel of a ball looks up, in a colour each.
pub(crate) fn slab_choice() -> Result<()> {
    let scene = posed("sphere_room")?;
    let view = scene.default_view(480, 360);
    let (_, slabs) = slabs_about(&scene)?;
    let choice =
        of_first_hits(&scene, &view, &slabs, |_, found| Vec3::from(COLORS[found.slab as usize].map(f32::from)) / 255.0);
    let panels = [choice, picture(&scene, &view, "light_field", "preset = \"small\"")?];
    save_small(&beside_of_width(&panels, 360), &root().join("docs/pictures/light_field-7.png"))
}

/// The view of one hall.
fn hall(triangles: u32) -> Result<(Scene, View)> {
    let mut scene = posed(&format!("large_room?triangles={triangles}"))?;
    let view = scene.default_view(640, 480);
    let ball = scene.objects[scene.specular_objects()[0] as usize].bounds;
    let (room, eye) = (Vec3::splat(0.1), view.eye());
    scene.region = Some(Aabb { min: ball.min.min(eye - room), max: ball.max.max(eye + room) });
    Ok((scene, view))
}

/// Frames by the scene's triangles: everything from slabs, the background drawn, and the reference. Halls take turns,
/// so that what else the machine does slows them alike.
pub(crate) fn scenes() -> Result<()> {
    let halls = HALLS.into_iter().map(hall).collect::<Result<Vec<_>>>()?;
    let mut sessions = Vec::new();
    for (scene, view) in &halls {
        for (method, settings) in WAYS {
            sessions.push((Session::new(method, settings, scene, QUALITY)?, view, Vec::new()));
        }
    }
    for _ in 0..FRAMES {
        for (session, view, times_ms) in &mut sessions {
            let mut target = Framebuffer::new(view.width, view.height);
            times_ms.push(timed(session, view, &mut target)?.1);
        }
    }
    print("| triangles | `background=slabs` | `background=scene` | reference |\n|---|---|---|---|")?;
    for ((scene, _), sessions) in halls.iter().zip(sessions.chunks_mut(WAYS.len())) {
        let cells = sessions.iter_mut().map(|(_, _, times_ms)| format!(" {:.0} ms |", median(times_ms)));
        print(&format!("| {} |{}", scene.triangles.len(), cells.collect::<String>()))?;
    }
    Ok(())
}
