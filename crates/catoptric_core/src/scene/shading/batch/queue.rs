//! Points that wait to be shaded together.

use super::super::super::Scene;
use super::query::SurfaceQuery;
use glam::Vec3;

/// Points that are shaded at once: as many as stay in the fastest cache.
const AT_ONCE: usize = 256;

/// Points whose radiance is added to colours when enough of them wait, or at the end; reused, it allocates nothing.
#[derive(Debug, Default)]
pub struct ShadingQueue {
    queries: Vec<SurfaceQuery>,
    /// The colour that each adds to, and the factor on its radiance.
    targets: Vec<(u32, Vec3)>,
    results: Vec<Vec3>,
}

impl ShadingQueue {
    /// Adds a point, whose radiance times `throughput` is part of the colour of this index; shades all that wait if
    /// they are many.
    #[inline(always)]
    pub fn push(&mut self, scene: &Scene, query: SurfaceQuery, index: u32, throughput: Vec3, colors: &mut [Vec3]) {
        self.queries.push(query);
        self.targets.push((index, throughput));
        if self.queries.len() >= AT_ONCE {
            self.shade(scene, colors);
        }
    }

    /// Adds the radiance of all points that wait to their colours.
    pub fn shade(&mut self, scene: &Scene, colors: &mut [Vec3]) {
        let Self { queries, targets, results } = self;
        results.resize(queries.len(), Vec3::ZERO);
        scene.radiance_batch(queries, results);
        for ((index, throughput), result) in targets.drain(..).zip(results) {
            colors[index as usize] += throughput * *result;
        }
        queries.clear();
    }
}
