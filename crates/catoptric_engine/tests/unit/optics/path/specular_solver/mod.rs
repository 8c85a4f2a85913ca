//! Newton's method on specular paths: closed forms, laws of optics, odd input.

mod alhazen;
mod damped;
mod focal;
mod laws;
mod meshes;

use catoptric_core::math::random::Stream;
use catoptric_core::scene::{Material, Scene};
use catoptric_core::surface::AnalyticSurface;
use catoptric_engine::optics::path::bundle::{Bounce, BounceKind, Eye};
use catoptric_engine::optics::path::manifold::{ManifoldVertex, SpecularSurfaces};
use catoptric_engine::optics::path::specular_solver::{MAX_BOUNCES, PathSites, Problem, bundle_of, residual, solve};
use catoptric_testkit::scenes::{random_vector as vector, scene_of};
use glam::{Affine3A, DVec2, DVec3, Quat, Vec3};

pub(super) fn mirror() -> Material {
    Material::mirror("mirror", Vec3::ONE)
}

pub(super) fn sphere(center: Vec3, radius: f32, material: Material) -> (AnalyticSurface, Affine3A, Material) {
    (AnalyticSurface::Sphere { radius: radius.into() }, Affine3A::from_translation(center), material)
}

pub(super) fn bounce(object: u32, kind: BounceKind) -> Bounce {
    Bounce { object, kind }
}

#[test]
fn degenerate_input_gives_values_or_nothing() {
    let turned = Affine3A::from_rotation_translation(Quat::from_rotation_x(0.4), Vec3::new(0.0, -2.0, 0.0));
    let plane = (AnalyticSurface::Plane { half_width: 1.0, half_height: 1.0 }, turned, mirror());
    let scene = scene_of(&[
        sphere(Vec3::ZERO, 1.0, Material::glass("glass", 1.5)),
        plane,
        sphere(Vec3::X * 3.0, 1.0, mirror()),
    ]);
    let surfaces = SpecularSurfaces::new(&scene);
    let places = [
        DVec3::ZERO,
        DVec3::X,
        DVec3::Y * 0.5,
        DVec3::new(1e-300, 0.0, 0.0),
        DVec3::splat(1e300),
        DVec3::new(0.0, -2.0, 0.0),
        DVec3::NAN,
        DVec3::INFINITY,
        DVec3::new(0.0, 3.0, 1.0),
        DVec3::X * 2.0,
    ];
    let kinds = [BounceKind::Reflect, BounceKind::Transmit];
    let mut solved = 0;
    let mut try_path = |eye: &Eye, point: DVec3, path: &PathSites| {
        if let Some(found) = solve(&surfaces, eye, point, path, 20, 1e-10) {
            assert!(found.residual.is_finite());
            assert!(found.sites.sites[..found.sites.count].iter().all(|site| site.position.is_finite()));
            solved += found.converged as u32;
        }
        assert!(residual(&surfaces, eye, point, path).is_none_or(f64::is_finite));
        bundle_of(&surfaces, eye, path);
    };
    for eye in places {
        let direction = eye.try_normalize().unwrap_or(DVec3::NAN);
        for point in places {
            for start in places {
                for object in 0..4 {
                    for kind in kinds {
                        let one = (bounce(object, kind), ManifoldVertex::on_surface(start));
                        let two = (bounce((object + 1) % 3, kind), ManifoldVertex::on_surface(eye));
                        for eye in [Eye::Point(eye), Eye::Direction(direction)] {
                            try_path(&eye, point, &PathSites::new(&[one]).unwrap());
                            try_path(&eye, point, &PathSites::new(&[one, two]).unwrap());
                        }
                    }
                }
            }
        }
    }
    assert!(solved > 100, "{solved}");
    assert!(PathSites::new(&[(bounce(0, kinds[0]), ManifoldVertex::default()); MAX_BOUNCES + 1]).is_none());
    let none = PathSites::new(&[]).unwrap();
    assert!(solve(&surfaces, &Eye::Point(DVec3::Y * 3.0), DVec3::X, &none, 9, 1e-9).is_none());
    assert!(bundle_of(&surfaces, &Eye::Point(DVec3::Y * 3.0), &none).is_none());
}

#[test]
fn a_point_behind_a_mirror_is_not_reflected() {
    let plane = (AnalyticSurface::Plane { half_width: 5.0, half_height: 5.0 }, Affine3A::IDENTITY, mirror());
    let scene = scene_of(&[plane]);
    let surfaces = SpecularSurfaces::new(&scene);
    let eye = Eye::Point(DVec3::new(0.0, 2.0, 0.0));
    let start =
        PathSites::new(&[(bounce(0, BounceKind::Reflect), ManifoldVertex::on_surface(DVec3::new(0.3, 0.0, 0.1)))])
            .unwrap();
    let found = solve(&surfaces, &eye, DVec3::new(1.0, 2.0, 0.0), &start, 30, 1e-13).unwrap();
    assert!(found.converged && found.sites.sites[0].position.distance(DVec3::new(0.5, 0.0, 0.0)) < 1e-12);
    assert!(solve(&surfaces, &eye, DVec3::new(1.0, -2.0, 0.0), &start, 30, 1e-13).is_none());
    // Beyond its border it goes on, and `is_within` is false.
    let found = solve(&surfaces, &eye, DVec3::new(30.0, 2.0, 0.0), &start, 30, 1e-13).unwrap();
    assert!(found.converged && found.sites.sites[0].position.distance(DVec3::new(15.0, 0.0, 0.0)) < 1e-10);
    assert!(!surfaces.is_within(0, &found.sites.sites[0]));
}
