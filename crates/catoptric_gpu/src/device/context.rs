//! A device with all pipelines.

use super::adapter::{AdapterDescription, choose};
use super::pipelines::Pipelines;
use super::readback::{Label, Readback};
use crate::error::GpuError;
use bytemuck::Pod;
use std::sync::{Arc, Mutex, PoisonError};

/// A device that draws: made once, shared by all methods.
#[derive(Debug)]
pub struct Context {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    pub(crate) pipelines: Pipelines,
    adapter: Option<AdapterDescription>,
    /// The first failure that the device has reported since it was asked last.
    failure: Arc<Mutex<Option<String>>>,
}

impl Context {
    /// A device of the best adapter, or of the best one whose name contains a text. It allows no more than WebGPU's
    /// default limits, so that what works here works in browsers.
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`], [`GpuError::UnknownAdapter`], [`GpuError::NoDevice`], and [`GpuError::Device`] if the
    /// driver refuses the shaders.
    pub fn new(adapter: Option<&str>) -> Result<Arc<Self>, GpuError> {
        pollster::block_on(Self::request(adapter))
    }

    /// The same for programs that must not wait, as in browsers.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub async fn request(adapter: Option<&str>) -> Result<Arc<Self>, GpuError> {
        let adapter = choose(adapter).await?;
        let info = adapter.get_info();
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("catoptric"),
            required_limits: wgpu::Limits::default(),
            // For the times of stages, where there is one.
            required_features: adapter.features() & wgpu::Features::TIMESTAMP_QUERY,
            ..Default::default()
        };
        let asked = adapter.request_device(&descriptor).await;
        let (device, queue) =
            asked.map_err(|error| GpuError::NoDevice { adapter: info.name.clone(), problem: error.to_string() })?;
        Self::sharing(&adapter, device, queue)
    }

    /// A context on a device of the caller's, as a window has one. Errors of the device that nobody captures are kept
    /// for [`Self::check`] from then on, where they would end the program.
    ///
    /// # Errors
    /// [`GpuError::Device`] if the driver refuses the shaders.
    pub fn sharing(adapter: &wgpu::Adapter, device: wgpu::Device, queue: wgpu::Queue) -> Result<Arc<Self>, GpuError> {
        let failure = Arc::<Mutex<Option<String>>>::default();
        let reported = failure.clone();
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            let mut first = reported.lock().unwrap_or_else(PoisonError::into_inner);
            first.get_or_insert_with(|| error.to_string());
        }));
        Self::with_pipelines(device, queue, Some(AdapterDescription::new(&adapter.get_info())), failure)
    }

    /// A context on a device of the caller's, which gives it at least WebGPU's default limits. Its failures are
    /// reported where the caller has chosen.
    ///
    /// # Errors
    /// [`GpuError::Device`] if the driver refuses the shaders.
    pub fn of_device(device: wgpu::Device, queue: wgpu::Queue) -> Result<Arc<Self>, GpuError> {
        Self::with_pipelines(device, queue, None, Arc::default())
    }

    fn with_pipelines(
        device: wgpu::Device,
        queue: wgpu::Queue,
        adapter: Option<AdapterDescription>,
        failure: Arc<Mutex<Option<String>>>,
    ) -> Result<Arc<Self>, GpuError> {
        let pipelines = Pipelines::new(&device);
        let context = Self { device, queue, pipelines, adapter, failure };
        context.check()?;
        Ok(Arc::new(context))
    }

    /// The adapter that the device belongs to; `None` for a device of the caller's.
    pub fn adapter(&self) -> Option<&AdapterDescription> {
        self.adapter.as_ref()
    }

    /// The device.
    pub fn device(&self) -> &wgpu::Device {
        &self.device
    }

    /// The device's queue.
    pub fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }

    /// An error if the device has reported a failure since the last call.
    ///
    /// # Errors
    /// [`GpuError::Device`].
    pub fn check(&self) -> Result<(), GpuError> {
        let failure = self.failure.lock().unwrap_or_else(PoisonError::into_inner).take();
        match failure {
            Some(problem) => Err(GpuError::Device { problem }),
            None => Ok(()),
        }
    }

    /// True if passes can be timed.
    pub(crate) fn has_clock(&self) -> bool {
        self.device.features().contains(wgpu::Features::TIMESTAMP_QUERY)
    }

    /// Does some work, then reads records from a buffer.
    pub(crate) fn read_buffer<T: Pod>(
        &self,
        mut encoder: wgpu::CommandEncoder,
        source: &wgpu::Buffer,
        offset: u64,
        count: usize,
    ) -> Result<Vec<T>, GpuError> {
        let size = (count * size_of::<T>()) as u64;
        let mut readback = Readback::default();
        readback.buffer(&self.device, &mut encoder, Label::Records, (source, offset, size));
        self.queue.submit([encoder.finish()]);
        readback.begin();
        self.wait()?;
        readback.records(Label::Records)
    }

    /// Waits until all work is done.
    pub(crate) fn wait(&self) -> Result<(), GpuError> {
        let waited = self.device.poll(wgpu::PollType::wait_indefinitely());
        waited.map_err(|error| GpuError::Device { problem: error.to_string() })?;
        self.check()
    }
}
