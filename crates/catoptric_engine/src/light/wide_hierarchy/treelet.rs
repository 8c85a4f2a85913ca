//! The leaves that a narrow beam of rays may meet: found once for all its rays.

use super::rays::{PrimitiveMet, PrimitiveTests, RaySlabs, SignBits, meet_leaf};
use super::{LEAF, NONE, SURFACE, TriangleHit, WideHierarchy, WideNode};
use catoptric_core::math::lanes::LANES;
use catoptric_core::scene::{Light, LightKind, Ray, ViewRays};
use glam::{Vec2, Vec3};

/// Beams that may meet more leaves than this are left to the whole hierarchy.
const MAX_LEAVES: usize = 64;

/// How far a beam reaches beyond the rays that it is made for, in pixels: far more than rounding.
const MARGIN_PX: f32 = 0.01;

/// The same in units of coordinates.
const MARGIN_OF_COORDINATES: f32 = 1e-5;

/// Rays between flat sides.
pub struct Beam<const SIDES: usize> {
    /// Normals of the sides, outwards, and the products with a point of each.
    sides: [(Vec3, f32); SIDES],
    /// Along the middle, and the smallest product with an origin.
    forward: Vec3,
    start: f32,
}

impl Beam<4> {
    /// The beam through the rectangle of a picture between two corners, in pixels.
    pub fn through(view: &ViewRays, low: Vec2, high: Vec2) -> Self {
        let (low, high) = (low - MARGIN_PX, high + MARGIN_PX);
        let corners = [low, Vec2::new(high.x, low.y), high, Vec2::new(low.x, high.y)];
        let rays = corners.map(|at| view.ray(at.x, at.y));
        let middle = view.ray(0.5 * (low.x + high.x), 0.5 * (low.y + high.y));
        // Rays differ in their directions or, where they are parallel, in their origins: directions have no size, and
        // must not be added to origins, which may be of any.
        let beside = |ray: &Ray, other: &Ray| match other.origin - ray.origin {
            Vec3::ZERO => other.direction,
            step => step,
        };
        let side = |index: usize| {
            let (ray, next) = (&rays[index], &rays[(index + 1) % 4]);
            let normal = ray.direction.cross(beside(ray, next)).normalize_or_zero();
            let normal = if normal.dot(beside(ray, &middle)) > 0.0 { -normal } else { normal };
            (normal, normal.dot(ray.origin))
        };
        let forward = middle.direction;
        let start = rays.iter().map(|ray| ray.origin.dot(forward)).fold(f32::INFINITY, f32::min);
        Self { sides: [side(0), side(1), side(2), side(3)], forward, start }
    }
}

impl Beam<6> {
    /// The beam from some points to a light; `None` where they lie all around it.
    pub(crate) fn to_light(light: &Light, points: &[Vec3]) -> Option<Self> {
        let middle = points.iter().sum::<Vec3>() / points.len() as f32;
        let is_far = light.kind == LightKind::Directional;
        let end = if is_far { middle - light.direction } else { light.position };
        let forward = (end - middle).try_normalize()?;
        let (across, along) = forward.any_orthonormal_pair();
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for point in points {
            let step = *point - end;
            // Points lie behind the light, or their ways to it leave the beam.
            let depth = -step.dot(forward);
            let scale = if is_far { 1.0 } else { 1.0 / depth };
            if depth <= 0.0 && !is_far || !scale.is_finite() {
                return None;
            }
            let place = Vec3::new(step.dot(across) * scale, step.dot(along) * scale, point.dot(forward));
            (low, high) = (low.min(place), high.max(place));
        }
        let size = end.abs().max(middle.abs()).max_element() + (end - middle).length();
        let scale = if is_far { 1.0 } else { 1.0 / (end - middle).length() };
        let margin = MARGIN_OF_COORDINATES * (size * scale + low.abs().max(high.abs()).truncate().max_element());
        // Seen from a near light, sides lean: they pass through it.
        let lean = if is_far { Vec3::ZERO } else { -forward };
        let side = |axis: Vec3, most: f32| {
            let most = most + margin;
            let normal = axis - lean * most;
            (normal, normal.dot(end) + if is_far { most } else { 0.0 })
        };
        let behind = (-forward, -low.z);
        let beyond = if is_far { (Vec3::ZERO, 1.0) } else { (forward, forward.dot(end)) };
        let sides =
            [side(across, high.x), side(-across, -low.x), side(along, high.y), side(-along, -low.y), behind, beyond];
        Some(Self { sides, forward, start: low.z })
    }
}

impl<const SIDES: usize> Beam<SIDES> {
    /// The children whose boxes the beam may meet, and distances that none of its rays reaches them before.
    #[inline(always)]
    fn children<S: SignBits>(&self, node: &WideNode) -> (u32, [f32; LANES]) {
        let mut outside = 0;
        for (normal, offset) in &self.sides {
            let (mut beyond, size) = least_along(node, *normal, *offset);
            for lane in 0..LANES {
                beyond[lane] = size[lane] * 1e-6 - beyond[lane];
            }
            outside |= S::sign_bits(beyond);
        }
        let (mut depths, size) = least_along(node, self.forward, self.start);
        for lane in 0..LANES {
            depths[lane] -= size[lane] * 1e-6;
        }
        (!outside & 0xff, depths)
    }
}

