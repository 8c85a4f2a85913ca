//! Sites of triangle meshes: the hit point on the flat triangle, the normal interpolated between its vertices.
//!
//! Motion goes on over edges where the surface is smooth, turning with the surface as a sheet of paper laid around
//! the edge would. At borders and creases sites continue in the plane of the last triangle.

use super::topology::Topology;
use super::vertex::{ManifoldFrame, ManifoldVertex};
use catoptric_core::scene::{Object, Scene};
use catoptric_core::surface::mesh::adjacency::NO_NEIGHBOUR;
use catoptric_core::surface::patch::{SurfacePatch, tangent_frame};
use glam::{DMat3, DVec2, DVec3};
use std::ops::Range;
use std::sync::Arc;

/// A step crosses at most this many triangles.
const MAX_CROSSINGS: usize = 10_000;

/// Steps around a border's corners, from triangle to triangle.
const MAX_SLIDES: usize = 64;

/// Beyond a border a site goes on until a barycentric weight is below this: two heights of the triangle. Normals
/// extrapolated further are useless. Triangles with a constant normal have no such limit.
const MIN_WEIGHT: f64 = -2.0;

/// Weights as far below 0 as this are within: meshes and ray hits have single precision.
const WITHIN: f64 = -1e-6;

/// Normals of a flat facet differ by no more (rounding of single precision).
const FLAT: f64 = 1e-6;

/// The triangles of one object.
pub(super) struct MeshManifold<'a> {
    scene: &'a Scene,
    triangles: Range<u32>,
    first_vertex: u32,
    topology: Arc<Topology>,
}

/// A triangle in double precision.
struct Facet {
    corners: [DVec3; 3],
    normals: [DVec3; 3],
    /// The cross product of its first two edges; as it is wound.
    face: DVec3,
    inverse_face2: f64,
}

impl Facet {
    /// The change of the three barycentric weights with a motion.
    #[inline]
    fn weights_along(&self, motion: DVec3) -> [f64; 3] {
        let [a, b, c] = self.corners;
        let second = (c - a).cross(self.face).dot(motion) * self.inverse_face2;
        let third = self.face.cross(b - a).dot(motion) * self.inverse_face2;
        [-second - third, second, third]
    }

    #[inline]
    fn point(&self, weights: &[f64; 3]) -> DVec3 {
        self.corners[0]
            + (self.corners[1] - self.corners[0]) * weights[1]
            + (self.corners[2] - self.corners[0]) * weights[2]
    }

    fn weights_of(&self, point: DVec3) -> [f64; 3] {
        let [first, second, third] = self.weights_along(point - self.corners[0]);
        [1.0 + first, second, third]
    }

    /// The unit normal of the flat triangle, on the side of its vertices' normals.
    #[inline]
    fn outer_normal(&self) -> DVec3 {
        let [a, b, c] = self.normals;
        let face = if self.face.dot(a + b + c) < 0.0 { -self.face } else { self.face };
        face * self.inverse_face2.sqrt()
    }

    /// The interpolated unit normal, and the inverse of its length before it was one. Returns `None` if normals cancel
    /// or are missing: there the flat triangle's counts, by the rule of the ray tracer.
    #[inline]
    fn normal_at(&self, [second, third]: [f64; 2]) -> Option<(DVec3, f64)> {
        let [a, b, c] = self.normals;
        let sum = a + (b - a) * second + (c - a) * third;
        let length2 = sum.length_squared();
        // Written so that a NaN goes on, to be found later.
        if length2 <= 1e-36 {
            return None;
        }
        let inverse = length2.sqrt().recip();
        Some((sum * inverse, inverse))
    }

    fn is_flat(&self) -> bool {
        let [a, b, c] = self.normals;
        a.distance_squared(b).max(a.distance_squared(c)) <= FLAT * FLAT
    }

    /// The point of the triangle nearest to a point of its plane, by its weights.
    fn nearest(&self, point: DVec3) -> [f64; 3] {
        let weights = self.weights_of(point);
        if weights.iter().all(|weight| *weight >= 0.0) {
            return weights;
        }
        let mut nearest = (f64::INFINITY, [1.0, 0.0, 0.0]);
        for opposite in 0..3 {
            let (p, q) = ((opposite + 1) % 3, (opposite + 2) % 3);
            let edge = self.corners[q] - self.corners[p];
            let share = ((point - self.corners[p]).dot(edge) / edge.length_squared()).clamp(0.0, 1.0);
            let mut on_edge = [0.0; 3];
            (on_edge[p], on_edge[q]) = (1.0 - share, share);
            let distance2 = self.point(&on_edge).distance_squared(point);
            if distance2 < nearest.0 {
                nearest = (distance2, on_edge);
            }
        }
        nearest.1
    }
}

