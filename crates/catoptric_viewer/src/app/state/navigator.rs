//! The camera under the user's hands: orbit, pan, zoom, fly.

use catoptric::math::Aabb;
use catoptric::scene::{Camera, Projection};
use glam::{Affine3A, Quat, Vec2, Vec3};

/// Cameras turn up and down to this angle: 88 degrees.
const STEEPEST: f32 = 1.54;

/// The least distance to the pivot, in sizes of the scene.
const NEAREST: f32 = 1e-4;

/// The farthest distance to the pivot, in sizes of the scene.
const FARTHEST: f32 = 1e3;

/// A camera with the point that it turns about.
#[derive(Clone, Debug)]
pub(in crate::app) struct Navigator {
    camera: Camera,
    pivot: Vec3,
    /// The scene's diagonal.
    scene_size: f32,
}

impl Navigator {
    /// Begins with a camera of a scene; it turns about the point on its axis at the depth of the scene's centre.
    pub(in crate::app) fn new(camera: Camera, bounds: &Aabb) -> Self {
        let pivot = camera.point_looked_at(bounds);
        Self { camera, pivot, scene_size: bounds.diagonal().max(1e-6) }
    }

    /// The camera.
    pub(in crate::app) fn camera(&self) -> &Camera {
        &self.camera
    }

    fn eye(&self) -> Vec3 {
        self.camera.world_from_camera.translation.into()
    }

    fn axis(&self, index: usize) -> Vec3 {
        self.camera.world_from_camera.matrix3.col(index).into()
    }

    /// Turns the camera about a point: to the right about the upward direction, and up about its own right.
    fn turn(&mut self, center: Vec3, right: f32, up: f32) {
        let elevation = self.axis(2).y.clamp(-1.0, 1.0).asin();
        // A camera that a file has placed steeper only comes back.
        let up = up.clamp((elevation - STEEPEST).min(0.0), (elevation + STEEPEST).max(0.0));
        let yaw = Quat::from_axis_angle(Vec3::Y, right);
        let turn = Quat::from_axis_angle(yaw * self.axis(0), up) * yaw;
        let about =
            Affine3A::from_translation(center) * Affine3A::from_quat(turn) * Affine3A::from_translation(-center);
        self.place(about * self.camera.world_from_camera);
    }

    /// Takes a place, without the rounding errors that many small turns would heap up.
    fn place(&mut self, place: Affine3A) {
        let (_, rotation, translation) = place.to_scale_rotation_translation();
        if rotation.is_finite() && translation.is_finite() {
            self.camera.world_from_camera = Affine3A::from_rotation_translation(rotation.normalize(), translation);
        }
    }

    /// Turns about the pivot as the scene follows a finger that moves so far, in parts of the picture's height.
    pub(in crate::app) fn orbit(&mut self, moved: Vec2) {
        let half_turn = std::f32::consts::PI;
        self.turn(self.pivot, -moved.x * half_turn, -moved.y * half_turn);
    }

    /// Turns the head: about the eye. The pivot stays in front.
    pub(in crate::app) fn look(&mut self, moved: Vec2) {
        let distance = self.eye().distance(self.pivot);
        self.turn(self.eye(), -moved.x, -moved.y);
        self.pivot = self.eye() - self.axis(2) * distance;
    }

    /// The length at the pivot that the picture's height shows.
    fn height_at_pivot(&self) -> f32 {
        match self.camera.projection {
            Projection::Perspective { fov_y } => 2.0 * self.eye().distance(self.pivot) * (0.5 * fov_y).tan(),
            Projection::Orthographic { half_height } => 2.0 * half_height,
        }
    }

    /// Moves across the view, so that the pivot follows a finger that moves so far, in parts of the picture's height.
    pub(in crate::app) fn pan(&mut self, moved: Vec2) {
        let step = (self.axis(1) * moved.y - self.axis(0) * moved.x) * self.height_at_pivot();
        self.shift(step);
    }

    /// Goes nearer to the pivot by a factor; below 1, away from it.
    pub(in crate::app) fn zoom(&mut self, factor: f32) {
        // A wheel at rest must not add up rounding errors.
        if !(factor.is_finite() && factor > 0.0) || factor == 1.0 {
            return;
        }
        let distance = self.eye().distance(self.pivot);
        let (nearest, farthest) = (NEAREST * self.scene_size, FARTHEST * self.scene_size);
        if let Projection::Orthographic { half_height } = &mut self.camera.projection {
            *half_height = (*half_height / factor).clamp(nearest, farthest);
            return;
        }
        // From beyond the limits, where a file has placed it, a camera only comes back.
        let wanted = (distance / factor).clamp(nearest.min(distance), farthest.max(distance));
        // The pivot stays where it is seen.
        let back = (self.eye() - self.pivot).try_normalize().unwrap_or(self.axis(2));
        let eye = self.pivot + back * wanted;
        self.camera.world_from_camera.translation = eye.into();
    }

