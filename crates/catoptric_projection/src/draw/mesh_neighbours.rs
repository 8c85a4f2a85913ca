//! The triangles beside those of reflectors and lenses: a picture's edges are off by parts of a pixel, rays are not.

use catoptric_core::scene::{Ray, Scene};
use catoptric_core::surface::mesh::adjacency::NO_NEIGHBOUR;
use catoptric_engine::raster::LayerSurface;
use glam::Vec2;

/// A place in a triangle's plane belongs to it up to this far beside it, in sizes of the triangle: pictures are off by
/// parts of a pixel. Chosen, not measured.
pub(super) const BESIDE: f32 = 3.0;

/// A place this far beside a triangle, in its sizes, still belongs to it: rounding.
const ROUNDING: f32 = 1e-4;

/// The maximum number of triangles that are passed on the way to a place.
const MAX_STEPS: usize = 8;

/// The neighbours across their edges of the triangles of a scene's reflectors and lenses that are meshes.
#[derive(Clone, Debug, Default)]
pub(super) struct MeshNeighbours {
    /// For each object and each of its triangles, the triangles across the edges opposite to the corners.
    pub(super) objects: Vec<Vec<[u32; 3]>>,
}

impl MeshNeighbours {
    /// [`Self::meet`] for a place in the picture, which may lie beyond the edge of the triangle that a sample beside it
    /// shows.
    #[inline(always)] // for the instructions of its caller
    pub(super) fn meet_seen(&self, scene: &Scene, ray: &Ray, surface: &mut LayerSurface) {
        let at = surface.barycentrics.value;
        let is_within = at.x > 0.0 && at.y > 0.0 && at.x + at.y < 1.0;
        if !is_within {
            self.meet(scene, ray, surface);
        }
    }

    /// Moves a surface to where a ray meets it, which may be in a triangle beside that of the surface; false, and
    /// nothing is done, if there is no such place.
    #[inline(always)] // for the instructions of its caller
    pub(super) fn meet(&self, scene: &Scene, ray: &Ray, surface: &mut LayerSurface) -> bool {
        let object = scene.triangle_objects[surface.source as usize];
        let first = scene.objects[object as usize].triangles.start;
        let Some(across) = self.objects.get(object as usize).filter(|across| !across.is_empty()) else { return false };
        let mut triangle = surface.source;
        for _ in 0..MAX_STEPS {
            let Some((at, distance)) = scene.plane_met(triangle, ray) else { return false };
            let weights = [1.0 - at.x - at.y, at.x, at.y];
            let mut least = 0;
            for corner in 1..3 {
                least = if weights[corner] < weights[least] { corner } else { least };
            }
            if weights[least] >= -ROUNDING && distance > 0.0 {
                surface.source = triangle;
                surface.barycentrics.value = at.clamp(Vec2::ZERO, Vec2::ONE);
                return true;
            }
            if weights[least] < -BESIDE {
                return false;
            }
            match across[(triangle - first) as usize][least] {
                NO_NEIGHBOUR => return false,
                other => triangle = first + other,
            }
        }
        false
    }
}
