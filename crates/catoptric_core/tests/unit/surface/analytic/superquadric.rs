//! Superquadrics.

use catoptric_core::surface::Superquadric;
use glam::DVec3;
use num_dual::Dual64;

#[test]
fn dual_numbers_along_a_ray_agree_with_the_gradient() {
    let surface = Superquadric::new([1.0, 0.7, 0.4], [0.6, 2.5]).unwrap();
    let (origin, direction) = (DVec3::new(0.3, -0.2, 0.5), DVec3::new(-0.4, 0.9, 0.1));
    let point: [Dual64; 3] = std::array::from_fn(|axis| Dual64::new(origin[axis], direction[axis]));
    let dual = surface.value(point);
    let (value, gradient) = surface.value_and_gradient(origin);
    assert!((dual.re - value).abs() < 1e-14 && (dual.eps - gradient.dot(direction)).abs() < 1e-13);
}
