//! A hierarchy of boxes over triangles, eight children a node and up to eight triangles a leaf, for beams and for rays.
//!
//! Boxes and corners are plain floats, one lane a child or triangle: a node or a leaf is tested at once. Triangles that
//! move keep their place in it ([`WideHierarchy::refit`]).

mod any;
mod build;
mod narrow;
mod rays;
mod treelet;

pub use build::{Solid, has_extent};
pub use narrow::Narrow;
#[cfg(target_arch = "x86_64")]
pub use rays::Avx2;
pub use rays::{Portable, PrimitiveMet, PrimitiveTests, SignBits, meet};
pub use treelet::{Beam, Treelet};

use catoptric_core::math::lanes::LANES;
use catoptric_core::scene::Scene;
use glam::{Vec2, Vec3, Vec3A};
use obvhs::aabb::Aabb as BvhBox;

/// Children with this bit are leaves: the rest is the number of their block of triangles.
const LEAF: u32 = 1 << 31;

/// Other children with this bit are analytic surfaces: the rest is the number of their object.
const SURFACE: u32 = 1 << 30;

/// A child that is not there.
const NONE: u32 = u32::MAX;

/// Triangles with this bit may have holes where their alpha is low, in hierarchies made for rays
/// ([`WideHierarchy::build_for_rays`]).
pub(crate) const ALPHA_TESTED: u32 = 1 << 30;

/// A triangle that is not there.
pub const NO_TRIANGLE: u32 = u32::MAX;

/// The boxes of eight children.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub struct WideNode {
    /// Lower corners by axis, then upper ones; empty (infinite, inside out) where there is no child.
    pub sides: [[f32; LANES]; 6],
    children: [u32; LANES],
}

impl WideNode {
    const EMPTY: Self = Self {
        sides: [
            [f32::INFINITY; LANES],
            [f32::INFINITY; LANES],
            [f32::INFINITY; LANES],
            [f32::NEG_INFINITY; LANES],
            [f32::NEG_INFINITY; LANES],
            [f32::NEG_INFINITY; LANES],
        ],
        children: [NONE; LANES],
    };

    fn set_box(&mut self, lane: usize, bounds: &BvhBox) {
        for axis in 0..3 {
            self.sides[axis][lane] = bounds.min[axis];
            self.sides[axis + 3][lane] = bounds.max[axis];
        }
    }

    /// The box around all children.
    fn bounds(&self) -> BvhBox {
        let low = |axis: usize| self.sides[axis].iter().copied().fold(f32::INFINITY, f32::min);
        let high = |axis: usize| self.sides[axis + 3].iter().copied().fold(f32::NEG_INFINITY, f32::max);
        BvhBox::new(Vec3A::from_array([0, 1, 2].map(low)), Vec3A::from_array([0, 1, 2].map(high)))
    }
}

/// The triangles of a leaf.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub struct TriangleBlock {
    /// x, y and z of the first corners, of the second and of the third ones. Not a number where there is no triangle:
    /// no test of such a lane succeeds.
    pub corners: [[f32; LANES]; 9],
    /// The scene's triangles, or [`NO_TRIANGLE`].
    pub triangles: [u32; LANES],
}

impl TriangleBlock {
    /// No triangle.
    pub const EMPTY: Self = Self { corners: [[f32::NAN; LANES]; 9], triangles: [NO_TRIANGLE; LANES] };

    /// Puts a triangle of the scene into a lane.
    pub fn set(&mut self, lane: usize, corners: [Vec3; 3], triangle: u32) {
        for (corner, position) in corners.into_iter().enumerate() {
            for axis in 0..3 {
                self.corners[corner * 3 + axis][lane] = position[axis];
            }
        }
        self.triangles[lane] = triangle;
    }

    fn bounds(&self) -> BvhBox {
        let mut bounds = BvhBox::empty();
        for lane in 0..LANES {
            for corner in 0..3 {
                if self.triangles[lane] != NO_TRIANGLE {
                    let at = |axis: usize| self.corners[corner * 3 + axis][lane];
                    bounds.extend(Vec3A::new(at(0), at(1), at(2)));
                }
            }
        }
        bounds
    }
}

/// The hierarchy. Without triangles it has no nodes.
#[derive(Clone, Debug, Default)]
pub struct WideHierarchy {
    /// The first one is the root; children come after their parents.
    nodes: Vec<WideNode>,
    blocks: Vec<TriangleBlock>,
    /// Triangles that had no extent when it was built.
    flat: Vec<u32>,
    /// Triangles that were left out, each with the one that was the same.
    copies: Vec<[u32; 2]>,
}

/// A visitor that looks for leaves. Not closures: those are not compiled for the instructions of the function that they
/// are in.
pub trait Visitor {
    /// The children that are of interest, one bit each.
    fn children(&self, node: &WideNode) -> u32;

    /// A leaf among them; false ends the walk.
    fn leaf(&mut self, block: &TriangleBlock) -> bool;
}

/// The nearest triangle along a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit {
    /// The distance from the origin, in lengths of the direction.
    pub distance: f32,
    /// The scene's triangle, as it stands in the hierarchy.
    pub triangle: u32,
    /// Weights of its second and third corner.
    pub barycentrics: Vec2,
}

impl WideHierarchy {
    /// The memory that it takes.
    pub fn byte_count(&self) -> u64 {
        let Self { nodes, blocks, flat, copies } = self;
        let lists = size_of_val(flat.as_slice()) + size_of_val(copies.as_slice());
        (size_of_val(nodes.as_slice()) + size_of_val(blocks.as_slice()) + lists) as u64
    }

    /// Shows a visitor the blocks of all leaves whose boxes pass its test.
    #[inline(always)]
    pub fn walk(&self, stack: &mut Vec<u32>, visitor: &mut impl Visitor) {
        stack.clear();
        if !self.nodes.is_empty() {
            stack.push(0);
        }
        while let Some(next) = stack.pop() {
            let node = &self.nodes[next as usize];
            let mut met = visitor.children(node);
            while met != 0 {
                let child = node.children[met.trailing_zeros() as usize];
                met &= met - 1;
                match child {
                    NONE => {}
                    block if block & LEAF != 0 => {
                        if !visitor.leaf(&self.blocks[(block & !LEAF) as usize]) {
                            return;
                        }
                    }
                    surface if surface & SURFACE != 0 => {}
                    inner => stack.push(inner),
                }
            }
        }
    }

    /// The number of places of triangles and surfaces in leaves.
    pub fn place_count(&self) -> usize {
        let children = self.nodes.iter().flat_map(|node| node.children);
        let surfaces = children.filter(|&child| child != NONE && child & (LEAF | SURFACE) == SURFACE).count();
        let triangles = self.blocks.iter().flat_map(|block| block.triangles);
        surfaces + triangles.filter(|triangle| *triangle != NO_TRIANGLE).count()
    }
}

fn corners_of(scene: &Scene, triangle: u32) -> [Vec3; 3] {
    scene.triangles[triangle as usize].map(|vertex| scene.positions[vertex as usize])
}
