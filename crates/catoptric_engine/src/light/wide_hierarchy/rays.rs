//! The nearest primitive along a ray.

use super::{LEAF, NO_TRIANGLE, SURFACE, TriangleBlock, TriangleHit, WideHierarchy, WideNode};
use catoptric_core::math::lanes::{LANES, bits_of};
use catoptric_core::scene::Ray;
use glam::Vec2;

/// Nodes that wait along a ray in place: seven a level of a tree of nine levels.
const WAITING: usize = 64;

impl WideHierarchy {
    /// The nearest triangle between two distances along a ray that passes a test; of equally near ones the first in
    /// the hierarchy's order.
    #[inline(always)]
    pub fn nearest<S: SignBits>(
        &self,
        ray: &Ray,
        near: f32,
        far: f32,
        passes: impl Fn(&TriangleHit) -> bool,
    ) -> Option<TriangleHit> {
        match self.nearest_of_all::<S>(ray, near, far, passes, |_, _| None, &mut ())? {
            PrimitiveMet::Triangle(hit) => Some(hit),
            PrimitiveMet::Surface(..) => None,
        }
    }

    /// As [`Self::nearest`], of triangles and surfaces. `surface` gives the distance, less than the given one, at which
    /// the ray meets an object's surface.
    #[inline(always)]
    pub(crate) fn nearest_of_all<S: SignBits>(
        &self,
        ray: &Ray,
        near: f32,
        mut far: f32,
        passes: impl Fn(&TriangleHit) -> bool,
        surface: impl Fn(u32, f32) -> Option<f32>,
        tests: &mut impl PrimitiveTests,
    ) -> Option<PrimitiveMet> {
        if self.nodes.is_empty() || !(ray.origin.is_finite() && ray.direction.is_finite()) {
            return None;
        }
        let slabs = RaySlabs::new(ray);
        let mut waiting = [(0u32, 0.0f32); WAITING];
        // Nodes that do not fit wait here: trees of degenerate input are deep.
        let mut more = Vec::new();
        waiting[0] = (0, 0.0);
        let mut count = 1;
        let mut best = None;
        loop {
            if count == 0 {
                let Some(next) = more.pop() else { break };
                (waiting[0], count) = (next, 1);
            }
            count -= 1;
            let (next, enter) = waiting[count];
            if enter > far {
                continue;
            }
            if next & (LEAF | SURFACE) != 0 {
                meet_leaf::<S>(self, next, ray, near, &mut far, &mut best, &passes, &surface, tests);
                continue;
            }
            let node = &self.nodes[next as usize];
            let (mut met, enters) = slabs.children::<S>(node, far);
            // The nearest child on top: the few that are met are sorted in place.
            let first = count;
            while met != 0 {
                let lane = met.trailing_zeros() as usize;
                met &= met - 1;
                let child = (node.children[lane], enters[lane]);
                if count == WAITING {
                    more.push(child);
                    continue;
                }
                let mut place = count;
                while place > first && waiting[place - 1].1 < child.1 {
                    waiting[place] = waiting[place - 1];
                    place -= 1;
                }
                waiting[place] = child;
                count += 1;
            }
        }
        best
    }
}

/// Meets what a leaf holds: the nearest before `far` becomes the best.
#[allow(clippy::too_many_arguments)] // inlined; a struct would only hide what is loop-invariant
#[inline(always)]
pub(super) fn meet_leaf<S: SignBits>(
    hierarchy: &WideHierarchy,
    code: u32,
    ray: &Ray,
    near: f32,
    far: &mut f32,
    best: &mut Option<PrimitiveMet>,
    passes: &impl Fn(&TriangleHit) -> bool,
    surface: &impl Fn(u32, f32) -> Option<f32>,
    tests: &mut impl PrimitiveTests,
) {
    if code & LEAF == 0 {
        let object = code & !SURFACE;
        tests.add_surface();
        if let Some(distance) = surface(object, *far) {
            *far = distance;
            *best = Some(PrimitiveMet::Surface(object, distance));
        }
        return;
    }
    let block = &hierarchy.blocks[(code & !LEAF) as usize];
    tests.add(block);
    let met = meet_block::<S>(block, ray, near, *far);
    let mut lanes = met.lanes;
    while lanes != 0 {
        let lane = lanes.trailing_zeros() as usize;
        lanes &= lanes - 1;
        let barycentrics = Vec2::new(met.weights[0][lane], met.weights[1][lane]);
        let (distance, triangle) = (met.distances[lane], block.triangles[lane]);
        let hit = TriangleHit { distance, triangle, barycentrics };
        if distance < *far && passes(&hit) {
            *far = distance;
            *best = Some(PrimitiveMet::Triangle(hit));
        }
    }
}

