//! The geometry that callers have drawn.

mod block_mask;
mod draw_list;

pub use block_mask::BlockMask;
pub use draw_list::{Branch, DrawList, DrawTriangle, Stencil};
