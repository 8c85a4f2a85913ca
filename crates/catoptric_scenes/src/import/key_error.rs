//! Wrong keys of surfaces and blends.

use catoptric_core::surface::SurfaceError;

/// The largest length in a scene file.
pub(super) const MAX_LENGTH: f64 = 1e9;

/// A wrong key and its fault.
#[derive(Debug, PartialEq)]
pub(super) struct KeyError {
    pub(super) key: &'static str,
    pub(super) problem: String,
}

impl From<SurfaceError> for KeyError {
    fn from(error: SurfaceError) -> Self {
        Self { key: error.parameter, problem: error.problem }
    }
}

pub(super) fn wrong<T>(key: &'static str, problem: impl Into<String>) -> Result<T, KeyError> {
    Err(KeyError { key, problem: problem.into() })
}

pub(super) fn positive(key: &'static str, length: f64) -> Result<f64, KeyError> {
    // Below the smallest normal float a length would be rounded to 0.
    if !(1e-9..=MAX_LENGTH).contains(&length) {
        return wrong(key, format!("{length}; a length must be from 1e-9 to {MAX_LENGTH:e}"));
    }
    Ok(length)
}
