//! catoptric in a window: reflections that move, in any scene, by any method, beside the ray-traced truth.
//!
//! [`studio`] draws, on a thread of its own; [`app`] is the window's content. They share nothing but orders, wishes
//! and news. [`software`] shows it where there is no graphics driver.

pub mod app;
pub mod memory;
#[cfg(not(target_family = "wasm"))]
pub mod software;
pub mod studio;
