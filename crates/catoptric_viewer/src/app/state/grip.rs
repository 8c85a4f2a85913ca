//! Grips of the hand.

use glam::Vec3;

/// The effect of dragging with the first button.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in crate::app) enum Tool {
    /// Turns the view.
    #[default]
    Turn,
    /// Moves the object under the pointer.
    Move,
}

/// An object in the hand.
#[derive(Clone, Debug)]
pub(in crate::app) struct Grip {
    /// The number of the order that finds out what it is.
    pub(in crate::app) number: u64,
    /// The object's name, where it was taken, and how far it had been moved before; `None` until that is known.
    pub(in crate::app) held: Option<(String, Vec3, Vec3)>,
}
