//! Drawing on devices, by wgpu.

mod adapter;
mod context;
mod failure;
mod frame;
mod method;
mod pipelines;
mod presenting;
mod projection;
mod readback;
mod reading;
mod renderer;
mod scene;

pub use adapter::{AdapterDescription, adapters};
pub use context::Context;
pub use frame::VertexAppearance;
pub use method::{DeviceMethod, create};
pub use reading::{Encoding, Pixels, Reading};
pub use renderer::Renderer;
