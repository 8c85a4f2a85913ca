//! Environment maps of reflectors: capture, and look-up with a parallax proxy.

use crate::error::RenderError;
use crate::light::cube_map::CubeMap;
use crate::light::parallax_proxy::ParallaxProxy;
use crate::light::radiance_field::RadianceField;
use crate::light::reflector_shader::{ReflectorShader, first_bounce, reflector_radiance};
use crate::method::Report;
use crate::method::lookup_shader::LookupShader;
use crate::optics::path::bundle::Bounce;
use crate::raster::{self, LookShader};
use catoptric_core::framebuffer::Framebuffer;
use catoptric_core::math::Aabb;
use catoptric_core::progress::{Progress, Silent, Stage};
use catoptric_core::scene::shade::SurfaceInteraction;
use catoptric_core::scene::{Ray, RayDifferential, Scene, View};
use glam::Vec3;
use std::sync::Arc;

/// Shape of the geometry around reflectors, by which a reflected ray becomes a direction of the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ProxyShape {
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
pub enum MapSource {
    /// Captured from the scene at each reflector's centre.
    Capture,
    /// The scene's background; objects are not reflected.
    Background,
}

/// Settings of the capture of maps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReflectorMapSettings {
    /// Shape of the surrounding geometry.
    pub proxy: ProxyShape,
    /// Source of the radiance.
    pub source: MapSource,
    /// Side of a face of the cube maps, in texels.
    pub size: u32,
    /// Samples a texel.
    pub capture_samples: u32,
}

impl Default for ReflectorMapSettings {
    fn default() -> Self {
        Self { proxy: ProxyShape::Infinite, source: MapSource::Capture, size: 512, capture_samples: 4 }
    }
}

/// Work that capturing the maps of a scene may take: a few seconds of one core. Many reflectors have smaller maps, or
/// share some. Chosen, not measured.
const CAPTURE_WORK: f64 = 40e6;

/// Work of a triangle in a face, and of a sample of it; in units of about 100 ns.
const WORK_A_TRIANGLE: f64 = 0.6;
const WORK_A_SAMPLE: f64 = 0.5;

/// Texels a side that maps have at least, unless fewer are wanted, before reflectors share them. Chosen, not measured.
const MIN_SIZE: u32 = 64;

/// The maps of some reflectors that can be captured in `CAPTURE_WORK`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CaptureLimits {
    /// Maps in one round.
    pub count: usize,
    /// Texels a side.
    pub size: u32,
}

impl CaptureLimits {
    /// The limits for maps of `reflectors` reflectors that are captured in `rounds` rounds.
    pub fn new(settings: &ReflectorMapSettings, scene: &Scene, reflectors: usize, rounds: u32) -> Self {
        let whole = Self { count: reflectors, size: settings.size };
        if settings.source == MapSource::Background {
            return whole;
        }
        let a_map = CAPTURE_WORK / (6.0 * f64::from(rounds));
        let geometry = WORK_A_TRIANGLE * scene.triangles.len() as f64;
        let samples = |size: u32| WORK_A_SAMPLE * f64::from(settings.capture_samples) * f64::from(size).powi(2);
        let least = settings.size.min(MIN_SIZE);
        let count = (a_map / (geometry + samples(least))).clamp(1.0, reflectors as f64) as usize;
        let left = a_map / count as f64 - geometry;
        let size = (left / (WORK_A_SAMPLE * f64::from(settings.capture_samples))).max(0.0).sqrt() as u32;
        Self { count, size: size.clamp(least, settings.size) }
    }

    /// The reflectors that share a map, or have one each.
    fn groups(&self, scene: &Scene, reflectors: &[u32]) -> Vec<Vec<u32>> {
        match self.count {
            count if count < reflectors.len() => grouped(scene, reflectors, count),
            _ => reflectors.iter().map(|object| vec![*object]).collect(),
        }
    }
}

