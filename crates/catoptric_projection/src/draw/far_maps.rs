//! Maps of far objects: those so far from a reflector that a look-up by the direction alone shows them in their places
//! are captured about its centre, and seen behind all that is projected (Chen, Arvo 2000, conclusion).

use catoptric_core::progress::{Progress, Stage};
use catoptric_core::scene::shade::SurfaceInteraction;
use catoptric_core::scene::{Environment, Light, Material, Ray, RayDifferential, Scene, Texture, View};
use catoptric_core::surface::PlacedSurface;
use catoptric_engine::error::RenderError;
use catoptric_engine::light::cube_map::CubeMap;
use catoptric_engine::light::reflector_shader::ReflectorShader;
use catoptric_engine::method::Report;
use catoptric_engine::method::lookup_shader::LookupShader;
use catoptric_engine::method::reflector_maps::{CaptureLimits, ReflectorMapSettings, ReflectorMaps, face_pictures};
use catoptric_engine::raster::{Fragment, LookShader, ShadingRequest};
use glam::{Vec2, Vec3, Vec4Swizzles};
use std::sync::Arc;

/// Environment maps that take the place of projected geometry.
#[derive(Clone, Copy, Default)]
pub(crate) struct MapsInView<'a> {
    /// Environment maps of reflectors at which no path goes on.
    pub(crate) whole: Option<&'a ReflectorMaps>,
    /// Maps of the objects that are far from a reflector, seen behind its paths.
    pub(crate) far: Option<&'a FarMaps>,
}

/// The maps of a scene's reflectors and lenses, of the objects that are far from each.
#[derive(Default)]
pub(crate) struct FarMaps {
    /// The far map of every object of the scene, `None` where it has none.
    maps: Vec<Option<FarMap>>,
    captured_faces: u64,
    /// Maps with fewer texels than wanted, and reflectors whose far objects are projected for want of work.
    smaller: u64,
    left_out: u64,
}

/// The map of one reflector.
struct FarMap {
    source: MapSource,
    /// Radiance of the far objects times their coverage, and that coverage.
    cube: Arc<CubeMap>,
}

/// Everything that a map depends on: it is kept while these are equal.
#[derive(PartialEq)]
struct MapSource {
    center: Vec3,
    size: u32,
    /// The far objects, by their numbers.
    objects: Vec<(u32, ObjectSource)>,
    materials: Vec<Material>,
    lights: Vec<Light>,
    textures: Vec<SameArc<Texture>>,
    environment: Option<SameArc<Environment>>,
}

/// The geometry of an object, in world space.
#[derive(PartialEq)]
struct ObjectSource {
    material: u32,
    inside: bool,
    surface: Option<PlacedSurface>,
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    uvs: Vec<[Vec2; 2]>,
    colors: Vec<[f32; 4]>,
    /// Corners, counted from the object's first vertex.
    triangles: Vec<[u32; 3]>,
}

/// A shared value that equals itself alone.
struct SameArc<T>(Arc<T>);

impl<T> PartialEq for SameArc<T> {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl MapSource {
    fn new(scene: &Scene, center: Vec3, size: u32, objects: &[u32]) -> Self {
        Self {
            center,
            size,
            objects: objects.iter().map(|&object| (object, ObjectSource::new(scene, object))).collect(),
            materials: scene.materials.clone(),
            lights: scene.lights.clone(),
            textures: scene.textures.iter().cloned().map(SameArc).collect(),
            environment: scene.environment.clone().map(SameArc),
        }
    }
}

impl ObjectSource {
    fn new(scene: &Scene, object: u32) -> Self {
        let object = &scene.objects[object as usize];
        let vertices = object.vertices.start as usize..object.vertices.end as usize;
        let triangles = &scene.triangles[object.triangles.start as usize..object.triangles.end as usize];
        let first = object.vertices.start;
        Self {
            material: object.material,
            inside: object.inside,
            surface: object.surface.clone(),
            positions: scene.positions[vertices.clone()].to_vec(),
            normals: scene.normals[vertices.clone()].to_vec(),
            uvs: scene.uvs[vertices.clone()].to_vec(),
            colors: scene.colors.get(vertices).unwrap_or_default().to_vec(),
            triangles: triangles.iter().map(|corners| corners.map(|corner| corner.wrapping_sub(first))).collect(),
        }
    }
}

/// The settings of a capture at infinity with so many texels a side.
fn capture_settings(size: u32) -> ReflectorMapSettings {
    ReflectorMapSettings { size, ..ReflectorMapSettings::default() }
}

/// The work of all captures in rounds over the scene: where there is an environment a second one takes the coverage.
fn limits(scene: &Scene, wanted: u32) -> CaptureLimits {
    let rounds = 1 + u32::from(scene.environment.is_some());
    CaptureLimits::new(&capture_settings(wanted), scene, scene.specular_objects().len().max(1), rounds)
}

impl FarMaps {
    /// Texels a side that maps of all reflectors may have, at most those wanted.
    pub(crate) fn affordable_size(scene: &Scene, wanted: u32) -> u32 {
        limits(scene, wanted).size
    }

