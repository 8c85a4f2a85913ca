//! A hierarchy of boxes over triangles, eight children a node and up to eight triangles a leaf, for beams and for rays.
//!
//! Boxes and corners are plain floats, one lane a child or triangle: a node or a leaf is tested at once. Triangles that
//! move keep their place in it ([`WideHierarchy::refit`]).

use crate::math::lanes::LANES;
use crate::scene::{Ray, Scene};
use glam::{Vec2, Vec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb as BvhBox;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::PlocBuilder;

/// Children with this bit are leaves: the rest is the number of their block of triangles.
const LEAF: u32 = 1 << 31;

/// A child that is not there.
const NONE: u32 = u32::MAX;

/// Beyond this many triangles the hierarchy is built with less care: it would take seconds.
const CAREFUL_BUILD: usize = 2_000_000;

/// A triangle that is not there.
pub(crate) const NO_TRIANGLE: u32 = u32::MAX;

/// The boxes of eight children.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(crate) struct WideNode {
    /// Lower corners by axis, then upper ones; empty (infinite, inside out) where there is no child.
    pub(crate) sides: [[f32; LANES]; 6],
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
pub(crate) struct TriangleBlock {
    /// x, y and z of the first corners, of the second and of the third ones. Not a number where there is no triangle:
    /// no test of such a lane succeeds.
    pub(crate) corners: [[f32; LANES]; 9],
    /// The scene's triangles, or [`NO_TRIANGLE`].
    pub(crate) triangles: [u32; LANES],
}

impl TriangleBlock {
    /// No triangle.
    pub(crate) const EMPTY: Self = Self { corners: [[f32::NAN; LANES]; 9], triangles: [NO_TRIANGLE; LANES] };

    /// Puts a triangle of the scene into a lane.
    pub(crate) fn set(&mut self, lane: usize, corners: [Vec3; 3], triangle: u32) {
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
pub(crate) struct WideHierarchy {
    /// The first one is the root; children come after their parents.
    nodes: Vec<WideNode>,
    blocks: Vec<TriangleBlock>,
}

/// The nearest triangle along a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TriangleHit {
    pub(crate) distance: f32,
    /// The scene's triangle.
    pub(crate) triangle: u32,
    /// Weights of its second and third corner.
    pub(crate) barycentrics: Vec2,
}

impl WideHierarchy {
    /// The hierarchy over the triangles of all objects for which `include` is true, those of analytic surfaces among
    /// them. Triangles that are not finite are left out.
    pub(crate) fn build(scene: &Scene, include: impl Fn(u32) -> bool) -> Self {
        let wanted = (0..scene.objects.len()).filter(|&object| include(object as u32));
        let all = wanted.flat_map(|object| scene.objects[object].triangles.clone());
        let is_finite = |triangle: &u32| corners_of(scene, *triangle).iter().all(|corner| corner.is_finite());
        let triangles: Vec<u32> = all.filter(is_finite).collect();
        if triangles.is_empty() {
            return Self::default();
        }
        let bounds = |triangle: &u32| {
            let corners = corners_of(scene, *triangle).map(Vec3A::from);
            BvhBox::from_points(&corners)
        };
        let boxes: Vec<BvhBox> = triangles.iter().map(bounds).collect();
        let preset = match boxes.len() {
            0..=CAREFUL_BUILD => BvhBuildParams::medium_build(),
            _ => BvhBuildParams::fast_build(),
        };
        let mut narrow = PlocBuilder::with_capacity(boxes.len()).build(
            preset.ploc_search_distance,
            &boxes,
            (0..boxes.len() as u32).collect(),
            preset.sort_precision,
            preset.search_depth_threshold,
        );
        ReinsertionOptimizer::default().run(&mut narrow, preset.reinsertion_batch_ratio, None);
        Widening::new(scene, &narrow, &triangles).run()
    }

    /// The memory that it takes.
    pub(crate) fn byte_count(&self) -> u64 {
        (size_of_val(self.nodes.as_slice()) + size_of_val(self.blocks.as_slice())) as u64
    }

    /// Brings boxes and corners to where the triangles are now; the scene has as many as before.
    pub(crate) fn refit(&mut self, scene: &Scene) {
        for block in &mut self.blocks {
            for lane in 0..LANES {
                let triangle = block.triangles[lane];
                if triangle != NO_TRIANGLE {
                    block.set(lane, corners_of(scene, triangle), triangle);
                }
            }
        }
        for index in (0..self.nodes.len()).rev() {
            let mut node = self.nodes[index];
            for lane in 0..LANES {
                let bounds = match node.children[lane] {
                    NONE => continue,
                    leaf if leaf & LEAF != 0 => self.blocks[(leaf & !LEAF) as usize].bounds(),
                    inner => self.nodes[inner as usize].bounds(),
                };
                node.set_box(lane, &bounds);
            }
            self.nodes[index] = node;
        }
    }

    /// Calls `leaf` with the blocks of all leaves whose boxes pass a test: of a node it gives a bit for every child.
    #[inline(always)]
    pub(crate) fn walk(
        &self,
        stack: &mut Vec<u32>,
        children: impl Fn(&WideNode) -> u32,
        mut leaf: impl FnMut(&TriangleBlock),
    ) {
        stack.clear();
        if !self.nodes.is_empty() {
            stack.push(0);
        }
        while let Some(next) = stack.pop() {
            let node = &self.nodes[next as usize];
            let mut met = children(node);
            while met != 0 {
                let child = node.children[met.trailing_zeros() as usize];
                met &= met - 1;
                match child {
                    NONE => {}
                    block if block & LEAF != 0 => leaf(&self.blocks[(block & !LEAF) as usize]),
                    inner => stack.push(inner),
                }
            }
        }
    }

    /// The nearest triangle between two distances along a ray that passes a test; of equally near ones the first in
    /// the hierarchy's order.
    #[inline(always)]
    pub(crate) fn nearest(
        &self,
        ray: &Ray,
        near: f32,
        mut far: f32,
        passes: impl Fn(&TriangleHit) -> bool,
    ) -> Option<TriangleHit> {
        if self.nodes.is_empty() || !(ray.origin.is_finite() && ray.direction.is_finite()) {
            return None;
        }
        let slabs = RaySlabs::new(ray);
        let mut waiting = [(0u32, 0.0f32); MAX_WAITING];
        waiting[0] = (0, 0.0);
        let mut count = 1;
        let mut best = None;
        while count > 0 {
            count -= 1;
            let (next, enter) = waiting[count];
            if enter > far {
                continue;
            }
            if next & LEAF != 0 {
                let block = &self.blocks[(next & !LEAF) as usize];
                let met = meet_block(block, ray, near, far);
                let mut lanes = met.lanes;
                while lanes != 0 {
                    let lane = lanes.trailing_zeros() as usize;
                    lanes &= lanes - 1;
                    let barycentrics = Vec2::new(met.weights[0][lane], met.weights[1][lane]);
                    let (distance, triangle) = (met.distances[lane], block.triangles[lane]);
                    let hit = TriangleHit { distance, triangle, barycentrics };
                    if distance < far && passes(&hit) {
                        far = distance;
                        best = Some(hit);
                    }
                }
                continue;
            }
            let node = &self.nodes[next as usize];
            let (mut met, enters) = slabs.children(node, far);
            // The nearest child on top: the few that are met are sorted in place.
            let first = count;
            while met != 0 {
                let lane = met.trailing_zeros() as usize;
                met &= met - 1;
                let child = (node.children[lane], enters[lane]);
                if count == MAX_WAITING {
                    break; // deeper than any hierarchy of as many triangles as a scene can have
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

/// Nodes that wait along a ray: seven a level of a tree of some thirty levels.
const MAX_WAITING: usize = 256;

fn corners_of(scene: &Scene, triangle: u32) -> [Vec3; 3] {
    scene.triangles[triangle as usize].map(|vertex| scene.positions[vertex as usize])
}

/// From a binary hierarchy to the wide one.
struct Widening<'a> {
    scene: &'a Scene,
    narrow: &'a Bvh2,
    /// The scene's triangle for each box.
    triangles: &'a [u32],
    /// Triangles below every node.
    counts: Vec<u32>,
    wide: WideHierarchy,
}

impl<'a> Widening<'a> {
    fn new(scene: &'a Scene, narrow: &'a Bvh2, triangles: &'a [u32]) -> Self {
        // Depth first, without recursion: trees of degenerate input are deep.
        let mut order = Vec::with_capacity(narrow.nodes.len());
        let mut waiting = vec![0u32];
        while let Some(index) = waiting.pop() {
            order.push(index);
            let node = &narrow.nodes[index as usize];
            if !node.is_leaf() {
                waiting.extend([node.first_index, node.first_index + 1]);
            }
        }
        let mut counts = vec![0; narrow.nodes.len()];
        for &index in order.iter().rev() {
            let node = &narrow.nodes[index as usize];
            let first = node.first_index as usize;
            counts[index as usize] = if node.is_leaf() { node.prim_count } else { counts[first] + counts[first + 1] };
        }
        Self { scene, narrow, triangles, counts, wide: WideHierarchy::default() }
    }

    fn run(mut self) -> WideHierarchy {
        self.wide.nodes.push(WideNode::EMPTY);
        // A wide node and the binary one that it stands for.
        let mut waiting = vec![(0usize, 0u32)];
        while let Some((place, root)) = waiting.pop() {
            let mut children = vec![root];
            // The largest box is opened until there are eight; leaves stay.
            while children.len() < LANES {
                let area = |child: &u32| self.narrow.nodes[*child as usize].aabb().half_area();
                let inner = children.iter().enumerate().filter(|(_, child)| self.opens(**child, **child == root));
                let largest = inner.max_by(|a, b| area(a.1).total_cmp(&area(b.1)));
                let Some((index, &child)) = largest else { break };
                let first = self.narrow.nodes[child as usize].first_index;
                children[index] = first;
                children.push(first + 1);
            }
            for (lane, &child) in children.iter().enumerate() {
                let bounds = *self.narrow.nodes[child as usize].aabb();
                let code = if self.opens(child, false) {
                    self.wide.nodes.push(WideNode::EMPTY);
                    waiting.push((self.wide.nodes.len() - 1, child));
                    (self.wide.nodes.len() - 1) as u32
                } else {
                    self.push_block(child)
                };
                let node = &mut self.wide.nodes[place];
                node.set_box(lane, &bounds);
                node.children[lane] = code;
            }
        }
        self.wide
    }

    /// True if a binary node does not become a leaf.
    fn opens(&self, node: u32, is_root: bool) -> bool {
        let is_large = self.counts[node as usize] as usize > LANES;
        (is_large || is_root) && !self.narrow.nodes[node as usize].is_leaf()
    }

    /// A leaf of all triangles below a node.
    fn push_block(&mut self, node: u32) -> u32 {
        let mut block = TriangleBlock::EMPTY;
        let (mut waiting, mut lane) = (vec![node], 0);
        while let Some(node) = waiting.pop() {
            let node = &self.narrow.nodes[node as usize];
            if !node.is_leaf() {
                waiting.extend([node.first_index + 1, node.first_index]);
                continue;
            }
            for primitive in 0..node.prim_count {
                let number = self.narrow.primitive_indices[(node.first_index + primitive) as usize];
                let triangle = self.triangles[number as usize];
                if lane < LANES {
                    block.set(lane, corners_of(self.scene, triangle), triangle);
                }
                lane += 1;
            }
        }
        self.wide.blocks.push(block);
        LEAF | (self.wide.blocks.len() - 1) as u32
    }
}

/// A ray, prepared for tests against boxes.
struct RaySlabs {
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
    fn new(ray: &Ray) -> Self {
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
    fn children(&self, node: &WideNode, far: f32) -> (u32, [f32; LANES]) {
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
        let mut met = 0;
        for lane in 0..LANES {
            met |= u32::from(enter[lane] <= leave[lane] * REACH) << lane;
        }
        (met, enter)
    }
}

/// The triangles of a leaf that a ray meets.
struct BlockHits {
    lanes: u32,
    distances: [f32; LANES],
    /// Weights of the second and third corner.
    weights: [[f32; LANES]; 2],
}

/// Decided by the signed volumes that the ray spans with the edges, which neighbours compute alike to the bit: no ray
/// passes between two triangles that share an edge. Both sides are met.
#[inline(always)]
fn meet_block(block: &TriangleBlock, ray: &Ray, near: f32, far: f32) -> BlockHits {
    let ([ox, oy, oz], [dx, dy, dz]) = (ray.origin.to_array(), ray.direction.to_array());
    let corners = &block.corners;
    let mut hits = BlockHits { lanes: 0, distances: [0.0; LANES], weights: [[0.0; LANES]; 2] };
    let mut inside = [0u32; LANES];
    for lane in 0..LANES {
        let (ax, ay, az) = (corners[0][lane] - ox, corners[1][lane] - oy, corners[2][lane] - oz);
        let (bx, by, bz) = (corners[3][lane] - ox, corners[4][lane] - oy, corners[5][lane] - oz);
        let (cx, cy, cz) = (corners[6][lane] - ox, corners[7][lane] - oy, corners[8][lane] - oz);
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
        let met = (smallest >= 0.0) | (largest <= 0.0);
        inside[lane] = u32::from(met & (sum != 0.0) & (distance >= near) & (distance < far));
        hits.distances[lane] = distance;
        let inverse = 1.0 / sum;
        hits.weights[0][lane] = vb * inverse;
        hits.weights[1][lane] = vc * inverse;
    }
    for (lane, inside) in inside.iter().enumerate() {
        hits.lanes |= inside << lane;
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Stream;
    use crate::scene::Material;
    use crate::scene::model::{LocalTransform, MeshAsset, Model, Node, Primitive};

    /// Triangles of all sizes, those of two objects, the second of them moved.
    fn scene(shift: Vec3) -> Scene {
        let mut random = Stream::new(21);
        let mut model = Model { materials: vec![Material::default()], ..Model::default() };
        for object in 0..2 {
            let mut primitive = Primitive::default();
            for triangle in 0..700u32 {
                let size = 0.02 * 1.007f32.powi(triangle as i32);
                let mut point = |size: f32| Vec3::from_array([0, 1, 2].map(|_| random.next_between(-size, size)));
                let middle = point(4.0);
                primitive.positions.extend([middle + point(size), middle + point(size), middle + point(size)]);
                primitive.triangles.push([3 * triangle, 3 * triangle + 1, 3 * triangle + 2]);
            }
            model.meshes.push(MeshAsset { primitives: vec![primitive], ..MeshAsset::default() });
            let local = LocalTransform::at(shift * object as f32);
            model.nodes.push(Node { mesh: Some(object), local, ..Node::default() });
        }
        model.pose(&Default::default()).expect("the model is valid")
    }

    fn rays() -> impl Iterator<Item = Ray> {
        let mut random = Stream::new(22);
        (0..2000).map(move |_| {
            let mut point = |size: f32| Vec3::from_array([0, 1, 2].map(|_| random.next_between(-size, size)));
            Ray { origin: point(6.0), direction: point(1.0).normalize_or(Vec3::X) }
        })
    }

    /// The nearest of all triangles, tested one by one.
    fn nearest_of_all(scene: &Scene, ray: &Ray) -> Option<TriangleHit> {
        let mut best: Option<TriangleHit> = None;
        for triangle in 0..scene.triangles.len() as u32 {
            let mut block = TriangleBlock::EMPTY;
            block.set(0, corners_of(scene, triangle), triangle);
            let hits = meet_block(&block, ray, 0.0, best.map_or(f32::INFINITY, |best| best.distance));
            if hits.lanes & 1 != 0 {
                let barycentrics = Vec2::new(hits.weights[0][0], hits.weights[1][0]);
                best = Some(TriangleHit { distance: hits.distances[0], triangle, barycentrics });
            }
        }
        best
    }

    #[test]
    fn the_nearest_triangle_is_that_of_all_triangles_also_after_a_refit() {
        let (before, after) = (scene(Vec3::ZERO), scene(Vec3::new(1.5, -0.5, 0.25)));
        let mut moved = WideHierarchy::build(&before, |_| true);
        moved.refit(&after);
        let mut hits = 0;
        for (name, hierarchy) in [("built", WideHierarchy::build(&after, |_| true)), ("refitted", moved)] {
            for ray in rays() {
                let found = hierarchy.nearest(&ray, 0.0, f32::INFINITY, |_| true);
                assert_eq!(found, nearest_of_all(&after, &ray), "{name}: {ray:?}");
                if let Some(hit) = found {
                    hits += 1;
                    let (at, distance) = after.plane_met(hit.triangle, &ray).expect("the triangle has a plane");
                    assert!((at - hit.barycentrics).length() < 1e-2 && (distance - hit.distance).abs() < 1e-3);
                }
            }
        }
        assert!(hits > 1000, "{hits}");
    }

    #[test]
    fn walks_come_by_every_triangle_once() {
        let scene = scene(Vec3::ONE);
        let hierarchy = WideHierarchy::build(&scene, |object| object == 1);
        let mut seen = Vec::new();
        hierarchy.walk(
            &mut Vec::new(),
            |_| 0xff,
            |block| {
                seen.extend(block.triangles.into_iter().filter(|triangle| *triangle != NO_TRIANGLE));
            },
        );
        seen.sort_unstable();
        assert_eq!(seen, (700..1400).collect::<Vec<u32>>());
    }

    #[test]
    fn nothing_is_met_where_there_is_nothing() {
        let hierarchy = WideHierarchy::build(&scene(Vec3::ZERO), |_| false);
        let mut rays = rays();
        assert!(rays.all(|ray| hierarchy.nearest(&ray, 0.0, f32::INFINITY, |_| true).is_none()));
    }
}
