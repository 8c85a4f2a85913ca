//! catoptric on graphics hardware: the same pictures by wgpu, on Vulkan, Metal, DX12 and WebGPU.
//!
//! Everything that a frame needs lies in flat tables ([`tables::SceneTables`]), whose records ([`layout`]) have twins
//! in the shaders; the shaders' functions ([`shader`]) are twins of the library's, under the same names. Without the
//! feature `wgpu` the crate holds these alone, and draws nothing.

pub mod error;
pub mod hierarchy;
pub mod layout;
pub mod shader;
pub mod tables;

#[cfg(feature = "wgpu")]
mod adapter;
#[cfg(feature = "wgpu")]
mod context;
#[cfg(feature = "wgpu")]
mod frame;
#[cfg(feature = "wgpu")]
mod method;
#[cfg(feature = "wgpu")]
mod pipelines;
#[cfg(feature = "wgpu")]
mod renderer;
#[cfg(feature = "wgpu")]
mod upload;

#[cfg(feature = "wgpu")]
pub use adapter::{AdapterDescription, adapters};
#[cfg(feature = "wgpu")]
pub use context::Context;
pub use error::GpuError;
#[cfg(feature = "wgpu")]
pub use method::create;
#[cfg(feature = "wgpu")]
pub use renderer::Renderer;
