//! Where layers are seen from.

use super::groups::LensGroup;
use crate::scene::{Camera, Scene, View};
use glam::{Quat, Vec3};

/// The widest picture of a group, in degrees.
const WIDEST_DEG: f32 = 100.0;

/// How much wider than the group a picture of it is.
const MARGIN: f32 = 1.02;

/// Viewpoints on an upright circle about a group through the eye of the scene's first camera, which is the first of them.
pub(super) fn circle(scene: &Scene, group: &LensGroup, count: u32) -> Vec<Vec3> {
    let center = group.center();
    let arm = scene.default_view(4, 3).eye() - center;
    let step = std::f32::consts::TAU / count as f32;
    (0..count).map(|number| center + Quat::from_rotation_y(number as f32 * step) * arm).collect()
}

/// The picture of a group from a viewpoint, `size` pixels a side.
pub(super) fn picture_of(scene: &Scene, group: &LensGroup, eye: Vec3, size: u32) -> View {
    let radius = 0.5 * group.bounds.diagonal();
    let sine = radius * MARGIN / eye.distance(group.center()).max(f32::MIN_POSITIVE);
    let fov_deg = (2.0 * sine.min(1.0).asin().to_degrees()).min(WIDEST_DEG);
    scene.view(&Camera::look_at("", eye, group.center(), Vec3::Y, fov_deg), size, size)
}
