//! The shape that the surround is taken to have.

use super::settings::{EnvironmentMapSettings, Parallax};
use crate::math::Aabb;
use crate::methods::lookup::surround::Surround;

/// The shape by the settings; `diffuse` is the box around everything that is reflected.
pub(super) fn surround_of(settings: &EnvironmentMapSettings, diffuse: &Aabb) -> Surround {
    let given = Aabb { min: settings.box_min.into(), max: settings.box_max.into() };
    match settings.parallax {
        Parallax::None => Surround::Infinite,
        Parallax::Box if given.size().min_element() > 0.0 => Surround::Box(given),
        Parallax::Box if diffuse.is_empty() => Surround::Infinite,
        Parallax::Box => Surround::Box(*diffuse),
        Parallax::Sphere => {
            let automatic = diffuse.size().element_sum() / 6.0;
            let radius = if settings.radius > 0.0 { settings.radius } else { automatic };
            if radius > 0.0 { Surround::Sphere(radius) } else { Surround::Infinite }
        }
    }
}
