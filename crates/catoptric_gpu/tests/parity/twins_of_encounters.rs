//! Encounters of rays, and the exact places there: in shaders, by the library, and by all triangles one by one.

use super::resources::SceneResources;
use super::twins::run;
use bytemuck::{Pod, Zeroable};
use catoptric::math::random::Stream;
use catoptric::parallel;
use catoptric::scene::shade::Barycentrics;
use catoptric::scene::{Material, Ray, RayDifferential, Scene};
use catoptric::surface::{
    AnalyticSurface, Ellipsoid, Implicit, Quadric, Revolution, Superquadric, SurfaceError, Torus,
};
use catoptric_gpu::Context;
use catoptric_gpu::layout::NONE;
use catoptric_testkit::scenes::SceneBuilder;
use glam::{Affine3A, DVec2, DVec3, Quat, Vec3};
use libtest_mimic::{Failed, Trial};
use std::sync::Arc;

const COUNT: usize = 100_000;
/// Rays that are tested against every triangle.
const TESTED_ONE_BY_ONE: usize = 500;

#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
struct Input {
    origin: Vec3,
    unused0: f32,
    direction: Vec3,
    unused1: f32,
    origin_dx: Vec3,
    unused2: f32,
    origin_dy: Vec3,
    unused3: f32,
    direction_dx: Vec3,
    unused4: f32,
    direction_dy: Vec3,
    unused5: f32,
}

#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
struct Output {
    position: Vec3,
    triangle: u32,
    geometric_normal: Vec3,
    distance: f32,
    normal: Vec3,
    unused0: f32,
    position_dx: Vec3,
    unused1: f32,
    position_dy: Vec3,
    unused2: f32,
    normal_dx: Vec3,
    unused3: f32,
    normal_dy: Vec3,
    unused4: f32,
}

pub(crate) fn trial(context: &Arc<Context>) -> Trial {
    let context = context.clone();
    Trial::test(format!("twins of encounters on {COUNT} rays"), move || compare(&context))
}

/// Mirrors of every kind.
fn scene() -> Result<Scene, SurfaceError> {
    let half_cone = [1.0, -0.4, 1.0, 0.1, 0.0, 0.2, 0.0, 0.1, 0.0, -0.3];
    let surfaces = [
        AnalyticSurface::Sphere { radius: 0.7 },
        AnalyticSurface::Plane { half_width: 0.8, half_height: 0.6 },
        AnalyticSurface::Ellipsoid(Ellipsoid::new([0.8, 0.5, 0.6])?),
        AnalyticSurface::Quadric(Quadric::new(half_cone, [-0.9; 3], [0.9; 3])?),
        AnalyticSurface::Torus(Torus::new(0.6, 0.2)?),
        AnalyticSurface::Superquadric(Superquadric::new([0.7, 0.6, 0.8], [0.6, 1.2])?),
        AnalyticSurface::Revolution(Revolution::new(1.2, [1.1, -1.7, 0.4, 0.6])?),
        AnalyticSurface::Implicit(Implicit::new("x^2 + y^2 + z^2 + 0.1 * sin(5 * x) - 0.4", [-0.9; 3], [0.9; 3])?),
    ];
    let mut builder = SceneBuilder::new();
    let mirror = builder.material(Material::mirror("mirror", Vec3::ONE));
    for (index, surface) in surfaces.into_iter().enumerate() {
        let (row, column) = (index / 3, index % 3);
        let turn = Quat::from_euler(glam::EulerRot::XYZ, 0.4 * index as f32, 0.9, 0.2 * index as f32);
        let place = Vec3::new(2.0 * column as f32 - 2.0, 2.0 * row as f32 - 2.0, 0.3 * index as f32);
        let place = Affine3A::from_rotation_translation(turn, place);
        builder.analytic(&format!("surface {index}"), place, surface, mirror, false);
    }
    builder.sphere_mesh("mesh", Vec3::new(2.0, 2.0, 1.0), 0.7, 24, mirror);
    Ok(builder.build())
}

fn inputs(scene: &Scene) -> Vec<Input> {
    let mut random = Stream::new(2828);
    let mut input = || {
        let mut vector = |size: f32| Vec3::from_array([0, 1, 2].map(|_| random.next_between(-size, size)));
        let towards = scene.bounds.center() + scene.bounds.size() * vector(0.5);
        let origin = scene.bounds.center() + scene.bounds.size() * vector(1.0);
        let direction = (towards - origin).normalize_or(Vec3::X);
        let [direction_dx, direction_dy] = [vector(0.01), vector(0.01)].map(|step| step.reject_from(direction));
        let [origin_dx, origin_dy] = [vector(0.01), vector(0.01)];
        Input { origin, direction, origin_dx, origin_dy, direction_dx, direction_dy, ..Input::default() }
    };
    (0..COUNT).map(|_| input()).collect()
}

/// Where a ray meets a triangle's plane: the distance, and the weights of the second and third corner.
fn in_plane([a, b, c]: [DVec3; 3], origin: DVec3, direction: DVec3) -> (f64, DVec2) {
    let (ab, ac) = (b - a, c - a);
    let face = ab.cross(ac);
    let distance = (a - origin).dot(face) / direction.dot(face);
    let from = origin + direction * distance - a;
    (distance, DVec2::new(from.cross(ac).dot(face), ab.cross(from).dot(face)) / face.length_squared())
}

fn corners(scene: &Scene, triangle: u32) -> [DVec3; 3] {
    scene.triangles[triangle as usize].map(|vertex| scene.positions[vertex as usize].as_dvec3())
}

