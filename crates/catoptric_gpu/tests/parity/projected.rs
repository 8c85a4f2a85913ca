//! Where devices see vertices in balls, against the law of reflection in double precision, without any of the library.

use catoptric::methods::Quality;
use catoptric::progress::Silent;
use catoptric::scene::{Scene, View};
use catoptric::surface::AnalyticSurface;
use catoptric_gpu::{Context, Renderer, VertexAppearance};
use catoptric_scenes::builtin;
use glam::{DVec2, DVec3};
use libtest_mimic::{Failed, Trial};
use std::sync::Arc;

/// No fewer vertices are compared.
const LEAST_COUNT: usize = 100_000;
/// Places may be off by so many pixels.
const MOST_PX: f64 = 0.02;
/// Vertices that are seen so near beside a ball, in shares of its radius, may be missed at its silhouette.
const BESIDE: f64 = 0.05;
/// One in so many may be missed elsewhere, too: tiles follow what shows it.
const MISSED: usize = 5000;
/// Vertices whose ray grazes a ball, by the sine of the angle to its surface, may appear beside it.
const GRAZING: f64 = 0.03;

pub(crate) fn trials(context: &Arc<Context>) -> Vec<Trial> {
    let trial = |id: &'static str| {
        let context = context.clone();
        Trial::test(format!("{id}: {LEAST_COUNT} vertices in balls"), move || compare(&context, id))
    };
    ["reflector_search", "explosion_map"].map(trial).into()
}

/// A ball, seen from an eye.
#[derive(Clone, Copy)]
struct Ball {
    center: DVec3,
    radius: f64,
    eye: DVec3,
}

impl Ball {
    /// Where a ray from the eye meets the ball, and the cosine of the angle to its normal.
    fn met(&self, direction: DVec3) -> Option<(DVec3, f64)> {
        let from = self.eye - self.center;
        let slope = from.dot(direction);
        let square = slope * slope - from.length_squared() + self.radius * self.radius;
        let at = self.eye + direction * (-slope - square.max(0.0).sqrt());
        let normal = (at - self.center) / self.radius;
        (square > 0.0).then(|| (at, -normal.dot(direction)))
    }

    /// By how much the reflected ray of a view ray misses a point, along two axes across it.
    fn miss(&self, direction: DVec3, point: DVec3, axes: [DVec3; 2]) -> Option<DVec2> {
        let (at, cosine) = self.met(direction)?;
        let normal = (at - self.center) / self.radius;
        let reflected = direction + normal * (2.0 * cosine);
        let from = point - at;
        let aside = from - reflected * from.dot(reflected);
        (from.dot(reflected) > 0.0).then(|| DVec2::new(aside.dot(axes[0]), aside.dot(axes[1])))
    }
}

/// The view rays of a picture, in double precision.
fn direction(view: &View, px: DVec2) -> DVec3 {
    let rays = view.rays();
    let through = rays.direction.as_dvec3() + rays.right.as_dvec3() * px.x + rays.down.as_dvec3() * px.y;
    through.normalize()
}

/// The place near another one whose reflected ray leads to a point, by Newton's method with differences.
fn exact_place(ball: &Ball, view: &View, start: DVec2, point: DVec3) -> Option<DVec2> {
    let mut px = start;
    for _ in 0..20 {
        let (at, cosine) = ball.met(direction(view, px))?;
        let normal = (at - ball.center) / ball.radius;
        let (x, y) = (direction(view, px) + normal * (2.0 * cosine)).any_orthonormal_pair();
        let miss = |px: DVec2| ball.miss(direction(view, px), point, [x, y]);
        let (here, step) = (miss(px)?, 1e-4);
        let change = [DVec2::X, DVec2::Y].map(|axis| Some((miss(px + axis * step)? - here) / step));
        let [Some(right), Some(down)] = change else { return None };
        let by = -glam::DMat2::from_cols(right, down).inverse() * here;
        px += by;
        if by.length() < 1e-6 {
            return Some(px);
        }
    }
    None
}

fn compare(context: &Arc<Context>, id: &str) -> Result<(), Failed> {
    let scene = Arc::new(builtin::parse("two_spheres?surface=analytic&tess=160")?.pose(&Default::default())?);
    let view = scene.default_view(960, 640);
    let method = catoptric_gpu::create(context, id, &Default::default())?.ok_or("it draws on devices")?;
    let mut renderer = Renderer::new(&method, &scene, Quality { samples: 1, order: 1 }, None, &Silent)?;
    let all = renderer.vertex_appearances(&view)?.ok_or("the device projects vertices")?;
    let (mut compared, mut wrong, mut worst) = (0, 0, 0.0f64);
    let mut missing = 0;
    for object in scene.specular_objects() {
        let ball = ball(&scene, &view, object)?;
        let seen: Vec<&VertexAppearance> = all.iter().filter(|one| one.reflector == object).collect();
        let mut count = vec![0; scene.positions.len()];
        for one in seen {
            count[one.vertex as usize] += 1;
            let point = scene.positions[one.vertex as usize].as_dvec3();
            let place = DVec2::from(one.image_px.map(f64::from));
            let is_grazing = ball.met(direction(&view, place)).is_none_or(|(_, cosine)| cosine < GRAZING);
            if one.is_beside || is_grazing {
                continue;
            }
            let error = exact_place(&ball, &view, place, point).map_or(f64::INFINITY, |exact| exact.distance(place));
            compared += 1;
            wrong += usize::from(error > MOST_PX);
            worst = worst.max(error);
        }
        // Every point that the ball neither hides nor almost hides appears in it once.
        let own = &scene.objects[object as usize].vertices;
        for (vertex, position) in (0..).zip(&scene.positions) {
            let way = position.as_dvec3() - ball.eye;
            let passes = Ball { radius: ball.radius * (1.0 + BESIDE), ..ball }.met(way.normalize()).is_none();
            let is_inside = position.as_dvec3().distance(ball.center) < ball.radius;
            missing += usize::from(!own.contains(&vertex) && passes && !is_inside && count[vertex as usize] != 1);
        }
    }
    if compared < LEAST_COUNT || wrong > 0 || missing > compared / MISSED {
        let problem = format!(
            "of {compared} vertices {wrong} are off by more than {MOST_PX} pixels (up to {worst:.3}), {missing} appear \
             not once"
        );
        return Err(problem.into());
    }
    Ok(())
}

fn ball(scene: &Scene, view: &View, object: u32) -> Result<Ball, Failed> {
    let surface = scene.objects[object as usize].surface.as_ref().ok_or("it is given by a formula")?;
    let AnalyticSurface::Sphere { radius } = surface.surface else { return Err("it is no ball".into()) };
    Ok(Ball { center: surface.world_from_surface.translation, radius, eye: view.eye().as_dvec3() })
}
