//! Commands beside drawing, projecting and baking.

mod compare;
mod diff;
mod helpers;
mod odd_files;
mod tasks;
mod watch;
