//! The beam of a tile: planes that all its rays lie between, and the triangles within.

use super::bundle::{BundleFit, RayBundle};
use catoptric_core::math::Aabb;
use catoptric_core::math::lanes::{LANES, bits_of};
use catoptric_engine::light::wide_hierarchy::{NO_TRIANGLE, TriangleBlock, Visitor, WideHierarchy, WideNode};
use glam::Vec3;

/// Beams are wider than the rays through pixels' centres by this much, in pixels: half a pixel to the outermost
/// samples, and a margin for the rays between.
const MARGIN_PX: f32 = 0.75;

/// Planes are moved outwards by this share of the coordinates' size: their rounding.
const ROUNDING: f32 = 1e-6;

/// The sides of a beam, and its near plane.
const PLANES: usize = 5;

/// Points p with `normal . p <= limit` for all planes.
#[derive(Clone, Copy, Debug)]
pub struct Beam {
    normals: [Vec3; PLANES],
    limits: [f32; PLANES],
}

impl Beam {
    /// The beam of a bundle's rays through a box. Conservative for points between the rays' least start and the box's
    /// far end.
    #[inline(always)]
    pub fn new(bundle: &RayBundle, fit: &BundleFit, bounds: &Aabb) -> Self {
        let w = bundle.axes[2];
        let farthest = (bounds.center() - bundle.origin).dot(w) + 0.5 * bounds.size().dot(w.abs());
        let near = bundle.start_range[0];
        let far = farthest.max(near * 2.0);
        let rows = bundle.pixels_from_plane(near + (far - near) / 3.0).transpose();
        let mut beam = Self { normals: [-w; PLANES], limits: [0.0; PLANES] };
        for (index, row) in [rows.x_axis, rows.y_axis].into_iter().enumerate() {
            // A row without length (all rays alike) bounds nothing.
            let row = row.normalize_or(glam::Vec2::X);
            let [low, high] = bundle.bounds_at(fit, row, near, MARGIN_PX);
            let [low_far, high_far] = bundle.bounds_at(fit, row, far, MARGIN_PX);
            let across = bundle.axes[0] * row.x + bundle.axes[1] * row.y;
            let mut set = |place: usize, sign: f32, near_bound: f32, far_bound: f32| {
                let growth = (far_bound - near_bound) / (far - near);
                beam.normals[place] = (across - w * growth) * sign;
                beam.limits[place] = (near_bound - growth * near) * sign;
            };
            set(index * 2, 1.0, high, high_far);
            set(index * 2 + 1, -1.0, low, low_far);
        }
        beam.limits[4] = -near * 0.999;
        let size = bundle.origin.abs().max_element() + bounds.min.abs().max(bounds.max.abs()).max_element();
        for (limit, normal) in beam.limits.iter_mut().zip(&beam.normals) {
            *limit += normal.dot(bundle.origin) + ROUNDING * size * normal.abs().element_sum();
        }
        beam
    }

    /// The children of a node that may hold something within the beam, one bit each.
    #[inline(always)]
    fn children(&self, node: &WideNode) -> u32 {
        let mut passes = [true; LANES];
        for (normal, limit) in self.normals.iter().zip(self.limits) {
            // The corner of each box that lies furthest inside.
            let x = &node.sides[if normal.x > 0.0 { 0 } else { 3 }];
            let y = &node.sides[if normal.y > 0.0 { 1 } else { 4 }];
            let z = &node.sides[if normal.z > 0.0 { 2 } else { 5 }];
            for lane in 0..LANES {
                let at = x[lane] * normal.x + y[lane] * normal.y + z[lane] * normal.z;
                passes[lane] &= at <= limit;
            }
        }
        bits_of(passes).into()
    }

