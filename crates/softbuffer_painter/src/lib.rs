#![doc = include_str!("../README.md")]

mod color;
mod fill;
mod painter;
mod plane;
mod region;
#[cfg(test)]
mod tests;
mod textures;
mod window;

pub use egui;
pub use egui_winit::winit;
pub use painter::Painter;
pub use window::{WindowError, run};
