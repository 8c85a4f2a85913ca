//! catoptric in a window: reflections that move, in any scene, by any method, beside the ray-traced truth.
//!
//! [`studio`] draws, on a thread of its own; [`app`] is the window's content. They share nothing but orders, wishes
//! and news.

pub mod app;
pub mod memory;
pub mod studio;
