//! Sample rays against traced neighbours, and their focal points against Coddington's equations.

use catoptric_core::math::random::Stream;
use catoptric_core::scene::{Material, Ray, Scene};
use catoptric_core::surface::AnalyticSurface;
use catoptric_engine::light::tracer::Tracer;
use catoptric_engine::optics::path::bundle::{BounceKind, Eye};
use catoptric_engine::optics::path::manifold::SpecularSurfaces;
use catoptric_projection::find::ray_map::{Approximation, RaySample, Specular, follow};
use catoptric_testkit::scenes::{random_vector as vector, scene_of};
use glam::{Affine3A, DVec2, DVec3, Vec3};

const REFLECT: BounceKind = BounceKind::Reflect;
const TRANSMIT: BounceKind = BounceKind::Transmit;

/// Balls with centres, radii and materials.
pub(super) fn balls(list: &[(Vec3, f64, Material)]) -> Scene {
    let ball = |(center, radius, material): &(Vec3, f64, Material)| {
        (AnalyticSurface::Sphere { radius: *radius }, Affine3A::from_translation(*center), material.clone())
    };
    scene_of(&list.iter().map(ball).collect::<Vec<_>>())
}

/// The view ray followed along a path of these bounces.
pub(super) fn traced(scene: &Scene, eye: DVec3, towards: DVec3, path: &[(u32, BounceKind)]) -> Option<RaySample> {
    let surfaces = SpecularSurfaces::new(scene);
    let tracer = Tracer::build(scene, |_| true);
    let specular = Specular { scene, tracer: &tracer, surfaces: &surfaces, order: path.len() as u32 };
    let origin = eye.as_vec3();
    let ray = Ray { origin, direction: (towards - eye).normalize().as_vec3() };
    let mut kept = None;
    follow(&specular, &Eye::Point(origin.as_dvec3()), &ray, 0.0, &mut |found, sample| {
        if found.bounces.iter().map(|bounce| (bounce.object, bounce.kind)).eq(path.iter().copied()) {
            kept = Some(sample);
        }
    });
    kept
}

/// Sums of errors over many neighbours: of the first reflection point by no, first and second order, and of the
/// optical length; for neighbours that are seen under an angle, and under a quarter of it.
#[derive(Debug, Default)]
struct Errors {
    cases: u32,
    sums: [[f64; 4]; 2],
}

/// Neighbours of rays towards random places near `aim`.
fn errors(scene: &Scene, aim: DVec3, spread: f64, path: &[(u32, BounceKind)]) -> Errors {
    let mut random = Stream::new(311);
    let eye = DVec3::new(0.25, 0.5, 4.0);
    let mut errors = Errors::default();
    for _ in 0..60 {
        let target = aim + vector(&mut random) * spread;
        let step = (target - eye).cross(vector(&mut random)).normalize() * 0.03;
        let reach = f64::from(random.next_between(1.0, 3.0));
        let Some(sample) = traced(scene, eye, target, path) else { continue };
        let neighbours = [1.0, 0.25].map(|share| traced(scene, eye, target + step * share, path));
        let [Some(_), Some(_)] = &neighbours else { continue };
        for (sums, neighbour) in errors.sums.iter_mut().zip(neighbours.iter().flatten()) {
            let point = neighbour.rays.origin + neighbour.rays.direction * reach;
            let orders = [Approximation::Nearest, Approximation::Linear, Approximation::Quadratic];
            for (sum, order) in sums.iter_mut().zip(orders) {
                *sum += sample
                    .neighbour(point, order)
                    .expect("a neighbour")
                    .reflection_point
                    .distance(neighbour.first.value);
            }
            let length = neighbour.optical_length + neighbour.media[neighbour.sites.count] * reach;
            sums[3] += (sample.optical_length_to(point) - length).abs();
        }
        errors.cases += 1;
    }
    errors
}

/// Errors fall by 4, 16 and 64 with a quarter of the step; limits in between. The length's fall by 64, but by 16 alone
/// beyond a focus, where the bend of the wavefront is limited.
fn check(errors: &Errors, what: &str, length: f64) {
    let [coarse, fine] = &errors.sums;
    assert!(errors.cases > 25, "{what}: {errors:?}");
    for (k, least) in [3.0, 10.0, 35.0, length].into_iter().enumerate() {
        assert!(coarse[k] > least * fine[k], "{what}, {k}: {errors:?}");
    }
    assert!(fine[0] > 5.0 * fine[1] && fine[1] > 5.0 * fine[2], "{what}: {errors:?}");
}

#[test]
fn each_order_of_the_expansion_gains_one_power_of_the_step() {
    let scene = balls(&[(Vec3::ZERO, 1.0, Material::mirror("mirror", Vec3::ONE))]);
    check(&errors(&scene, DVec3::ZERO, 0.5, &[(0, REFLECT)]), "mirror ball", 35.0);
    let scene = balls(&[(Vec3::ZERO, 1.0, Material::glass("glass", 1.5))]);
    check(&errors(&scene, DVec3::ZERO, 0.4, &[(0, TRANSMIT), (0, TRANSMIT)]), "glass ball", 10.0);
    // Two mirrors that face each other sideways.
    let scene = balls(&[
        (Vec3::ZERO, 1.0, Material::mirror("mirror", Vec3::ONE)),
        (Vec3::new(3.0, 0.5, 1.5), 1.5, Material::mirror("mirror", Vec3::ONE)),
    ]);
    check(&errors(&scene, DVec3::new(0.55, 0.15, 0.75), 0.15, &[(0, REFLECT), (1, REFLECT)]), "two mirror balls", 35.0);
}

#[test]
fn focal_points_of_a_hollow_mirror_obey_coddington() {
    let (radius, scene) = (2.0, balls(&[(Vec3::ZERO, 2.0, Material::mirror("mirror", Vec3::ONE))]));
    let mut random = Stream::new(8);
    let mut counts = [0; 3];
    for case in 0..120 {
        let eye = (vector(&mut random) * 1.9).as_vec3().as_dvec3();
        let Some(sample) = traced(&scene, eye, vector(&mut random) * 1.9, &[(0, REFLECT)]) else { continue };
        let at = sample.first.value;
        let distance = at.distance(eye);
        let cosine = (at - eye).normalize().dot(at.normalize());
        if cosine < 0.2 {
            continue;
        }
        // 1/s + 1/s' = 2 / (R cos i) in the plane of incidence and 2 cos i / R across it.
        let focal = [2.0 / (radius * cosine), 2.0 * cosine / radius].map(|power| 1.0 / (power - 1.0 / distance));
        for share in [0.2, 0.7, 0.95, 1.05, 1.4, 4.0] {
            for near in focal.iter().filter(|focal| **focal > 0.0) {
                let length = near * share;
                if focal.iter().any(|focal| (length / focal - 1.0).abs() < 0.02) {
                    continue; // at a focal point
                }
                let expected = focal.iter().filter(|focal| **focal > 0.0 && length > **focal).count() as u32;
                let motion = sample.motion(length, DVec2::ZERO).unwrap();
                assert_eq!(motion.focal_index, expected, "case {case}: at {length} with focal points {focal:?}");
                counts[expected as usize] += 1;
            }
        }
    }
    assert!(counts.iter().all(|count| *count > 40), "{counts:?}");
}
