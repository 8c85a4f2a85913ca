//! The hierarchy of boxes over a scene's triangles, two children a node, for shaders to walk.

use crate::layout::{MAX_DEPTH, Node};
use catoptric::scene::Scene;
use glam::Vec3A;
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb as BvhBox;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::leaf_collapser::collapse;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::PlocBuilder;

/// The most triangles of a leaf.
const LEAF: u32 = 4;
/// The time of a step down in those of a test of a triangle.
const STEP_COST: f32 = 1.0;
/// More triangles are sorted with less care: it would take seconds.
const CAREFUL_BUILD: usize = 500_000;

/// The hierarchy: nodes, the root first, and the triangles of their leaves.
#[derive(Clone, Debug, Default)]
pub struct Hierarchy {
    /// Both children of a node are neighbours.
    pub nodes: Vec<Node>,
    /// The scene's triangles in the order of the leaves.
    pub triangles: Vec<u32>,
}

impl Hierarchy {
    /// The hierarchy over all triangles that have corners in different places; without any it has no nodes.
    pub fn new(scene: &Scene) -> Self {
        let corners = |triangle: u32| scene.triangles[triangle as usize].map(|v| scene.positions[v as usize]);
        let is_there = |triangle: &u32| {
            let [a, b, c] = corners(*triangle);
            let normal = (b - a).cross(c - a);
            normal.is_finite() && normal != glam::Vec3::ZERO
        };
        let triangles: Vec<u32> = (0..scene.triangles.len() as u32).filter(is_there).collect();
        let boxes: Vec<BvhBox> = triangles.iter().map(|triangle| box_of(corners(*triangle))).collect();
        if boxes.is_empty() {
            return Self::default();
        }
        let preset = match boxes.len() {
            0..=CAREFUL_BUILD => BvhBuildParams::medium_build(),
            _ => BvhBuildParams::fast_build(),
        };
        let mut tree = PlocBuilder::with_capacity(boxes.len()).build(
            preset.ploc_search_distance,
            &boxes,
            (0..boxes.len() as u32).collect(),
            preset.sort_precision,
            preset.search_depth_threshold,
        );
        ReinsertionOptimizer::default().run(&mut tree, preset.reinsertion_batch_ratio, None);
        collapse(&mut tree, LEAF, STEP_COST);
        let hierarchy = Self::of_tree(&tree, &triangles);
        if hierarchy.depth() <= MAX_DEPTH { hierarchy } else { Self::halved(&boxes, &triangles) }
    }

    fn of_tree(tree: &Bvh2, triangles: &[u32]) -> Self {
        let nodes = tree.nodes.iter().map(|node| {
            let bounds = node.aabb();
            let (low, high) = (bounds.min.to_array(), bounds.max.to_array());
            Node { low, first: node.first_index, high, count: node.prim_count }
        });
        let order = tree.primitive_indices.iter().map(|place| triangles[*place as usize]);
        Self { nodes: nodes.collect(), triangles: order.collect() }
    }

    /// The number of nodes from the root to the farthest leaf.
    pub fn depth(&self) -> usize {
        let (mut deepest, mut waiting) = (0, vec![(0u32, 1usize)]);
        while let Some((index, depth)) = waiting.pop() {
            deepest = deepest.max(depth);
            match self.nodes.get(index as usize) {
                Some(node) if node.count == 0 => waiting.extend([(node.first, depth + 1), (node.first + 1, depth + 1)]),
                _ => {}
            }
        }
        deepest
    }

    /// The hierarchy that halves the number of triangles at every node, along the longest side of the box of their
    /// middles: never deep, but slower to walk.
    fn halved(boxes: &[BvhBox], triangles: &[u32]) -> Self {
        let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
        let mut nodes = vec![Node::default()];
        let mut waiting = vec![(0usize, 0usize, order.len())];
        while let Some((index, start, end)) = waiting.pop() {
            let part = &mut order[start..end];
            let (mut bounds, mut middles) = (BvhBox::empty(), BvhBox::empty());
            for place in part.iter() {
                bounds = bounds.union(&boxes[*place as usize]);
                middles.extend(boxes[*place as usize].center());
            }
            let (low, high) = (bounds.min.to_array(), bounds.max.to_array());
            nodes[index] = Node { low, first: start as u32, high, count: (end - start) as u32 };
            if end - start <= LEAF as usize {
                continue;
            }
            let size = middles.max - middles.min;
            let axis = (0..3).max_by(|a, b| size[*a].total_cmp(&size[*b])).unwrap_or_default();
            let middle = part.len() / 2;
            let along = |place: &u32| boxes[*place as usize].center()[axis];
            part.select_nth_unstable_by(middle, |a, b| along(a).total_cmp(&along(b)));
            let first = nodes.len();
            (nodes[index].first, nodes[index].count) = (first as u32, 0);
            nodes.extend([Node::default(); 2]);
            waiting.extend([(first, start, start + middle), (first + 1, start + middle, end)]);
        }
        Self { nodes, triangles: order.iter().map(|place| triangles[*place as usize]).collect() }
    }
}

fn box_of(corners: [glam::Vec3; 3]) -> BvhBox {
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
    fn check(hierarchy: &Hierarchy, scene: &Scene) {
        let mut seen = vec![0; scene.triangles.len()];
        let mut waiting = vec![(0u32, Vec::<usize>::new())];
        while let Some((index, mut above)) = waiting.pop() {
            above.push(index as usize);
            let node = hierarchy.nodes[index as usize];
            if node.count == 0 {
                waiting.extend([(node.first, above.clone()), (node.first + 1, above)]);
                continue;
            }
            for place in node.first..node.first + node.count {
                let triangle = hierarchy.triangles[place as usize];
                seen[triangle as usize] += 1;
                for vertex in scene.triangles[triangle as usize] {
                    let position = scene.positions[vertex as usize].to_array();
                    for &node in &above {
                        let Node { low, high, .. } = hierarchy.nodes[node];
                        assert!((0..3).all(|axis| (low[axis]..=high[axis]).contains(&position[axis])));
                    }
                }
            }
        }
        assert!(seen.iter().all(|count| *count == 1));
    }

    #[test]
    fn all_triangles_lie_within_their_nodes() {
        let scene = builtin::parse("sphere_room?tess=16").unwrap().pose(&Default::default()).unwrap();
        let hierarchy = Hierarchy::new(&scene);
        check(&hierarchy, &scene);
        assert!(hierarchy.nodes.len() < 2 * scene.triangles.len(), "leaves hold one triangle each");
        let boxes: Vec<BvhBox> = scene
            .triangles
            .iter()
            .map(|triangle| box_of(triangle.map(|vertex| scene.positions[vertex as usize])))
            .collect();
        let all: Vec<u32> = (0..boxes.len() as u32).collect();
        let halved = Hierarchy::halved(&boxes, &all);
        check(&halved, &scene);
        assert!(halved.depth() <= 2 + boxes.len().ilog2() as usize, "{}", halved.depth());
        assert!(Hierarchy::new(&Scene::default()).nodes.is_empty());
    }
}
