//! The locator of a reflector: its map, or its profile.

use super::map::ExplosionMap;
use super::profile::Profile;
use super::settings::ExplosionMapSettings;
use crate::find::virtual_objects::{Locator, ReflectionPoint, ReflectionPoints, Reflector};
use catoptric_core::math::Aabb;
use catoptric_engine::method::Report;
use glam::Vec3;

/// Finds points in one reflector, for one kind of rays.
pub(super) enum Finder {
    /// A map on spheres about the reflector.
    Map(ExplosionMap),
    /// The profile of a reflector that is a linear extrusion.
    Profile(Profile),
}

impl Finder {
    /// The best one for a reflector; returns `None` if that shows nothing.
    pub(super) fn new(reflector: &Reflector<'_>, scene: &Aabb, settings: &ExplosionMapSettings) -> Option<Self> {
        match Profile::new(reflector) {
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
                let mut found = Vec::new();
                for (image, point) in images.iter_mut().zip(points) {
                    found.clear();
                    profile.locate_point(reflector, *point, &mut found);
                    let mirrored = |first: &ReflectionPoint| {
                        let height = first.normal.dot(*point - first.position);
                        *point - first.normal * (2.0 * height)
                    };
                    *image = found.first().map_or(Vec3::NAN, mirrored);
                }
            }
        }
    }
}

/// Rays, cells and their beams, and maps of four spheres: measured on a mesh of ninety thousand triangles.
const WORK_A_TRIANGLE: u64 = 90;

impl Locator for Finder {
    fn locate(&self, reflector: &Reflector<'_>, points: &[Vec3], found: &mut ReflectionPoints) {
        match self {
            Self::Map(map) => map.locate(reflector, points, found),
            Self::Profile(profile) => profile.locate(reflector, points, found),
        }
    }

    fn add_fallbacks(&self, report: &mut Report) {
        match self {
            Self::Map(map) => map.add_fallbacks(report),
            Self::Profile(profile) => profile.add_fallbacks(report),
        }
    }

    fn work_a_triangle() -> u64 {
        WORK_A_TRIANGLE
    }

    fn build_work(&self) -> u64 {
        match self {
            Self::Map(map) => map.build_work(),
            Self::Profile(profile) => profile.build_work(),
        }
    }

    fn byte_count(&self) -> u64 {
        match self {
            Self::Map(map) => map.byte_count(),
            Self::Profile(profile) => profile.byte_count(),
        }
    }
}
