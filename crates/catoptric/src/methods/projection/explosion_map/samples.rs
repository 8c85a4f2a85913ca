//! Some rays of a reflector, for points so near to it that spheres about it say little.

use super::cells::Cells;
use super::subdivision::Walks;
use crate::methods::projection::virtual_objects::{Foot, Reflector};
use glam::{Vec2, Vec3};

/// About so many rays.
const COUNT: usize = 512;

/// Walks start from so many of them.
const STARTS: usize = 4;

/// Of rays that start nearer to each other than this share of the reflector's radius one is enough to start from.
const NEIGHBOUR_SHARE: f32 = 0.15;

/// Rays that leave the reflector, spread over its triangles.
pub(super) struct Samples {
    origins: Vec<Vec3>,
    directions: Vec<Vec3>,
    triangles: Vec<u32>,
}

impl Samples {
    pub(super) fn new(reflector: &Reflector<'_>, cells: &Cells) -> Self {
        let mut samples = Self { origins: Vec::new(), directions: Vec::new(), triangles: Vec::new() };
        let shown: Vec<_> = cells.cells.iter().filter(|cell| !cell.beyond).collect();
        let stride = shown.len().div_ceil(COUNT).max(1);
        for cell in shown.into_iter().step_by(stride) {
            let corners = reflector.mesh.triangles[cell.triangle as usize];
            let mean = |values: &[Vec3]| corners.iter().map(|vertex| values[*vertex as usize]).sum::<Vec3>() / 3.0;
            samples.origins.push(mean(&reflector.mesh.positions));
            samples.directions.push(mean(&reflector.rays.outgoing).normalize_or_zero());
            samples.triangles.push(cell.triangle);
        }
        samples
    }

    /// Calls `take` for the cells that walks find from the rays that pass nearest to a point, as seen from where they
    /// start.
    pub(super) fn locate(&self, reflector: &Reflector<'_>, point: Vec3, take: &mut dyn FnMut(&Foot)) {
        let mut best = [(f32::INFINITY, usize::MAX); STARTS];
        for (index, (origin, direction)) in self.origins.iter().zip(&self.directions).enumerate() {
            let from = point - *origin;
            let along = from.dot(*direction);
            // The squared tangent of the angle; rays that lead away from the point are as good as across it.
            let aside = from.length_squared() - along * along;
            let miss = if along > 0.0 { aside / (along * along) } else { f32::INFINITY };
            if miss < best[STARTS - 1].0 {
                self.enter(&mut best, miss, index, reflector.mesh.radius);
            }
        }
        let mut walks = Walks::new(reflector, point);
        for (_, index) in best.into_iter().filter(|(miss, _)| miss.is_finite()) {
            walks.walk(self.triangles[index], Vec2::splat(1.0 / 3.0), take);
        }
    }

    /// Puts a ray among the best; of rays that start near to each other only the better one counts.
    fn enter(&self, best: &mut [(f32, usize); STARTS], miss: f32, index: usize, radius: f32) {
        let near = NEIGHBOUR_SHARE * radius;
        let is_near = |other: &(f32, usize)| {
            other.1 != usize::MAX && self.origins[other.1].distance_squared(self.origins[index]) < near * near
        };
        let place = match best.iter().position(is_near) {
            Some(rival) if best[rival].0 <= miss => return,
            Some(rival) => rival,
            None => STARTS - 1,
        };
        best[place] = (miss, index);
        best[..=place].sort_by(|a, b| a.0.total_cmp(&b.0));
    }

    pub(super) fn byte_count(&self) -> u64 {
        28 * self.origins.len() as u64
    }
}