    /// Captures the maps of the objects that are far from each reflector (by object, in ascending order); those of
    /// `old` that would be the same are taken. Where there is work for some only, those of the most triangles have one.
    ///
    /// # Errors
    /// [`RenderError::Cancelled`].
    pub(crate) fn capture(
        scene: &Scene,
        far: &[Vec<u32>],
        wanted: u32,
        mut old: Option<Self>,
        progress: &dyn Progress,
    ) -> Result<Self, RenderError> {
        let CaptureLimits { count, size } = limits(scene, wanted);
        let triangles =
            |reflector: &u32| far[*reflector as usize].iter().map(|&o| scene.objects[o as usize].triangles.len()).sum();
        let mut reflectors: Vec<u32> = (0..far.len() as u32).filter(|&one| !far[one as usize].is_empty()).collect();
        reflectors.sort_by_key(|one| (std::cmp::Reverse::<usize>(triangles(one)), *one));
        let left_out = reflectors.len().saturating_sub(count) as u64;
        reflectors.truncate(count);
        let smaller = if size < wanted { reflectors.len() as u64 } else { 0 };
        let mut maps = Self { smaller, left_out, ..Self::default() };
        maps.maps.resize_with(scene.objects.len(), || None);
        let stage = Stage::begin(progress, "capturing maps of far objects", reflectors.len())?;
        for reflector in reflectors {
            let center = scene.objects[reflector as usize].bounds.center();
            let source = MapSource::new(scene, center, size, &far[reflector as usize]);
            let old = old.as_mut().and_then(|old| old.maps.get_mut(reflector as usize)?.take());
            let map = match old.filter(|old| old.source == source) {
                Some(same) => same,
                None => {
                    maps.captured_faces += 6;
                    FarMap::capture(scene, source)?
                }
            };
            maps.maps[reflector as usize] = Some(map);
            stage.advance(1)?;
        }
        Ok(maps)
    }

    /// True if a reflector shows an object by its map.
    pub(super) fn shows(&self, reflector: u32, object: u32) -> bool {
        self.map(reflector).is_some_and(|map| map.shows(object))
    }

    /// The radiance from a direction at the end of paths whose last bounce is on a reflector; `change` is that of the
    /// ray from pixel to pixel.
    #[inline(never)] // kept out of the walk along paths
    pub(super) fn behind(
        &self,
        scene: &Scene,
        reflector: u32,
        direction: Vec3,
        change: impl FnOnce() -> RayDifferential,
    ) -> Vec3 {
        let background = scene.background(direction);
        let Some(map) = self.map(reflector) else { return background };
        let RayDifferential { direction_dx, direction_dy, .. } = change();
        let found = map.cube.filtered_with_coverage(direction, [direction_dx, direction_dy]);
        found.xyz() + background * (1.0 - found.w).max(0.0)
    }

    fn map(&self, reflector: u32) -> Option<&FarMap> {
        self.maps.get(reflector as usize)?.as_ref()
    }

    /// Faces of cubes drawn since the last view or change of the scene.
    pub(crate) fn captured_faces(&self) -> u64 {
        self.captured_faces
    }

    /// Adds counts, fall-backs and bytes to a report.
    pub(crate) fn describe(&self, report: &mut Report) {
        let maps = || self.maps.iter().flatten();
        report.counts.insert("far_maps", maps().count() as u64);
        report.counts.insert("far_objects", maps().map(|map| map.source.objects.len() as u64).sum());
        report.bytes.insert("far_maps", maps().map(|map| map.cube.byte_count()).sum());
        report.add_fallback("smaller_far_maps", self.smaller);
        report.add_fallback("far_maps_left_out", self.left_out);
    }
}

impl FarMap {
    fn shows(&self, object: u32) -> bool {
        self.source.objects.binary_search_by_key(&object, |(shown, _)| *shown).is_ok()
    }

    fn capture(scene: &Scene, source: MapSource) -> Result<Self, RenderError> {
        let (settings, center) = (capture_settings(source.size), source.center);
        let is_far = |object: u32| source.objects.binary_search_by_key(&object, |(far, _)| *far).is_ok();
        let colors = |view: &View| LookupShader { scene, rays: view.rays(), reflectors: &Black, backdrop: None };
        let mut pictures = face_pictures(&settings, scene, center, is_far, colors)?;
        // Without an environment nothing is seen between the objects.
        if scene.environment.is_some() {
            let covered = face_pictures(&settings, scene, center, is_far, |_| CoverageShader { scene })?;
            for (color, covered) in pictures.iter_mut().flatten().zip(covered.into_iter().flatten()) {
                color[3] = covered[0];
            }
        }
        let cube = Arc::new(CubeMap::new(source.size, pictures));
        Ok(Self { source, cube })
    }
}

/// A shader without light: reflectors and the background are black.
struct Black;

impl ReflectorShader for Black {
    fn radiance(&self, _: &Scene, _: &SurfaceInteraction, _: &Ray, _: &RayDifferential) -> Vec3 {
        Vec3::ZERO
    }

    fn behind(&self, _: &Scene, _: &Ray, _: &RayDifferential) -> Vec3 {
        Vec3::ZERO
    }
}

/// 1 where there is a surface, 0 elsewhere.
struct CoverageShader<'a> {
    scene: &'a Scene,
}

impl LookShader for CoverageShader<'_> {
    fn scene(&self) -> &Scene {
        self.scene
    }

    fn look(&self, fragment: &Fragment<'_>) -> ShadingRequest {
        ShadingRequest::Color(if fragment.chain.is_empty() { Vec3::ZERO } else { Vec3::ONE })
    }
}
