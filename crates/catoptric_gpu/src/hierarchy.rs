//! The hierarchy of boxes over a scene's triangles, two children a node, for shaders to walk.

use crate::layout::{LEAF, LeafTriangle, MAX_DEPTH, NONE, Node, WIDTH, WideChild, bits, triangle_flags as flags};
use catoptric::light::tracer::{Narrow, Solid, has_extent};
use catoptric::light::visibility::casts_shadows;
use catoptric::parallel;
use catoptric::scene::{Role, Scene};
use glam::{Vec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb as BvhBox;
use obvhs::bvh2::leaf_collapser::collapse;
use std::ops::Range;

/// The most triangles of a leaf.
const LARGEST_LEAF: u32 = 4;
/// The time of a step down in those of a test of a triangle.
const STEP_COST: f32 = 1.0;
/// More triangles are sorted with less care: it would take seconds.
const CAREFUL_BUILD: usize = 500_000;

/// The hierarchy: nodes, and the triangles of leaves.
#[derive(Clone, Debug)]
pub struct Hierarchy {
    /// The first node, or a leaf, or [`NONE`] without triangles.
    pub root: u32,
    /// Children come after their parents.
    pub nodes: Vec<Node>,
    /// The scene's triangles in the order of the leaves.
    pub triangles: Vec<LeafTriangle>,
    /// True for each of the scene's triangles that it holds: not those without extent, nor copies that lie in piles.
    pub holds: Vec<bool>,
}

/// Records that are worked on at once. A size for threads.
const RECORDS_AT_ONCE: usize = 2048;

/// A node on its own: its box, and the first of two children, or of so many triangles.
#[derive(Clone, Copy)]
struct Lone {
    bounds: BvhBox,
    first: u32,
    count: u32,
}

impl Hierarchy {
    /// The hierarchy over all triangles that have an extent; without any it has no nodes.
    pub fn new(scene: &Scene) -> Self {
        Self::of(scene, |_| true)
    }

    /// The same over some objects.
    pub fn of(scene: &Scene, is_wanted: impl Fn(u32) -> bool) -> Self {
        let is_there =
            |triangle: u32| is_wanted(scene.triangle_objects[triangle as usize]) && has_extent(scene, triangle);
        let mut holds: Vec<bool> = (0..scene.triangles.len() as u32).map(is_there).collect();
        let triangles: Vec<u32> = (0..).zip(&holds).filter_map(|(triangle, holds)| holds.then_some(triangle)).collect();
        let boxes: Vec<BvhBox> = triangles.iter().map(|triangle| box_of(corners(scene, *triangle))).collect();
        if boxes.is_empty() {
            return Self { root: NONE, nodes: Vec::new(), triangles: Vec::new(), holds };
        }
        let preset = match boxes.len() {
            0..=CAREFUL_BUILD => BvhBuildParams::medium_build(),
            _ => BvhBuildParams::fast_build(),
        };
        let solid = |number: u32| Solid::new(scene, triangles[number as usize]);
        let Narrow { mut tree, left_out } = Narrow::new(&boxes, &preset, solid);
        for [copy, _] in left_out {
            holds[triangles[copy as usize] as usize] = false;
        }
        collapse(&mut tree, LARGEST_LEAF, STEP_COST);
        let nodes = tree.nodes.iter().map(|node| Lone {
            bounds: *node.aabb(),
            first: node.first_index,
            count: node.prim_count,
        });
        let (nodes, order) = match nodes.collect::<Vec<_>>() {
            nodes if depth(&nodes) <= MAX_DEPTH => (nodes, tree.primitive_indices),
            _ => halved(&boxes),
        };
        let flags = flags_of_objects(scene);
        let of_place = |place: &u32| leaf_triangle(scene, &flags, triangles[*place as usize]);
        let (root, nodes) = joined(&nodes);
        Self { root, nodes, triangles: order.iter().map(of_place).collect(), holds }
    }

    /// Adds the nodes and triangles of another, and returns its root.
    pub fn append(&mut self, other: Self) -> u32 {
        let (first_node, first_triangle) = (self.nodes.len() as u32, self.triangles.len() as u32);
        let moved = |code: u32| match code {
            NONE => NONE,
            code if code & LEAF != 0 => code + (first_triangle << 3),
            code => code + first_node,
        };
        let moved_node = |node: Node| Node { child0: moved(node.child0), child1: moved(node.child1), ..node };
        self.nodes.extend(other.nodes.into_iter().map(moved_node));
        self.triangles.extend(other.triangles);
        moved(other.root)
    }

    /// The same with up to [`WIDTH`] children a node, the root first: where many threads walk together. Without
    /// triangles it has one node without children.
    pub fn wide(&self) -> WideHierarchy {
        let mut wide = vec![[WideChild::default(); WIDTH]];
        let mut narrow_codes = vec![[NONE; WIDTH]];
        // Narrow nodes, and the places of the wide ones that stand for them.
        let mut waiting = Vec::new();
        match self.nodes.first() {
            Some(_) => waiting.push((0u32, 0usize)),
            None => (wide[0][0], narrow_codes[0][0]) = (self.child(self.root), self.root),
        }
        while let Some((node, place)) = waiting.pop() {
            let mut children = [WideChild::default(); WIDTH];
            let narrow = &self.nodes[node as usize];
            (children[0], children[1]) = (narrow.first(), narrow.second());
            for count in 2..WIDTH {
                let inner = (0..count).filter(|child| children[*child].code & LEAF == 0);
                let area = |child: &usize| children[*child].bounds().half_area();
                let Some(largest) = inner.max_by(|a, b| area(a).total_cmp(&area(b))) else { break };
                let divided = &self.nodes[children[largest].code as usize];
                (children[largest], children[count]) = (divided.first(), divided.second());
            }
            narrow_codes[place] = children.map(|child| child.code);
            for child in children.iter_mut().filter(|child| child.code & LEAF == 0) {
                waiting.push((child.code, wide.len()));
                child.code = wide.len() as u32;
                wide.push([WideChild::default(); WIDTH]);
                narrow_codes.push([NONE; WIDTH]);
            }
            wide[place] = children;
        }
        WideHierarchy { nodes: wide, narrow_codes }
    }

    /// A leaf or [`NONE`] as a child.
    fn child(&self, code: u32) -> WideChild {
        if code == NONE {
            return WideChild::default();
        }
        let bounds = bounds_of(code, &self.nodes, &self.triangles);
        WideChild { low: bounds.min.to_array(), code, high: bounds.max.to_array(), unused: 0 }
    }

    /// Brings the hierarchy to another moment of its scene, in which some objects have moved and the same triangles
    /// have an extent. Where much has moved, rays take longer than through a new hierarchy.
    pub(crate) fn move_to(&mut self, scene: &Scene, has_moved: impl Fn(u32) -> bool + Sync) -> MovedPlaces {
        let flags = flags_of_objects(scene);
        parallel::for_each_chunk_mut(&mut self.triangles, RECORDS_AT_ONCE, |_, leaves| {
            for leaf in leaves.iter_mut().filter(|leaf| has_moved(leaf.object)) {
                *leaf = leaf_triangle(scene, &flags, leaf.triangle);
            }
        });
        let triangles = self.triangles.iter().map(|leaf| has_moved(leaf.object)).collect();
        let mut places = MovedPlaces { triangles, nodes: vec![false; self.nodes.len()] };
        for index in (0..self.nodes.len()).rev() {
            let mut node = self.nodes[index];
            let has_moved = [node.child0, node.child1].map(|child| places.has(child));
            if has_moved[0] {
                let bounds = bounds_of(node.child0, &self.nodes, &self.triangles);
                (node.low0, node.high0) = (bounds.min.to_array(), bounds.max.to_array());
            }
            if has_moved[1] {
                let bounds = bounds_of(node.child1, &self.nodes, &self.triangles);
                (node.low1, node.high1) = (bounds.min.to_array(), bounds.max.to_array());
            }
            self.nodes[index] = node;
            places.nodes[index] = has_moved[0] || has_moved[1];
        }
        places
    }

    /// True if, of some of the scene's triangles, those have an extent that the hierarchy over all holds.
    pub(crate) fn has_same_extents(&self, scene: &Scene, triangles: Range<u32>) -> bool {
        let chunks = (triangles.len()).div_ceil(RECORDS_AT_ONCE);
        let is_same = |triangle: u32| self.holds.get(triangle as usize) == Some(&has_extent(scene, triangle));
        let are_same = parallel::map_collect(chunks, |chunk| {
            let start = triangles.start + (chunk * RECORDS_AT_ONCE) as u32;
            (start..triangles.end.min(start + RECORDS_AT_ONCE as u32)).all(is_same)
        });
        !are_same.contains(&false)
    }

    /// The same nodes about the places where triangles are now; `None` if other triangles have an extent than before.
    pub fn refitted(&self, scene: &Scene) -> Option<Self> {
        if self.holds.len() != scene.triangles.len() || !self.has_same_extents(scene, 0..scene.triangles.len() as u32) {
            return None;
        }
        let mut refitted = self.clone();
        refitted.move_to(scene, |_| true);
        Some(refitted)
    }
}

/// The places of a hierarchy where something has moved.
#[derive(Clone, Debug)]
pub struct MovedPlaces {
    /// For every triangle of the leaves, true if it has moved.
    pub triangles: Vec<bool>,
    /// For every node, true if something in it has moved.
    pub nodes: Vec<bool>,
}

impl MovedPlaces {
    /// True if something in a child of a node has moved: a node, a leaf, or [`NONE`].
    fn has(&self, code: u32) -> bool {
        if code == NONE {
            return false;
        }
        if code & LEAF == 0 {
            return self.nodes[code as usize];
        }
        let (start, count) = leaf_range(code);
        self.triangles[start..start + count].contains(&true)
    }
}

/// A hierarchy of up to [`WIDTH`] children a node.
#[derive(Clone, Debug)]
pub struct WideHierarchy {
    /// The root first.
    pub nodes: Vec<[WideChild; WIDTH]>,
    /// The codes of the children in the narrow hierarchy, of nodes or leaves; [`NONE`]: there is no child.
    narrow_codes: Vec<[u32; WIDTH]>,
}

impl WideHierarchy {
    /// Follows the narrow hierarchy, in which something has moved; tells which nodes change.
    pub fn move_to(&mut self, hierarchy: &Hierarchy, places: &MovedPlaces) -> Vec<bool> {
        let Self { nodes, narrow_codes } = self;
        parallel::for_each_chunk_mut(nodes, RECORDS_AT_ONCE / WIDTH, |chunk, nodes| {
            let codes = &narrow_codes[chunk * (RECORDS_AT_ONCE / WIDTH)..];
            let children = nodes.iter_mut().flatten().zip(codes.iter().flatten());
            for (child, code) in children.filter(|(_, code)| places.has(**code)) {
                let bounds = bounds_of(*code, &hierarchy.nodes, &hierarchy.triangles);
                (child.low, child.high) = (bounds.min.to_array(), bounds.max.to_array());
            }
        });
        narrow_codes.iter().map(|codes| codes.iter().any(|code| places.has(*code))).collect()
    }
}

/// The first triangle of a leaf, and their number.
fn leaf_range(code: u32) -> (usize, usize) {
    (((code & !LEAF) >> 3) as usize, (code & 7) as usize)
}

impl Node {
    fn first(&self) -> WideChild {
        WideChild { low: self.low0, code: self.child0, high: self.high0, unused: 0 }
    }

    fn second(&self) -> WideChild {
        WideChild { low: self.low1, code: self.child1, high: self.high1, unused: 0 }
    }
}

impl WideChild {
    fn bounds(&self) -> BvhBox {
        BvhBox::new(self.low.into(), self.high.into())
    }
}

/// The box of a child of a node.
fn bounds_of(child: u32, nodes: &[Node], triangles: &[LeafTriangle]) -> BvhBox {
    let mut bounds = BvhBox::empty();
    if child & LEAF == 0 {
        let Node { low0, high0, low1, high1, .. } = nodes[child as usize];
        for corner in [low0, high0, low1, high1] {
            bounds.extend(corner.into());
        }
        return bounds;
    }
    let (start, count) = leaf_range(child);
    for LeafTriangle { a, b, c, .. } in &triangles[start..start + count] {
        for corner in [a, b, c] {
            bounds.extend((*corner).into());
        }
    }
    bounds
}

fn corners(scene: &Scene, triangle: u32) -> [Vec3; 3] {
    scene.triangles[triangle as usize].map(|vertex| scene.positions[vertex as usize])
}

/// The number of nodes from the root to the farthest leaf.
fn depth(nodes: &[Lone]) -> usize {
    let (mut deepest, mut waiting) = (0, vec![(0u32, 1usize)]);
    while let Some((index, depth)) = waiting.pop() {
        deepest = deepest.max(depth);
        if let Some(Lone { first, count: 0, .. }) = nodes.get(index as usize) {
            waiting.extend([(*first, depth + 1), (*first + 1, depth + 1)]);
        }
    }
    deepest
}

/// The root, and nodes that have the boxes of their children, from such that have their own.
fn joined(nodes: &[Lone]) -> (u32, Vec<Node>) {
    let code = |node: &Lone, number: u32| if node.count > 0 { LEAF | node.first << 3 | node.count } else { number };
    let mut joined = vec![Node::default(); usize::from(nodes[0].count == 0)];
    let mut waiting: Vec<(u32, u32)> = if joined.is_empty() { Vec::new() } else { vec![(0, 0)] };
    while let Some((index, number)) = waiting.pop() {
        let first = nodes[index as usize].first;
        let children = [first, first + 1].map(|child| nodes[child as usize]);
        let codes = [0, 1].map(|side: usize| {
            let next = joined.len() as u32;
            if children[side].count == 0 {
                joined.push(Node::default());
                waiting.push((first + side as u32, next));
            }
            code(&children[side], next)
        });
        let [low0, low1] = children.map(|child| child.bounds.min.to_array());
        let [high0, high1] = children.map(|child| child.bounds.max.to_array());
        let [child0, child1] = codes;
        joined[number as usize] = Node { low0, child0, high0, low1, child1, high1, ..Node::default() };
    }
    (code(&nodes[0], 0), joined)
}

/// The flags that all triangles of an object have.
fn flags_of_objects(scene: &Scene) -> Vec<u32> {
    let of_object = |object: u32| {
        let material = scene.material_of(object);
        bits(&[
            (flags::HIDES_LIGHTS, casts_shadows(material)),
            (flags::MAY_HAVE_HOLES, scene.is_alpha_tested(object)),
            (flags::REFLECTS, material.role != Role::Diffuse),
            (flags::REFRACTS, material.role == Role::Lens),
            (flags::IS_ROUGH, material.reflection_roughness() > 0.0),
            (flags::SPREADS, material.lobes().is_some()),
            (flags::PASSES, material.role != Role::Lens && !material.unlit && material.lets_light_pass()),
        ])
    };
    (0..scene.objects.len() as u32).map(of_object).collect()
}

fn leaf_triangle(scene: &Scene, flags_of_objects: &[u32], triangle: u32) -> LeafTriangle {
    let vertices = scene.triangles[triangle as usize].map(|vertex| vertex as usize);
    let [a, b, c] = vertices.map(|vertex| scene.positions[vertex]);
    let normal: Vec3 = vertices.iter().map(|vertex| scene.normals[*vertex]).sum();
    let object = scene.triangle_objects[triangle as usize];
    let turned = bits(&[(flags::TURNED, (b - a).cross(c - a).dot(normal) < 0.0)]);
    let flags = flags_of_objects[object as usize] | turned;
    LeafTriangle { a: a.to_array(), triangle, b: b.to_array(), object, c: c.to_array(), flags }
}

/// The nodes and the order of boxes of a hierarchy that halves their number at every node, along the longest side of
/// the box of their middles: never deep, but slower to walk.
fn halved(boxes: &[BvhBox]) -> (Vec<Lone>, Vec<u32>) {
    let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
    let empty = Lone { bounds: BvhBox::empty(), first: 0, count: 0 };
    let mut nodes = vec![empty];
    let mut waiting = vec![(0usize, 0usize, order.len())];
    while let Some((index, start, end)) = waiting.pop() {
        let part = &mut order[start..end];
        let (mut bounds, mut middles) = (BvhBox::empty(), BvhBox::empty());
        for place in part.iter() {
            bounds = bounds.union(&boxes[*place as usize]);
            middles.extend(boxes[*place as usize].center());
        }
        nodes[index] = Lone { bounds, first: start as u32, count: (end - start) as u32 };
        if end - start <= LARGEST_LEAF as usize {
            continue;
        }
        let size = middles.max - middles.min;
        let axis = (0..3).max_by(|a, b| size[*a].total_cmp(&size[*b])).unwrap_or_default();
        let middle = part.len() / 2;
        let along = |place: &u32| boxes[*place as usize].center()[axis];
        part.select_nth_unstable_by(middle, |a, b| along(a).total_cmp(&along(b)));
        let first = nodes.len();
        (nodes[index].first, nodes[index].count) = (first as u32, 0);
        nodes.extend([empty; 2]);
        waiting.extend([(first, start, start + middle), (first + 1, start + middle, end)]);
    }
    (nodes, order)
}

fn box_of(corners: [Vec3; 3]) -> BvhBox {
    let mut bounds = BvhBox::empty();
    for corner in corners {
        bounds.extend(Vec3A::from(corner));
    }
    bounds
}

#[cfg(test)]
mod tests {
    use super::*;
    use catoptric_scenes::builtin;

    /// Every triangle is in one leaf, within the boxes of all nodes above.
    fn check(scene: &Scene, root: u32, nodes: &[Node], triangles: &[u32]) {
        let mut seen = vec![0; scene.triangles.len()];
        let mut waiting = vec![(root, Vec::new())];
        while let Some((code, above)) = waiting.pop() {
            if code & LEAF == 0 {
                let node = nodes[code as usize];
                for (child, low, high) in [(node.child0, node.low0, node.high0), (node.child1, node.low1, node.high1)] {
                    waiting.push((child, [above.as_slice(), &[(low, high)]].concat()));
                }
                continue;
            }
            let (start, count) = (((code & !LEAF) >> 3) as usize, (code & 7) as usize);
            for &triangle in &triangles[start..start + count] {
                seen[triangle as usize] += 1;
                for vertex in scene.triangles[triangle as usize] {
                    let at = scene.positions[vertex as usize].to_array();
                    assert!(above.iter().all(|(low, high)| (0..3).all(|i| low[i] <= at[i] && at[i] <= high[i])));
                }
            }
        }
        assert!(seen.iter().all(|count| *count == 1));
    }

    #[test]
    fn all_triangles_lie_within_their_nodes() {
        let scene = builtin::parse("sphere_room?tess=16").unwrap().pose(&Default::default()).unwrap();
        let hierarchy = Hierarchy::new(&scene);
        let triangles: Vec<u32> = hierarchy.triangles.iter().map(|triangle| triangle.triangle).collect();
        check(&scene, hierarchy.root, &hierarchy.nodes, &triangles);
        assert!(hierarchy.nodes.len() < scene.triangles.len(), "leaves hold one triangle each");
        let corners = |triangle: &[u32; 3]| triangle.map(|vertex| scene.positions[vertex as usize]);
        let boxes: Vec<BvhBox> = scene.triangles.iter().map(|triangle| box_of(corners(triangle))).collect();
        let (nodes, order) = halved(&boxes);
        let (root, joined) = joined(&nodes);
        check(&scene, root, &joined, &order);
        assert!(depth(&nodes) <= 2 + boxes.len().ilog2() as usize, "{}", depth(&nodes));
    }

    #[test]
    fn a_single_triangle_is_a_leaf_and_none_is_nothing() {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y].map(|corner| BvhBox::from_point(corner.into()));
        let (nodes, _) = halved(&corners[..1]);
        assert_eq!(joined(&nodes), (LEAF | 1, Vec::new()));
        assert_eq!(Hierarchy::new(&Scene::default()).root, NONE);
    }

    #[test]
    fn triangles_that_moved_lie_within_refitted_nodes() {
        let mut scene = builtin::parse("sphere_room?tess=16").unwrap().pose(&Default::default()).unwrap();
        let hierarchy = Hierarchy::new(&scene);
        for (index, position) in scene.positions.iter_mut().enumerate() {
            *position += Vec3::new((index as f32).sin(), 0.3, (index as f32 * 0.7).cos()) * 0.2;
        }
        let refitted = hierarchy.refitted(&scene).expect("no triangle has become flat");
        let triangles: Vec<u32> = refitted.triangles.iter().map(|triangle| triangle.triangle).collect();
        check(&scene, refitted.root, &refitted.nodes, &triangles);
        let [a, b, _] = scene.triangles[0];
        scene.positions[a as usize] = scene.positions[b as usize];
        assert!(hierarchy.refitted(&scene).is_none());
    }
}
