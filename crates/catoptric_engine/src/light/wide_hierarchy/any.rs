//! The search for anything that a ray meets, for shadows.

use super::rays::{RaySlabs, meet_leaf};
use super::{LEAF, SURFACE, SignBits, TriangleHit, WideHierarchy};
use catoptric_core::scene::Ray;

/// Nodes that wait along a ray in place.
const WAITING: usize = 64;

impl WideHierarchy {
    /// Returns true if a triangle that passes a test, or a surface, is nearer along a ray than a distance; `surface` as
    /// in [`Self::nearest_of_all`]. What is nearest does not matter: nodes are walked as they come.
    #[inline(always)]
    pub(crate) fn meets_any<S: SignBits>(
        &self,
        ray: &Ray,
        distance: f32,
        passes: impl Fn(&TriangleHit) -> bool,
        surface: impl Fn(u32, f32) -> Option<f32>,
    ) -> bool {
        if self.nodes.is_empty() || !(ray.origin.is_finite() && ray.direction.is_finite()) {
            return false;
        }
        let slabs = RaySlabs::new(ray);
        let mut waiting = [0u32; WAITING];
        // Nodes that do not fit wait here: trees of degenerate input are deep.
        let mut more = Vec::new();
        let mut count = 1;
        loop {
            if count == 0 {
                let Some(next) = more.pop() else { return false };
                (waiting[0], count) = (next, 1);
            }
            count -= 1;
            let next = waiting[count];
            if next & (LEAF | SURFACE) != 0 {
                let (mut far, mut best) = (distance, None);
                meet_leaf::<S>(self, next, ray, 0.0, &mut far, &mut best, &passes, &surface, &mut ());
                if best.is_some() {
                    return true;
                }
                continue;
            }
            let node = &self.nodes[next as usize];
            let (mut met, _) = slabs.children::<S>(node, distance);
            while met != 0 {
                let lane = met.trailing_zeros() as usize;
                met &= met - 1;
                if count == WAITING {
                    more.push(node.children[lane]);
                    continue;
                }
                waiting[count] = node.children[lane];
                count += 1;
            }
        }
    }
}