/// Where the map of a group of reflectors is captured, and the members that it is captured without: those that the
/// place lies in.
fn place_of(scene: &Scene, group: &[u32]) -> (Vec3, Vec<u32>) {
    let bounds = |object: u32| &scene.objects[object as usize].bounds;
    let center = match group {
        [object] => bounds(*object).center(),
        several => several.iter().map(|object| bounds(*object).center()).sum::<Vec3>() / several.len() as f32,
    };
    let is_around = |object: &u32| group.len() == 1 || bounds(*object).contains(center);
    (center, group.iter().copied().filter(is_around).collect())
}

/// Pictures of the six faces of a cube about a point: the wanted objects of a scene, by a shader of each face's view.
///
/// # Errors
/// The errors of the rasteriser.
pub fn face_pictures<S: LookShader>(
    settings: &ReflectorMapSettings,
    scene: &Scene,
    center: Vec3,
    is_wanted: impl Fn(u32) -> bool,
    shader: impl Fn(&View) -> S,
) -> Result<Vec<Vec<[f32; 4]>>, RenderError> {
    let picture = |face| {
        let view = CubeMap::face_view(face, center, settings.size, scene.near());
        let list = raster::scene_draw_list(scene, &view, |object| is_wanted(object).then_some(0));
        let mut picture = Framebuffer::new(view.width, view.height);
        raster::draw(&view, settings.capture_samples, &[list], &shader(&view), &mut picture, &Silent)?;
        Ok(picture.pixels)
    };
    (0..6).map(picture).collect()
}

/// Reflectors in groups of neighbours, at most so many: halved along the longest side of their centres' box, the
/// largest group first.
fn grouped(scene: &Scene, reflectors: &[u32], count: usize) -> Vec<Vec<u32>> {
    let center = |object: &u32| scene.objects[*object as usize].bounds.center();
    let mut groups: Vec<Vec<u32>> = vec![reflectors.to_vec()];
    while groups.len() < count {
        let Some(largest) = (0..groups.len()).max_by_key(|group| (groups[*group].len(), usize::MAX - group)) else {
            break;
        };
        if groups[largest].len() < 2 {
            break;
        }
        let mut group = groups.swap_remove(largest);
        let size = Aabb::around(group.iter().map(center)).size();
        let axis = (0..3).max_by(|a: &usize, b| size[*a].total_cmp(&size[*b])).unwrap_or(0);
        group.sort_by(|a, b| center(a)[axis].total_cmp(&center(b)[axis]).then(a.cmp(b)));
        let other = group.split_off(group.len() / 2);
        groups.extend([group, other]);
    }
    groups
}

/// The map of one reflector, or of several that share it.
#[derive(Clone, Debug)]
pub struct ReflectorCubeMap {
    /// Where it was captured, in world space.
    pub center: Vec3,
    /// The captured radiance; `None` if the scene's background is read.
    pub cube: Option<Arc<CubeMap>>,
    /// Shape of the surrounding geometry.
    pub proxy: ParallaxProxy,
}

/// The maps of some of a scene's reflectors and lenses.
#[derive(Clone, Debug, Default)]
pub struct ReflectorMaps {
    /// For every object of the scene.
    maps: Vec<Option<ReflectorCubeMap>>,
    captured_faces: u64,
    /// Reflectors whose maps are smaller than wanted, and those that share one with others.
    smaller: u64,
    shared: u64,
}

impl ReflectorMaps {
    /// The maps of some objects; where these are many, smaller ones, or some in common. In `rounds` rounds all of one
    /// show the maps of the round before; without any there are none.
    pub fn capture(
        wanted: &ReflectorMapSettings,
        scene: &Scene,
        reflectors: &[u32],
        rounds: u32,
        progress: &dyn Progress,
    ) -> Result<Self, RenderError> {
        let mut maps = Self { maps: vec![None; scene.objects.len()], ..Self::default() };
        let rounds = match wanted.source {
            MapSource::Capture => rounds,
            MapSource::Background => rounds.min(1),
        };
        if rounds == 0 || reflectors.is_empty() {
            return Ok(maps);
        }
        let limits = CaptureLimits::new(wanted, scene, reflectors.len(), rounds);
        let groups = limits.groups(scene, reflectors);
        let settings = ReflectorMapSettings { size: limits.size, ..*wanted };
        maps.shared = groups.iter().filter(|group| group.len() > 1).map(|group| group.len() as u64).sum();
        maps.smaller = if limits.size < wanted.size { reflectors.len() as u64 } else { 0 };
        let stage = Stage::begin(progress, "capturing environment maps", rounds as usize * groups.len())?;
        for _ in 0..rounds {
            let mut captured = vec![None; scene.objects.len()];
            for group in &groups {
                let map = maps.map(&settings, scene, group)?;
                for &object in group {
                    captured[object as usize] = Some(map.clone());
                }
                stage.advance(1)?;
            }
            maps.maps = captured;
        }
        Ok(maps)
    }

