//! The walk of a ray through `obvhs`'s compressed hierarchy, with AVX2 where the machine has it.
//!
//! The crate's own walk tests four boxes at a time with SSE2; this one tests all eight children of a node at once
//! where the machine can, and widens boxes by the rounding of the test, so that no scale of scene loses hits.

use crate::scene::Ray;
use glam::{UVec2, Vec2, Vec3, Vec3A, Vec4, Vec4Swizzles};
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::node::CwBvhNode;
use obvhs::traverse;

/// One primitive in the order of the hierarchy's leaves.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))] // one line of the cache
pub(super) struct LeafRange {
    /// The triangle's corners; without meaning where there is no triangle.
    pub(super) corners: Corners,
    /// Number of the primitive in the hierarchy's owner.
    pub(super) code: u32,
}

/// The corners of a triangle: their x, y and z in one register each. The last lane repeats the first.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corners {
    x: Vec4,
    y: Vec4,
    z: Vec4,
}

impl Corners {
    pub(super) fn new([a, b, c]: [Vec3; 3]) -> Self {
        let lanes = |axis: usize| Vec4::new(a[axis], b[axis], c[axis], a[axis]);
        Self { x: lanes(0), y: lanes(1), z: lanes(2) }
    }
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
    /// Primitives that were tested.
    pub(super) tests: u32,
}

impl Nearest {
    const NOTHING: Self = Self { distance: f32::INFINITY, barycentrics: Vec2::ZERO, code: u32::MAX, tests: 0 };
}

/// What is asked about leaves with [`SPECIAL`] bits: the distance and barycentric coordinates, if the ray meets the
/// leaf before the given distance.
pub(super) type SpecialLeaf<'a> = dyn Fn(&LeafRange, f32) -> Option<(f32, Vec2)> + 'a;

/// The nearest primitive at a distance of at least `near`.
#[inline]
pub(super) fn nearest(bvh: &CwBvh, leaves: &[LeafRange], ray: &Ray, near: f32, special: &SpecialLeaf<'_>) -> Nearest {
    #[cfg(target_arch = "x86_64")]
    if avx2::is_available() {
        #[allow(unsafe_code, reason = "the machine has just been asked for the features that the function needs")]
        return unsafe { avx2::walk(bvh, leaves, ray, near, special) };
    }
    walk(bvh, leaves, ray, near, special)
}

/// The walk, with the test of a node's children filled in. A macro, because a function that takes the test as an
/// argument could not be compiled for the instructions that the test needs.
macro_rules! walk {
    ($meet_children:path, $bvh:ident, $leaves:ident, $ray:ident, $near:ident, $special:ident) => {{
        let direction = Vec3A::from($ray.direction);
        let origin = Vec3A::from($ray.origin);
        let slabs = Slabs::new(origin, direction);
        let mut best = Nearest::NOTHING;
        let mut state = $bvh.new_traversal(direction);
        let mut node;
        traverse!($bvh, node, state, children($meet_children(node, &slabs, best.distance), node, state.oct_inv4), {
            let leaf = &$leaves[state.primitive_id as usize];
            best.tests += 1;
            let met = if leaf.code & SPECIAL == 0 {
                meet_triangle(&leaf.corners, origin, direction, $near, best.distance)
            } else {
                $special(leaf, best.distance)
            };
            if let Some((distance, barycentrics)) = met {
                best = Nearest { distance, barycentrics, code: leaf.code, ..best };
            }
        });
        best
    }};
}

/// For machines without AVX2.
fn walk(bvh: &CwBvh, leaves: &[LeafRange], ray: &Ray, near: f32, special: &SpecialLeaf<'_>) -> Nearest {
    walk!(meet_children, bvh, leaves, ray, near, special)
}

/// A ray, prepared for tests against boxes.
struct Slabs {
    origin: Vec3A,
    inverse: Vec3A,
    backwards: [bool; 3],
}

impl Slabs {
    #[inline(always)]
    fn new(origin: Vec3A, direction: Vec3A) -> Self {
        // Zero components get a huge inverse of their sign: such rays stay within their slabs.
        let smallest = Vec3A::splat(1e-18);
        let limited = Vec3A::select(direction.abs().cmplt(smallest), smallest.copysign(direction), direction);
        let inverse = limited.recip();
        Self { origin, inverse, backwards: [inverse.x < 0.0, inverse.y < 0.0, inverse.z < 0.0] }
    }

    /// The distance to a node's planes grows by the first value from plane to plane, and starts between the others.
    #[inline(always)]
    fn of(&self, node: &CwBvhNode) -> (Vec3A, Vec3A, Vec3A) {
        let step = node.compute_extent() * self.inverse;
        let start = (Vec3A::from(node.p) - self.origin) * self.inverse;
        // The rounding of the start is the error that matters: it moves all planes of an axis alike.
        let slack = start.abs() * 4e-7;
        (step, start - slack, start + slack)
    }
}

/// How much further boxes reach, as a share of the distance: the rounding of the test.
const REACH: f32 = 1.000_001;

