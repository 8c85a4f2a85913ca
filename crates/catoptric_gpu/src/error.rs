//! Errors of the GPU backend.

/// A reason why a GPU cannot draw a picture. The message names the remedy.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GpuError {
    /// There is no adapter at all.
    #[error(
        "no GPU adapter was found: install a driver for Vulkan, Metal or DX12 (on Debian without a GPU, the packages \
         mesa-vulkan-drivers and libvulkan1 draw on the processor), or use the CPU backend"
    )]
    NoAdapter,
    /// No adapter has this name.
    #[error("no GPU adapter's name contains `{name}`; there are: {known}")]
    UnknownAdapter {
        /// The name asked for.
        name: String,
        /// The names of those that exist.
        known: String,
    },
    /// The adapter gives no device.
    #[error("the adapter `{adapter}` gives no device: {problem}; update its driver, or use the CPU backend")]
    NoDevice {
        /// The adapter's name.
        adapter: String,
        /// The driver's message.
        problem: String,
    },
    /// Something of the scene or picture is larger than the device allows.
    #[error("{what} needs {needed}, but the device allows {allowed}: {remedy}")]
    Limit {
        /// The thing that is too large.
        what: String,
        /// The size that is needed.
        needed: String,
        /// The limit.
        allowed: String,
        /// A way round it.
        remedy: &'static str,
    },
    /// The scene has something that the GPU backend does not draw yet.
    #[error("the GPU backend does not draw {what} yet: use the CPU backend")]
    Unsupported {
        /// The thing.
        what: String,
    },
    /// The device reports a failure.
    #[error("the GPU has failed: {problem}; use the CPU backend")]
    Device {
        /// The device's message.
        problem: String,
    },
}