/// The library's encounter with a triangle; the changes of its weights are differences of places in its plane.
fn expected(scene: &Scene, given: &Input, triangle: u32) -> Output {
    let corners = corners(scene, triangle);
    let at = |step: f64, [origin, direction]: [Vec3; 2]| {
        let origin = given.origin.as_dvec3() + origin.as_dvec3() * step;
        in_plane(corners, origin, given.direction.as_dvec3() + direction.as_dvec3() * step)
    };
    const STEP: f64 = 1e-4;
    let change = |of: [Vec3; 2]| ((at(STEP, of).1 - at(-STEP, of).1) / (2.0 * STEP)).as_vec2();
    let (distance, value) = at(0.0, [Vec3::ZERO; 2]);
    let dx = change([given.origin_dx, given.direction_dx]);
    let dy = change([given.origin_dy, given.direction_dy]);
    let barycentrics = Barycentrics { value: value.as_vec2(), dx, dy, samples: 1 };
    let ray = Ray { origin: given.origin, direction: given.direction };
    let Input { origin_dx, origin_dy, direction_dx, direction_dy, .. } = *given;
    let change = RayDifferential { origin_dx, origin_dy, direction_dx, direction_dy };
    let met = scene.drawn_encounter(triangle, &barycentrics, &ray, &change);
    let ([position_dx, position_dy], [normal_dx, normal_dy]) = (met.position_change, met.normal_change);
    Output {
        position: met.point.position,
        triangle,
        geometric_normal: met.point.geometric_normal,
        distance: distance as f32,
        normal: met.point.normal,
        position_dx,
        position_dy,
        normal_dx,
        normal_dy,
        ..Output::default()
    }
}

/// Quantities that are compared: how far each may be off, as a share of its size, and the least size that counts.
/// Single precision, more of it lost at grazing rays, where changes are large.
const LIMITS: [(&str, f32, f32); 5] = [
    ("distance", 1e-5, 1.0),
    ("position", 1e-5, 1.0),
    ("normals", 1e-3, 1.0),
    ("changes of positions", 1e-2, 0.01),
    ("changes of normals", 1e-2, 0.01),
];
/// The share of rays that may be off by more: those that graze.
const MOST_OFF: f64 = 1e-4;

fn compare(context: &Context) -> Result<(), Failed> {
    let scene = scene()?;
    let inputs = inputs(&scene);
    let resources = SceneResources::new(context, &scene)?;
    let (first, second) = (resources.of_scene(&[0, 1, 2, 3, 4, 5]), resources.of_hierarchy());
    let found: Vec<Output> = run(context, "twins/encounters.wgsl", &resources.constants, &inputs, &first, &second)?;
    let mut met = vec![0usize; scene.objects.len()];
    let mut off = [0usize; LIMITS.len()];
    for (given, found) in inputs.iter().zip(&found).filter(|(_, found)| found.triangle != NONE) {
        met[scene.triangle_objects[found.triangle as usize] as usize] += 1;
        let known = expected(&scene, given, found.triangle);
        let pairs: [&[[Vec3; 2]]; LIMITS.len()] = [
            &[[Vec3::splat(known.distance), Vec3::splat(found.distance)]],
            &[[known.position, found.position]],
            &[[known.geometric_normal, found.geometric_normal], [known.normal, found.normal]],
            &[[known.position_dx, found.position_dx], [known.position_dy, found.position_dy]],
            &[[known.normal_dx, found.normal_dx], [known.normal_dy, found.normal_dy]],
        ];
        for ((count, pairs), (_, share, least)) in off.iter_mut().zip(pairs).zip(LIMITS) {
            let is_near = |[known, found]: &[Vec3; 2]| known.distance(*found) <= share * known.length().max(least);
            *count += usize::from(!pairs.iter().all(is_near));
        }
    }
    let mut problems: Vec<String> = Vec::new();
    for (count, (name, ..)) in off.iter().zip(LIMITS) {
        if *count as f64 > MOST_OFF * COUNT as f64 {
            problems.push(format!("{name}: {count} of {COUNT}"));
        }
    }
    if met.iter().any(|count| *count < COUNT / 200) {
        problems.push(format!("some surfaces are hardly met: {met:?}"));
    }
    let others = others(&scene, &inputs[..TESTED_ONE_BY_ONE], &found);
    if others > 1 {
        problems.push(format!("{others} of {TESTED_ONE_BY_ONE} rays do not end at the nearest triangle"));
    }
    if problems.is_empty() { Ok(()) } else { Err(problems.join(", ").into()) }
}

/// How many rays do not end where the nearest of all triangles is.
fn others(scene: &Scene, inputs: &[Input], found: &[Output]) -> usize {
    // Rays that pass an edge within rounding may meet either side, or slip past a silhouette.
    const BESIDE: f64 = 1e-5;
    let all: Vec<[DVec3; 3]> = (0..scene.triangles.len() as u32).map(|triangle| corners(scene, triangle)).collect();
    let is_other = parallel::map_collect(inputs.len(), |index| {
        let (origin, direction) = (inputs[index].origin.as_dvec3(), inputs[index].direction.as_dvec3());
        let nearest = |beside: f64| {
            let met = all.iter().map(|corners| in_plane(*corners, origin, direction));
            let is_met = |(distance, at): &(f64, DVec2)| {
                *distance >= 0.0 && at.min_element() >= -beside && at.x + at.y <= 1.0 + beside
            };
            met.filter(is_met).map(|(distance, _)| distance).fold(f64::INFINITY, f64::min)
        };
        let found = match found[index].triangle {
            NONE => f64::INFINITY,
            _ => f64::from(found[index].distance),
        };
        let is_near = |distance: f64| distance == found || (distance - found).abs() <= 1e-5 * distance;
        !is_near(nearest(BESIDE)) && !is_near(nearest(-BESIDE))
    });
    is_other.into_iter().filter(|is_other| *is_other).count()
}
