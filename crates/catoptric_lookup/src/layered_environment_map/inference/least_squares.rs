//! Textures whose look-ups come closest to the observed radiance: sparse least squares for four channels at once.

use catoptric_core::parallel;
use glam::{DVec4, Vec4};

/// Rows or columns that a thread takes at once: sums are over such pieces, whatever the number of threads. A size for
/// threads; chosen, not measured.
const PIECE: usize = 4096;

/// Equations: of every one the texels with their weights, and the value that their sum should have.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Equations {
    /// End of each equation's terms; the next one's begin there.
    ends: Vec<u32>,
    /// The texel of every term.
    pub texels: Vec<u32>,
    /// The weight of every term.
    pub weights: Vec<f32>,
    /// The value of every equation.
    pub values: Vec<Vec4>,
}

impl Equations {
    /// Appends an equation that counts by its square; `terms` calls with texels and weights.
    #[inline]
    pub fn push(&mut self, confidence: f32, value: Vec4, terms: impl FnOnce(&mut dyn FnMut(u32, f32))) {
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

    /// Joins the equations of several systems.
    pub fn joined(systems: impl IntoIterator<Item = Self>) -> Self {
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

    /// The number of equations.
    pub(crate) fn len(&self) -> usize {
        self.ends.len()
    }

    /// The terms of an equation.
    pub fn range(&self, row: usize) -> std::ops::Range<usize> {
        let start = if row == 0 { 0 } else { self.ends[row - 1] };
        start as usize..self.ends[row] as usize
    }

    /// The terms by texels, of which there are `count`: the end of each texel's terms, their equations, and their
    /// weights.
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
        // Every start has moved to the end of its texel's terms.
        ends.pop();
        Self { ends, texels, weights, values: Vec::new() }
    }

    /// The sum of every row's terms, over `of`.
    pub fn times(&self, of: &[Vec4], sums: &mut [Vec4]) {
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
pub struct Residual {
    /// The root mean square of the residuals before the solution, with the expected texels.
    pub before: f64,
    /// The root mean square of the residuals after the solution.
    pub after: f64,
    /// Steps that were taken.
    pub steps: u32,
}

/// When the solution is near enough.
#[derive(Clone, Copy, Debug)]
pub struct Stop {
    /// The maximum number of steps.
    pub most_steps: u32,
    /// The length of the gradient, as a share of that at the start.
    pub gradient: f64,
}

/// The texels that solve equations best in the sense of least squares, where each texel is also expected to have a
/// value, an equation of its own that counts by `trust`: texels that no equation has keep that value.
///
/// By preconditioned conjugate gradients on the normal equations (Hestenes, Stiefel 1952), for all four channels in one
/// pass over the matrix, with step lengths of their own.
pub fn solve(equations: &Equations, expected: &[Vec4], trust: f32, stop: Stop) -> (Vec<Vec4>, Residual) {
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
