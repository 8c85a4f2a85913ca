//! A window without a graphics driver: egui's meshes drawn by the processor.

mod color;
mod fill;
mod painter;
mod plane;
mod region;
#[cfg(test)]
mod tests;
mod textures;
mod window;

pub use painter::Painter;
pub use window::{Make, WindowError, run};
