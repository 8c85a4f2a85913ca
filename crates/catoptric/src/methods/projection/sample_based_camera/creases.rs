//! Creases, and where one part of a reflector hides another: borders between connected regions of one path's rays.

use super::follow::Steps;
use super::grid::{BORDER_PX, GridRay, PathRays, Sampler};
use super::pieces::difference;

/// The rays on both sides of such borders, close to where they cross the lines between neighbouring regular rays, with
/// their pieces.
pub(super) fn beside(group: &PathRays, sampler: &Sampler<'_>, reach: f64, steps: &mut Steps) -> Vec<(GridRay, u32)> {
    let mut found = Vec::new();
    if group.piece_count < 2 {
        return found;
    }
    for own in 0..group.rays.len() {
        let [column, row] = group.cell_of(own);
        if group.regular(column, row) != Some(own) {
            continue;
        }
        for next in [group.regular(column + 1, row), group.regular(column, row + 1)].into_iter().flatten() {
            if group.piece_of_ray[own] == group.piece_of_ray[next] {
                continue;
            }
            let mut ends = [own, next].map(|ray| (group.rays[ray], group.piece_of_ray[ray]));
            let mut apart_px = sampler.spacing_px;
            while apart_px > BORDER_PX {
                let [(from, _), (to, _)] = &ends;
                let middle = [0, 1].map(|axis: usize| 0.5 * (from.place[axis] + to.place[axis]));
                // There may be something else between the two.
                let Some(ray) = sampler.ray_on(&group.path, middle, steps) else { break };
                let nearer = usize::from(difference(&ray, to, reach) < difference(&ray, from, reach));
                ends[nearer].0 = ray;
                apart_px *= 0.5;
            }
            let moved = |(ray, _): &(GridRay, u32)| [own, next].iter().all(|&end| ray.place != group.rays[end].place);
            found.extend(ends.into_iter().filter(moved));
        }
    }
    found
}
