//! Damped least squares on the specular constraint, for where Newton's method fails.

use super::{Linearised, Problem, inverted, largest, sum_of_squares};
use crate::optics::path::manifold::{ManifoldFrame, ManifoldVertex};
use glam::{DMat2, DVec2};

/// The weight of a damped step's length at first.
const FIRST_DAMPING: f64 = 1e-3;

/// Four damped steps must bring the residual below this share of its value.
const MIN_DESCENT: f64 = 0.95;

impl<const N: usize> Problem<'_, N> {
    /// Damped steps for where Newton's method stalls: beside folds a matrix is nearly singular in one direction, and
    /// its steps along that one leave no room for the others. The residual that is left.
    pub(super) fn descended(&mut self, max_steps: u32, steps: &mut u32, tolerance: f64, reach: f64) -> f64 {
        let start = self.at[0].1.position;
        let is_within =
            |at: &[(ManifoldVertex, ManifoldFrame); N]| at[0].1.position.distance_squared(start) <= reach * reach;
        let mut damping = FIRST_DAMPING;
        let (mut residual, mut earlier) = (largest(&self.constraints), [f64::INFINITY; 4]);
        while residual > tolerance && *steps < max_steps && residual < MIN_DESCENT * earlier[3] {
            earlier = [residual, earlier[0], earlier[1], earlier[2]];
            *steps += 1;
            let Some(step) = self.damped_step(damping) else { break };
            let share = self.trusted_share(&step);
            let next = self.stepped(&step, share).filter(is_within);
            let next = next.and_then(|at| self.constraints_at(&at).map(|constraints| (at, constraints)));
            match next {
                Some((at, constraints)) if sum_of_squares(&constraints) < self.square() => {
                    (self.at, self.constraints) = (at, constraints);
                    damping *= 0.1;
                }
                _ => damping *= 8.0,
            }
            residual = largest(&self.constraints);
        }
        largest(&self.constraints)
    }

    /// Levenberg and Marquardt's step: least squares of the linearised constraints and, with weight `damping` (of
    /// the largest diagonal entry), of the step itself.
    pub fn damped_step(&self, damping: f64) -> Option<[DVec2; N]> {
        let rows: [Linearised; N] = std::array::from_fn(|k| self.linearised(k));
        let block = |k: usize, column: usize| match (column + 1).checked_sub(k) {
            Some(0) => rows[k].before,
            Some(1) => rows[k].own,
            Some(2) => rows[k].after,
            _ => DMat2::ZERO,
        };
        let mut matrix = [[DMat2::ZERO; N]; N];
        let mut right = [DVec2::ZERO; N];
        for i in 0..N {
            for (k, row) in rows.iter().enumerate() {
                let transposed = block(k, i).transpose();
                right[i] += transposed * row.rest;
                for (j, entry) in matrix[i].iter_mut().enumerate() {
                    *entry += transposed * block(k, j);
                }
            }
        }
        let largest = (0..N).map(|k| matrix[k][k].x_axis.x.max(matrix[k][k].y_axis.y)).fold(0.0, f64::max);
        for (k, row) in matrix.iter_mut().enumerate() {
            row[k] += DMat2::from_diagonal(DVec2::splat(damping * largest));
        }
        // Gaussian elimination by blocks; the matrix is positive definite.
        for k in 0..N {
            let inverse = inverted(&matrix[k][k])?;
            for i in k + 1..N {
                let factor = matrix[i][k] * inverse;
                let pivots = matrix[k];
                for (entry, pivot) in matrix[i].iter_mut().zip(pivots).skip(k) {
                    *entry -= factor * pivot;
                }
                let pivot = right[k];
                right[i] -= factor * pivot;
            }
        }
        for k in (0..N).rev() {
            for j in k + 1..N {
                let known = right[j];
                right[k] -= matrix[k][j] * known;
            }
            right[k] = inverted(&matrix[k][k])? * right[k];
        }
        Some(right)
    }
}
