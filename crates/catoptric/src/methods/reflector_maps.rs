//! Environment maps of reflectors: capture, and look-up with a parallax proxy.

use crate::error::RenderError;
use crate::framebuffer::Framebuffer;
use crate::light::cube_map::CubeMap;
use crate::light::parallax_proxy::ParallaxProxy;
use crate::light::radiance_field::RadianceField;
use crate::light::reflector_shader::{ReflectorShader, reflector_radiance};
use crate::math::Aabb;
use crate::methods::lookup_shader::LookupShader;
use crate::progress::{Progress, Silent, Stage};
use crate::raster;
use crate::scene::shade::SurfaceInteraction;
use crate::scene::{Ray, RayDifferential, Scene};
use glam::Vec3;

/// Shape of the geometry around reflectors, by which a reflected ray becomes a direction of the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum ProxyShape {
    /// Infinitely far.
    Infinite,
    /// A box in world space; `None`: the bounds of all diffuse objects.
    Box(Option<Aabb>),
    /// A sphere about the reflector with this radius; `None`: half the mean side of the bounds of all diffuse objects.
    Sphere(Option<f32>),
}

impl ProxyShape {
    /// The proxy of a scene whose diffuse objects have these bounds.
    fn around(self, diffuse: &Aabb) -> ParallaxProxy {
        match self {
            Self::Infinite => ParallaxProxy::Infinite,
            Self::Box(Some(bounds)) => ParallaxProxy::Box(bounds),
            Self::Box(None) if diffuse.is_empty() => ParallaxProxy::Infinite,
            Self::Box(None) => ParallaxProxy::Box(*diffuse),
            Self::Sphere(radius) => {
                let radius = radius.unwrap_or_else(|| diffuse.size().element_sum() / 6.0);
                if radius > 0.0 { ParallaxProxy::Sphere(radius) } else { ParallaxProxy::Infinite }
            }
        }
    }
}

/// Source of the radiance of maps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MapSource {
    /// Captured from the scene at each reflector's centre.
    Capture,
    /// The scene's background; objects are not reflected.
    Background,
}

/// Settings of the capture of maps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ReflectorMapSettings {
    /// Shape of the surrounding geometry.
    pub(super) proxy: ProxyShape,
    /// Source of the radiance.
    pub(super) source: MapSource,
    /// Side of a face of the cube maps, in texels.
    pub(super) size: u32,
    /// Samples a texel.
    pub(super) capture_samples: u32,
}

impl Default for ReflectorMapSettings {
    fn default() -> Self {
        Self { proxy: ProxyShape::Infinite, source: MapSource::Capture, size: 512, capture_samples: 4 }
    }
}

/// The map of one reflector.
#[derive(Clone, Debug)]
struct ReflectorCubeMap {
    /// Centre of the reflector's bounds, in world space.
    center: Vec3,
    /// The captured radiance; `None` if the scene's background is read.
    cube: Option<CubeMap>,
    /// Shape of the surrounding geometry, in world space.
    proxy: ParallaxProxy,
}

/// The maps of some of a scene's reflectors and lenses.
#[derive(Clone, Debug, Default)]
pub(super) struct ReflectorMaps {
    /// For every object of the scene.
    maps: Vec<Option<ReflectorCubeMap>>,
    captured_faces: u64,
}

impl ReflectorMaps {
    /// The maps of some objects. In `rounds` rounds all of one show the maps of the round before; without any there are
    /// none.
    pub(super) fn capture(
        settings: &ReflectorMapSettings,
        scene: &Scene,
        reflectors: &[u32],
        rounds: u32,
        progress: &dyn Progress,
    ) -> Result<Self, RenderError> {
        let mut maps = Self { maps: vec![None; scene.objects.len()], captured_faces: 0 };
        let rounds = match settings.source {
            MapSource::Capture => rounds,
            MapSource::Background => rounds.min(1),
        };
        if rounds == 0 || reflectors.is_empty() {
            return Ok(maps);
        }
        let stage = Stage::begin(progress, "capturing environment maps", rounds as usize * reflectors.len())?;
        for _ in 0..rounds {
            let mut captured = vec![None; scene.objects.len()];
            for &object in reflectors {
                captured[object as usize] = Some(maps.map(settings, scene, object)?);
                stage.advance(1)?;
            }
            maps.maps = captured;
        }
        Ok(maps)
    }

