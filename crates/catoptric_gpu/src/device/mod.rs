//! Drawing on devices, by wgpu.

mod adapter;
mod context;
mod frame;
mod maps;
mod method;
mod mirrors;
mod pipelines;
mod renderer;
mod tiles;
mod timer;
mod upload;

pub use adapter::{AdapterDescription, adapters};
pub use context::Context;
pub use method::create;
pub use renderer::Renderer;