/// The way over an edge into a neighbouring triangle.
struct EdgeCrossing {
    facet: Facet,
    triangle: u32,
    /// The neighbour's vertices at the edge's two ends.
    ends: [usize; 2],
    /// A point of the edge, and its direction.
    start: DVec3,
    along: DVec3,
    /// Away from the edge, out of the old triangle and into the new one.
    out: DVec3,
    into: DVec3,
}

impl EdgeCrossing {
    /// A motion in the old triangle's plane, laid into the new one's.
    fn laid_over(&self, motion: DVec3) -> DVec3 {
        self.along * motion.dot(self.along) + self.into * motion.dot(self.out)
    }
}

impl<'a> MeshManifold<'a> {
    /// True if it is closed and convex.
    pub(super) fn is_convex(&self) -> bool {
        self.topology.convex
    }

    /// The triangles of an object, with the topology that was found for them.
    pub(super) fn new(scene: &'a Scene, object: &Object, topology: Arc<Topology>) -> Self {
        Self { scene, triangles: object.triangles.clone(), first_vertex: object.vertices.start, topology }
    }

    pub(super) fn byte_count(&self) -> u64 {
        self.topology.byte_count()
    }

    /// Returns `None` for triangles of other objects and those without area.
    #[inline]
    fn facet(&self, triangle: u32) -> Option<Facet> {
        if !self.triangles.contains(&triangle) {
            return None;
        }
        let vertices = self.scene.triangles[triangle as usize];
        let corners = vertices.map(|vertex| self.scene.positions[vertex as usize].as_dvec3());
        let normals = vertices.map(|vertex| self.scene.normals[vertex as usize].as_dvec3());
        let face = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        let inverse_face2 = face.length_squared().recip();
        inverse_face2.is_finite().then_some(Facet { corners, normals, face, inverse_face2 })
    }

    fn group(&self, triangle: u32, corner: usize) -> u32 {
        let vertex = self.scene.triangles[triangle as usize][corner];
        self.topology.groups[(vertex - self.first_vertex) as usize]
    }

    /// The way over the edge opposite a vertex; returns `None` at borders and creases.
    fn crossing(&self, facet: &Facet, triangle: u32, opposite: usize) -> Option<EdgeCrossing> {
        let neighbour = self.topology.neighbours[(triangle - self.triangles.start) as usize][opposite];
        if neighbour == NO_NEIGHBOUR {
            return None;
        }
        let neighbour = neighbour + self.triangles.start;
        let next = self.facet(neighbour)?;
        let ends = [(opposite + 1) % 3, (opposite + 2) % 3];
        let groups = ends.map(|end| self.group(triangle, end));
        let position = |group: u32| (0..3).find(|&corner| self.group(neighbour, corner) == group);
        let (p, q) = (position(groups[0])?, position(groups[1])?);
        let (start, along) =
            (facet.corners[ends[0]], (facet.corners[ends[1]] - facet.corners[ends[0]]).try_normalize()?);
        let across = |vector: DVec3| (vector - along * vector.dot(along)).try_normalize();
        let out = across(start - facet.corners[opposite])?;
        let into = across(next.corners[3 - p - q] - start)?;
        Some(EdgeCrossing { facet: next, triangle: neighbour, ends: [p, q], start, along, out, into })
    }

    fn site(facet: &Facet, triangle: u32, weights: &[f64; 3]) -> ManifoldVertex {
        ManifoldVertex { position: facet.point(weights), triangle, barycentrics: [weights[1], weights[2]] }
    }

    pub(super) fn landed(&self, site: &ManifoldVertex) -> Option<(ManifoldVertex, ManifoldFrame)> {
        let [second, third] = site.barycentrics;
        let facet = self.facet(site.triangle)?;
        let site = Self::site(&facet, site.triangle, &[1.0 - second - third, second, third]);
        Some((site, Self::frame_of(&facet, &site)?))
    }

