//! What a picture shows: the adaptive mesh before the scene.

use super::maps::LayeredMap;
use super::mesh::{AdaptiveMesh, same_way};
use crate::methods::lookup::greedy::{First, GreedyPath, GreedyPaths};
use crate::optics::{Interface, transmittance};
use crate::raster::{Fragment, LayerSurface, Look, LookShader};
use crate::scene::shade::Barycentrics;
use crate::scene::{Ray, RayDifferential, Role, Scene, ViewRays};
use glam::{Mat2, Vec2, Vec3};
use std::sync::atomic::{AtomicU64, Ordering};

/// The group of triangles that are no part of the mesh.
pub(super) const NO_LEAF: u32 = u32::MAX;

/// Colours a view of the scene.
pub(super) struct LensShader<'a> {
    pub(super) scene: &'a Scene,
    pub(super) rays: ViewRays,
    /// Of every object the paths among its group, and the layers about that.
    pub(super) lenses: &'a (dyn Fn(u32) -> Option<(GreedyPaths<'a>, &'a LayeredMap)> + Sync),
    pub(super) mesh: &'a AdaptiveMesh,
    /// Rays that were traced for fragments.
    pub(super) ray_count: &'a AtomicU64,
}

impl LookShader for LensShader<'_> {
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
        if !self.scene.role_of(object).is_specular() {
            let ray = self.rays.ray(at.x, at.y);
            return Look::of_diffuse(self.scene, surface, &ray, Vec3::ONE, Vec3::ZERO);
        }
        let (ray, change) = self.rays.ray_with_differential(at.x, at.y);
        Look::Color(self.lens(object, surface, &ray, &change))
    }
}

/// How paths change over a triangle of the mesh: of each corner its share at a fragment, and how that changes from pixel to pixel.
struct Blend<'a> {
    paths: [&'a [GreedyPath; 2]; 3],
    shares: Vec3,
    changes: [Vec3; 2],
}

impl LensShader<'_> {
    /// What a reflector or lens shows.
    fn lens(&self, object: u32, surface: &LayerSurface, ray: &Ray, change: &RayDifferential) -> Vec3 {
        let scene = self.scene;
        let encounter = scene.drawn_encounter(surface, ray, change);
        let point = &encounter.point;
        let material = scene.material_of(object);
        let interface = Interface::of(scene, material, point, ray.direction);
        let own = match interface.scattered {
            0.0 => Vec3::ZERO,
            _ => scene.own_radiance(point, -ray.direction),
        };
        let Some((paths, map)) = (self.lenses)(object).filter(|(paths, _)| paths.order > 0) else {
            return own * interface.scattered;
        };
        let blend = self.blend(surface);
        let arriving = |first: First, arrived: &mut f32| {
            let (path, change) = match &blend {
                Some(blend) => blend.path(first as usize),
                None => {
                    let path = paths.follow(ray.direction, encounter, first);
                    self.ray_count.fetch_add(u64::from(path.events), Ordering::Relaxed);
                    (path, RayDifferential::default())
                }
            };
            let Some(leaving) = &path.leaving else { return path.added };
            if interface.attenuation.is_some() {
                *arrived = map.distance(leaving);
            }
            path.added + path.share * map.radiance(scene, leaving, &change)
        };
        let (mut sum, mut own_share, mut distance) = (Vec3::ZERO, interface.scattered, f32::INFINITY);
        if interface.reflected != Vec3::ZERO {
            let mut reflection = interface.reflected * arriving(First::Reflected, &mut distance);
            if let Some(deferred) = interface.deferred(own) {
                let (settled, weight) = deferred.settled(distance);
                (own_share, reflection) = (0.0, settled + reflection * weight);
            }
            sum += reflection;
        }
        if interface.transmitted != Vec3::ZERO {
            sum += interface.transmitted * arriving(First::Refracted, &mut distance);
        }
        sum += own * own_share;
        if material.role == Role::Lens && !interface.facing.outside {
            sum *= transmittance(material.absorption, ray.origin.distance(point.position));
        }
        if sum.is_finite() { sum } else { Vec3::ZERO }
    }

    /// The corners of the mesh's triangle that a surface is a part of.
    fn blend(&self, surface: &LayerSurface) -> Option<Blend<'_>> {
        let leaf = self.mesh.leaves.get(surface.group as usize)?;
        let [a, b, c] = leaf.corners;
        let inverse = Mat2::from_cols(b - a, c - a).inverse();
        let Barycentrics { value, dx, dy, .. } = surface.barycentrics;
        let shares = |at: Vec2| Vec3::new(1.0 - at.x - at.y, at.x, at.y);
        let within = shares(inverse * (value - a)).max(Vec3::ZERO);
        let changes = [dx, dy].map(|change| {
            let change = inverse * change;
            Vec3::new(-change.x - change.y, change.x, change.y)
        });
        let paths = leaf.vertices.map(|vertex| &self.mesh.paths[vertex as usize]);
        let shares = within / within.element_sum();
        shares.is_finite().then_some(Blend { paths, shares, changes })
    }
}

impl Blend<'_> {
    /// The path of a fragment and the change of the ray that leaves. Where the corners' paths take different ways it is that of
    /// the nearest corner.
    fn path(&self, way: usize) -> (GreedyPath, RayDifferential) {
        let [a, b, c] = self.paths.map(|paths| &paths[way]);
        let nearest = [a, b, c][self.shares.max_position()];
        let mut blended = *nearest;
        let mut change = RayDifferential::default();
        let (Some(from_a), Some(from_b), Some(from_c)) = (&a.leaving, &b.leaving, &c.leaving) else {
            return (blended, change);
        };
        if !(same_way(a, b) && same_way(b, c)) {
            return (blended, change);
        }
        let [x, y, z] = self.shares.to_array();
        blended.share = a.share * x + b.share * y + c.share * z;
        blended.added = a.added * x + b.added * y + c.added * z;
        let sum = |shares: Vec3, a: Vec3, b: Vec3, c: Vec3| a * shares.x + b * shares.y + c * shares.z;
        let origin = |shares: Vec3| sum(shares, from_a.origin, from_b.origin, from_c.origin);
        let direction = |shares: Vec3| sum(shares, from_a.direction, from_b.direction, from_c.direction);
        let long = direction(self.shares);
        let length = long.length();
        let Some(unit) = long.try_normalize() else { return (blended, change) };
        blended.leaving = Some(Ray { origin: origin(self.shares), direction: unit });
        let [dx, dy] = self.changes;
        let turned = |change: Vec3| (change - unit * unit.dot(change)) / length;
        change = RayDifferential {
            origin_dx: origin(dx),
            origin_dy: origin(dy),
            direction_dx: turned(direction(dx)),
            direction_dy: turned(direction(dy)),
        };
        (blended, change)
    }
}
