//! The agreement of the nodes around the eye on a path: it is blended only if they see the same appearances.

use super::blend::MorphProjector;
use catoptric_core::math::random::spread;
use catoptric_core::parallel;
use catoptric_core::scene::Scene;
use glam::Vec3;

/// Points of the scene that are looked at for every path. Chosen, not measured.
const PROBES: usize = 128;

/// The number of appearances after which no more are compared. Chosen, not measured.
const ENOUGH: u32 = 200;

/// The share of appearances that are not known at all nodes above which a path is not blended: a solver has to look for
/// these from the eye, which takes longer than cameras there, and finds one appearance of a point where there may be
/// several. Convex mirrors on their own have none to a hundredth of it, a ball in another ball a tenth, the `vase` a
/// sixth, saddles, urns and rings a quarter to a half. With 0.15 the balls in each other were blended, at the cost of
/// half as much time again, and a pixel off where cameras at the eye are a hundredth.
const MOST_SOLVED: f32 = 0.05;

/// Points all over a scene: half of them spread over all triangles, half over all objects.
pub(super) fn probes(scene: &Scene) -> Vec<Vec3> {
    let (triangles, objects) = (scene.triangles.len(), scene.objects.len());
    if triangles == 0 || objects == 0 {
        return Vec::new();
    }
    let half = PROBES / 2;
    let over_triangles = (0..half).map(|probe| probe * triangles / half);
    let over_objects = (0..half).filter_map(|probe| {
        let own = &scene.objects[probe % objects].triangles;
        let count = own.len();
        // An object gives another triangle each time that its turn comes.
        let turn = (spread(probe as u32).x * count as f32) as usize;
        (count > 0).then(|| own.start as usize + turn.min(count - 1))
    });
    let point = |(probe, triangle): (u32, usize)| {
        let at = spread(probe + 1);
        let at = if at.x + at.y > 1.0 { 1.0 - at } else { at };
        let [a, b, c] = scene.triangles.get(triangle)?.map(|corner| scene.positions[corner as usize]);
        Some(a + (b - a) * at.x + (c - a) * at.y)
    };
    (0..).zip(over_triangles.chain(over_objects)).filter_map(point).collect()
}

impl MorphProjector<'_> {
    /// True for paths on which the nodes agree, by the appearances of some points.
    pub(super) fn are_blended(&self, probes: &[Vec3]) -> Vec<bool> {
        parallel::map_collect(self.paths.len(), |path| self.is_blended(path as u32, probes))
    }

    fn is_blended(&self, path: u32, probes: &[Vec3]) -> bool {
        let Some(lookout) = self.lookout_on(path) else { return true };
        let (mut seen, mut solved) = (0, 0);
        for &probe in probes {
            for sightings in &*self.sightings(path, &lookout, probe) {
                let (projection, is_blended) = self.seen_from_eye(path, &lookout, sightings, probe);
                seen += u32::from(projection.is_some());
                solved += u32::from(projection.is_some() && !is_blended);
            }
            if seen > ENOUGH {
                break;
            }
        }
        solved as f32 <= MOST_SOLVED * seen as f32
    }
}
