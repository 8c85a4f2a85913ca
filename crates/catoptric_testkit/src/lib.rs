//! Analytic scenes and helpers for the tests of catoptric.

pub mod baking;
pub mod drawing;
pub mod highlights;
pub mod readme;
pub mod scenes;
mod session;

pub use session::{Drawn, Session};