/// Which children of a node a ray may meet before `far`, one bit each.
#[inline(always)]
fn meet_children(node: &CwBvhNode, slabs: &Slabs, far: f32) -> u32 {
    let (step, near_start, far_start) = slabs.of(node);
    let (low_x, high_x) = ordered(&node.child_min_x, &node.child_max_x, slabs.backwards[0]);
    let (low_y, high_y) = ordered(&node.child_min_y, &node.child_max_y, slabs.backwards[1]);
    let (low_z, high_z) = ordered(&node.child_min_z, &node.child_max_z, slabs.backwards[2]);
    let mut met = 0;
    for child in 0..8 {
        let x0 = low_x[child] as f32 * step.x + near_start.x;
        let y0 = low_y[child] as f32 * step.y + near_start.y;
        let z0 = low_z[child] as f32 * step.z + near_start.z;
        let x1 = high_x[child] as f32 * step.x + far_start.x;
        let y1 = high_y[child] as f32 * step.y + far_start.y;
        let z1 = high_z[child] as f32 * step.z + far_start.z;
        let enter = larger(larger(x0, y0), larger(z0, 0.0));
        let leave = smaller(smaller(x1, y1), smaller(z1, far));
        met |= u32::from(enter <= leave * REACH) << child;
    }
    met
}

/// The children that are met, in the form that `traverse!` expects.
#[inline(always)]
fn children(mut met: u32, node: &CwBvhNode, oct_inv4: u32) -> u32 {
    let (child_bits8, bit_index8) = node.get_child_and_index_bits(oct_inv4);
    let mut hits = 0u32;
    while met != 0 {
        let shift = met.trailing_zeros() * 8;
        met &= met - 1;
        hits |= ((child_bits8 >> shift) as u32 & 0xff) << ((bit_index8 >> shift) as u32 & 0xff);
    }
    hits
}

/// The same walk with all eight children in one register.
#[cfg(target_arch = "x86_64")]
mod avx2 {
    use super::*;
    use std::arch::x86_64::*;

    #[inline(always)]
    pub(super) fn is_available() -> bool {
        is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("fma")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2")
            && is_x86_feature_detected!("lzcnt")
            && is_x86_feature_detected!("popcnt")
    }

    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn walk(bvh: &CwBvh, leaves: &[LeafRange], ray: &Ray, near: f32, special: &SpecialLeaf<'_>) -> Nearest {
        walk!(meet_children, bvh, leaves, ray, near, special)
    }

    /// Distances at which a ray meets eight planes of one axis.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn planes(at: &[u8; 8], step: f32, start: f32) -> __m256 {
        let at = _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(_mm_cvtsi64_si128(i64::from_le_bytes(*at))));
        _mm256_add_ps(_mm256_mul_ps(at, _mm256_set1_ps(step)), _mm256_set1_ps(start))
    }

    #[inline]
    #[target_feature(enable = "avx2")]
    fn meet_children(node: &CwBvhNode, slabs: &Slabs, far: f32) -> u32 {
        let (step, near_start, far_start) = slabs.of(node);
        let (low_x, high_x) = ordered(&node.child_min_x, &node.child_max_x, slabs.backwards[0]);
        let (low_y, high_y) = ordered(&node.child_min_y, &node.child_max_y, slabs.backwards[1]);
        let (low_z, high_z) = ordered(&node.child_min_z, &node.child_max_z, slabs.backwards[2]);
        let (x0, x1) = (planes(low_x, step.x, near_start.x), planes(high_x, step.x, far_start.x));
        let (y0, y1) = (planes(low_y, step.y, near_start.y), planes(high_y, step.y, far_start.y));
        let (z0, z1) = (planes(low_z, step.z, near_start.z), planes(high_z, step.z, far_start.z));
        let enter = _mm256_max_ps(_mm256_max_ps(x0, y0), _mm256_max_ps(z0, _mm256_setzero_ps()));
        let leave = _mm256_min_ps(_mm256_min_ps(x1, y1), _mm256_min_ps(z1, _mm256_set1_ps(far)));
        let leave = _mm256_mul_ps(leave, _mm256_set1_ps(REACH));
        _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(enter, leave)) as u32
    }
}

#[inline(always)]
fn ordered<'a>(low: &'a [u8; 8], high: &'a [u8; 8], backwards: bool) -> (&'a [u8; 8], &'a [u8; 8]) {
    if backwards { (high, low) } else { (low, high) }
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
    corners: &Corners,
    origin: Vec3A,
    direction: Vec3A,
    near: f32,
    far: f32,
) -> Option<(f32, Vec2)> {
    // Corners a, b, c from the origin, and the ones before them: c, a, b.
    let (x, y, z) = (corners.x - origin.x, corners.y - origin.y, corners.z - origin.z);
    let (px, py, pz) = (x.zxyw(), y.zxyw(), z.zxyw());
    let (ex, ey, ez) = (px - x, py - y, pz - z);
    let (sx, sy, sz) = (px + x, py + y, pz + z);
    // Each lane: an edge's cross product with twice its middle, times the direction.
    let volumes =
        (ey * sz - ez * sy) * direction.x + (ez * sx - ex * sz) * direction.y + (ex * sy - ey * sx) * direction.z;
    if volumes.cmplt(Vec4::ZERO).any() && volumes.cmpgt(Vec4::ZERO).any() {
        return None;
    }
    // Edges a - b and b - c span the triangle.
    let (ab, bc) = (Vec3A::new(ex.y, ey.y, ez.y), Vec3A::new(ex.z, ey.z, ez.z));
    let normal = bc.cross(ab);
    let distance = normal.dot(Vec3A::new(x.x, y.x, z.x)) / normal.dot(direction);
    let sum = volumes.x + volumes.y + volumes.z;
    // Written so that a NaN is no hit.
    if !(distance >= near && distance < far && sum != 0.0) {
        return None;
    }
    let inverse = 1.0 / sum;
    Some((distance, Vec2::new(volumes.x * inverse, volumes.y * inverse)))
}
