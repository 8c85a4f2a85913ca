//! Drawing on devices, by wgpu.

mod adapter;
mod context;
mod frame;
mod kept;
mod method;
mod moving;
mod pipelines;
mod presenting;
mod projection;
mod reading;
mod renderer;
mod upload;

pub use adapter::{AdapterDescription, adapters};
pub use context::Context;
pub use frame::VertexAppearance;
pub use method::{DeviceMethod, create};
pub use reading::{Encoding, Pixels, Reading};
pub use renderer::Renderer;
