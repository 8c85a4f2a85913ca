//! Simple shapes that a surround is taken to have, and where rays meet them.

use crate::math::Aabb;
use glam::{Vec2, Vec3};

/// The shape of a surround.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Surround {
    /// Infinitely far.
    Infinite,
    /// A box.
    Box(Aabb),
    /// A sphere about the map's centre.
    Sphere(f32),
    /// An upright cylinder about the map's centre, with a bottom and a top that are this much higher than that.
    Cylinder { radius: f32, bottom: f32, top: f32 },
}

impl Surround {
    /// The direction of the map (about `center`) that a ray from `position` reads.
    ///
    /// A position outside the shape is met by growing the shape to hold it.
    #[inline(always)] // for the instructions of its caller
    pub(super) fn direction(&self, center: Vec3, position: Vec3, direction: Vec3) -> Vec3 {
        let distance = self.distance(center, position, direction);
        if !distance.is_finite() {
            return direction;
        }
        let found = match self {
            Self::Sphere(_) | Self::Cylinder { .. } => (position - center) + direction * distance,
            _ => position + direction * distance - center,
        };
        // On the shape's own centre every direction is as good as the ray's.
        if found.length_squared() > 0.0 { found } else { direction }
    }

    /// How far a ray of unit direction from `position` goes until it meets the shape; infinite where it never does.
    #[inline(always)] // for the instructions of its caller
    pub(super) fn distance(&self, center: Vec3, position: Vec3, direction: Vec3) -> f32 {
        match *self {
            Self::Infinite => f32::INFINITY,
            Self::Box(bounds) => {
                let bounds = bounds.with(position);
                let exit = Vec3::select(direction.cmpgt(Vec3::ZERO), bounds.max, bounds.min);
                // A component of zero never leaves; its quotient is infinite or not a number, and is left out.
                let distances = ((exit - position) / direction).to_array();
                distances.into_iter().filter(|t| t.is_finite()).fold(f32::INFINITY, f32::min)
            }
            Self::Sphere(radius) => {
                let offset = position - center;
                let along = offset.dot(direction);
                let beyond = (radius * radius).max(offset.length_squared()) - offset.length_squared();
                (along * along + beyond).sqrt() - along
            }
            Self::Cylinder { radius, bottom, top } => {
                let offset = position - center;
                let (aside, across) = (Vec2::new(offset.x, offset.z), Vec2::new(direction.x, direction.z));
                let along = aside.dot(across);
                let beyond = (radius * radius - aside.length_squared()).max(0.0);
                let side =
                    ((along * along + across.length_squared() * beyond).sqrt() - along) / across.length_squared();
                let end = if direction.y > 0.0 { top.max(offset.y) } else { bottom.min(offset.y) };
                // A component of zero never leaves; its quotient is infinite or not a number, and is left out.
                let distances = [side, (end - offset.y) / direction.y];
                distances.into_iter().filter(|t| t.is_finite()).fold(f32::INFINITY, f32::min)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_meet_the_shape() {
        let bounds = Aabb { min: Vec3::new(-1.0, -2.0, -3.0), max: Vec3::new(1.0, 2.0, 3.0) };
        let center = Vec3::new(0.1, 0.2, 0.3);
        let position = Vec3::new(0.5, 0.0, 0.0);
        let hit = Surround::Box(bounds).direction(center, position, Vec3::X) + center;
        assert!((hit - Vec3::new(1.0, 0.0, 0.0)).length() < 1e-6);
        assert_eq!(Surround::Box(bounds).distance(center, position, Vec3::X), 0.5);
        assert_eq!(Surround::Infinite.distance(center, position, Vec3::X), f32::INFINITY);
        let slanted = Vec3::new(0.0, -0.6, 0.8);
        let hit = Surround::Box(bounds).direction(center, position, slanted) + center;
        assert!((hit - Vec3::new(0.5, -2.0, 2.0 / 0.6 * 0.8)).length() < 1e-5, "{hit}");
        let hit = Surround::Sphere(2.0).direction(center, position, slanted) + center;
        assert!(((hit - center).length() - 2.0).abs() < 1e-5);
        assert!((hit - position).cross(slanted).length() < 1e-5 && (hit - position).dot(slanted) > 0.0);
    }

    #[test]
    fn rays_meet_the_side_and_the_ends_of_a_cylinder() {
        let cylinder = Surround::Cylinder { radius: 2.0, bottom: -1.0, top: 3.0 };
        let center = Vec3::new(5.0, 0.0, 1.0);
        let position = center + Vec3::new(0.5, 0.5, 0.0);
        let distance = |direction: Vec3| cylinder.distance(center, position, direction.normalize());
        assert!((distance(Vec3::X) - 1.5).abs() < 1e-6);
        assert!((distance(Vec3::Y) - 2.5).abs() < 1e-6 && (distance(Vec3::NEG_Y) - 1.5).abs() < 1e-6);
        let found = cylinder.direction(center, position, Vec3::new(-0.6, 0.1, 0.8).normalize());
        assert!((Vec2::new(found.x, found.z).length() - 2.0).abs() < 1e-5, "{found}");
        let found = cylinder.direction(center, position, Vec3::new(0.1, -0.9, 0.0).normalize());
        assert!((found.y + 1.0).abs() < 1e-5, "{found}");
    }

    #[test]
    fn positions_outside_the_shape_give_a_direction() {
        let bounds = Aabb { min: Vec3::splat(-1.0), max: Vec3::ONE };
        let cylinder = Surround::Cylinder { radius: 1.0, bottom: -1.0, top: 1.0 };
        for shape in [Surround::Box(bounds), Surround::Sphere(1.0), cylinder] {
            for direction in [Vec3::X, Vec3::NEG_X, Vec3::ZERO] {
                let found = shape.direction(Vec3::ZERO, Vec3::new(5.0, 0.0, 0.0), direction);
                assert!(found.is_finite());
            }
        }
    }
}
