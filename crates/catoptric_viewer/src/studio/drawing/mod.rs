//! Drawing: the sides of the picture, on the CPU or a GPU, and their comparison.

mod compare;
mod gpu;
mod means;
mod overlays;
mod pace;
mod side;

pub(super) use compare::compare;
pub use gpu::Gpu;
pub(super) use overlays::OverlayMaker;
pub(super) use side::{Fineness, OnItsWay, Outcome, Side, Tools, steps};
