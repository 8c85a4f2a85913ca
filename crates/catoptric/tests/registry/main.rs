//! All registered methods: pictures of all built-in scenes within limits, bounded work, budgets of time, frames that
//! do not pop, degenerate scenes, declarations of settings.

mod bounded;
mod budget;
mod cancelling;
mod degenerate;
mod drawers;
mod highlights;
mod lobes;
mod matrix;
mod overlays;
mod popping;
mod settings;
