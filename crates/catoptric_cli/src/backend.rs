//! The processor that draws: the CPU, or a GPU in programs with the feature `gpu`, as they are by default.

use crate::args::{Backend, DrawArgs};
use crate::failure::Failure;
use crate::settings::Chosen;
use crate::terminal::Terminal;
use catoptric::methods::Method;

/// A GPU that draws what it can.
pub(crate) struct Gpu {
    /// The user wants the GPU: methods that it cannot draw are an error. Else the CPU draws these.
    pub(crate) is_wanted: bool,
    device: device::Device,
}

impl Gpu {
    /// The GPU that the options ask for; `None` for the CPU. Of itself a program takes real GPUs alone, not drivers
    /// that draw on the processor.
    pub(crate) fn open(args: &DrawArgs) -> Result<Option<Self>, Failure> {
        let name = args.adapter.as_deref();
        match args.backend {
            Backend::Cpu if name.is_some() => {
                Err(Failure::usage("--adapter names a GPU, but --backend cpu draws on the processor"))
            }
            Backend::Cpu => Ok(None),
            Backend::Gpu => Ok(Some(Self { is_wanted: true, device: device::open(name)? })),
            Backend::Auto if name.is_some() => Ok(Some(Self { is_wanted: false, device: device::open(name)? })),
            Backend::Auto => {
                let device = device::real();
                Ok(device.map(|device| Self { is_wanted: false, device }))
            }
        }
    }

    /// The GPU's name.
    pub(crate) fn name(&self) -> String {
        device::name(&self.device)
    }

    /// The method on the GPU; `None` where the CPU is to draw it.
    pub(crate) fn method(&self, chosen: &Chosen) -> Result<Option<Box<dyn Method>>, Failure> {
        let method = device::method(&self.device, chosen)?;
        if method.is_none() && self.is_wanted && chosen.info.id != "reference" {
            let known: Vec<&str> =
                catoptric::methods::all().iter().filter(|info| info.gpu).map(|info| info.id).collect();
            let (id, known) = (chosen.info.id, known.join(", "));
            let problem = format!("--backend gpu: method `{id}` draws on the CPU alone; on GPUs draw: {known}");
            return Err(Failure::input(problem));
        }
        Ok(method)
    }
}

/// Remarks with `--verbose` that no GPU was found, if the choice was left to the program.
pub(crate) fn remark(args: &DrawArgs, gpu: Option<&Gpu>, terminal: &Terminal) {
    let is_missed = cfg!(feature = "gpu") && args.backend == Backend::Auto && gpu.is_none();
    if is_missed && terminal.verbose {
        terminal.say("no GPU that can draw was found: drawn on the CPU (`catoptric doctor` lists what there is)");
    }
}

/// The lines of `doctor` about GPUs.
pub(crate) fn describe() -> Vec<String> {
    device::describe()
}

/// The processor's name, or its kind if the system has no name.
pub(crate) fn processor() -> String {
    let described = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("model name"))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    });
    described.unwrap_or_else(|| std::env::consts::ARCH.into())
}

#[cfg(feature = "gpu")]
mod device {
    use super::{Chosen, Failure, Method};
    use catoptric_gpu::{Context, adapters, create};
    use std::sync::Arc;

    pub(super) type Device = Arc<Context>;

    pub(super) fn open(name: Option<&str>) -> Result<Device, Failure> {
        let option = if name.is_some() { "--adapter" } else { "--backend gpu" };
        Context::new(name).map_err(|error| Failure::input(format!("{option}: {error}")))
    }

    /// A GPU that is no driver on the processor, if there is one.
    pub(super) fn real() -> Option<Device> {
        let first = adapters().into_iter().next().filter(|adapter| !adapter.is_software)?;
        Context::new(Some(&first.name)).ok()
    }

    pub(super) fn name(device: &Device) -> String {
        device.adapter().map_or_else(String::new, |adapter| format!("{} ({})", adapter.name, adapter.backend))
    }

    pub(super) fn method(device: &Device, chosen: &Chosen) -> Result<Option<Box<dyn Method>>, Failure> {
        let method = create(device, chosen.info.id, &chosen.settings).map_err(Failure::usage)?;
        Ok(method.map(|method| Box::new(method) as Box<dyn Method>))
    }

    pub(super) fn describe() -> Vec<String> {
        let adapters = adapters();
        if adapters.is_empty() {
            return vec![catoptric_gpu::GpuError::NoAdapter.to_string()];
        }
        let line = |adapter: catoptric_gpu::AdapterDescription| {
            let kind = if adapter.is_software { ", draws on the processor" } else { "" };
            format!("{} ({}, {}{kind})", adapter.name, adapter.backend, adapter.driver)
        };
        adapters.into_iter().map(line).collect()
    }
}

#[cfg(not(feature = "gpu"))]
mod device {
    use super::{Chosen, Failure, Method};

    const NOT_BUILT: &str = "this program was built without the GPU backend, which it has by default: build it with \
                             its feature `gpu` (no `--no-default-features`), or use --backend cpu";

    /// There is none.
    pub(super) enum Device {}

    pub(super) fn open(name: Option<&str>) -> Result<Device, Failure> {
        let option = if name.is_some() { "--adapter" } else { "--backend gpu" };
        Err(Failure::input(format!("{option}: {NOT_BUILT}")))
    }

    pub(super) fn real() -> Option<Device> {
        None
    }

    pub(super) fn name(device: &Device) -> String {
        match *device {}
    }

    pub(super) fn method(device: &Device, _: &Chosen) -> Result<Option<Box<dyn Method>>, Failure> {
        match *device {}
    }

    pub(super) fn describe() -> Vec<String> {
        vec![NOT_BUILT.into()]
    }
}
