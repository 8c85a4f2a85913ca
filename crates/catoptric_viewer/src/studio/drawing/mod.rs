//! Drawing: the sides of the picture, on the CPU or a GPU, and their comparison.

mod compare;
mod gpu;
mod means;
mod pace;
mod side;

pub(super) use compare::compare;
pub use gpu::Gpu;
pub(super) use side::{Fineness, OnItsWay, Outcome, Side, Tools, steps};
