//! Measures of a projection's error.

pub mod round_trip;
