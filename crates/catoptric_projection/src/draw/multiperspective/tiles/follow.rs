//! The rays of paths: from the eye along the surfaces that a sample shows.

use super::found::FoundSurface;
use super::reflections::Reflections;
use crate::draw::path_shader::meet_known_surface;
use catoptric_core::scene::Ray;
use catoptric_engine::optics::path::bundle::BounceKind;
use catoptric_engine::optics::step::{Facing, relative_index};
use catoptric_engine::raster::source::{EMPTY, TileBelow, found_number};
use glam::{Vec2, Vec3};

/// The maximum number of bounces of a path: the rasteriser has a layer for each.
pub(in super::super) const MAX_BOUNCES: usize = 63;

/// A pixel's centre may lie this far beside the triangle that a sample of it shows, in sizes of the triangle.
const BESIDE: f32 = 3.0;

/// The surfaces that a sample shows, from the first layer on, by their ids.
pub(in super::super) type Chain = [u32; MAX_BOUNCES];

/// A ray after the last bounce of a path.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct PathRay {
    pub(in super::super) ray: Ray,
    /// The flat surface's normal on the side that the ray leaves to.
    normal: Vec3,
    /// The size of the coordinates that its start was computed from.
    coordinate_size: f32,
    /// Length of the eye's ray at depth 1.
    pub(in super::super) length: f32,
    /// True if the ray leaves the outer side of the last object.
    pub(in super::super) outside: bool,
}

impl PathRay {
    /// The ray with its start a little off the surface, as in `Tracer::departure`.
    #[inline(always)]
    pub(in super::super) fn departing(&self) -> Ray {
        let offset = 16.0 * f32::EPSILON * self.coordinate_size.max(f32::MIN_POSITIVE);
        Ray { origin: self.ray.origin + self.normal * offset, direction: self.ray.direction }
    }
}

/// The chain of a sample in the layers below.
#[inline(always)]
pub(in super::super) fn chain(tile: &TileBelow<'_>, sample: usize) -> Chain {
    let mut chain = [EMPTY; MAX_BOUNCES];
    for (layer, id) in chain.iter_mut().enumerate().take(tile.layer()) {
        *id = tile.ids(layer)[sample];
    }
    chain
}

/// The event at the surface of a layer.
#[inline(always)]
pub(in super::super) fn kind(tile: &TileBelow<'_>, layer: usize) -> BounceKind {
    BounceKind::at(layer, tile.second_branches)
}

impl Reflections<'_> {
    /// The ray that leaves the last of a chain of surfaces, seen at a position of the picture. `None` where light does
    /// not go on.
    #[inline(always)]
    pub(in super::super) fn follow(
        &self,
        tile: &TileBelow<'_>,
        surfaces: &[FoundSurface],
        chain: &Chain,
        position: Vec2,
    ) -> Option<PathRay> {
        let scene = self.scene;
        let mut ray = self.rays.ray(position.x, position.y);
        let length = 1.0 / ray.direction.dot(self.forward).max(1e-3);
        let mut last = None;
        for (bounce, &id) in chain.iter().enumerate().take(tile.layer()) {
            let mut surface = match found_number(id) {
                Some(number) => surfaces[number as usize].surface(position, Some(BESIDE)),
                None => tile.surface(id, position, BESIDE),
            };
            match bounce {
                // A pixel's centre may lie beyond the edge of the triangle that its sample shows.
                0 => self.shapes.neighbours.meet_seen(scene, &ray, &mut surface),
                _ => meet_known_surface(scene, Some(&self.shapes.neighbours), &mut ray, &mut surface),
            }
            let point = scene.drawn_point(surface.source, &surface.barycentrics, &ray);
            let material = scene.material_of(point.object);
            let normal = if self.model.turns_normals { scene.turned_normal(material, &point) } else { point.normal };
            let facing = Facing::new(ray.direction, point.geometric_normal, normal);
            let kind = kind(tile, bounce);
            let eta = relative_index(material.ior, facing.outside);
            let direction = facing.outgoing(kind, ray.direction, eta)?;
            let (outside, side) = match kind {
                BounceKind::Reflect => (facing.outside, 1.0),
                BounceKind::Transmit => (!facing.outside, -1.0),
            };
            ray = Ray { origin: point.position, direction };
            let (normal, coordinate_size) = (facing.geometric * side, point.coordinate_size);
            last = Some(PathRay { ray, normal, coordinate_size, length, outside });
        }
        last.filter(|last| last.ray.origin.is_finite() && last.ray.direction.is_finite())
    }
}
