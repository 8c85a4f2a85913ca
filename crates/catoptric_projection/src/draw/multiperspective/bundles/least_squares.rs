//! Quadratics of the place in the picture, by least squares.

/// Coefficients of 1, u, v, u², uv, v².
pub const TERMS: usize = 6;

/// The first of them are those of a linear function.
const LINEAR_TERMS: usize = 3;

/// The least numbers of values from which a quadratic, and a linear function, are fitted.
const QUADRATIC_VALUES: usize = 10;
pub(in super::super) const LINEAR_VALUES: usize = 4;

/// The terms at a place.
#[inline(always)]
pub(in super::super) fn terms(u: f32, v: f32) -> [f32; TERMS] {
    [1.0, u, v, u * u, u * v, v * v]
}

/// The quadratics, or linear functions, that are nearest to some values of `Q` quantities; `basis` are the terms at
/// their places, which should be of order 1. `None` if the values are too few or their places lie in a row.
#[inline(always)]
pub(in super::super) fn fit_quadratics<const Q: usize>(
    basis: &[[f32; TERMS]],
    values: &[[f32; Q]],
) -> Option<[[f32; TERMS]; Q]> {
    let quadratic = if basis.len() < QUADRATIC_VALUES { None } else { solve(basis, values, TERMS) };
    match quadratic {
        None if basis.len() >= LINEAR_VALUES => solve(basis, values, LINEAR_TERMS),
        found => found,
    }
}

/// Least squares with the first terms alone.
#[inline(always)]
fn solve<const Q: usize>(basis: &[[f32; TERMS]], values: &[[f32; Q]], used: usize) -> Option<[[f32; TERMS]; Q]> {
    let mut gram = [[0.0f32; TERMS]; TERMS];
    let mut right = [[0.0f32; Q]; TERMS];
    for (basis, values) in basis.iter().zip(values) {
        for row in 0..TERMS {
            for column in 0..TERMS {
                gram[row][column] += basis[row] * basis[column];
            }
            for quantity in 0..Q {
                right[row][quantity] += basis[row] * values[quantity];
            }
        }
    }
    // Cholesky's factorisation; the basis is of order 1, and a small pivot means that places lie on a curve.
    let mut lower = [[0.0f32; TERMS]; TERMS];
    let least = 1e-4 * basis.len() as f32;
    for row in 0..used {
        for column in 0..=row {
            let mut rest = gram[row][column];
            for (one, other) in lower[row].iter().zip(&lower[column]).take(column) {
                rest -= one * other;
            }
            lower[row][column] = match row == column {
                true if rest < least => return None,
                true => rest.sqrt(),
                false => rest / lower[column][column],
            };
        }
    }
    let mut solution = [[0.0f32; TERMS]; Q];
    for (quantity, solution) in solution.iter_mut().enumerate() {
        let mut half = [0.0f32; TERMS];
        for row in 0..used {
            let mut rest = right[row][quantity];
            for (factor, half) in lower[row].iter().zip(&half).take(row) {
                rest -= factor * half;
            }
            half[row] = rest / lower[row][row];
        }
        for row in (0..used).rev() {
            let mut rest = half[row];
            for k in row + 1..used {
                rest -= lower[k][row] * solution[k];
            }
            solution[row] = rest / lower[row][row];
        }
    }
    solution.iter().flatten().all(|value| value.is_finite()).then_some(solution)
}
