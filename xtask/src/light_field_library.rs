//! Figures and a table of the light field that are made by library calls: what rays of a picture are in slabs, and frames by the
//! scene's size.

use crate::panels::{beside_of_width, save_small};
use crate::root;
use anyhow::{Context, Result};
use catoptric::framebuffer::Framebuffer;
use catoptric::math::Aabb;
use catoptric::methods::lookup::light_field::{LightFieldSettings, SlabCoordinates, Slabs};
use catoptric::methods::{self, Job, Quality, ReflectionMethod};
use catoptric::progress::Silent;
use catoptric::scene::shade::SurfacePoint;
use catoptric::scene::{PoseOptions, Scene, View, builtin};
use catoptric::surface::tracer::Tracer;
use glam::{Vec2, Vec3};
use image::{Rgb, RgbImage};
use std::io::Write;
use std::time::Instant;

/// Colours of the six slabs: +x, -x, +y, -y, +z, -z.
const COLORS: [[u8; 3]; 6] =
    [[214, 69, 65], [240, 180, 60], [120, 180, 70], [60, 150, 160], [70, 110, 200], [160, 90, 170]];

/// Triangles of the hall in the table of scenes.
const HALLS: [u32; 4] = [10_000, 100_000, 1_000_000, 5_000_000];

/// Frames of which the median is told.
const FRAMES: usize = 15;

/// How those frames are drawn: a method and its settings.
const WAYS: [(&str, &str); 3] =
    [("light_field", "st = 8\nuv = 32\nbackground = \"slabs\""), ("light_field", "st = 8\nuv = 32"), ("reference", "")];

const QUALITY: Quality = Quality { samples: 4, order: 1 };

const WHITE: Rgb<u8> = Rgb([255; 3]);

fn posed(name: &str) -> Result<Scene> {
    Ok(builtin::parse(name)?.pose(&PoseOptions::default())?)
}

/// A method's picture.
fn picture(scene: &Scene, view: &View, method: &str, settings: &str) -> Result<RgbImage> {
    let mut method = methods::create(method, &settings.parse()?)?;
    method.prepare(scene, QUALITY, &Silent)?;
    let mut target = Framebuffer::new(view.width, view.height);
    method.render(&Job { scene, view, quality: QUALITY, progress: &Silent }, &mut target)?;
    RgbImage::from_raw(view.width, view.height, target.to_srgb8()).context("a picture has as many pixels as its view")
}

/// What first reflections on a scene's reflectors are, in colours.
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

/// The same view of one hall, made ready for drawing in several ways.
struct Hall {
    scene: Scene,
    view: View,
    ways: Vec<Box<dyn ReflectionMethod>>,
}

impl Hall {
    fn new(triangles: u32) -> Result<Self> {
        let mut scene = posed(&format!("large_room?triangles={triangles}"))?;
        let view = scene.default_view(640, 480);
        let ball = scene.objects[scene.specular_objects()[0] as usize].bounds;
        let room = Vec3::splat(0.1);
        let eye = view.eye();
        scene.region = Some(Aabb { min: ball.min.min(eye - room), max: ball.max.max(eye + room) });
        let mut ways = Vec::new();
        for (method, settings) in WAYS {
            let mut method = methods::create(method, &settings.parse()?)?;
            method.prepare(&scene, QUALITY, &Silent)?;
            ways.push(method);
        }
        Ok(Self { scene, view, ways })
    }
}

/// Frames by the scene's triangles: everything from slabs, the background drawn, and the reference. Halls take turns, so that
/// what else the machine does slows them alike.
pub(crate) fn scenes() -> Result<()> {
    let mut halls = HALLS.into_iter().map(Hall::new).collect::<Result<Vec<Hall>>>()?;
    let mut times_ms = vec![vec![Vec::new(); WAYS.len()]; halls.len()];
    for _ in 0..FRAMES {
        for (hall, times_ms) in halls.iter_mut().zip(&mut times_ms) {
            let job = Job { scene: &hall.scene, view: &hall.view, quality: QUALITY, progress: &Silent };
            let mut target = Framebuffer::new(hall.view.width, hall.view.height);
            for (way, times_ms) in hall.ways.iter_mut().zip(times_ms) {
                let start = Instant::now();
                way.render(&job, &mut target)?;
                times_ms.push(start.elapsed().as_secs_f64() * 1e3);
            }
        }
    }
    let mut table = std::io::stdout();
    writeln!(table, "| triangles | `background=slabs` | `background=scene` | reference |")?;
    writeln!(table, "|---|---|---|---|")?;
    for (hall, times_ms) in halls.iter().zip(times_ms) {
        write!(table, "| {} |", hall.scene.triangles.len())?;
        for mut times_ms in times_ms {
            times_ms.sort_by(f64::total_cmp);
            write!(table, " {:.0} ms |", times_ms[FRAMES / 2])?;
        }
        writeln!(table)?;
    }
    Ok(())
}
