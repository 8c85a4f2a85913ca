//! Connected regions of a path's rays: where neighbouring rays differ far more than those beside them, another part of
//! the reflector begins (an edge, a part in front of another). No camera is fitted across.

use super::grid::{GridRay, NO_CELL, PathRays};

/// Neighbouring rays are of different pieces when they differ by more than this many times what the rays beside them
/// do. (At silhouettes of round bodies the last two may differ two and a half times as much as those before them.)
const JUMP: f64 = 4.0;

/// Differences below this share of how far rays go are none.
const NO_JUMP: f64 = 1e-3;

/// How different two rays are: about how far apart they run a little way on.
pub(super) fn difference(a: &GridRay, b: &GridRay, reach: f64) -> f64 {
    0.25 * reach * a.direction.distance(b.direction) + a.tail.distance(b.tail)
}

/// The piece of each ray and how many there are. `between` are the cells between which rays were looked for.
pub(super) fn of(group: &PathRays, between: &[[u32; 2]], columns: u32, reach: f64) -> (Vec<u32>, u32) {
    let rays = &group.rays;
    let mut union = Union((0..rays.len() as u32).collect());
    let compare = |a: usize, b: usize| difference(&rays[a], &rays[b], reach);
    for (index, from) in between.iter().enumerate() {
        if from[0] == NO_CELL {
            let [column, row] = group.cell_of(index);
            for [right, down] in [[1, 0], [0, 1]] {
                let at = |step: i64| group.regular(column + right * step, row + down * step);
                let Some(next) = at(1) else { continue };
                let own = compare(index, next);
                let beside = [at(-1).map(|before| compare(before, index)), at(2).map(|after| compare(next, after))];
                let usual = beside.into_iter().flatten().reduce(f64::max);
                if usual.is_none_or(|usual| own <= JUMP * usual) || own <= NO_JUMP * reach {
                    union.join(index as u32, next as u32);
                }
            }
            continue;
        }
        // To the more similar of the two rays that it was found between, or else to what was found near it.
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
