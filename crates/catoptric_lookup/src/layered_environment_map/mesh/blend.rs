//! Paths between the vertices of the adaptive mesh.

use super::{AdaptiveMesh, same_way};
use catoptric_core::scene::shade::Barycentrics;
use catoptric_core::scene::{Ray, RayDifferential};
use catoptric_engine::light::two_path_tracer::SpecularChain;
use catoptric_engine::raster::LayerSurface;
use glam::{Mat2, Vec2, Vec3};

/// The change of paths over a triangle of the mesh: each corner's share at a fragment, and the changes of the shares
/// from pixel to pixel.
pub(crate) struct PathBlend<'a> {
    paths: [&'a [SpecularChain; 2]; 3],
    shares: Vec3,
    changes: [Vec3; 2],
}

impl AdaptiveMesh {
    /// The corners of the mesh's triangle that a surface is a part of.
    pub(crate) fn blend(&self, surface: &LayerSurface) -> Option<PathBlend<'_>> {
        let leaf = self.leaves.get(surface.group as usize)?;
        let [a, b, c] = leaf.corners;
        let inverse = Mat2::from_cols(b - a, c - a).inverse();
        let Barycentrics { value, dx, dy, .. } = surface.barycentrics;
        let shares = |at: Vec2| Vec3::new(1.0 - at.x - at.y, at.x, at.y);
        let within = shares(inverse * (value - a)).max(Vec3::ZERO);
        let changes = [dx, dy].map(|change| {
            let change = inverse * change;
            Vec3::new(-change.x - change.y, change.x, change.y)
        });
        let paths = leaf.vertices.map(|vertex| &self.paths[vertex as usize]);
        let shares = within / within.element_sum();
        shares.is_finite().then_some(PathBlend { paths, shares, changes })
    }
}

impl PathBlend<'_> {
    /// The path of a fragment and the differential of its leaving ray; `None` if the corners' paths have different
    /// events.
    pub(crate) fn path(&self, way: usize) -> Option<(SpecularChain, RayDifferential)> {
        let [a, b, c] = self.paths.map(|paths| &paths[way]);
        if !(same_way(a, b) && same_way(b, c)) {
            return None;
        }
        let sum = |shares: Vec3, a: Vec3, b: Vec3, c: Vec3| a * shares.x + b * shares.y + c * shares.z;
        let mut blended = SpecularChain {
            share: sum(self.shares, a.share, b.share, c.share),
            added: sum(self.shares, a.added, b.added, c.added),
            ..*a
        };
        let (Some(from_a), Some(from_b), Some(from_c)) = (&a.leaving, &b.leaving, &c.leaving) else {
            // The light of all of them ends on the way.
            return Some((blended, RayDifferential::default()));
        };
        let origin = |shares: Vec3| sum(shares, from_a.origin, from_b.origin, from_c.origin);
        let direction = |shares: Vec3| sum(shares, from_a.direction, from_b.direction, from_c.direction);
        let long = direction(self.shares);
        let length = long.length();
        let unit = long.try_normalize()?;
        blended.leaving = Some(Ray { origin: origin(self.shares), direction: unit });
        let [dx, dy] = self.changes;
        let turned = |change: Vec3| (change - unit * unit.dot(change)) / length;
        let change = RayDifferential {
            origin_dx: origin(dx),
            origin_dy: origin(dy),
            direction_dx: turned(direction(dx)),
            direction_dy: turned(direction(dy)),
        };
        Some((blended, change))
    }

    /// The path of the nearest corner.
    pub(crate) fn nearest(&self, way: usize) -> (SpecularChain, RayDifferential) {
        (self.paths[self.shares.max_position()][way], RayDifferential::default())
    }
}
