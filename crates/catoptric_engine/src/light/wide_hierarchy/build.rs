//! The building of hierarchies.

use super::{
    ALPHA_TESTED, LEAF, NO_TRIANGLE, NONE, Narrow, SURFACE, TriangleBlock, WideHierarchy, WideNode, corners_of,
};
use catoptric_core::math::lanes::LANES;
use catoptric_core::scene::{AlphaMode, Role, Scene};
use glam::Vec3A;
use obvhs::aabb::Aabb as BvhBox;
use obvhs::bvh2::Bvh2;
use obvhs::splits::split_aabbs_preset;
use obvhs::triangle::Triangle;
use obvhs::{Boundable, BvhBuildParams};

/// Boxes beyond this many are built with less care: it would take seconds.
const CAREFUL_BUILD: usize = 2_000_000;

/// Up to this many boxes every node is tried in better places, twice: it takes a tenth of a second.
const THOROUGH_BUILD: usize = 100_000;

/// Triangles that are lower than this share of their largest coordinate are flat: four times its rounding.
const FLAT: f64 = 2.0 * f32::EPSILON as f64;

/// The primitive that a box stands for.
#[derive(Clone, Copy, Debug)]
enum Primitive {
    /// A triangle of the scene, with what is to be remembered of it ([`ALPHA_TESTED`]).
    Triangle(u32, u32),
    /// The analytic surface of an object.
    Surface(u32),
}

impl WideHierarchy {
    /// The hierarchy over the triangles of all objects for which `include` is true, those of analytic surfaces among
    /// them. Triangles without extent are left out.
    pub fn build(scene: &Scene, include: impl Fn(u32) -> bool) -> Self {
        let wanted = (0..scene.objects.len()).filter(|&object| include(object as u32));
        let all = wanted.flat_map(|object| scene.objects[object].triangles.clone());
        let (triangles, flat): (Vec<u32>, Vec<u32>) = all.partition(|triangle| has_extent(scene, *triangle));
        let boxes: Vec<BvhBox> = triangles.iter().map(|triangle| corners(scene, *triangle).aabb()).collect();
        let primitives: Vec<Primitive> = triangles.iter().map(|triangle| Primitive::Triangle(*triangle, 0)).collect();
        let preset = match boxes.len() {
            0..=CAREFUL_BUILD => BvhBuildParams::medium_build(),
            _ => BvhBuildParams::fast_build(),
        };
        Self { flat, ..Self::over(scene, &boxes, &primitives, &preset) }
    }

    /// The hierarchy for rays alone: analytic surfaces stand for themselves, large triangles in several leaves, and
    /// more time is taken. Triangles without extent are left out; those of objects for which `is_tested` is true have
    /// the bit `1 << 30`.
    pub fn build_for_rays(scene: &Scene, include: impl Fn(u32) -> bool, is_tested: impl Fn(u32) -> bool) -> Self {
        let (mut triangles, mut primitives, mut surfaces) = (Vec::new(), Vec::new(), Vec::new());
        let mut flat = Vec::new();
        for (index, object) in scene.objects.iter().enumerate().filter(|(index, _)| include(*index as u32)) {
            let index = index as u32;
            if object.surface.is_some() {
                surfaces.push(index);
                continue;
            }
            let tag = if is_tested(index) { ALPHA_TESTED } else { 0 };
            for triangle in object.triangles.clone() {
                if !has_extent(scene, triangle) {
                    flat.push(triangle);
                    continue;
                }
                triangles.push(corners(scene, triangle));
                primitives.push(Primitive::Triangle(triangle, tag));
            }
        }
        let mut boxes: Vec<BvhBox> = triangles.iter().map(Boundable::aabb).collect();
        // Which primitive a box stands for.
        let mut indices: Vec<u32> = (0..boxes.len() as u32).collect();
        split_large(&mut boxes, &mut indices, &triangles);
        for object in surfaces {
            let Some(bounds) = box_of_surface(scene, object) else { continue };
            boxes.push(bounds);
            indices.push(primitives.len() as u32);
            primitives.push(Primitive::Surface(object));
        }
        let preset = match boxes.len() {
            count if count <= THOROUGH_BUILD => {
                BvhBuildParams { reinsertion_batch_ratio: 2.0, ..BvhBuildParams::slow_build() }
            }
            count if count <= CAREFUL_BUILD => BvhBuildParams::slow_build(),
            _ => BvhBuildParams::fast_build(),
        };
        let of_boxes: Vec<Primitive> = indices.iter().map(|index| primitives[*index as usize]).collect();
        Self { flat, ..Self::over(scene, &boxes, &of_boxes, &preset) }
    }