/// The least product of a direction with the points of each child's box, less an offset, and the size of its terms: it
/// is rounded by little of that.
#[inline(always)]
fn least_along(node: &WideNode, direction: Vec3, offset: f32) -> ([f32; LANES], [f32; LANES]) {
    let (mut least, mut size) = ([-offset; LANES], [offset.abs(); LANES]);
    for axis in 0..3 {
        let component = direction[axis];
        let sides = &node.sides[if component > 0.0 { axis } else { axis + 3 }];
        for lane in 0..LANES {
            let term = sides[lane] * component;
            least[lane] += term;
            size[lane] += term.abs();
        }
    }
    (least, size)
}

/// Leaves that the rays of a beam may meet.
#[derive(Debug, Default)]
pub struct Treelet {
    /// Leaves in order of their least distance from the start of rays: the first distance of each eight, and their
    /// boxes.
    groups: Vec<(f32, WideNode)>,
    waiting: Vec<u32>,
    leaves: Vec<(f32, [f32; 6], u32)>,
    /// The beam meets more leaves than are kept.
    overflows: bool,
}

impl Treelet {
    /// The nearest primitive at a distance of at least `near` along a ray of the beam, as in the whole hierarchy.
    /// `None` in the outer option: the whole hierarchy must be asked.
    #[inline(always)]
    pub fn nearest<S: SignBits>(
        &self,
        hierarchy: &WideHierarchy,
        ray: &Ray,
        near: f32,
        passes: impl Fn(&TriangleHit) -> bool,
        surface: impl Fn(u32, f32) -> Option<f32>,
        tests: &mut impl PrimitiveTests,
    ) -> Option<Option<PrimitiveMet>> {
        if self.overflows || !(ray.origin.is_finite() && ray.direction.is_finite()) {
            return None;
        }
        let slabs = RaySlabs::new(ray);
        let (mut far, mut best) = (f32::INFINITY, None);
        for (least, group) in &self.groups {
            if *least > far {
                break;
            }
            let (mut met, enters) = slabs.children::<S>(group, far);
            while met != 0 {
                let lane = met.trailing_zeros() as usize;
                met &= met - 1;
                if enters[lane] <= far {
                    let code = group.children[lane];
                    meet_leaf::<S>(hierarchy, code, ray, near, &mut far, &mut best, &passes, &surface, tests);
                }
            }
        }
        Some(best)
    }

    /// True if a ray of the beam meets anything nearer than a distance: [`WideHierarchy::meets_any`]. `None`: the whole
    /// hierarchy must be asked.
    #[inline(always)]
    pub(crate) fn meets_any<S: SignBits>(
        &self,
        hierarchy: &WideHierarchy,
        ray: &Ray,
        distance: f32,
        passes: impl Fn(&TriangleHit) -> bool,
        surface: impl Fn(u32, f32) -> Option<f32>,
    ) -> Option<bool> {
        if self.overflows || !(ray.origin.is_finite() && ray.direction.is_finite()) {
            return None;
        }
        let slabs = RaySlabs::new(ray);
        for (_, group) in &self.groups {
            let (mut met, _) = slabs.children::<S>(group, distance);
            while met != 0 {
                let lane = met.trailing_zeros() as usize;
                met &= met - 1;
                let (mut far, mut best) = (distance, None);
                let code = group.children[lane];
                meet_leaf::<S>(hierarchy, code, ray, 0.0, &mut far, &mut best, &passes, &surface, &mut ());
                if best.is_some() {
                    return Some(true);
                }
            }
        }
        Some(false)
    }
}

impl WideHierarchy {
    /// Finds the leaves that a beam may meet.
    #[inline(always)]
    pub fn gather<S: SignBits, const SIDES: usize>(&self, beam: &Beam<SIDES>, treelet: &mut Treelet) {
        let Treelet { groups, waiting, leaves, overflows } = treelet;
        groups.clear();
        waiting.clear();
        leaves.clear();
        *overflows = false;
        if !self.nodes.is_empty() {
            waiting.push(0);
        }
        while let Some(next) = waiting.pop() {
            let node = &self.nodes[next as usize];
            let (mut met, depths) = beam.children::<S>(node);
            while met != 0 {
                let lane = met.trailing_zeros() as usize;
                met &= met - 1;
                let child = node.children[lane];
                if child == NONE {
                    continue;
                }
                if child & (LEAF | SURFACE) == 0 {
                    waiting.push(child);
                    continue;
                }
                if leaves.len() == MAX_LEAVES {
                    *overflows = true;
                    return;
                }
                let mut sides = [0.0; 6];
                for (side, of_children) in sides.iter_mut().zip(&node.sides) {
                    *side = of_children[lane];
                }
                leaves.push((depths[lane], sides, child));
            }
        }
        leaves.sort_by(|a, b| a.0.total_cmp(&b.0));
        for leaves in leaves.chunks(LANES) {
            let mut group = WideNode::EMPTY;
            for (lane, (_, sides, child)) in leaves.iter().enumerate() {
                for (of_children, side) in group.sides.iter_mut().zip(sides) {
                    of_children[lane] = *side;
                }
                group.children[lane] = *child;
            }
            groups.push((leaves[0].0, group));
        }
    }
}
