//! Figure 17: where heads and tails of reflected rays appear, and differences from ray tracing.

use super::sizes::{BALL, FULL};
use crate::panels::{below, beside_of_width, cut};
use crate::stage::{BUNDLE, CAMERAS, PINHOLE, Stage, print, rgb};
use anyhow::Result;
use catoptric::math::Aabb;
use catoptric::methods::projector::{Projections, VertexProjector};
use catoptric::scene::Ray;
use glam::{DVec3, Vec2, Vec3};
use image::{Rgb, RgbImage};

/// The ball of `sphere_room`.
const CENTER: DVec3 = DVec3::new(0.0, 1.3, 0.0);
const RADIUS: f64 = 0.8;
/// Tails are so far from the ball: on the ball itself nothing is reflected.
const TAIL_DISTANCE: f64 = 0.016;
/// Pixels of the picture that are shown around a ray, and how large each is drawn.
const SHOWN_PX: u32 = 5;
const ZOOM: u32 = 48;
/// The width of a panel.
const WIDTH: u32 = SHOWN_PX * ZOOM;
/// Rays that are drawn.
const DRAWN: usize = 5;

/// Whose pictures are compared with the reference's.
pub(super) const COMPARED: [(&str, &str); 3] = [(CAMERAS, PINHOLE), (CAMERAS, BUNDLE), ("environment_map", "")];

/// A view ray reflected by the ball, by the sphere's formula in double precision.
struct Reflected {
    pixel: Vec2,
    tail: Vec3,
    head: Vec3,
}

/// The appearance of a point nearest to its true place; returns `None` if it does not appear.
fn appearance(projector: &dyn VertexProjector, point: Vec3, near: Vec2) -> Option<Vec2> {
    let mut found = Projections::default();
    projector.project(&[point], &mut found);
    let places = found.all().iter().map(|projection| projection.image_px);
    places.min_by(|a, b| a.distance(near).total_cmp(&b.distance(near)))
}

impl Reflected {
    fn new(ray: &Ray, pixel: Vec2, bounds: &Aabb) -> Option<Self> {
        let (origin, direction) = (ray.origin.as_dvec3() - CENTER, ray.direction.as_dvec3().normalize());
        let half = origin.dot(direction);
        let distance = -half - (half * half - origin.length_squared() + RADIUS * RADIUS).sqrt();
        if !distance.is_finite() {
            return None;
        }
        let normal = (origin + direction * distance) / RADIUS;
        let out = direction - normal * (2.0 * direction.dot(normal));
        let start = CENTER + normal * RADIUS;
        let (low, high) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
        let exits = [0, 1, 2].map(|axis| {
            let wall = if out[axis] > 0.0 { high[axis] } else { low[axis] };
            (wall - start[axis]) / out[axis]
        });
        let exit = exits.into_iter().filter(|exit| exit.is_finite()).fold(f64::INFINITY, f64::min);
        let at = |distance: f64| (start + out * distance).as_vec3();
        exit.is_finite().then(|| Self { pixel, tail: at(TAIL_DISTANCE), head: at(exit) })
    }
}

