//! What finds points in a reflector: its map, or its profile.

use super::map::ExplosionMap;
use super::profile::Profile;
use super::settings::ExplosionMapSettings;
use crate::math::Aabb;
use crate::methods::projection::virtual_objects::{Foot, Locator, Reflector};
use glam::Vec3;

/// Finds points in one reflector, for one kind of rays.
pub(super) enum Finder {
    /// By the spheres about it.
    Map(ExplosionMap),
    /// By its profile, of reflectors that are drawn along one axis.
    Profile(Profile),
}

impl Finder {
    /// The best one for a reflector; none where that shows nothing.
    pub(super) fn new(reflector: &Reflector<'_>, scene: &Aabb, settings: &ExplosionMapSettings) -> Option<Self> {
        let profile = if settings.extrusions { Profile::new(reflector) } else { None };
        match profile {
            Some(profile) => Some(Self::Profile(profile)),
            None => ExplosionMap::new(reflector, scene, settings).map(Self::Map),
        }
    }

    /// Mirrors points, each in the tangent plane at one place where it appears; see
    /// [`super::ReflectorMap::virtual_vertices`].
    pub(super) fn mirror_images(&self, reflector: &Reflector<'_>, points: &[Vec3], images: &mut [Vec3]) {
        match self {
            Self::Map(map) => map.mirror_images(points, images),
            Self::Profile(profile) => {
                for (image, point) in images.iter_mut().zip(points) {
                    let mut first = None;
                    profile.locate(reflector, *point, &mut |foot| {
                        let height = foot.normal.dot(*point - foot.position);
                        first.get_or_insert(*point - foot.normal * (2.0 * height));
                    });
                    *image = first.unwrap_or(Vec3::NAN);
                }
            }
        }
    }
}

impl Locator for Finder {
    fn locate(&self, reflector: &Reflector<'_>, point: Vec3, take: &mut dyn FnMut(&Foot)) {
        match self {
            Self::Map(map) => map.locate(reflector, point, take),
            Self::Profile(profile) => profile.locate(reflector, point, take),
        }
    }

    fn byte_count(&self) -> u64 {
        match self {
            Self::Map(map) => map.byte_count(),
            Self::Profile(profile) => profile.byte_count(),
        }
    }
}
