//! Patches of surfaces.

use catoptric_core::surface::{SurfacePatch, Taylor2, Taylor3};
use glam::{DMat3, DVec3};

#[test]
fn the_patch_of_a_sphere_is_the_sphere() {
    // g = |x|^2 - R^2; the unit normal of a sphere is x / R, to every order.
    let (radius, direction) = (2.5, DVec3::new(0.3, -0.8, 0.4).normalize());
    let at = direction * radius;
    let lower = Taylor2 { value: 0.0, gradient: at * 2.0, hessian: DMat3::IDENTITY * 2.0 };
    let patch = SurfacePatch::of_implicit(at, &Taylor3 { lower, third: [DMat3::ZERO; 3] }).unwrap();
    for a in 0..2 {
        assert!((patch.normal_change[a] - patch.tangents[a] / radius).length() < 1e-14);
    }
    for k in 0..3 {
        assert!((patch.normal_bend[k] - patch.bend[k] / radius).length() < 1e-14);
    }
    let step = 1e-3;
    assert!((patch.position_at([step, -step]).length() - radius).abs() < 1e-9);
}
