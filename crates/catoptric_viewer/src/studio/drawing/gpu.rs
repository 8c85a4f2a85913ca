//! The graphics processor that draws, where there is one.

use catoptric::error::RenderError;
use catoptric::methods::Method;
use catoptric_gpu::{Context, GpuError};
use std::sync::Arc;

/// The processor that is to draw.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Backend {
    /// A GPU if there is a real one, else the CPU.
    #[default]
    Auto,
    /// The CPU.
    Cpu,
    /// A GPU, drivers that draw on the processor included; the best, or the one whose name has this part.
    Gpu(Option<String>),
}

/// A graphics processor.
#[derive(Clone, Debug)]
pub struct Gpu {
    context: Arc<Context>,
}

impl Gpu {
    /// Opens what `backend` asks for; `None` for the CPU.
    ///
    /// # Errors
    /// [`GpuError`] where a GPU is wanted and there is none that can draw.
    pub fn open(backend: &Backend) -> Result<Option<Self>, GpuError> {
        let open = |name: Option<&str>| Context::new(name).map(|context| Some(Self { context }));
        match backend {
            Backend::Cpu => Ok(None),
            Backend::Gpu(name) => open(name.as_deref()),
            Backend::Auto => {
                let first = catoptric_gpu::adapters().into_iter().next().filter(|adapter| !adapter.is_software);
                Ok(first.and_then(|adapter| open(Some(&adapter.name)).ok()).flatten())
            }
        }
    }

    /// Its name.
    pub fn name(&self) -> String {
        let adapter = self.context.adapter();
        adapter.map_or_else(|| "GPU".into(), |adapter| format!("{} ({})", adapter.name, adapter.backend))
    }

    /// A method on it; `None` for those that draw on the CPU alone.
    pub(super) fn method(&self, id: &str, settings: &toml::Table) -> Result<Option<Box<dyn Method>>, RenderError> {
        let method = catoptric_gpu::create(&self.context, id, settings)?;
        Ok(method.map(|method| Box::new(method) as Box<dyn Method>))
    }
}