    /// The places of the maps that [`Self::capture`] makes of some objects, with the objects that each is captured
    /// without.
    pub fn places(
        wanted: &ReflectorMapSettings,
        scene: &Scene,
        reflectors: &[u32],
        rounds: u32,
    ) -> Vec<Option<(ReflectorCubeMap, Vec<u32>)>> {
        let mut places = vec![None; scene.objects.len()];
        if rounds == 0 || reflectors.is_empty() {
            return places;
        }
        let proxy = wanted.proxy.around(&diffuse_bounds(scene));
        for group in CaptureLimits::new(wanted, scene, reflectors.len(), rounds).groups(scene, reflectors) {
            let (center, around) = place_of(scene, &group);
            for object in group {
                let map = ReflectorCubeMap { center, cube: None, proxy };
                places[object as usize] = Some((map, around.clone()));
            }
        }
        places
    }

    /// Adds what is not as it was wanted to a report.
    pub fn add_fallbacks(&self, report: &mut Report) {
        report.add_fallback("smaller_environment_maps", self.smaller);
        report.add_fallback("shared_environment_maps", self.shared);
    }

    /// The map of every object of the scene that has one.
    pub fn into_maps(self) -> Vec<Option<ReflectorCubeMap>> {
        self.maps
    }

    /// The same.
    pub fn all(&self) -> &[Option<ReflectorCubeMap>] {
        &self.maps
    }

    /// Keeps the maps of some objects alone.
    pub fn retaining(mut self, objects: &[bool]) -> Self {
        for (map, kept) in self.maps.iter_mut().zip(objects) {
            if !kept {
                *map = None;
            }
        }
        self
    }

    /// Returns true for objects with a map.
    #[inline]
    pub fn has(&self, object: u32) -> bool {
        self.maps.get(object as usize).is_some_and(Option::is_some)
    }

    /// The bounces of the light that a reflector or lens shows to a ray that meets it: one, if it has a map.
    pub fn bounces(&self, scene: &Scene, encounter: &SurfaceInteraction, ray: &Ray) -> Vec<Bounce> {
        let bounce = self.has(encounter.point.object).then(|| first_bounce(scene, encounter, ray));
        bounce.flatten().into_iter().collect()
    }

    /// Faces of cubes drawn to make them.
    pub fn captured_faces(&self) -> u64 {
        self.captured_faces
    }

    /// Memory of the cubes.
    pub fn byte_count(&self) -> u64 {
        let mut cubes: Vec<&Arc<CubeMap>> = self.maps.iter().flatten().filter_map(|map| map.cube.as_ref()).collect();
        cubes.sort_by_key(|cube| Arc::as_ptr(cube));
        cubes.dedup_by_key(|cube| Arc::as_ptr(cube));
        cubes.into_iter().map(|cube| cube.byte_count()).sum()
    }

    /// The map of a group of reflectors, with the others as they look so far; members that the centre lies in are left
    /// out.
    fn map(
        &mut self,
        settings: &ReflectorMapSettings,
        scene: &Scene,
        group: &[u32],
    ) -> Result<ReflectorCubeMap, RenderError> {
        let (center, around) = place_of(scene, group);
        let proxy = settings.proxy.around(&diffuse_bounds(scene));
        let cube = match settings.source {
            MapSource::Background => None,
            MapSource::Capture => {
                let reflectors = &*self;
                let shader = |view: &View| LookupShader { scene, rays: view.rays(), reflectors, backdrop: None };
                let pictures = face_pictures(settings, scene, center, |other| !around.contains(&other), shader)?;
                self.captured_faces += 6;
                Some(Arc::new(CubeMap::new(settings.size, pictures)))
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
