//! Analytic scenes and helpers for the tests of catoptric.

pub mod drawing;
pub mod scenes;