    /// Turns about another point from now on, and goes nearer to that; the view stays as it is.
    pub(in crate::app) fn focus(&mut self, point: Vec3) {
        if point.is_finite() {
            self.pivot = point;
        }
    }

    /// Flies along its own axes (right, up, back), in sizes of the scene. The pivot comes along.
    pub(in crate::app) fn fly(&mut self, step: Vec3) {
        let step = (self.axis(0) * step.x + self.axis(1) * step.y + self.axis(2) * step.z) * self.scene_size;
        self.shift(step);
    }

    fn shift(&mut self, step: Vec3) {
        let (eye, pivot) = (self.eye() + step, self.pivot + step);
        if eye.is_finite() && pivot.is_finite() && eye.length() < 1e9 * self.scene_size.max(1.0) {
            (self.camera.world_from_camera.translation, self.pivot) = (eye.into(), pivot);
        }
    }

    /// Goes back along its own direction until it sees all of a box.
    pub(in crate::app) fn frame(&mut self, bounds: &Aabb) {
        let radius = (bounds.diagonal() * 0.5).max(1e-6);
        self.pivot = bounds.center();
        let distance = match &mut self.camera.projection {
            Projection::Perspective { fov_y } => radius / (*fov_y * 0.5).sin(),
            Projection::Orthographic { half_height } => {
                *half_height = radius;
                self.scene_size.max(radius)
            }
        };
        self.camera.world_from_camera.translation = (self.pivot + self.axis(2) * distance).into();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn start() -> Navigator {
        let bounds = Aabb { min: Vec3::splat(-1.0), max: Vec3::ONE };
        Navigator::new(Camera::look_at("", Vec3::new(0.0, 0.5, 4.0), Vec3::ZERO, Vec3::Y, 40.0), &bounds)
    }

    #[test]
    fn the_scene_follows_the_finger() {
        let to_right = Vec2::new(0.1, 0.0);
        let mut navigator = start();
        navigator.orbit(to_right);
        // The near side moves to the right: the eye goes to the left.
        assert!(navigator.eye().x < -0.1 && (navigator.eye().length() - start().eye().length()).abs() < 1e-4);
        let mut navigator = start();
        let pivot = navigator.pivot;
        navigator.pan(to_right);
        let view = catoptric::scene::View::new(navigator.camera(), 300, 200, 1e-4);
        // A tenth of the height of 200 pixels.
        let seen = view.pixel_of(pivot).unwrap();
        assert!((seen - Vec2::new(170.0, 100.0)).length() < 0.01, "{seen}");
    }

    #[test]
    fn the_point_in_focus_stays_where_it_is_seen() {
        let mut navigator = start();
        let point = Vec3::new(0.7, 0.4, -0.3);
        let seen = |navigator: &Navigator| {
            catoptric::scene::View::new(navigator.camera(), 300, 200, 1e-4).pixel_of(point).unwrap()
        };
        let before = (seen(&navigator), navigator.camera().clone());
        navigator.focus(point);
        assert_eq!(*navigator.camera(), before.1);
        navigator.zoom(1.7);
        assert!(
            seen(&navigator).distance(before.0) < 0.05
                && navigator.eye() != before.1.world_from_camera.translation.into()
        );
        let distance = navigator.eye().distance(point);
        navigator.orbit(Vec2::new(0.2, 0.1));
        assert!((navigator.eye().distance(point) - distance).abs() < 1e-4);
    }

    #[test]
    fn framing_shows_everything() {
        let bounds = Aabb { min: Vec3::new(3.0, -1.0, -2.0), max: Vec3::new(9.0, 2.0, 0.0) };
        let mut navigator = start();
        navigator.frame(&bounds);
        let view = catoptric::scene::View::new(navigator.camera(), 200, 200, 1e-4);
        for corner in bounds.corners() {
            let seen = view.pixel_of(corner).unwrap();
            assert!(seen.min_element() > 0.0 && seen.max_element() < 200.0, "{seen}");
        }
    }

    proptest! {
        #[test]
        fn no_input_breaks_the_camera(
            steps in prop::collection::vec((0..6u8, -3.0f32..3.0, -3.0f32..3.0), 0..200)
        ) {
            let mut navigator = start();
            for (kind, x, y) in steps {
                match kind {
                    0 => navigator.orbit(Vec2::new(x, y)),
                    1 => navigator.pan(Vec2::new(x, y)),
                    2 => navigator.zoom(2f32.powf(4.0 * x)),
                    3 => navigator.look(Vec2::new(x, y)),
                    4 => navigator.focus(Vec3::new(x, y, x - y)),
                    _ => navigator.fly(Vec3::new(x, y, x * y)),
                }
                let place = navigator.camera().world_from_camera;
                prop_assert!(place.is_finite());
                prop_assert!((place.matrix3.determinant() - 1.0).abs() < 1e-3);
                // The camera stays upright.
                prop_assert!(navigator.axis(1).y > 0.0 && navigator.axis(0).y.abs() < 1e-2);
            }
        }
    }
}
