//! Analytic scenes and helpers for the tests of catoptric.
