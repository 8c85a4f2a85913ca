//! Explosion maps as they were meant: all vertices of a scene mirrored at once.

use super::locator::Finder;
use super::settings::ExplosionMapSettings;
use crate::find::virtual_objects::{Reflector, ReflectorMesh, VertexRays};
use catoptric_core::parallel;
use catoptric_core::scene::{Scene, View};
use glam::Vec3;

/// Vertices that a thread takes at once. A size for threads; chosen, not measured.
const AT_ONCE: usize = 4096;

/// The explosion map of one convex reflector, for views and vertices that change from frame to frame.
///
/// Virtual vertices are the paper's (Ofek, Rappoport 1998): between the mirror images in the tangent planes of two
/// spheres' records, without derivatives, correction, polish or a test of what is hidden. They are as far off as the
/// `faithful` preset of the method. A reflector that shows a point several times gives one of its images.
///
/// ```
/// use catoptric::methods::projection::explosion_map::{ExplosionMapSettings, Preset, ReflectorMap};
/// use catoptric_scenes::builtin;
/// use glam::Vec3;
///
/// let scene = builtin::load("sphere_room", &[]).unwrap().pose(&Default::default()).unwrap();
/// let mirror = scene.specular_objects()[0];
/// let mut map = ReflectorMap::new(&scene, mirror, &ExplosionMapSettings::preset(Preset::Faithful));
/// map.look(&scene.default_view(640, 480));
/// let mut images = vec![Vec3::NAN; scene.positions.len()];
/// map.virtual_vertices(&scene.positions, &mut images);
/// assert!(images.iter().any(|image| image.is_finite()));
/// ```
pub struct ReflectorMap {
    mesh: ReflectorMesh,
    scene_bounds: catoptric_core::math::Aabb,
    settings: ExplosionMapSettings,
    /// The map for the last view; `None` if the reflector shows nothing.
    seen: Option<ViewMap>,
}

/// View-dependent data.
struct ViewMap {
    view: View,
    rays: VertexRays,
    finder: Finder,
}

impl ReflectorMap {
    /// Prepares an object of a scene, for no view yet.
    ///
    /// # Panics
    /// Where the scene has no such object.
    pub fn new(scene: &Scene, object: u32, settings: &ExplosionMapSettings) -> Self {
        let mesh = ReflectorMesh::new(scene, object, settings.longest_edge);
        Self { mesh, scene_bounds: scene.bounds, settings: settings.clone(), seen: None }
    }

    /// Triangles of the reflector.
    pub fn triangle_count(&self) -> usize {
        self.mesh.triangles.len()
    }

    /// Builds the map for the eye of a view.
    pub fn look(&mut self, view: &View) {
        let rays = VertexRays::of_view(&self.mesh, view);
        let reflector = Reflector { index: Some(0), mesh: &self.mesh, rays: &rays, view: Some(view) };
        let finder = Finder::new(&reflector, &self.scene_bounds, &self.settings);
        self.seen = finder.map(|finder| ViewMap { view: view.clone(), rays, finder });
    }

    /// Mirrors `points` into as many of `images`; points that the reflector does not show get images that are not
    /// finite.
    pub fn virtual_vertices(&self, points: &[Vec3], images: &mut [Vec3]) {
        let Some(ViewMap { view, rays, finder }) = &self.seen else { return images.fill(Vec3::NAN) };
        let reflector = Reflector { index: Some(0), mesh: &self.mesh, rays, view: Some(view) };
        parallel::for_each_chunk_mut(images, AT_ONCE, |chunk, images| {
            let points = points.get(chunk * AT_ONCE..).unwrap_or_default();
            finder.mirror_images(&reflector, points, images);
        });
    }
}