    pub(super) fn frame(&self, site: &ManifoldVertex) -> Option<ManifoldFrame> {
        Self::frame_of(&self.facet(site.triangle)?, site)
    }

    #[inline]
    fn frame_of(facet: &Facet, site: &ManifoldVertex) -> Option<ManifoldFrame> {
        let [a, b, c] = facet.normals;
        let geometric = facet.outer_normal();
        let first = (facet.corners[1] - facet.corners[0]).try_normalize()?;
        let tangents = [first, geometric.cross(first)];
        let Some((normal, inverse)) = facet.normal_at(site.barycentrics) else {
            let frame =
                ManifoldFrame { position: site.position, normal: geometric, tangents, normal_change: [DVec3::ZERO; 2] };
            return frame.position.is_finite().then_some(frame);
        };
        let normal_change = tangents.map(|tangent| {
            let [_, second, third] = facet.weights_along(tangent);
            let change = ((b - a) * second + (c - a) * third) * inverse;
            change - normal * normal.dot(change)
        });
        let finite = site.position.is_finite()
            && normal.is_finite()
            && tangents[1].is_finite()
            && normal_change[0].is_finite()
            && normal_change[1].is_finite();
        finite.then_some(ManifoldFrame { position: site.position, normal, tangents, normal_change })
    }

    /// A step along the tangents, over edges.
    pub(super) fn stepped(
        &self,
        from: &(ManifoldVertex, ManifoldFrame),
        step: DVec2,
    ) -> Option<(ManifoldVertex, ManifoldFrame)> {
        let (site, frame) = from;
        let motion = frame.tangents[0] * step.x + frame.tangents[1] * step.y;
        if !motion.is_finite() {
            return None;
        }
        let mut facet = self.facet(site.triangle)?;
        let mut triangle = site.triangle;
        let [second, third] = site.barycentrics;
        let mut weights = [1.0 - second - third, second, third];
        let mut motion = motion;
        if weights.iter().any(|weight| *weight < 0.0) {
            // From beyond a border the way starts at the border, or it would pass by the triangles next to it.
            let target = site.position + motion;
            weights = facet.nearest(site.position);
            motion = target - facet.point(&weights);
        }
        for _ in 0..MAX_CROSSINGS {
            let change = facet.weights_along(motion);
            let mut share = 1.0;
            let mut exit = None;
            for side in 0..3 {
                if weights[side] + change[side] < 0.0 && change[side] < 0.0 {
                    let until = (weights[side] / -change[side]).max(0.0);
                    if exit.is_none() || until < share {
                        (share, exit) = (until, Some(side));
                    }
                }
            }
            let Some(side) = exit else {
                let end = [0, 1, 2].map(|k: usize| weights[k] + change[k]);
                let site = Self::site(&facet, triangle, &end);
                return Some((site, Self::frame_of(&facet, &site)?));
            };
            let Some(crossing) = self.crossing(&facet, triangle, side) else {
                let target = facet.point(&weights) + motion;
                return self.beyond_border(facet, triangle, target);
            };
            let at = [0, 1, 2].map(|k: usize| weights[k] + change[k] * share);
            let (p, q) = (at[(side + 1) % 3].max(0.0), at[(side + 2) % 3].max(0.0));
            let sum = p + q;
            weights = [0.0; 3];
            (weights[crossing.ends[0]], weights[crossing.ends[1]]) = (p / sum, q / sum);
            motion = crossing.laid_over(motion * (1.0 - share));
            (facet, triangle) = (crossing.facet, crossing.triangle);
        }
        None
    }

    /// A site beyond a border, in the plane of the triangle that is nearest there.
    fn beyond_border(&self, facet: Facet, triangle: u32, target: DVec3) -> Option<(ManifoldVertex, ManifoldFrame)> {
        let (mut facet, mut triangle, mut target) = (facet, triangle, target);
        let mut nearest = facet.nearest(target);
        for _ in 0..MAX_SLIDES {
            let distance2 = facet.point(&nearest).distance_squared(target);
            let nearer = |side: usize| {
                let crossing = (nearest[side] == 0.0).then(|| self.crossing(&facet, triangle, side))??;
                let laid = crossing.start + crossing.laid_over(target - crossing.start);
                let nearest = crossing.facet.nearest(laid);
                let is_nearer = crossing.facet.point(&nearest).distance_squared(laid) < distance2 * (1.0 - 1e-9);
                is_nearer.then_some((crossing, laid, nearest))
            };
            let Some((crossing, laid, found)) = (0..3).find_map(nearer) else { break };
            (facet, triangle, target, nearest) = (crossing.facet, crossing.triangle, laid, found);
        }
        let weights = facet.weights_of(target);
        if !facet.is_flat() && weights.iter().any(|weight| *weight < MIN_WEIGHT) {
            return None;
        }
        let site = Self::site(&facet, triangle, &weights);
        Some((site, Self::frame_of(&facet, &site)?))
    }

