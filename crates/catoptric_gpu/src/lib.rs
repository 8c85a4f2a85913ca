//! catoptric on graphics hardware: the same pictures by wgpu, on Vulkan, Metal, DX12 and WebGPU.
//!
//! Everything that a frame needs lies in flat tables ([`tables::SceneTables`]), whose records ([`layout`]) have twins
//! in the shaders; the shaders' functions ([`shader`]) are twins of the library's, under the same names. Without the
//! feature `wgpu` the crate holds these alone, and draws nothing.

#[cfg(feature = "wgpu")]
mod device;
pub mod error;
pub mod hierarchy;
pub mod layout;
pub mod shader;
pub mod tables;

#[cfg(feature = "wgpu")]
pub use device::{
    AdapterDescription, Context, DeviceMethod, Encoding, Pixels, Reading, Renderer, VertexAppearance, adapters, create,
};
pub use error::GpuError;
