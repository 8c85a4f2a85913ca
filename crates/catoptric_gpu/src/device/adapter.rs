//! The machine's adapters, and the choice of one.

use crate::error::GpuError;

/// An adapter: a GPU, or a driver that draws on the processor, by one programming interface.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AdapterDescription {
    /// The adapter's name.
    pub name: String,
    /// The interface: Vulkan, Metal, Dx12 or BrowserWebGpu.
    pub backend: String,
    /// The driver and its version.
    pub driver: String,
    /// True for a driver that draws on the processor, without a GPU.
    pub is_software: bool,
}

impl AdapterDescription {
    pub(crate) fn new(info: &wgpu::AdapterInfo) -> Self {
        let driver = [info.driver.as_str(), info.driver_info.as_str()];
        Self {
            name: info.name.clone(),
            backend: format!("{:?}", info.backend),
            driver: driver.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(" "),
            is_software: info.device_type == wgpu::DeviceType::Cpu,
        }
    }
}

/// All adapters, the best first: GPUs before others, discrete ones before those that share the processor's memory.
pub fn adapters() -> Vec<AdapterDescription> {
    pollster::block_on(all()).iter().map(|adapter| AdapterDescription::new(&adapter.get_info())).collect()
}

async fn all() -> Vec<wgpu::Adapter> {
    // Without OpenGL, which other crates may bring: it lacks pictures of floats to draw on, and its libraries complain
    // on standard error where there is no display.
    let backends = wgpu::Backends::PRIMARY;
    let descriptor = wgpu::InstanceDescriptor { backends, ..wgpu::InstanceDescriptor::new_without_display_handle() };
    let instance = wgpu::Instance::new(descriptor);
    let mut adapters = instance.enumerate_adapters(backends).await;
    // Without compute and storage buffers nothing can be drawn.
    adapters.retain(|adapter| adapter.limits().max_storage_buffers_per_shader_stage >= 8);
    adapters.sort_by_key(|adapter| rank(&adapter.get_info()));
    adapters
}

fn rank(info: &wgpu::AdapterInfo) -> u8 {
    match info.device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    }
}

/// The best adapter, or the best one whose name contains a text (in any case).
pub(crate) async fn choose(name: Option<&str>) -> Result<wgpu::Adapter, GpuError> {
    let mut adapters = all().await;
    let known = adapters.iter().map(|adapter| adapter.get_info().name).collect::<Vec<_>>().join(", ");
    if let Some(name) = name {
        let wanted = name.to_lowercase();
        adapters.retain(|adapter| adapter.get_info().name.to_lowercase().contains(&wanted));
    }
    match (adapters.into_iter().next(), name) {
        (Some(adapter), _) => Ok(adapter),
        (None, Some(name)) if !known.is_empty() => Err(GpuError::UnknownAdapter { name: name.into(), known }),
        (None, _) => Err(GpuError::NoAdapter),
    }
}
