//! Scenes.

mod blend;
mod coincident;
mod far;
mod framing;
mod roles;
mod shading;
mod view;
