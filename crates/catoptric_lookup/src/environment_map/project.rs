//! The places where environment maps show scene points: the inverse of the look-up.
//!
//! A map that was captured at a centre shows a point in the direction from there. A reflector shows it wherever the ray
//! that leaves it reads that direction: with the surround at infinity where the ray has the direction, with a parallax
//! proxy where the ray meets the proxy at the place that lies in the direction. A point is therefore seen where another
//! point, its *stand-in* there, would truly be reflected, and a search for true reflections finds it.

use super::{EnvironmentMapSettings, Source};
use catoptric_core::scene::{Ray, Scene};
use catoptric_engine::light::tracer::Tracer;
use catoptric_engine::method::reflector_maps::{ReflectorCubeMap, ReflectorMapSettings, ReflectorMaps};
use glam::{DVec3, DVec4};

/// The weight of points at infinity, an inverse distance in scene units: solvers take finite points.
const INFINITY_WEIGHT: f64 = 1e-9;

/// The distance in front of a point, as a share of its distance, within which surfaces do not hide it: they are off by
/// rounding.
const TOUCHING: f32 = 1e-3;

/// The places of a scene's environment maps, without their contents.
pub struct MapPlaces {
    /// The map of every object, and the objects that the map does not show.
    maps: Vec<Option<(ReflectorCubeMap, Vec<u32>)>>,
    /// True if nothing of the scene is shown but what is infinitely far.
    is_empty: bool,
}

impl MapPlaces {
    /// The places of the maps that the method makes with these settings, for pictures of an order.
    pub fn new(settings: &EnvironmentMapSettings, scene: &Scene, order: u32) -> Self {
        let settings_of_maps = ReflectorMapSettings::from(settings);
        let maps = ReflectorMaps::places(&settings_of_maps, scene, &scene.specular_objects(), order);
        Self { maps, is_empty: settings.source == Source::Environment }
    }

    fn map(&self, object: u32) -> Option<&(ReflectorCubeMap, Vec<u32>)> {
        self.maps.get(object as usize).and_then(Option::as_ref).filter(|_| !self.is_empty)
    }

    /// The point that is truly reflected in an object where its map shows `point`, in homogeneous world coordinates: at
    /// infinity without a parallax proxy. `None` for objects without a map and maps that show no scene points.
    pub fn stand_in(&self, object: u32, point: DVec3) -> Option<DVec4> {
        let (map, _) = self.map(object)?;
        let center = map.center.as_dvec3();
        let direction = (point - center).try_normalize()?;
        let distance = f64::from(map.proxy.distance(map.center, map.center, direction.as_vec3()));
        if distance.is_finite() {
            return Some((center + direction * distance).extend(1.0));
        }
        Some((direction + center * INFINITY_WEIGHT).extend(INFINITY_WEIGHT))
    }

    /// The angle at the map's centre between `point` and the direction that a ray leaving an object from `position`
    /// looks up, in radians: 0 where the map shows the point. A stand-in fails where a place of the reflector lies
    /// outside the parallax proxy, which is grown there.
    pub fn angle_missed(&self, object: u32, position: DVec3, direction: DVec3, point: DVec3) -> Option<f64> {
        let (map, _) = self.map(object)?;
        let read = map.proxy.direction(map.center, position.as_vec3(), direction.as_vec3()).as_dvec3();
        Some(read.angle_between(point - map.center.as_dvec3()))
    }

    /// True if the map of an object shows `point` itself and nothing that hides it from the centre; `tracer` is one of
    /// all objects.
    pub fn is_shown(&self, scene: &Scene, tracer: &Tracer, object: u32, point: DVec3) -> bool {
        let Some((map, left_out)) = self.map(object) else { return false };
        let way = point.as_vec3() - map.center;
        let objects: Vec<bool> = (0..scene.objects.len() as u32).map(|other| !left_out.contains(&other)).collect();
        let Some(direction) = way.try_normalize() else { return false };
        let hit = tracer.first_hit_of(scene, &Ray { origin: map.center, direction }, 0.0, &objects);
        hit.is_none_or(|hit| hit.distance() >= way.length() * (1.0 - TOUCHING))
    }
}