    /// The triangles of a block that may lie within the beam, one bit each.
    #[inline(always)]
    fn triangles(&self, block: &TriangleBlock) -> u32 {
        let mut passes = [true; LANES];
        let corners = &block.corners;
        for (normal, limit) in self.normals.iter().zip(self.limits) {
            for lane in 0..LANES {
                let at = |corner: usize| {
                    corners[corner][lane] * normal.x
                        + corners[corner + 1][lane] * normal.y
                        + corners[corner + 2][lane] * normal.z
                };
                let inside = (at(0) <= limit) | (at(3) <= limit) | (at(6) <= limit);
                passes[lane] &= inside;
            }
        }
        bits_of(passes).into()
    }
}

/// Puts the triangles in a beam into a list.
struct Collector<'a> {
    list: &'a mut CandidateList,
    beam: &'a Beam,
    most: usize,
}

impl Visitor for Collector<'_> {
    #[inline(always)]
    fn children(&self, node: &WideNode) -> u32 {
        self.beam.children(node)
    }

    #[inline(always)]
    fn leaf(&mut self, block: &TriangleBlock) -> bool {
        self.list.push_all(block, self.beam.triangles(block));
        self.list.len <= self.most
    }
}

/// Triangles that a tile may see, eight a block; the last one may have empty lanes.
#[derive(Debug, Default)]
pub struct CandidateList {
    /// Blocks of them.
    pub blocks: Vec<TriangleBlock>,
    len: usize,
}

impl CandidateList {
    /// A list of all triangles of some blocks.
    pub fn of(blocks: &[TriangleBlock]) -> Self {
        let mut list = Self::default();
        blocks.iter().for_each(|block| list.push_all(block, u32::MAX >> (32 - LANES)));
        list
    }

    /// The number of triangles in the list.
    pub fn count(&self) -> usize {
        self.len
    }

    pub(in super::super) fn clear(&mut self) {
        self.blocks.clear();
        self.len = 0;
    }

    #[inline(always)]
    fn push(&mut self, from: &TriangleBlock, lane: usize) {
        let place = self.len % LANES;
        if place == 0 {
            self.blocks.push(TriangleBlock::EMPTY);
        }
        if let Some(block) = self.blocks.last_mut() {
            for (to, from) in block.corners.iter_mut().zip(&from.corners) {
                to[place] = from[lane];
            }
            block.triangles[place] = from.triangles[lane];
        }
        self.len += 1;
    }

    #[inline(always)]
    fn push_all(&mut self, from: &TriangleBlock, mut lanes: u32) {
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize;
            lanes &= lanes - 1;
            if from.triangles[lane] != NO_TRIANGLE {
                self.push(from, lane);
            }
        }
    }

    /// Becomes the triangles of a hierarchy that may lie in a beam; some of them, and more than `most`, where there are
    /// more.
    #[inline(always)]
    pub(in super::super) fn collect(
        &mut self,
        hierarchy: &WideHierarchy,
        beam: &Beam,
        stack: &mut Vec<u32>,
        most: usize,
    ) {
        self.clear();
        hierarchy.walk(stack, &mut Collector { list: self, beam, most });
    }

    /// Becomes those of another list that may lie in a beam.
    #[inline(always)]
    pub fn filter(&mut self, parent: &Self, beam: &Beam) {
        self.clear();
        for block in &parent.blocks {
            self.push_all(block, beam.triangles(block));
        }
    }

    /// The least and largest depth of their corners along an axis, from an origin.
    #[inline(always)]
    pub(in super::super) fn depth_range(&self, origin: Vec3, axis: Vec3) -> [f32; 2] {
        let (mut low, mut high) = ([f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]);
        let shift = origin.dot(axis);
        for block in &self.blocks {
            for corner in [0, 3, 6] {
                for lane in 0..LANES {
                    let at = block.corners[corner][lane] * axis.x
                        + block.corners[corner + 1][lane] * axis.y
                        + block.corners[corner + 2][lane] * axis.z
                        - shift;
                    // Empty lanes are not numbers and change nothing.
                    low[lane] = if at < low[lane] { at } else { low[lane] };
                    high[lane] = if at > high[lane] { at } else { high[lane] };
                }
            }
        }
        [low.into_iter().fold(f32::INFINITY, f32::min), high.into_iter().fold(f32::NEG_INFINITY, f32::max)]
    }
}
