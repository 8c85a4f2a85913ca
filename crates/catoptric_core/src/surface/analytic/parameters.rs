//! Parameters of surfaces: the values that are allowed, and the error about others.

use glam::DVec3;

/// The reason why there is no such surface.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{parameter}: {problem}")]
pub struct SurfaceError {
    /// The parameter at fault, as it is called in scene files.
    pub parameter: &'static str,
    /// The fault, and the values that are allowed.
    pub problem: String,
}

impl SurfaceError {
    pub(super) fn new(parameter: &'static str, problem: impl Into<String>) -> Self {
        Self { parameter, problem: problem.into() }
    }
}

/// The largest length of a surface.
pub(super) const MAX_LENGTH: f64 = 1e9;

/// The smallest length of a surface: below the smallest normal single a length would be rounded to 0.
pub(super) const MIN_LENGTH: f64 = 1e-9;

/// A length of a surface, checked.
pub(super) fn checked_length(parameter: &'static str, length: f64) -> Result<f64, SurfaceError> {
    match (MIN_LENGTH..=MAX_LENGTH).contains(&length) {
        true => Ok(length),
        false => {
            let problem = format!("{length}; a length must be from {MIN_LENGTH:e} to {MAX_LENGTH:e}");
            Err(SurfaceError::new(parameter, problem))
        }
    }
}

/// A box that cuts a surface, checked: its corners, the smaller first.
pub(super) fn checked_bounds(min: [f64; 3], max: [f64; 3]) -> Result<[DVec3; 2], SurfaceError> {
    for (parameter, corner) in [("bounds_min", min), ("bounds_max", max)] {
        if corner.iter().any(|x| x.is_nan() || x.abs() > MAX_LENGTH) {
            return Err(SurfaceError::new(parameter, format!("{corner:?}; allowed is up to {MAX_LENGTH:e}")));
        }
    }
    match (0..3).all(|axis| max[axis] - min[axis] >= MIN_LENGTH) {
        true => Ok([DVec3::from(min), DVec3::from(max)]),
        false => {
            let problem = format!("{max:?}; every number must be above that of `bounds_min` {min:?}");
            Err(SurfaceError::new("bounds_max", problem))
        }
    }
}
