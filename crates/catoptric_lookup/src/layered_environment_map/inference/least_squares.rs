//! Textures whose look-ups come closest to what was seen: sparse least squares for four channels at once.

use catoptric_core::parallel;
use glam::{DVec4, Vec4};

/// Rows or columns that a thread takes at once: sums are over such pieces, whatever the number of threads. A size for
/// threads; chosen, not measured.
const PIECE: usize = 4096;

/// Equations: of every one the texels with their weights, and the value that their sum should have.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Equations {
    /// End of each equation's terms; the next one's begin there.
    ends: Vec<u32>,
    texels: Vec<u32>,
    weights: Vec<f32>,
    values: Vec<Vec4>,
}

impl Equations {
    /// Appends an equation that counts by its square; `terms` calls with texels and weights.
    #[inline]
    pub(crate) fn push(&mut self, confidence: f32, value: Vec4, terms: impl FnOnce(&mut dyn FnMut(u32, f32))) {
        let (texels, weights) = (&mut self.texels, &mut self.weights);
        terms(&mut |texel, weight| {
            if weight != 0.0 {
                texels.push(texel);
                weights.push(weight * confidence);
            }
        });
        self.ends.push(self.texels.len() as u32);
        self.values.push(value * confidence);
    }

    /// All equations of several systems.
    pub(crate) fn joined(systems: impl IntoIterator<Item = Self>) -> Self {
        let mut all = Self::default();
        for system in systems {
            let first = all.texels.len() as u32;
            all.ends.extend(system.ends.iter().map(|end| first + end));
            all.texels.extend(system.texels);
            all.weights.extend(system.weights);
            all.values.extend(system.values);
        }
        all
    }

    /// How many there are.
    pub(crate) fn len(&self) -> usize {
        self.ends.len()
    }

    fn range(&self, row: usize) -> std::ops::Range<usize> {
        let start = if row == 0 { 0 } else { self.ends[row - 1] };
        start as usize..self.ends[row] as usize
    }

    /// The same terms by texels, of which there are `count`: where each one's end, their equations, and their weights.
    fn transposed(&self, count: usize) -> Self {
        let mut ends = vec![0u32; count + 1];
        for texel in &self.texels {
            ends[*texel as usize + 1] += 1;
        }
        for index in 1..ends.len() {
            ends[index] += ends[index - 1];
        }
        let (mut texels, mut weights) = (vec![0; self.texels.len()], vec![0.0; self.texels.len()]);
        for row in 0..self.len() {
            for term in self.range(row) {
                let place = &mut ends[self.texels[term] as usize];
                texels[*place as usize] = row as u32;
                weights[*place as usize] = self.weights[term];
                *place += 1;
            }
        }
        // Every start has moved to where the texel's terms end.
        ends.pop();
        Self { ends, texels, weights, values: Vec::new() }
    }

    /// Sum of the squares of every texel's weights.
    #[cfg(test)]
    pub(crate) fn squares(&self, count: usize) -> Vec<f32> {
        let mut squares = vec![0.0; count];
        self.texels.iter().zip(&self.weights).for_each(|(texel, weight)| squares[*texel as usize] += weight * weight);
        squares
    }

    /// Has the equations hold for texels.
    #[cfg(test)]
    pub(crate) fn show(&mut self, texels: &[Vec4]) {
        let mut values = vec![Vec4::ZERO; self.len()];
        self.times(texels, &mut values);
        self.values = values;
    }

    /// The sum of every row's terms, over `of`.
    pub(crate) fn times(&self, of: &[Vec4], sums: &mut [Vec4]) {
        parallel::for_each_chunk_mut(sums, PIECE, |piece, sums| {
            for (index, sum) in sums.iter_mut().enumerate() {
                let range = self.range(piece * PIECE + index);
                let terms = self.texels[range.clone()].iter().zip(&self.weights[range]);
                *sum = terms.map(|(texel, weight)| of[*texel as usize] * *weight).sum();
            }
        });
    }
}

