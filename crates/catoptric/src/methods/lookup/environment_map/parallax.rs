//! Where a reflected ray meets the shape that the surround is taken to have.

use super::settings::{EnvironmentMapSettings, Parallax};
use crate::math::Aabb;
use glam::Vec3;

/// The shape of the surround, for one map.
#[derive(Clone, Copy, Debug)]
pub(super) enum Surround {
    /// Infinitely far.
    Infinite,
    /// A box.
    Box(Aabb),
    /// A sphere about the map's centre.
    Sphere(f32),
}

impl Surround {
    /// The shape by the settings; `diffuse` is the box around everything that is reflected.
    pub(super) fn new(settings: &EnvironmentMapSettings, diffuse: &Aabb) -> Self {
        let given = Aabb { min: settings.box_min.into(), max: settings.box_max.into() };
        match settings.parallax {
            Parallax::None => Self::Infinite,
            Parallax::Box if given.size().min_element() > 0.0 => Self::Box(given),
            Parallax::Box if diffuse.is_empty() => Self::Infinite,
            Parallax::Box => Self::Box(*diffuse),
            Parallax::Sphere => {
                let automatic = diffuse.size().element_sum() / 6.0;
                let radius = if settings.radius > 0.0 { settings.radius } else { automatic };
                if radius > 0.0 { Self::Sphere(radius) } else { Self::Infinite }
            }
        }
    }

    /// The direction of the map (about `center`) that a ray from `position` reads.
    ///
    /// A position outside the shape is met by growing the shape to hold it.
    pub(super) fn direction(&self, center: Vec3, position: Vec3, direction: Vec3) -> Vec3 {
        let distance = self.distance(center, position, direction);
        if !distance.is_finite() {
            return direction;
        }
        let found = match self {
            Self::Sphere(_) => (position - center) + direction * distance,
            _ => position + direction * distance - center,
        };
        // On the shape's own centre every direction is as good as the ray's.
        if found.length_squared() > 0.0 { found } else { direction }
    }

    /// How far a ray of unit direction from `position` goes until it meets the shape; infinite where it never does.
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
    fn positions_outside_the_shape_give_a_direction() {
        let bounds = Aabb { min: Vec3::splat(-1.0), max: Vec3::ONE };
        for shape in [Surround::Box(bounds), Surround::Sphere(1.0)] {
            for direction in [Vec3::X, Vec3::NEG_X, Vec3::ZERO] {
                let found = shape.direction(Vec3::ZERO, Vec3::new(5.0, 0.0, 0.0), direction);
                assert!(found.is_finite());
            }
        }
    }
}