    /// Brings boxes and corners to where triangles and surfaces are now; the scene has as many as before. Returns false
    /// if triangles are missing that had no extent before, or that were the same as others: then it has to be built
    /// anew.
    pub fn refit(&mut self, scene: &Scene) -> bool {
        let is_same =
            |[copy, same]: &[u32; 2]| Solid::new(scene, *copy).is_some_and(|it| Some(it) == Solid::new(scene, *same));
        if self.flat.iter().any(|triangle| has_extent(scene, *triangle)) || !self.copies.iter().all(is_same) {
            return false;
        }
        for block in &mut self.blocks {
            for lane in 0..LANES {
                let triangle = block.triangles[lane];
                if triangle != NO_TRIANGLE {
                    block.set(lane, corners_of(scene, triangle & !ALPHA_TESTED), triangle);
                }
            }
        }
        for index in (0..self.nodes.len()).rev() {
            let mut node = self.nodes[index];
            for lane in 0..LANES {
                let bounds = match node.children[lane] {
                    NONE => continue,
                    leaf if leaf & LEAF != 0 => self.blocks[(leaf & !LEAF) as usize].bounds(),
                    surface if surface & SURFACE != 0 => match box_of_surface(scene, surface & !SURFACE) {
                        Some(bounds) => bounds,
                        None => return false,
                    },
                    inner => self.nodes[inner as usize].bounds(),
                };
                node.set_box(lane, &bounds);
            }
            self.nodes[index] = node;
        }
        true
    }

    fn over(scene: &Scene, boxes: &[BvhBox], primitives: &[Primitive], preset: &BvhBuildParams) -> Self {
        if boxes.is_empty() {
            return Self::default();
        }
        let triangle = |number: u32| match primitives[number as usize] {
            Primitive::Triangle(triangle, tag) => Some((triangle, tag)),
            Primitive::Surface(_) => None,
        };
        let key = |number: u32| {
            let (triangle, tag) = triangle(number)?;
            Some((Solid::new(scene, triangle)?, tag, bits_of(&boxes[number as usize])))
        };
        let Narrow { mut tree, left_out } = Narrow::new(boxes, preset, key);
        tree.uses_spatial_splits = true;
        let pairs = left_out.into_iter().filter_map(|[number, same]| Some([triangle(number)?.0, triangle(same)?.0]));
        // Pairs of a triangle in several boxes follow each other.
        let mut copies: Vec<[u32; 2]> = pairs.collect();
        copies.dedup();
        Self { copies, ..Widening::new(scene, &tree, primitives).run() }
    }
}

/// The corners of a triangle of a solid surface, as bits. Of two that are the same no ray tells one from the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Solid([[u32; 3]; 3]);

impl Solid {
    /// `None` for triangles of glass, and where anything is seen through them.
    pub fn new(scene: &Scene, triangle: u32) -> Option<Self> {
        let object = *scene.triangle_objects.get(triangle as usize)?;
        let material = scene.material_of(object);
        if scene.role_of(object) == Role::Lens || material.alpha_mode != AlphaMode::Opaque {
            return None;
        }
        let mut corners = corners_of(scene, triangle).map(|corner| corner.to_array().map(f32::to_bits));
        // The same for each of three orders that show the same side.
        let first = (0..3).min_by_key(|corner| corners[*corner]).unwrap_or(0);
        corners.rotate_left(first);
        Some(Self(corners))
    }
}

fn bits_of(bounds: &BvhBox) -> [u32; 6] {
    let [a, b, c] = bounds.min.to_array();
    let [d, e, f] = bounds.max.to_array();
    [a, b, c, d, e, f].map(f32::to_bits)
}

