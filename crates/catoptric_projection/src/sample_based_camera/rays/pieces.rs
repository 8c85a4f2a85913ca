//! Connected regions of a path's rays: where neighbouring rays differ far more than those beside them, another part of
//! the reflector begins (an edge, a part in front of another). No camera is fitted across.

use super::grid_ray::GridRay;
use super::path_rays::{DensePathRays, NO_RAY};
use super::rows::NO_CELL;
use catoptric_core::parallel;

/// Neighbouring rays are of different pieces when they differ by more than this many times the difference of the rays
/// beside them. (At silhouettes of round bodies the last two may differ two and a half times as much as those before
/// them.) 4 leaves room above that; not measured.
const JUMP: f64 = 4.0;

/// Differences below this share of how far rays go are none. Chosen, not measured.
const NO_JUMP: f64 = 1e-3;

/// Difference of two rays: about how far apart they run a little way on.
fn difference(a: &GridRay, b: &GridRay, reach: f64) -> f64 {
    0.25 * reach * a.direction.distance(b.direction) + a.tail.distance(b.tail)
}

/// The piece of the one among other rays, given with their pieces, that a ray resembles most; none if there are none.
pub(in super::super) fn of_most_alike(ray: &GridRay, others: &[(GridRay, u32)], reach: f64) -> Option<u32> {
    let unlike = |other: &GridRay| difference(ray, other, reach);
    let nearest = others.iter().min_by(|a, b| unlike(&a.0).total_cmp(&unlike(&b.0)))?;
    Some(nearest.1)
}

/// The piece of each ray and how many there are. `between` are the cells between which rays were looked for.
pub(in super::super) fn of(group: &DensePathRays, between: &[[u32; 2]], columns: u32, reach: f64) -> (Vec<u32>, u32) {
    let rays = &group.rays;
    let mut union = Union((0..rays.len() as u32).collect());
    join_regular(group, reach, &mut union);
    let compare = |a: usize, b: usize| difference(&rays[a], &rays[b], reach);
    for (index, from) in between.iter().enumerate() {
        if from[0] == NO_CELL {
            continue;
        }
        // A ray is joined to the more similar of the two rays that it was found between, or else to one found near it.
        let ends = from.map(|cell| group.regular(i64::from(cell % columns), i64::from(cell / columns)));
        let nearest = ends.into_iter().flatten().min_by(|a, b| compare(index, *a).total_cmp(&compare(index, *b)));
        match nearest {
            Some(end) => union.join(index as u32, end as u32),
            None => {
                let [column, row] = group.cell_of(index);
                let around = (-1..=1).flat_map(|down| (-1..=1).map(move |right| (column + right, row + down)));
                for neighbour in around.flat_map(|(column, row)| group.in_cell(column, row)) {
                    if between[neighbour][0] != NO_CELL {
                        union.join(index as u32, neighbour as u32);
                    }
                }
            }
        }
    }
    let mut number_of = vec![u32::MAX; rays.len()];
    let mut count = 0;
    let pieces = (0..rays.len() as u32)
        .map(|ray| {
            let number = &mut number_of[union.root(ray) as usize];
            if *number == u32::MAX {
                *number = count;
                count += 1;
            }
            *number
        })
        .collect();
    (pieces, count)
}

/// Joins regular rays with those beside and below them.
fn join_regular(group: &DensePathRays, reach: f64, union: &mut Union) {
    let ([columns, rows], regular) = group.regular_rays();
    // Cells without a ray give not a number.
    let compare = |a: usize, b: usize| match (regular[a], regular[b]) {
        (NO_RAY, _) | (_, NO_RAY) => f64::NAN,
        (a, b) => difference(&group.rays[a as usize], &group.rays[b as usize], reach),
    };
    // True if a difference is no jump, compared with those before and after it.
    let joined = |before: f64, own: f64, after: f64| {
        let usual = before.max(after); // the other one where either is not a number
        usual.is_nan() && !own.is_nan() || own <= JUMP * usual || own <= NO_JUMP * reach
    };
    // The differences of each row to the one below, and which of its rays are joined with the one beside.
    let differences = parallel::map_collect(rows, |row| {
        let cells = row * columns..(row + 1) * columns;
        let down: Vec<f64> = match row + 1 < rows {
            true => cells.clone().map(|cell| compare(cell, cell + columns)).collect(),
            false => vec![f64::NAN; columns],
        };
        let last = cells.end - 1;
        let right = |cell: usize| if cell < last { compare(cell, cell + 1) } else { f64::NAN };
        let (mut before, mut own) = (f64::NAN, right(cells.start));
        let beside: Vec<bool> = cells
            .map(|cell| {
                let after = right(cell + 1);
                let is_joined = joined(before, own, after);
                (before, own) = (own, after);
                is_joined
            })
            .collect();
        (down, beside)
    });
    for (row, (_, beside)) in differences.iter().enumerate() {
        for (column, _) in beside.iter().enumerate().filter(|(_, joined)| **joined) {
            let cell = row * columns + column;
            // The ray before leads directly to the first of its run, because only this row is joined so far.
            union.0[regular[cell + 1] as usize] = union.0[regular[cell] as usize];
        }
    }
    let nothing = vec![f64::NAN; columns];
    let down = |row: usize| differences.get(row).map_or(&nothing, |(down, _)| down);
    for row in 0..rows.saturating_sub(1) {
        let before = if row > 0 { down(row - 1) } else { &nothing };
        let (own, after) = (down(row), down(row + 1));
        let mut last = [NO_RAY; 2];
        for column in 0..columns {
            if joined(before[column], own[column], after[column]) {
                let cell = row * columns + column;
                let runs = [cell, cell + columns].map(|cell| union.0[regular[cell] as usize]);
                if runs != last {
                    union.join(runs[0], runs[1]);
                    last = runs;
                }
            }
        }
    }
}

/// Sets of rays, each named by one of them.
struct Union(Vec<u32>);

impl Union {
    fn root(&mut self, of: u32) -> u32 {
        let mut at = of;
        while self.0[at as usize] != at {
            let above = self.0[self.0[at as usize] as usize];
            self.0[at as usize] = above;
            at = above;
        }
        at
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        // The lower number names both: independent of the order of joins.
        self.0[a.max(b) as usize] = a.min(b);
    }
}
