//! The window's end of the line to the studio.

mod restarts;
#[cfg(not(target_family = "wasm"))]
mod thread;

pub use restarts::Restarts;
#[cfg(not(target_family = "wasm"))]
pub use thread::StudioThread;

use crate::studio::news::News;
use crate::studio::order::{Order, Wish};
use std::sync::Arc;

/// A line to a studio, wherever it works.
///
/// A studio that fails is started again, as often as [`Restarts`] allows, and [`News::Restarted`] is told; what waited
/// for it is forgotten.
pub trait Link {
    /// Gives an order.
    fn send(&self, order: Order);

    /// Replaces the wish.
    fn wish(&self, wish: Arc<Wish>);

    /// The next news, if there is any.
    fn news(&self) -> Option<News>;
}