/// The drawings and the differences.
pub(crate) fn draw() -> Result<RgbImage> {
    let stage = Stage::new("sphere_room?surface=analytic", FULL, 1)?.with_samples(16);
    let (mask, truth) = (stage.mask(), stage.truth()?);
    let picture = rgb(&truth)?;
    let seen = picture.enumerate_pixels().zip(&mask).filter(|(_, seen)| **seen);
    let rays: Vec<Reflected> = seen
        .filter_map(|((x, y, _), _)| {
            let pixel = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
            Reflected::new(&stage.view.ray(pixel.x, pixel.y), pixel, &stage.scene.bounds)
        })
        .collect();
    print("| cameras | point | asked | p50 px | p99 px | max px | missing |\n|---|---|---|---|---|---|---|")?;
    let mut rows = Vec::new();
    for (label, settings) in [("pinholes, 1 px", PINHOLE), ("ray bundles, 0.1 px", BUNDLE)] {
        let drawings = stage.session(CAMERAS, settings)?.with_projector(&stage.view, |projector| -> Result<_> {
            for (name, is_head) in [("tail", false), ("head", true)] {
                let point = |ray: &Reflected| if is_head { ray.head } else { ray.tail };
                let place = |ray: &Reflected| appearance(projector, point(ray), ray.pixel);
                let errors = rays.iter().step_by(3).map(|ray| place(ray).map(|place| place.distance(ray.pixel)));
                print(&statistics(label, name, &errors.collect::<Vec<_>>()))?;
            }
            // From the middle of the ball to its silhouette.
            let chosen = (1..=DRAWN).map(|step| rays.len() * step / (DRAWN + 1));
            Ok(chosen
                .filter_map(|index| rays.get(index))
                .map(|ray| zoomed(&picture, ray, projector))
                .collect::<Vec<_>>())
        })??;
        rows.push(beside_of_width(&drawings, WIDTH));
    }
    let mut differences = Vec::new();
    let cameras = COMPARED.into_iter().filter(|(method, _)| *method == CAMERAS);
    for ((method, settings), times) in COMPARED.map(|way| (way, 1)).into_iter().chain(cameras.map(|way| (way, 8))) {
        let drawn = rgb(&stage.draw(method, settings, 1)?.picture)?;
        let difference = RgbImage::from_fn(drawn.width(), drawn.height(), |x, y| {
            let (a, b) = (drawn.get_pixel(x, y).0, picture.get_pixel(x, y).0);
            Rgb([0, 1, 2].map(|channel: usize| 255 - a[channel].abs_diff(b[channel]).saturating_mul(times)))
        });
        differences.push(cut(&difference, BALL));
    }
    rows.push(beside_of_width(&differences, WIDTH));
    Ok(below(&rows))
}

fn statistics(label: &str, name: &str, errors: &[Option<f32>]) -> String {
    let mut known: Vec<f32> = errors.iter().copied().flatten().collect();
    known.sort_by(f32::total_cmp);
    let share = |share: f64| {
        let rank = (share * known.len() as f64).ceil() as usize;
        known.get(rank.max(1) - 1).map_or(String::new(), |error| format!("{error:.4}"))
    };
    let missing = errors.len() - known.len();
    format!("| {label} | {name} | {} | {} | {} | {} | {missing} |", errors.len(), share(0.5), share(0.99), share(1.0))
}

/// The pixels around a ray, enlarged: their grid white, the true place a blue square, the tail a straight green cross,
/// the head a diagonal red one.
fn zoomed(picture: &RgbImage, ray: &Reflected, projector: &dyn VertexProjector) -> RgbImage {
    let corner = (ray.pixel - 0.5 * SHOWN_PX as f32).floor();
    let side = SHOWN_PX * ZOOM;
    let mut drawing = RgbImage::from_fn(side, side, |x, y| {
        if x % ZOOM == 0 || y % ZOOM == 0 {
            return Rgb([255; 3]);
        }
        let place = [corner.x as u32 + x / ZOOM, corner.y as u32 + y / ZOOM];
        let below = picture.get_pixel_checked(place[0], place[1]).map_or([0; 3], |pixel| pixel.0);
        // Grey and dark, so that the markers stand out.
        let grey = (below.iter().map(|channel| u32::from(*channel)).sum::<u32>() / 6) as u8;
        Rgb([grey; 3])
    });
    let mut mark = |place: Vec2, colour: [u8; 3], covers: &dyn Fn(f32, f32) -> bool| {
        let center = (place - corner) * ZOOM as f32;
        for (x, y, pixel) in drawing.enumerate_pixels_mut() {
            let (right, down) = (x as f32 + 0.5 - center.x, y as f32 + 0.5 - center.y);
            if covers(right, down) {
                *pixel = Rgb(colour);
            }
        }
    };
    mark(ray.pixel, [80, 140, 255], &|right, down| right.abs().max(down.abs()) < 7.0);
    let arm = 16.0;
    if let Some(place) = appearance(projector, ray.tail, ray.pixel) {
        mark(place, [40, 230, 60], &|right, down| {
            right.abs().max(down.abs()) < arm && right.abs().min(down.abs()) < 1.6
        });
    }
    if let Some(place) = appearance(projector, ray.head, ray.pixel) {
        mark(place, [255, 60, 40], &|right, down| {
            right.abs().max(down.abs()) < arm && (right.abs() - down.abs()).abs() < 2.2
        });
    }
    drawing
}
