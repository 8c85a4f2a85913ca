//! Bundles of rays.

use catoptric_core::surface::patch::SurfacePatch;
use catoptric_core::surface::{AnalyticSurface, PlacedSurface};
use catoptric_engine::optics::path::bundle::{BounceKind, Eye, OutgoingRays, RayBundle};
use glam::{Affine3A, DVec2, DVec3, Vec3};

fn sphere(center: Vec3, radius: f32) -> PlacedSurface {
    let world_from_surface = Affine3A::from_translation(center).as_daffine3();
    PlacedSurface { surface: AnalyticSurface::Sphere { radius: radius.into() }, world_from_surface }
}

fn reflected(eye: DVec3, center: DVec3, radius: f64, direction: DVec3) -> (DVec3, DVec3) {
    let relative = eye - center;
    let b = relative.dot(direction);
    let distance = -b - (b * b - relative.length_squared() + radius * radius).sqrt();
    let at = eye + direction * distance;
    let normal = (at - center) / radius;
    (at, direction - normal * (2.0 * direction.dot(normal)))
}

fn sphere_bundle(eye: DVec3, center: DVec3, radius: f64, direction: DVec3) -> RayBundle {
    let (at, _) = reflected(eye, center, radius, direction);
    let surface = sphere(center.as_vec3(), radius as f32);
    let patch = SurfacePatch::of_implicit(at, &surface.taylor3(at)).expect("the surface has a patch");
    let arriving = RayBundle::arriving(&Eye::Point(eye), &patch).expect("the ray goes on");
    arriving.scattered(&patch, &RayBundle::own_parameters(), BounceKind::Reflect, 1.0).expect("the ray goes on")
}

#[test]
fn perturbations_of_a_sphere_are_of_third_order() {
    let (eye, center) = (DVec3::new(0.5, 1.0, 5.0), DVec3::new(0.25, 0.0, -0.5));
    let direction = DVec3::new(0.02, -0.15, -1.0).normalize();
    let bundle = sphere_bundle(eye, center, 1.0, direction);
    let rays = OutgoingRays::new(&bundle).unwrap();
    let mut errors = [[0f64; 3]; 2];
    for (scale, errors) in [2e-3, 1e-3].into_iter().zip(&mut errors) {
        // A point on a neighbouring ray, whose reflection point is exact.
        let turned = (direction + DVec3::new(1.0, -0.6, 0.3) * scale).normalize();
        let (truth, outgoing) = reflected(eye, center, 1.0, turned);
        let point = truth + outgoing * 2.3;
        let moved = rays.perturbed(point).unwrap();
        let at = |z: DVec2| bundle.first.value + bundle.first.first[0] * z.x + bundle.first.first[1] * z.y;
        let lifted = |z: DVec2| {
            let bend = &bundle.first.second;
            let l = moved.linear;
            at(z) + (bend[0] * (l.x * l.x) + bend[1] * (2.0 * l.x * l.y) + bend[2] * (l.y * l.y)) * 0.5
        };
        errors[0] = bundle.first.value.distance(truth);
        errors[1] = at(moved.linear).distance(truth);
        errors[2] = lifted(moved.linear + moved.quadratic).distance(truth);
    }
    for (order, (coarse, fine)) in errors[0].iter().zip(errors[1]).enumerate() {
        let rate = (coarse / fine).log2();
        assert!((rate - (order as f64 + 1.0)).abs() < 0.1, "order {order}: {coarse} {fine}, rate {rate}");
    }
}

#[test]
fn a_concave_sphere_focuses_at_half_its_radius() {
    // Rays near the axis from an eye at distance a from the mirror meet again at b, 1/a + 1/b = 2/R.
    let (radius, a) = (3.0f64, 2.4);
    let surface = sphere(Vec3::ZERO, radius as f32);
    let at = DVec3::new(0.0, 0.0, -radius);
    let patch = SurfacePatch::of_implicit(at, &surface.taylor3(at)).unwrap();
    let eye = Eye::Point(at + DVec3::Z * a);
    let bundle = RayBundle::arriving(&eye, &patch).unwrap();
    let bundle = bundle.scattered(&patch, &RayBundle::own_parameters(), BounceKind::Reflect, 1.0).unwrap();
    let focal = OutgoingRays::new(&bundle).unwrap().focal_distances();
    let expected = 1.0 / (2.0 / radius - 1.0 / a);
    for found in focal {
        assert!((found.unwrap() - expected).abs() < 1e-9 * expected, "{found:?} against {expected}");
    }
    // A convex one has none in front.
    let convex = sphere_bundle(DVec3::new(0.0, 0.1, 5.0), DVec3::ZERO, 1.0, DVec3::new(0.01, -0.1, -1.0).normalize());
    assert_eq!(OutgoingRays::new(&convex).unwrap().focal_distances(), [None, None]);
}
