//! The keys of analytic surfaces.

use super::{reflector, wrong_key};
use catoptric_core::scene::{Material, Role};
use catoptric_core::surface::AnalyticSurface;
use glam::Vec3;

fn surface(kind: &str, lines: &str) -> AnalyticSurface {
    reflector(kind, lines).unwrap().nodes.swap_remove(0).analytic.unwrap().surface
}

fn material(kind: &str, lines: &str) -> Material {
    reflector(kind, lines).unwrap().materials.swap_remove(0)
}

#[test]
fn surfaces_and_materials() {
    assert_eq!(surface("sphere", "radius = 2.0"), AnalyticSurface::Sphere { radius: 2.0 });
    assert_eq!(material("sphere", "radius = 2.0"), Material::mirror("sphere", Vec3::ONE));
    let plane = "normal = [0, 0, 1]\nsize = [2.0, 4.0]\nior = 1.3";
    assert_eq!(surface("plane", plane), AnalyticSurface::Plane { half_width: 1.0, half_height: 2.0 });
    assert_eq!(material("plane", plane).role, Role::Lens);
    let unit = "coefficients = [1, 1, 1, 0, 0, 0, 0, 0, 0, -1]\nbounds_min = [-1, -1, -1]\nbounds_max = [1, 1, 1]";
    for (kind, lines) in [
        ("ellipsoid", "radii = [1, 2, 3]"),
        ("quadric", unit),
        ("torus", "major_radius = 1\nminor_radius = 0.3"),
        ("superquadric", "radii = [1, 1, 1]\nexponents = [0.5, 1.5]"),
        ("revolution", "height = 2\nprofile = [5.8, -9.78, 3.9, 0.47]"),
    ] {
        assert_eq!(surface(kind, lines).kind(), kind);
    }
}

#[test]
fn wrong_keys_are_named() {
    let key = |kind: &str, lines: &str| wrong_key(reflector(kind, lines));
    assert_eq!(key("sphere", ""), "radius");
    assert_eq!(key("sphere", "radius = nan"), "radius");
    assert_eq!(key("sphere", "radius = -1"), "radius");
    assert_eq!(key("torus", "major_radius = 1\nminor_radius = 1"), "minor_radius");
    assert_eq!(key("ellipsoid", "radii = [1, 0, 1]"), "radii");
    assert_eq!(key("sphere", "radius = 1\nior = 11"), "ior");
    assert_eq!(key("sphere", "radius = 1\nior = 1.5\ninside = true"), "inside");
    assert_eq!(key("sphere", "radius = 1\ntint = [0, 2, 0]"), "tint");
    assert!(reflector("cube", "").unwrap_err().contains("sphere"));
}