/// The products of all elements of two vectors, summed channel by channel.
fn dot(a: &[Vec4], b: &[Vec4]) -> DVec4 {
    let pieces = a.len().div_ceil(PIECE);
    let piece = |piece: usize| {
        let range = piece * PIECE..((piece + 1) * PIECE).min(a.len());
        let products = a[range.clone()].iter().zip(&b[range]);
        products.map(|(a, b)| (*a * *b).as_dvec4()).sum::<DVec4>()
    };
    parallel::map_collect(pieces, piece).into_iter().sum()
}

/// `to += of * by`, channel by channel.
fn add(to: &mut [Vec4], of: &[Vec4], by: Vec4) {
    to.iter_mut().zip(of).for_each(|(to, of)| *to += *of * by);
}

/// Residual of a solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Residual {
    /// The root of the mean square of what equations are off by, before: with the texels that were expected.
    pub(crate) before: f64,
    /// The same after.
    pub(crate) after: f64,
    /// Steps that were taken.
    pub(crate) steps: u32,
}

/// When the solution is near enough.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stop {
    pub(crate) most_steps: u32,
    /// The gradient's length has become this share of what it was.
    pub(crate) gradient: f64,
}

/// The texels that solve equations best in the sense of least squares, where each texel is also expected to have a
/// value, an equation of its own that counts by `trust`: texels that no equation has keep that value.
///
/// By preconditioned conjugate gradients on the normal equations (Hestenes, Stiefel 1952), for all four channels in one
/// pass over the matrix, with step lengths of their own.
pub(crate) fn solve(equations: &Equations, expected: &[Vec4], trust: f32, stop: Stop) -> (Vec<Vec4>, Residual) {
    let (rows, columns) = (equations.len(), expected.len());
    let by_texel = equations.transposed(columns);
    let scale = |texel: usize| {
        let squares: f32 = by_texel.weights[by_texel.range(texel)].iter().map(|weight| weight * weight).sum();
        1.0 / (squares + trust).max(f32::MIN_POSITIVE)
    };
    let scale: Vec<f32> = (0..columns).map(scale).collect();
    let scaled = |gradient: &[Vec4]| gradient.iter().zip(&scale).map(|(value, scale)| *value * *scale).collect();
    // Residual of the expected texels.
    let mut off = vec![Vec4::ZERO; rows];
    equations.times(expected, &mut off);
    off.iter_mut().zip(&equations.values).for_each(|(off, value)| *off = *value - *off);
    let mean = |off: &[Vec4]| (dot(off, off).element_sum() / (4 * rows).max(1) as f64).sqrt();
    let before = mean(&off);
    let mut change = vec![Vec4::ZERO; columns];
    let mut gradient = vec![Vec4::ZERO; columns];
    by_texel.times(&off, &mut gradient);
    let mut ahead: Vec<Vec4> = scaled(&gradient);
    let mut length = dot(&gradient, &ahead);
    let goal = length * (stop.gradient * stop.gradient);
    let (mut moved, mut pulled, mut steps) = (vec![Vec4::ZERO; rows], vec![Vec4::ZERO; columns], 0);
    // A quotient of nothing by nothing is no step at all.
    let quotient = |a: DVec4, b: DVec4| DVec4::select(b.cmpgt(DVec4::ZERO), a / b, DVec4::ZERO);
    while steps < stop.most_steps && length.cmpgt(goal).any() {
        equations.times(&ahead, &mut moved);
        by_texel.times(&moved, &mut pulled);
        add(&mut pulled, &ahead, Vec4::splat(trust));
        let step = quotient(length, dot(&ahead, &pulled)).as_vec4();
        add(&mut change, &ahead, step);
        add(&mut off, &moved, -step);
        add(&mut gradient, &pulled, -step);
        let next: Vec<Vec4> = scaled(&gradient);
        let next_length = dot(&gradient, &next);
        let turn = quotient(next_length, length).as_vec4();
        ahead.iter_mut().zip(&next).for_each(|(ahead, next)| *ahead = *next + *ahead * turn);
        length = next_length;
        steps += 1;
    }
    change.iter_mut().zip(expected).for_each(|(change, expected)| *change += *expected);
    (change, Residual { before, after: mean(&off), steps })
}