/// Signs as bits: compilers find no short way from lanes to bits.
pub trait SignBits {
    /// Bit `i` is set where lane `i` is negative; -0 counts as negative, the sign of what is not a number counts.
    fn sign_bits(lanes: [f32; LANES]) -> u32;
}

/// For every machine.
pub struct Portable;

impl SignBits for Portable {
    #[inline(always)]
    fn sign_bits(lanes: [f32; LANES]) -> u32 {
        bits_of(lanes.map(|lane| lane.is_sign_negative())).into()
    }
}

/// Only to be used within functions that are compiled for AVX2, and run where the machine has it.
#[cfg(target_arch = "x86_64")]
pub struct Avx2;

#[cfg(target_arch = "x86_64")]
impl Avx2 {
    /// True on machines with all that functions for it are compiled for: `avx2,bmi1,bmi2,lzcnt,popcnt`.
    #[inline(always)]
    pub fn is_available() -> bool {
        is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2")
            && is_x86_feature_detected!("lzcnt")
            && is_x86_feature_detected!("popcnt")
    }
}

#[cfg(target_arch = "x86_64")]
impl SignBits for Avx2 {
    #[inline(always)]
    fn sign_bits(lanes: [f32; LANES]) -> u32 {
        #[inline]
        #[target_feature(enable = "avx2")]
        fn of([a, b, c, d, e, f, g, h]: [f32; LANES]) -> u32 {
            use std::arch::x86_64::{_mm256_movemask_ps, _mm256_setr_ps};
            _mm256_movemask_ps(_mm256_setr_ps(a, b, c, d, e, f, g, h)) as u32
        }
        #[allow(unsafe_code, reason = "the type is used where the machine has been asked for the feature alone")]
        unsafe {
            of(lanes)
        }
    }
}

/// The first primitive that a ray meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PrimitiveMet {
    /// A triangle of the scene.
    Triangle(TriangleHit),
    /// An object's analytic surface, at a distance.
    Surface(u32, f32),
}

/// Counts what rays are tested against; `()` does not.
pub trait PrimitiveTests {
    /// A block of triangles was tested.
    fn add(&mut self, block: &TriangleBlock);
    /// An analytic surface was tested.
    fn add_surface(&mut self);
}

impl PrimitiveTests for () {
    #[inline(always)]
    fn add(&mut self, _: &TriangleBlock) {}

    #[inline(always)]
    fn add_surface(&mut self) {}
}

impl PrimitiveTests for u64 {
    fn add(&mut self, block: &TriangleBlock) {
        *self += block.triangles.iter().filter(|triangle| **triangle != NO_TRIANGLE).count() as u64;
    }

    fn add_surface(&mut self) {
        *self += 1;
    }
}

/// A ray, prepared for tests against boxes.
pub(super) struct RaySlabs {
    origin: [f32; 3],
    inverse: [f32; 3],
    /// The sides that it meets first and last, by axis.
    first: [usize; 3],
    last: [usize; 3],
}

/// How much further boxes reach, as a share of the distance: the rounding of the test.
const REACH: f32 = 1.000_002;

impl RaySlabs {
    #[inline(always)]
    pub(super) fn new(ray: &Ray) -> Self {
        // Zero components get a huge inverse of their sign: such rays stay within their slabs.
        let inverse = ray.direction.to_array().map(|component| match component.abs() < 1e-18 {
            true => 1e18_f32.copysign(component),
            false => 1.0 / component,
        });
        let axis = [0, 1, 2];
        let backwards = inverse.map(|inverse| inverse < 0.0);
        let first = axis.map(|axis| if backwards[axis] { axis + 3 } else { axis });
        let last = axis.map(|axis| if backwards[axis] { axis } else { axis + 3 });
        Self { origin: ray.origin.to_array(), inverse, first, last }
    }

    /// The children that the ray meets before a distance, one bit each, and where it enters them.
    #[inline(always)]
    pub(super) fn children<S: SignBits>(&self, node: &WideNode, far: f32) -> (u32, [f32; LANES]) {
        let (mut enter, mut leave) = ([0.0f32; LANES], [far; LANES]);
        for axis in 0..3 {
            let (first, last) = (&node.sides[self.first[axis]], &node.sides[self.last[axis]]);
            let (origin, inverse) = (self.origin[axis], self.inverse[axis]);
            for lane in 0..LANES {
                let a = (first[lane] - origin) * inverse;
                let b = (last[lane] - origin) * inverse;
                enter[lane] = if a > enter[lane] { a } else { enter[lane] };
                leave[lane] = if b < leave[lane] { b } else { leave[lane] };
            }
        }
        let mut beyond = [0.0; LANES];
        for lane in 0..LANES {
            // More than nothing, or -0 less 0 would be negative.
            beyond[lane] = leave[lane] * REACH - enter[lane] + f32::MIN_POSITIVE;
        }
        (!S::sign_bits(beyond) & 0xff, enter)
    }
}

