//! The walk of a ray through `obvhs`'s compressed hierarchy, compiled for several SIMD levels and chosen at run time.
//!
//! The crate's own walk tests four boxes at a time with SSE2; this one tests all eight children of a node at once
//! where the machine can, and widens boxes by the rounding of the test, so that no scale of scene loses hits.

use crate::scene::Ray;
use glam::{UVec2, Vec2, Vec3, Vec3A};
use multiversion::multiversion;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::node::CwBvhNode;
use obvhs::traverse;

/// One primitive in the order of the hierarchy's leaves.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leaf {
    /// The triangle's corners; unused where `special` is.
    pub(super) corners: [Vec3; 3],
    /// What the owner of the hierarchy knows the primitive by.
    pub(super) code: u32,
}

/// Leaves with any of these bits in their code are left to the owner of the hierarchy.
pub(super) const SPECIAL: u32 = 0b11 << 30;

/// The nearest primitive along a ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct Nearest {
    /// Distance along the ray; infinite if nothing was met.
    pub(super) distance: f32,
    /// Barycentric coordinates of the second and third corner.
    pub(super) barycentrics: Vec2,
    /// The leaf's code.
    pub(super) code: u32,
}

impl Nearest {
    const NOTHING: Self = Self { distance: f32::INFINITY, barycentrics: Vec2::ZERO, code: u32::MAX };
}

/// The nearest primitive at a distance of at least `near`.
///
/// `special(leaf, far)` is asked about leaves with [`SPECIAL`] bits: the distance and barycentric coordinates, if the
/// ray meets it before `far`.
#[inline]
pub(super) fn nearest(
    bvh: &CwBvh,
    leaves: &[Leaf],
    ray: &Ray,
    near: f32,
    special: &dyn Fn(&Leaf, f32) -> Option<(f32, Vec2)>,
) -> Nearest {
    walk(bvh, leaves, ray, near, special)
}

#[multiversion(targets("x86_64+avx2+fma+bmi1+bmi2+lzcnt+popcnt", "x86_64+sse4.2+popcnt"))]
fn walk(
    bvh: &CwBvh,
    leaves: &[Leaf],
    ray: &Ray,
    near: f32,
    special: &dyn Fn(&Leaf, f32) -> Option<(f32, Vec2)>,
) -> Nearest {
    let direction = Vec3A::from(ray.direction);
    let origin = Vec3A::from(ray.origin);
    // Zero components get a huge inverse of their sign: such rays stay within their slabs.
    let smallest = Vec3A::splat(1e-18);
    let limited = Vec3A::select(direction.abs().cmplt(smallest), smallest.copysign(direction), direction);
    let inverse = limited.recip();
    let backwards = [inverse.x < 0.0, inverse.y < 0.0, inverse.z < 0.0];
    let mut best = Nearest::NOTHING;
    let mut state = bvh.new_traversal(direction);
    let mut node;
    traverse!(bvh, node, state, meet_children(node, origin, inverse, backwards, best.distance, state.oct_inv4), {
        let leaf = &leaves[state.primitive_id as usize];
        let met = if leaf.code & SPECIAL == 0 {
            meet_triangle(&leaf.corners, origin, direction, near, best.distance)
        } else {
            special(leaf, best.distance)
        };
        if let Some((distance, barycentrics)) = met {
            best = Nearest { distance, barycentrics, code: leaf.code };
        }
    });
    best
}

/// Which children of a node a ray may meet before `far`, in the form that `traverse!` expects.
#[inline(always)]
fn meet_children(
    node: &CwBvhNode,
    origin: Vec3A,
    inverse: Vec3A,
    backwards: [bool; 3],
    far: f32,
    oct_inv4: u32,
) -> u32 {
    let step = node.compute_extent() * inverse;
    let start = (Vec3A::from(node.p) - origin) * inverse;
    // The rounding of `start` is the error that matters: it moves all planes of an axis alike.
    let slack = start.abs() * 4e-7;
    let (near_start, far_start) = (start - slack, start + slack);
    let (low_x, high_x) = ordered(&node.child_min_x, &node.child_max_x, backwards[0]);
    let (low_y, high_y) = ordered(&node.child_min_y, &node.child_max_y, backwards[1]);
    let (low_z, high_z) = ordered(&node.child_min_z, &node.child_max_z, backwards[2]);
    // Loops over eight numbers with nothing else in them become single instructions.
    let x0 = planes(low_x, step.x, near_start.x);
    let y0 = planes(low_y, step.y, near_start.y);
    let z0 = planes(low_z, step.z, near_start.z);
    let x1 = planes(high_x, step.x, far_start.x);
    let y1 = planes(high_y, step.y, far_start.y);
    let z1 = planes(high_z, step.z, far_start.z);
    let mut flags = [0u32; 8];
    for child in 0..8 {
        let enter = larger(larger(x0[child], y0[child]), larger(z0[child], 0.0));
        let leave = smaller(smaller(x1[child], y1[child]), smaller(z1[child], far));
        flags[child] = if enter <= leave * 1.000_001 { 1 << child } else { 0 };
    }
    let mut met = 0u32;
    for flag in flags {
        met |= flag;
    }
    let (child_bits8, bit_index8) = node.get_child_and_index_bits(oct_inv4);
    let mut hits = 0u32;
    while met != 0 {
        let shift = met.trailing_zeros() * 8;
        met &= met - 1;
        hits |= ((child_bits8 >> shift) as u32 & 0xff) << ((bit_index8 >> shift) as u32 & 0xff);
    }
    hits
}

#[inline(always)]
fn ordered<'a>(low: &'a [u8; 8], high: &'a [u8; 8], backwards: bool) -> (&'a [u8; 8], &'a [u8; 8]) {
    if backwards { (high, low) } else { (low, high) }
}

/// Where a ray meets eight planes of one axis.
#[inline(always)]
fn planes(at: &[u8; 8], step: f32, start: f32) -> [f32; 8] {
    let mut distances = [0.0; 8];
    for child in 0..8 {
        distances[child] = at[child] as f32 * step + start;
    }
    distances
}

/// The larger one, as one instruction: the second where either is not a number.
#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// The smaller one, as one instruction: the second where either is not a number.
#[inline(always)]
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// Distance and barycentric coordinates where a ray meets a triangle, from either side.
///
/// Decided by the signed volumes that the ray spans with the edges, which neighbours compute alike to the bit: no
/// ray passes between two triangles that share an edge (as in Embree's robust mode).
#[inline(always)]
pub(super) fn meet_triangle(
    corners: &[Vec3; 3],
    origin: Vec3A,
    direction: Vec3A,
    near: f32,
    far: f32,
) -> Option<(f32, Vec2)> {
    let a = Vec3A::from(corners[0]) - origin;
    let b = Vec3A::from(corners[1]) - origin;
    let c = Vec3A::from(corners[2]) - origin;
    let (ca, ab, bc) = (c - a, a - b, b - c);
    let u = ca.cross(c + a).dot(direction);
    let v = ab.cross(a + b).dot(direction);
    let w = bc.cross(b + c).dot(direction);
    let (low, high) = (smaller(smaller(u, v), w), larger(larger(u, v), w));
    if low < 0.0 && high > 0.0 {
        return None;
    }
    let normal = bc.cross(ab);
    let distance = normal.dot(a) / normal.dot(direction);
    let sum = u + v + w;
    // Written so that a NaN is no hit.
    if !(distance >= near && distance < far && sum != 0.0) {
        return None;
    }
    let inverse = 1.0 / sum;
    Some((distance, Vec2::new(u * inverse, v * inverse)))
}
