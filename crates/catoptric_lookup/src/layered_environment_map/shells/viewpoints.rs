//! Viewpoints for which layers are inferred, and their weights for an eye between them.

use super::groups::LensGroup;
use crate::layered_environment_map::settings::{LayeredEnvironmentMapSettings, Viewpoints};
use catoptric_core::math::portable::{PortableMath, turn_about_f32};
use catoptric_core::scene::{Camera, Scene, View};
use glam::{Vec2, Vec3};
use std::f32::consts::TAU;

/// The widest picture of a group, in degrees. Chosen, not measured.
const WIDEST_DEG: f32 = 100.0;

/// The width of a picture of the group, in widths of the group. Chosen, not measured.
const MARGIN: f32 = 1.02;

/// Eyes of a grid look down or up no steeper than this, in degrees. Chosen, not measured.
const STEEPEST_DEG: f32 = 85.0;

/// Viewpoints with a smaller share in a picture are left out. Half a step of eight bits; not measured.
const MIN_SHARE: f32 = 1.0 / 512.0;

/// Viewpoints about a group, in rows of `columns`; with the eye of the scene's first camera among them.
#[derive(Clone, Debug, PartialEq)]
pub struct Viewspace {
    center: Vec3,
    /// The vector from the centre to the eye of the scene's first camera.
    arm: Vec3,
    shape: ViewspaceShape,
    /// Viewpoints in a row.
    pub columns: u32,
}

#[derive(Clone, Debug, PartialEq)]
enum ViewspaceShape {
    /// Around the upright axis through the centre, at these heights above the horizon (radians), ascending, evenly.
    Circles(Vec<f32>),
    /// Along this axis, a step from each to the next.
    Line(Vec3),
}

/// Viewpoints about an eye with their shares in its picture; up to four.
pub(crate) type Shares = Vec<(u32, f32)>;

impl Viewspace {
    /// About a group of a scene.
    pub fn new(settings: &LayeredEnvironmentMapSettings, scene: &Scene, group: &LensGroup) -> Self {
        let center = group.center();
        let arm = scene.default_view(4, 3).eye() - center;
        let height = elevation(arm);
        let count = settings.viewpoint_count;
        let shape = match settings.viewpoints {
            Viewpoints::Circle => ViewspaceShape::Circles(vec![height]),
            Viewpoints::Grid => {
                let rows = settings.viewpoint_rows as f32;
                let step = TAU / count as f32;
                let steepest = STEEPEST_DEG.to_radians();
                let from_middle = |row: u32| (row as f32 - 0.5 * (rows - 1.0)) * step;
                // The camera's height is that of one of the rows, where there are three or more.
                let highest = (steepest - from_middle(settings.viewpoint_rows - 1)).max(0.0);
                let middle = height.clamp(-highest, highest);
                ViewspaceShape::Circles((0..settings.viewpoint_rows).map(|row| middle + from_middle(row)).collect())
            }
            Viewpoints::Line => {
                let span = if settings.line_length > 0.0 { settings.line_length } else { arm.length() };
                let along = Vec3::new(arm.z, 0.0, -arm.x).normalize_or(Vec3::X);
                ViewspaceShape::Line(along * (span / (count - 1).max(1) as f32))
            }
        };
        Self { center, arm, shape, columns: count }
    }

    /// The number of viewpoints.
    pub fn count(&self) -> u32 {
        match &self.shape {
            ViewspaceShape::Circles(heights) => self.columns * heights.len() as u32,
            ViewspaceShape::Line(_) => self.columns,
        }
    }

    /// The eye of a viewpoint, or a place between viewpoints: `offset` is in steps along a row.
    pub fn eye(&self, number: u32, offset: f32) -> Vec3 {
        let (row, column) = (number / self.columns, (number % self.columns) as f32 + offset);
        match &self.shape {
            ViewspaceShape::Circles(heights) => {
                let height = heights.get(row as usize).copied().unwrap_or(0.0);
                let flat = Vec3::new(self.arm.x, 0.0, self.arm.z).normalize_or(Vec3::Z);
                let out = flat * height.cosine() + Vec3::Y * height.sine();
                self.center + turn_about_f32(Vec3::Y, column * TAU / self.columns as f32) * out * self.arm.length()
            }
            ViewspaceShape::Line(step) => self.center + self.arm + *step * (column - 0.5 * (self.columns - 1) as f32),
        }
    }

    /// The viewpoints nearest to an eye: of a row two, between two rows four.
    pub fn around(&self, eye: Vec3) -> Shares {
        let arm = eye - self.center;
        let (column, row) = match &self.shape {
            ViewspaceShape::Circles(heights) => {
                let turned = angle(arm) - angle(self.arm);
                let step = TAU / self.columns as f32;
                let row = match &heights[..] {
                    [first, second, ..] => (elevation(arm) - first) / (second - first),
                    _ => 0.0,
                };
                ((turned / step).rem_euclid(self.columns as f32), row.clamp(0.0, (heights.len() - 1) as f32))
            }
            ViewspaceShape::Line(step) => {
                let along = (arm - self.arm).dot(*step) / step.length_squared().max(f32::MIN_POSITIVE);
                let last = (self.columns - 1) as f32;
                ((along + 0.5 * last).clamp(0.0, last), 0.0)
            }
        };
        let place = Vec2::new(column, row);
        let low = place.floor();
        let part = place - low;
        let number = |dx: u32, dy: u32| (low.y as u32 + dy) * self.columns + (low.x as u32 + dx) % self.columns;
        let shares = [
            (number(0, 0), (1.0 - part.x) * (1.0 - part.y)),
            (number(1, 0), part.x * (1.0 - part.y)),
            (number(0, 1), (1.0 - part.x) * part.y),
            (number(1, 1), part.x * part.y),
        ];
        // Shares that are not numbers are left out, and those too small to be seen.
        let seen = shares.into_iter().filter(|(_, share)| *share > MIN_SHARE);
        let sum: f32 = seen.clone().map(|(_, share)| share).sum();
        seen.map(|(number, share)| (number, share / sum)).collect()
    }
}

/// The angle above the horizon, in radians.
fn elevation(arm: Vec3) -> f32 {
    arm.y.arc_tangent2(Vec2::new(arm.x, arm.z).length())
}

/// Around the upright axis, in radians.
fn angle(arm: Vec3) -> f32 {
    arm.x.arc_tangent2(arm.z)
}

/// The picture past a group from a viewpoint, as wide as any, `size` pixels a side.
pub(crate) fn picture_past(scene: &Scene, group: &LensGroup, eye: Vec3, size: u32) -> View {
    scene.view(&Camera::look_at("", eye, group.center(), Vec3::Y, WIDEST_DEG), size, size)
}

/// The picture of a group from a viewpoint, `size` pixels a side.
pub fn picture_of(scene: &Scene, group: &LensGroup, eye: Vec3, size: u32) -> View {
    let radius = 0.5 * group.bounds.diagonal();
    let sine = radius * MARGIN / eye.distance(group.center()).max(f32::MIN_POSITIVE);
    let fov_deg = (2.0 * sine.min(1.0).arc_sine().to_degrees()).min(WIDEST_DEG);
    scene.view(&Camera::look_at("", eye, group.center(), Vec3::Y, fov_deg), size, size)
}
