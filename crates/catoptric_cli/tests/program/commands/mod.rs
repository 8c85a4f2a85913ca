//! Commands beside drawing, projecting and baking.

mod diff;
mod helpers;
mod tasks;
mod watch;
