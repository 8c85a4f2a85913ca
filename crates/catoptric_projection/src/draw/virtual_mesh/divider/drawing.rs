//! Pieces that are drawn between the appearances at their corners.

use super::division::WORK_A_PIECE;
use super::missed_boundaries::{EndKey, MissedBoundary};
use super::shapes::{PieceCorner, TracePlace};
use crate::draw::virtual_mesh::edge::EdgeRule;
use crate::draw::virtual_mesh::mesh::VirtualMesh;
use crate::draw::virtual_mesh::object::VirtualObject;
use crate::find::work;
use catoptric_engine::method::projector::{Projection, Projections, VertexProjector};
use catoptric_engine::raster::DrawTriangle;
use glam::Vec2;
use std::collections::HashMap;
use std::ops::Range;

/// Blocks this near to pieces that are left out are left out, too, in pixels: a pixel's samples lie around its middle,
/// and appearances are known to less than one.
const LEFT_OUT_LEEWAY_PX: f32 = 1.0;

/// Draws pieces of triangles of one object on one path.
pub(super) struct PieceDrawing<'a, P: VertexProjector + ?Sized> {
    pub(super) projector: &'a P,
    pub(super) object: &'a VirtualObject,
    pub(super) rule: EdgeRule,
    /// The triangle of the scene.
    pub(super) source: u32,
    /// The work that each triangle may take.
    pub(super) limit: u64,
    pub(super) dips: Vec<MissedBoundary>,
    /// The appearances of all points so far.
    pub(super) appearances: Vec<Projection>,
    /// The ranges in `way_points` of the ways of appearances to their ends.
    pub(super) ends: HashMap<EndKey, Range<u32>>,
    pub(super) way_points: Vec<(Projection, f32)>,
    pub(super) scratch: Projections,
    /// The piece that is being drawn.
    pub(super) piece: [TracePlace; 3],
    /// The side of it that ways lead to, if neither of its ends has the appearance and no way got there yet.
    pub(super) far_side: Option<[TracePlace; 2]>,
    /// Work of this thread before the triangle.
    pub(super) work_before: u64,
    pub(super) mesh: VirtualMesh,
}

impl<'a, P: VertexProjector + ?Sized> PieceDrawing<'a, P> {
    /// For triangles of `object`, each of which takes no more work than about `limit`.
    pub(super) fn new(projector: &'a P, object: &'a VirtualObject, rule: EdgeRule, limit: u64) -> Self {
        let known = if rule.leaves_out() { projector.holes(object.path) } else { None };
        let holes = known.cloned().unwrap_or_else(|| rule.picture().no_blocks());
        let mesh = VirtualMesh { holes, ..VirtualMesh::default() };
        Self {
            projector,
            object,
            rule,
            source: 0,
            limit,
            dips: Vec::new(),
            appearances: Vec::new(),
            ends: HashMap::new(),
            way_points: Vec::new(),
            scratch: Projections::default(),
            piece: [TracePlace::default(); 3],
            far_side: None,
            work_before: 0,
            mesh,
        }
    }

    /// The appearances of a corner.
    pub(super) fn of(&self, corner: &PieceCorner) -> &[Projection] {
        &self.appearances[corner.range()]
    }

    /// True if the triangle's work is done.
    pub(super) fn is_spent(&self) -> bool {
        work::since(self.work_before) >= self.limit
    }

    /// True if a piece is drawn too straight between its corners' appearances.
    pub(super) fn is_bent(&self, corners: &[PieceCorner; 3], shown: &[Projection; 3]) -> bool {
        (0..3).any(|k| {
            let next = (k + 1) % 3;
            self.rule.is_bent(&shown[k], &shown[next], corners[next].position - corners[k].position)
        })
    }

    /// Leaves the blocks of the picture to something else that places touch, or lie between.
    pub(super) fn leave_out<const COUNT: usize>(&mut self, places: [Vec2; COUNT]) {
        let low = places.into_iter().fold(Vec2::INFINITY, Vec2::min) - LEFT_OUT_LEEWAY_PX;
        let high = places.into_iter().fold(Vec2::NEG_INFINITY, Vec2::max) + LEFT_OUT_LEEWAY_PX;
        self.mesh.holes.add_box(low, high);
    }

    /// The appearance of another corner that belongs to one of `own`.
    pub(super) fn partner(&self, index: usize, own: &PieceCorner, other: &PieceCorner) -> Option<usize> {
        let step = other.position - own.position;
        let (here, there) = (self.of(own), self.of(other));
        let partner = self.rule.partner(&self.appearances[index], here, there, step)?;
        let place = there.iter().position(|one| std::ptr::eq(one, partner))?;
        Some(other.range().start + place)
    }

    /// Draws a piece.
    pub(super) fn push(&mut self, corners: [(Projection, Vec2); 3]) {
        let [a, b, c] = corners.map(|(_, weights)| weights);
        if a == b || b == c || c == a {
            return; // cut to nothing
        }
        let mesh = &mut self.mesh;
        let first = mesh.vertices.len() as u32;
        mesh.vertices.extend(corners.iter().map(|(projection, _)| self.rule.picture().point(projection)));
        let vertices = [first, first + 1, first + 2];
        let (source, alpha_tested) = (self.source, self.object.alpha_tested);
        mesh.triangles.push(DrawTriangle { vertices, source, group: 0, patch: 0, alpha_tested });
        mesh.corners.push(corners.map(|(_, weights)| weights));
        work::add(WORK_A_PIECE);
    }
}