    /// The exact point where a ray meets the plane of a triangle.
    pub(super) fn intersection(&self, triangle: u32, origin: DVec3, direction: DVec3) -> Option<ManifoldVertex> {
        let facet = self.facet(triangle)?;
        let distance = (facet.corners[0] - origin).dot(facet.face) / direction.dot(facet.face);
        let site = Self::site(&facet, triangle, &facet.weights_of(origin + direction * distance));
        (site.position.is_finite()).then_some(site)
    }

    /// The same point with its shading normal and that of the triangle, both on the outer side.
    #[inline]
    pub(super) fn arrived(&self, triangle: u32, origin: DVec3, direction: DVec3) -> Option<(DVec3, DVec3, DVec3)> {
        let facet = self.facet(triangle)?;
        let distance = (facet.corners[0] - origin).dot(facet.face) / direction.dot(facet.face);
        let weights = facet.weights_of(origin + direction * distance);
        let (position, geometric) = (facet.point(&weights), facet.outer_normal());
        let normal = facet.normal_at([weights[1], weights[2]]).map_or(geometric, |(normal, _)| normal);
        (position.is_finite() && normal.is_finite()).then_some((position, normal, geometric))
    }

    pub(super) fn is_within(&self, site: &ManifoldVertex) -> bool {
        let [second, third] = site.barycentrics;
        self.triangles.contains(&site.triangle) && second >= WITHIN && third >= WITHIN && 1.0 - second - third >= WITHIN
    }

    /// The smooth surface that the mesh stands for, near a site: through the site, with the interpolated normal, and
    /// with the shape operators of the triangle's vertices interpolated.
    pub(super) fn patch(&self, site: &ManifoldVertex) -> Option<SurfacePatch> {
        let facet = self.facet(site.triangle)?;
        let frame = Self::frame_of(&facet, site)?;
        let operators = [0, 1, 2].map(|corner| self.topology.operators[self.group(site.triangle, corner) as usize]);
        let blend =
            |weights: [f64; 3]| operators[0] * weights[0] + operators[1] * weights[1] + operators[2] * weights[2];
        let (position, normal) = (frame.position, frame.normal);
        let tangents = tangent_frame(normal);
        // Beyond a border curvature stays as it is there.
        let operator = blend(facet.nearest(position));
        let form = |operator: &DMat3, a: usize, b: usize| tangents[a].dot(*operator * tangents[b]);
        let shape = [form(&operator, 0, 0), form(&operator, 0, 1), form(&operator, 1, 1)];
        let normal_change =
            [tangents[0] * shape[0] + tangents[1] * shape[1], tangents[0] * shape[1] + tangents[1] * shape[2]];
        let bend = shape.map(|curvature| normal * -curvature);
        // Derivatives of the shape are symmetric in all three directions (Codazzi); the differences of the vertices'
        // operators are so only nearly.
        let change = tangents.map(|tangent| blend(facet.weights_along(tangent)));
        let cubic = [
            form(&change[0], 0, 0),
            (form(&change[1], 0, 0) + 2.0 * form(&change[0], 0, 1)) / 3.0,
            (form(&change[0], 1, 1) + 2.0 * form(&change[1], 0, 1)) / 3.0,
            form(&change[1], 1, 1),
        ];
        let normal_bend = [(0, 0), (0, 1), (1, 1)].map(|(a, b): (usize, usize)| {
            tangents[0] * cubic[a + b] + tangents[1] * cubic[a + b + 1]
                - normal * normal_change[a].dot(normal_change[b])
        });
        let patch = SurfacePatch { position, normal, tangents, bend, normal_change, normal_bend };
        patch.is_finite().then_some(patch)
    }
}
