//! Scenes.

mod blend;
mod far;
mod framing;
mod roles;
mod shading;
mod view;
