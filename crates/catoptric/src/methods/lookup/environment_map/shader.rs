//! Colours of diffuse surfaces, and of reflectors that look up their map.

use super::cube_map::CubeMap;
use super::parallax::Surround;
use crate::optics::{fresnel_dielectric, mirror_tint, reflect, reflected_change, refract, refracted_change};
use crate::raster::{Fragment, Look, LookShader};
use crate::scene::shade::Encounter;
use crate::scene::{Material, Ray, RayDifferential, Role, Scene, ViewRays};
use glam::{Vec3, Vec4Swizzles};

/// The map of one reflector.
#[derive(Clone, Debug)]
pub(super) struct ReflectorMap {
    /// Where it was captured.
    pub(super) center: Vec3,
    /// The captured radiance; none: the scene's environment is read.
    pub(super) cube: Option<CubeMap>,
    /// The shape of the surround.
    pub(super) surround: Surround,
}

/// Colours a view of the scene.
pub(super) struct MapShader<'a> {
    pub(super) scene: &'a Scene,
    pub(super) rays: ViewRays,
    /// For every object its map; none: reflectors are black.
    pub(super) maps: &'a [Option<ReflectorMap>],
}

impl MapShader<'_> {
    fn specular(&self, encounter: &Encounter, material: &Material, ray: &Ray, change: &RayDifferential) -> Vec3 {
        let point = &encounter.point;
        let object = &self.scene.objects[point.object as usize];
        let outside = ray.direction.dot(point.geometric_normal) <= 0.0;
        let sign = if outside { 1.0 } else { -1.0 };
        let normal = point.normal * sign;
        let cosine = -ray.direction.dot(normal);
        let base = self.scene.base_color(material, point).xyz();
        let map = self.maps[point.object as usize].as_ref();
        let fetch = |direction: Vec3, direction_change: [Vec3; 2]| {
            map.map_or(Vec3::ZERO, |map| map.radiance(self.scene, encounter, direction, direction_change))
        };
        let mirrored = || {
            let bend = |ray_change, k: usize| {
                reflected_change(ray.direction, ray_change, normal, encounter.normal_change[k] * sign)
            };
            let change = [bend(change.direction_dx, 0), bend(change.direction_dy, 1)];
            fetch(reflect(ray.direction, normal), change)
        };
        match material.role {
            Role::Diffuse => Vec3::ZERO,
            Role::Reflector if outside && object.inside => Vec3::ZERO,
            Role::Reflector => {
                let reflection = mirror_tint(material, base, cosine) * mirrored();
                let Some(blend) = &material.blend else { return reflection };
                let mut weight = blend.weight_at(cosine.max(0.0));
                if let Some(attenuation) = &blend.attenuation {
                    // What is reflected is taken to be as far away as the surround.
                    let towards = reflect(ray.direction, normal);
                    let distance = |map: &ReflectorMap| map.surround.distance(map.center, point.position, towards);
                    weight *= attenuation.weight(map.map_or(f32::INFINITY, distance));
                }
                reflection * weight + self.scene.own_radiance(point, -ray.direction) * (1.0 - weight)
            }
            Role::Coated => {
                let reflectance = material.coat * fresnel_dielectric(cosine, 1.0 / material.ior);
                mirrored() * reflectance + self.scene.radiance(point, -ray.direction) * (1.0 - reflectance)
            }
            Role::Lens => {
                let eta = if outside { 1.0 / material.ior } else { material.ior };
                let reflectance = fresnel_dielectric(cosine, eta);
                let mut sum = mirrored() * reflectance;
                if let Some(direction) = refract(ray.direction, normal, eta) {
                    let bend = |ray_change, k: usize| {
                        refracted_change(ray.direction, ray_change, normal, encounter.normal_change[k] * sign, eta)
                    };
                    let change = [bend(change.direction_dx, 0), bend(change.direction_dy, 1)];
                    sum += base * fetch(direction, change) * (1.0 - reflectance);
                }
                sum
            }
        }
    }
}

impl ReflectorMap {
    /// The radiance that the map gives for a ray that leaves a surface.
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
}

impl LookShader for MapShader<'_> {
    fn scene(&self) -> &Scene {
        self.scene
    }

    #[inline]
    fn look(&self, fragment: &Fragment<'_>) -> Look {
        let at = fragment.position;
        let Some(surface) = fragment.chain.first() else {
            return Look::Color(self.scene.background(self.rays.ray(at.x, at.y).direction));
        };
        let object = self.scene.triangle_objects[surface.source as usize];
        let material = self.scene.material_of(object);
        if !material.role.is_specular() {
            let ray = self.rays.ray(at.x, at.y);
            return Look::of_diffuse(self.scene, surface, &ray, Vec3::ONE, Vec3::ZERO);
        }
        let (ray, change) = self.rays.ray_with_differential(at.x, at.y);
        let encounter = self.scene.drawn_encounter(surface, &ray, &change);
        Look::Color(self.specular(&encounter, material, &ray, &change))
    }
}
