//! A photographer's studio as light from infinity.

use catoptric_core::math::portable::PortableMath;
use catoptric_core::scene::{Environment, Material, Model};
use glam::Vec3;
use std::sync::Arc;

const WIDTH: u32 = 256;
const HEIGHT: u32 = 128;

/// A soft box: where it is, its half extents in radians across and along, and its radiance.
struct SoftBox {
    towards: Vec3,
    half_extent: [f32; 2],
    radiance: f32,
}

/// The light of scenes that bring none: a large soft box above, a tall one at either side, walls and a floor of grey. A
/// white surface that faces up is about white.
pub fn studio() -> Environment {
    let boxes = [
        SoftBox { towards: Vec3::new(-0.25, 1.0, 0.35), half_extent: [0.55, 0.4], radiance: 2.2 },
        SoftBox { towards: Vec3::new(-1.0, 0.35, 0.45), half_extent: [0.16, 0.5], radiance: 2.4 },
        SoftBox { towards: Vec3::new(0.9, 0.4, 0.1), half_extent: [0.28, 0.42], radiance: 1.2 },
        SoftBox { towards: Vec3::new(0.2, 0.25, -1.0), half_extent: [0.5, 0.08], radiance: 1.6 },
    ];
    let mut radiance = Vec::with_capacity((WIDTH * HEIGHT) as usize);
    for row in 0..HEIGHT {
        for column in 0..WIDTH {
            let [u, v] = [(column, WIDTH), (row, HEIGHT)].map(|(at, count)| (at as f32 + 0.5) / count as f32);
            let direction = Environment::direction(u, v);
            // The floor is darker than the walls, without an edge between them.
            let wall = 0.22 + 0.16 * smooth(-0.35, 0.25, direction.y) + 0.1 * smooth(0.2, 1.0, direction.y);
            let light = boxes.iter().map(|soft_box| soft_box.radiance_towards(direction)).sum::<f32>();
            radiance.push([wall + light; 3]);
        }
    }
    Environment::new("studio", WIDTH, HEIGHT, radiance)
}

/// The names of the environments that need no file.
pub const ENVIRONMENT_NAMES: [&str; 2] = ["studio", "sky"];

/// One of [`ENVIRONMENT_NAMES`], by its name.
pub fn named_environment(name: &str) -> Option<Environment> {
    match name {
        "studio" => Some(studio()),
        "sky" => Some(crate::sky::sky()),
        _ => None,
    }
}

/// Puts a model that brings no light into the [`studio`], if it has mirrors or glass, or is given some by roles.
pub fn light_if_dark(model: &mut Model, has_roles: bool) {
    let is_lit = model.environment.is_some() || model.nodes.iter().any(|node| node.light.is_some());
    let reflects = |material: &Material| material.role.is_specular() || material.lobes().is_some();
    if !is_lit && (has_roles || model.materials.iter().any(reflects)) {
        model.environment = Some(Arc::new(studio()));
    }
}

impl SoftBox {
    fn radiance_towards(&self, direction: Vec3) -> f32 {
        let forward = self.towards.normalize();
        let across = Vec3::Y.cross(forward).normalize();
        let along = forward.cross(across);
        let depth = direction.dot(forward);
        if depth <= 0.0 {
            return 0.0;
        }
        let inside = [across, along].into_iter().zip(self.half_extent).map(|(axis, half)| {
            let angle = (direction.dot(axis) / depth).arc_tangent().abs();
            1.0 - smooth(half - 0.03, half + 0.03, angle)
        });
        // Brighter in the middle, as a lamp behind cloth is.
        let off_axis = direction.dot(across).abs().max(direction.dot(along).abs());
        self.radiance * inside.product::<f32>() * (1.0 - 0.35 * off_axis)
    }
}

/// From 0 to 1 between two values.
fn smooth(from: f32, to: f32, value: f32) -> f32 {
    let share = ((value - from) / (to - from)).clamp(0.0, 1.0);
    share * share * (3.0 - 2.0 * share)
}
