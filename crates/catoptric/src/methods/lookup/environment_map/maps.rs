//! Maps of reflectors: captured, and looked up.

use super::cube_map::CubeMap;
use super::parallax::surround_of;
use super::settings::{EnvironmentMapSettings, Source};
use crate::error::RenderError;
use crate::framebuffer::Framebuffer;
use crate::math::Aabb;
use crate::methods::lookup::reflector::{ArrivingLight, ReflectorLook, reflector_radiance};
use crate::methods::lookup::shader::LookupShader;
use crate::methods::lookup::surround::Surround;
use crate::progress::Progress;
use crate::raster;
use crate::scene::shade::Encounter;
use crate::scene::{Ray, RayDifferential, Scene};
use glam::Vec3;

/// The map of one reflector.
#[derive(Clone, Debug)]
struct ReflectorMap {
    /// Where it was captured.
    center: Vec3,
    /// The captured radiance; none: the scene's environment is read.
    cube: Option<CubeMap>,
    /// The shape of the surround.
    surround: Surround,
}

/// The maps of some of a scene's reflectors and lenses.
#[derive(Clone, Debug, Default)]
pub(in crate::methods) struct ReflectorMaps {
    /// For every object of the scene.
    maps: Vec<Option<ReflectorMap>>,
    captured_faces: u64,
}

impl ReflectorMaps {
    /// The maps of some objects. In `rounds` rounds all of one show the maps of the round before; without any there are
    /// none.
    pub(in crate::methods) fn capture(
        settings: &EnvironmentMapSettings,
        scene: &Scene,
        reflectors: &[u32],
        rounds: u32,
        progress: &dyn Progress,
    ) -> Result<Self, RenderError> {
        let mut maps = Self { maps: vec![None; scene.objects.len()], captured_faces: 0 };
        let rounds = match settings.source {
            Source::Capture => rounds,
            Source::Environment => rounds.min(1),
        };
        if rounds == 0 || reflectors.is_empty() {
            return Ok(maps);
        }
        progress.begin("capturing environment maps", u64::from(rounds) * reflectors.len() as u64);
        for _ in 0..rounds {
            let mut captured = vec![None; scene.objects.len()];
            for &object in reflectors {
                captured[object as usize] = Some(maps.map(settings, scene, object)?);
                progress.advance(1);
            }
            maps.maps = captured;
        }
        progress.end();
        Ok(maps)
    }

    /// Those of some objects alone.
    pub(in crate::methods) fn retaining(mut self, objects: &[bool]) -> Self {
        for (map, kept) in self.maps.iter_mut().zip(objects) {
            if !kept {
                *map = None;
            }
        }
        self
    }

    /// Whether they were captured in a scene with as many objects.
    pub(in crate::methods) fn fit(&self, scene: &Scene) -> bool {
        self.maps.len() == scene.objects.len()
    }

    /// Whether an object has one.
    #[inline]
    pub(in crate::methods) fn has(&self, object: u32) -> bool {
        self.maps.get(object as usize).is_some_and(Option::is_some)
    }

    /// Faces of cubes drawn to make them.
    pub(in crate::methods) fn captured_faces(&self) -> u64 {
        self.captured_faces
    }

    /// Memory of the cubes.
    pub(in crate::methods) fn byte_count(&self) -> u64 {
        self.maps.iter().flatten().filter_map(|map| map.cube.as_ref()).map(CubeMap::byte_count).sum()
    }

    /// The map of one reflector, with the other reflectors as they look so far.
    fn map(
        &mut self,
        settings: &EnvironmentMapSettings,
        scene: &Scene,
        object: u32,
    ) -> Result<ReflectorMap, RenderError> {
        let center = scene.objects[object as usize].bounds.center();
        let surround = surround_of(settings, &diffuse_bounds(scene));
        let cube = match settings.source {
            Source::Environment => None,
            Source::Capture => {
                let mut pictures = Vec::with_capacity(6);
                for face in 0..6 {
                    let view = CubeMap::face_view(face, center, settings.size, scene.near());
                    let list = raster::scene_draw_list(scene, &view, |other| (other != object).then_some(0));
                    let shader = LookupShader { scene, rays: view.rays(), reflectors: &*self };
                    let mut picture = Framebuffer::new(view.width, view.height);
                    raster::draw(&view, settings.capture_samples, &[list], &shader, &mut picture)?;
                    pictures.push(picture.pixels);
                }
                self.captured_faces += 6;
                Some(CubeMap::new(settings.size, pictures))
            }
        };
        Ok(ReflectorMap { center, cube, surround })
    }
}

impl ReflectorLook for ReflectorMaps {
    fn radiance(&self, scene: &Scene, encounter: &Encounter, ray: &Ray, change: &RayDifferential) -> Vec3 {
        let map = self.maps.get(encounter.point.object as usize).and_then(Option::as_ref);
        reflector_radiance(map, scene, encounter, ray, change)
    }
}

impl ArrivingLight for ReflectorMap {
    fn radiance(&self, scene: &Scene, encounter: &Encounter, direction: Vec3, change: [Vec3; 2]) -> Vec3 {
        let position = encounter.point.position;
        let read = |position: Vec3, direction: Vec3| self.surround.direction(self.center, position, direction);
        let found = read(position, direction);
        let Some(cube) = &self.cube else {
            return scene.background(found.try_normalize().unwrap_or(direction));
        };
        // How far the neighbouring pixels' look-ups are: changes of the unit direction.
        let unit = found.normalize_or_zero();
        let neighbour = |k: usize| {
            let turned = (direction + change[k]).normalize_or(direction);
            read(position + encounter.position_change[k], turned).normalize_or_zero() - unit
        };
        cube.filtered(unit, [neighbour(0), neighbour(1)])
    }

    /// As far as the surround is.
    fn distance(&self, position: Vec3, direction: Vec3) -> f32 {
        self.surround.distance(self.center, position, direction)
    }
}

/// The box around everything that does not reflect.
fn diffuse_bounds(scene: &Scene) -> Aabb {
    let diffuse = (0..scene.objects.len()).filter(|&object| !scene.role_of(object as u32).is_specular());
    diffuse.map(|object| scene.objects[object].bounds).fold(Aabb::EMPTY, Aabb::union)
}