/// The triangles of a leaf that a ray meets.
pub(super) struct BlockHits {
    pub(super) lanes: u32,
    pub(super) distances: [f32; LANES],
    /// Weights of the second and third corner.
    pub(super) weights: [[f32; LANES]; 2],
}

/// The corners of a triangle: x, y and z of each.
pub(crate) type TriangleCorners = [[f32; 3]; 3];

/// Where a ray meets the plane of a triangle.
#[derive(Clone, Copy)]
pub struct PlaneMet {
    /// Within the triangle.
    pub inside: bool,
    /// The distance from the origin, in lengths of the direction.
    pub distance: f32,
    /// Weights of the second and third corner.
    pub weights: [f32; 2],
}

/// The outcome of a ray from `[0]` along `[1]` with a triangle, from either side: whether it meets it, and where.
///
/// Decided by the signed volumes that the ray spans with the edges, which neighbours compute alike to the bit: no ray
/// passes between two triangles that share an edge (as in Embree's robust mode).
#[inline(always)]
pub fn meet([a, b, c]: TriangleCorners, [[ox, oy, oz], [dx, dy, dz]]: [[f32; 3]; 2]) -> PlaneMet {
    let (ax, ay, az) = (a[0] - ox, a[1] - oy, a[2] - oz);
    let (bx, by, bz) = (b[0] - ox, b[1] - oy, b[2] - oz);
    let (cx, cy, cz) = (c[0] - ox, c[1] - oy, c[2] - oz);
    // The cross product of an edge with twice its middle, times the direction: a neighbour's is its negative to the
    // bit, and little is lost where an edge is short beside its distance.
    let of_edge = |px: f32, py: f32, pz: f32, qx: f32, qy: f32, qz: f32| {
        let (ex, ey, ez, sx, sy, sz) = (qx - px, qy - py, qz - pz, px + qx, py + qy, pz + qz);
        (sy * ez - sz * ey) * dx + (sz * ex - sx * ez) * dy + (sx * ey - sy * ex) * dz
    };
    let (va, vb, vc) =
        (of_edge(bx, by, bz, cx, cy, cz), of_edge(cx, cy, cz, ax, ay, az), of_edge(ax, ay, az, bx, by, bz));
    let (ux, uy, uz) = (bx - ax, by - ay, bz - az);
    let (wx, wy, wz) = (cx - ax, cy - ay, cz - az);
    let (nx, ny, nz) = (uy * wz - uz * wy, uz * wx - ux * wz, ux * wy - uy * wx);
    let distance = (nx * ax + ny * ay + nz * az) / (nx * dx + ny * dy + nz * dz);
    let sum = va + vb + vc;
    let smallest = smaller(va, smaller(vb, vc));
    let largest = larger(va, larger(vb, vc));
    let inverse = 1.0 / sum;
    let inside = ((smallest >= 0.0) | (largest <= 0.0)) & (sum != 0.0);
    PlaneMet { inside, distance, weights: [vb * inverse, vc * inverse] }
}

#[inline(always)]
pub(super) fn meet_block<S: SignBits>(block: &TriangleBlock, ray: &Ray, near: f32, far: f32) -> BlockHits {
    let line = [ray.origin.to_array(), ray.direction.to_array()];
    let corners = &block.corners;
    let mut hits = BlockHits { lanes: 0, distances: [0.0; LANES], weights: [[0.0; LANES]; 2] };
    let mut outside = [0.0; LANES];
    for lane in 0..LANES {
        let a = [corners[0][lane], corners[1][lane], corners[2][lane]];
        let b = [corners[3][lane], corners[4][lane], corners[5][lane]];
        let c = [corners[6][lane], corners[7][lane], corners[8][lane]];
        let met = meet([a, b, c], line);
        // Written so that a NaN is no hit.
        let is_hit = met.inside & (met.distance >= near) & (met.distance < far);
        outside[lane] = if is_hit { 1.0 } else { -1.0 };
        hits.distances[lane] = met.distance;
        hits.weights[0][lane] = met.weights[0];
        hits.weights[1][lane] = met.weights[1];
    }
    hits.lanes = !S::sign_bits(outside) & 0xff;
    hits
}

#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[inline(always)]
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}