/// True if a triangle is finite and higher than rounding makes one whose corners lie on a line. Rays miss others; in
/// hierarchies heaps of them would be tested one by one.
pub fn has_extent(scene: &Scene, triangle: u32) -> bool {
    let [a, b, c] = corners_of(scene, triangle).map(|corner| corner.as_dvec3());
    let twice_area = (b - a).cross(c - a).length();
    let longest = (b - a).length().max((c - a).length()).max((c - b).length());
    let largest = [a, b, c].into_iter().map(|corner| corner.abs().max_element()).fold(0.0, f64::max);
    // Not true of what is no number, either.
    twice_area > longest * largest * FLAT && twice_area.is_finite()
}

/// The box around the analytic surface of an object, if it has one.
fn box_of_surface(scene: &Scene, object: u32) -> Option<BvhBox> {
    let bounds = scene.objects[object as usize].surface.as_ref()?.bounds();
    // A plane's box is flat, and the tests of boxes are not exact: leave some room.
    let margin = Vec3A::splat(1e-5 * (bounds.diagonal() + bounds.center().abs().max_element()) + 1e-12);
    Some(BvhBox::new(Vec3A::from(bounds.min) - margin, Vec3A::from(bounds.max) + margin))
}

fn corners(scene: &Scene, triangle: u32) -> Triangle {
    let [v0, v1, v2] = corners_of(scene, triangle).map(Vec3A::from);
    Triangle { v0, v1, v2 }
}

/// Gives large triangles (walls, floors) several small boxes each, or they would overlap everything near them.
fn split_large(boxes: &mut Vec<BvhBox>, indices: &mut Vec<u32>, triangles: &[Triangle]) {
    if boxes.is_empty() || boxes.len() > CAREFUL_BUILD {
        return;
    }
    let areas = boxes.iter().map(|bounds| bounds.half_area());
    let (sum, largest) = areas.fold((0.0f64, 0.0f32), |(sum, largest), area| (sum + area as f64, area.max(largest)));
    let mean = (sum / boxes.len() as f64) as f32;
    if mean.is_finite() && largest.is_finite() {
        split_aabbs_preset(boxes, indices, triangles, mean, largest);
    }
}

/// From a binary hierarchy to the wide one.
struct Widening<'a> {
    scene: &'a Scene,
    narrow: &'a Bvh2,
    /// The primitive of each box.
    primitives: &'a [Primitive],
    /// Boxes below every node.
    counts: Vec<u32>,
    /// Nodes that analytic surfaces are below of.
    has_surfaces: Vec<bool>,
    wide: WideHierarchy,
}

impl<'a> Widening<'a> {
    fn new(scene: &'a Scene, narrow: &'a Bvh2, primitives: &'a [Primitive]) -> Self {
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
        let mut has_surfaces = vec![false; narrow.nodes.len()];
        for &index in order.iter().rev() {
            let node = &narrow.nodes[index as usize];
            let (index, first) = (index as usize, node.first_index as usize);
            if node.is_leaf() {
                let numbers = &narrow.primitive_indices[first..first + node.prim_count as usize];
                let is_surface = |number: &u32| matches!(primitives[*number as usize], Primitive::Surface(_));
                (counts[index], has_surfaces[index]) = (node.prim_count, numbers.iter().any(is_surface));
            } else {
                counts[index] = counts[first] + counts[first + 1];
                has_surfaces[index] = has_surfaces[first] || has_surfaces[first + 1];
            }
        }
        Self { scene, narrow, primitives, counts, has_surfaces, wide: WideHierarchy::default() }
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
        let is_large = self.counts[node as usize] as usize > LANES || self.has_surfaces[node as usize];
        (is_large || is_root) && !self.narrow.nodes[node as usize].is_leaf()
    }

    /// A leaf of all triangles below a node, or of its surface: the builder's leaves have one box each.
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
                match self.primitives[number as usize] {
                    Primitive::Surface(object) => return SURFACE | object,
                    // Boxes of one triangle may meet again.
                    Primitive::Triangle(triangle, tag) if block.triangles[..lane].contains(&(triangle | tag)) => {}
                    Primitive::Triangle(triangle, tag) => {
                        block.set(lane, corners_of(self.scene, triangle), triangle | tag);
                        lane += 1;
                    }
                }
            }
        }
        self.wide.blocks.push(block);
        LEAF | (self.wide.blocks.len() - 1) as u32
    }
}