    /// Keeps the maps of some objects alone.
    pub(super) fn retaining(mut self, objects: &[bool]) -> Self {
        for (map, kept) in self.maps.iter_mut().zip(objects) {
            if !kept {
                *map = None;
            }
        }
        self
    }

    /// Returns true for objects with a map.
    #[inline]
    pub(super) fn has(&self, object: u32) -> bool {
        self.maps.get(object as usize).is_some_and(Option::is_some)
    }

    /// Faces of cubes drawn to make them.
    pub(super) fn captured_faces(&self) -> u64 {
        self.captured_faces
    }

    /// Memory of the cubes.
    pub(super) fn byte_count(&self) -> u64 {
        self.maps.iter().flatten().filter_map(|map| map.cube.as_ref()).map(CubeMap::byte_count).sum()
    }

    /// The map of one reflector, with the other reflectors as they look so far.
    fn map(
        &mut self,
        settings: &ReflectorMapSettings,
        scene: &Scene,
        object: u32,
    ) -> Result<ReflectorCubeMap, RenderError> {
        let center = scene.objects[object as usize].bounds.center();
        let proxy = settings.proxy.around(&diffuse_bounds(scene));
        let cube = match settings.source {
            MapSource::Background => None,
            MapSource::Capture => {
                let mut pictures = Vec::with_capacity(6);
                for face in 0..6 {
                    let view = CubeMap::face_view(face, center, settings.size, scene.near());
                    let list = raster::scene_draw_list(scene, &view, |other| (other != object).then_some(0));
                    let shader = LookupShader { scene, rays: view.rays(), reflectors: &*self };
                    let mut picture = Framebuffer::new(view.width, view.height);
                    raster::draw(&view, settings.capture_samples, &[list], &shader, &mut picture, &Silent)?;
                    pictures.push(picture.pixels);
                }
                self.captured_faces += 6;
                Some(CubeMap::new(settings.size, pictures))
            }
        };
        Ok(ReflectorCubeMap { center, cube, proxy })
    }
}

impl ReflectorShader for ReflectorMaps {
    fn radiance(&self, scene: &Scene, encounter: &SurfaceInteraction, ray: &Ray, change: &RayDifferential) -> Vec3 {
        let map = self.maps.get(encounter.point.object as usize).and_then(Option::as_ref);
        reflector_radiance(map, scene, encounter, ray, change)
    }
}

impl RadianceField for ReflectorCubeMap {
    fn radiance(&self, scene: &Scene, ray: &Ray, change: Option<&RayDifferential>) -> Vec3 {
        let Ray { origin: position, direction } = *ray;
        let change = change.copied().unwrap_or_default();
        let read = |position: Vec3, direction: Vec3| self.proxy.direction(self.center, position, direction);
        let found = read(position, direction);
        let Some(cube) = &self.cube else {
            return scene.background(found.try_normalize().unwrap_or(direction));
        };
        // How far the neighbouring pixels' look-ups are: changes of the unit direction.
        let unit = found.normalize_or_zero();
        let neighbour = |moved: Vec3, turned: Vec3| {
            let turned = (direction + turned).normalize_or(direction);
            read(position + moved, turned).normalize_or_zero() - unit
        };
        let RayDifferential { origin_dx, origin_dy, direction_dx, direction_dy } = change;
        cube.filtered(unit, [neighbour(origin_dx, direction_dx), neighbour(origin_dy, direction_dy)])
    }

    /// Distance of the parallax proxy.
    fn distance(&self, ray: &Ray) -> f32 {
        self.proxy.distance(self.center, ray.origin, ray.direction)
    }
}

/// The box around everything that does not reflect.
fn diffuse_bounds(scene: &Scene) -> Aabb {
    let diffuse = (0..scene.objects.len()).filter(|&object| !scene.role_of(object as u32).is_specular());
    diffuse.map(|object| scene.objects[object].bounds).fold(Aabb::EMPTY, Aabb::union)
}