#[cfg(test)]
mod tests {
    use super::*;
    use catoptric_core::math::random::Stream;

    /// Random equations of a few texels each.
    fn system(rows: usize, columns: usize, seed: u64, value: impl Fn(&[(u32, f32)]) -> Vec4) -> Equations {
        let mut random = Stream::new(seed);
        let mut equations = Equations::default();
        for _ in 0..rows {
            let terms: Vec<(u32, f32)> = (0..5)
                .map(|_| {
                    let texel = (random.next_between(0.0, columns as f32) as u32).min(columns as u32 - 1);
                    (texel, random.next_between(0.1, 1.0))
                })
                .collect();
            equations.push(1.0, value(&terms), |tap| terms.iter().for_each(|(texel, weight)| tap(*texel, *weight)));
        }
        equations
    }

    const STOP: Stop = Stop { most_steps: 500, gradient: 1e-6 };

    #[test]
    fn what_made_the_equations_comes_back() {
        let mut random = Stream::new(4);
        let texels: Vec<Vec4> = (0..200)
            .map(|_| Vec4::new(random.next_between(0.0, 1.0), 0.5, random.next_between(0.0, 4.0), 0.0))
            .collect();
        let equations =
            system(2000, 200, 1, |terms| terms.iter().map(|(texel, weight)| texels[*texel as usize] * *weight).sum());
        let (found, residual) = solve(&equations, &[Vec4::splat(0.7); 200], 1e-7, STOP);
        for (found, texel) in found.iter().zip(&texels) {
            assert!((*found - *texel).abs().max_element() < 1e-3, "{found} for {texel}");
        }
        assert!(residual.after < 1e-3 * residual.before, "{residual:?}");
    }

    #[test]
    fn contradictions_are_settled_as_the_normal_equations_say() {
        let mut random = Stream::new(11);
        let noise: Vec<f32> = (0..300).map(|_| random.next_between(-1.0, 1.0)).collect();
        let columns = 20;
        let equations = system(300, columns, 2, |terms| Vec4::splat(noise[(terms[0].1 * 290.0) as usize]));
        let (trust, expected) = (0.25, vec![Vec4::splat(0.3); columns]);
        let (found, _) = solve(&equations, &expected, trust, STOP);
        // The gradient of the sum of squares, summed up in double precision.
        let mut gradient: Vec<f64> =
            found.iter().map(|value| f64::from(trust) * (f64::from(value.x) - f64::from(expected[0].x))).collect();
        let mut largest = 0.0f64;
        for row in 0..equations.len() {
            let range = equations.range(row);
            let terms = || equations.texels[range.clone()].iter().zip(&equations.weights[range.clone()]);
            let sum: f64 =
                terms().map(|(texel, weight)| f64::from(found[*texel as usize].x) * f64::from(*weight)).sum();
            let off = sum - f64::from(equations.values[row].x);
            for (texel, weight) in terms() {
                gradient[*texel as usize] += off * f64::from(*weight);
                largest = largest.max((off * f64::from(*weight)).abs());
            }
        }
        assert!(gradient.iter().all(|value| value.abs() < 1e-4 * largest), "{gradient:?}");
    }

    #[test]
    fn confidence_decides_between_contradictions_and_untouched_texels_keep_their_value() {
        let mut equations = Equations::default();
        equations.push(1.0, Vec4::splat(2.0), |tap| tap(0, 1.0));
        equations.push(0.5, Vec4::splat(4.0), |tap| tap(0, 1.0));
        let (found, _) = solve(&equations, &[Vec4::ZERO, Vec4::splat(9.0)], 1e-9, STOP);
        // (2 + 4 / 4) / (1 + 1 / 4)
        assert!((found[0] - 2.4).abs().max_element() < 1e-4, "{found:?}");
        assert_eq!(found[1], Vec4::splat(9.0));
        let none = solve(&Equations::default(), &[Vec4::ONE], 1e-3, STOP);
        assert_eq!(none.0, [Vec4::ONE]);
    }
}
