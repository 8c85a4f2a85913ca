//! The search for all vertices of a scene at once.

use super::image::ReflectorImage;
use super::locator::ReflectorSearch;
use super::settings::{Images, ReflectorSearchSettings};
use crate::find::virtual_objects::{Reflector, ReflectorMesh, VertexRays};
use crate::virtual_object_method::LONGEST_EDGE;
use catoptric_core::parallel;
use catoptric_core::scene::{Scene, View};
use glam::Vec3;
use std::sync::Arc;

/// Vertices that a thread takes at once. A size for threads; chosen, not measured.
const AT_ONCE: usize = 4096;

/// The pictures of one reflector, for views and vertices that change from frame to frame.
///
/// Virtual vertices are the paper's (Estalella et al. 2006): mirror images in the tangent plane where the normal is the
/// half vector, without derivatives, correction, polish or a test of what is hidden. They are as far off as those of
/// the method with `refine = "texel"`. A reflector that shows a point several times gives one of its images.
///
/// ```
/// use catoptric::methods::projection::reflector_search::{ReflectorPictures, ReflectorSearchSettings};
/// use catoptric_scenes::builtin;
/// use glam::Vec3;
///
/// let scene = builtin::load("sphere_room", &[]).unwrap().pose(&Default::default()).unwrap();
/// let mirror = scene.specular_objects()[0];
/// let mut pictures = ReflectorPictures::new(&scene, mirror, &ReflectorSearchSettings::default());
/// pictures.look(&scene.default_view(640, 480));
/// let mut images = vec![Vec3::NAN; scene.positions.len()];
/// pictures.virtual_vertices(&scene.positions, &mut images);
/// assert!(images.iter().any(|image| image.is_finite()));
/// ```
pub struct ReflectorPictures {
    mesh: ReflectorMesh,
    settings: ReflectorSearchSettings,
    /// Made when they are first needed.
    cube: Option<Arc<ReflectorImage>>,
    seen: Option<ViewPictures>,
}

/// View-dependent data.
struct ViewPictures {
    view: View,
    rays: VertexRays,
    search: ReflectorSearch,
}

impl ReflectorPictures {
    /// Prepares an object of a scene, for no view yet.
    ///
    /// # Panics
    /// Where the scene has no such object.
    pub fn new(scene: &Scene, object: u32, settings: &ReflectorSearchSettings) -> Self {
        let mesh = ReflectorMesh::new(scene, object, LONGEST_EDGE);
        Self { mesh, settings: settings.clone(), cube: None, seen: None }
    }

    /// Triangles of the reflector.
    pub fn triangle_count(&self) -> usize {
        self.mesh.triangles.len()
    }

    /// Makes ready for the eye of a view.
    pub fn look(&mut self, view: &View) {
        let size = self.settings.map_size;
        let image = match self.settings.images {
            Images::Eye => ReflectorImage::from_eye(&self.mesh, view, size).map(Arc::new),
            Images::Cube => {
                let make = || Arc::new(ReflectorImage::around(&self.mesh, size.div_ceil(2)));
                Some(self.cube.get_or_insert_with(make).clone())
            }
        };
        let rays = VertexRays::of_view(&self.mesh, view);
        let reflector = Reflector { index: Some(0), mesh: &self.mesh, rays: &rays, view: Some(view) };
        let search = image.and_then(|image| ReflectorSearch::new(&reflector, image, self.settings.search));
        self.seen = search.map(|search| ViewPictures { view: view.clone(), rays, search });
    }

    /// Mirrors `points` into as many of `images`; points that the reflector does not show get images that are not
    /// finite.
    pub fn virtual_vertices(&self, points: &[Vec3], images: &mut [Vec3]) {
        let Some(seen) = &self.seen else { return images.fill(Vec3::NAN) };
        let reflector = Reflector { index: Some(0), mesh: &self.mesh, rays: &seen.rays, view: Some(&seen.view) };
        parallel::for_each_chunk_mut(images, AT_ONCE, |chunk, images| {
            let points = points.get(chunk * AT_ONCE..).unwrap_or_default();
            seen.search.mirror_images(&reflector, points, images);
        });
    }
}
