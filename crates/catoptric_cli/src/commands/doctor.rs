//! `catoptric doctor`: what this machine offers.

use super::{columns, pretty};
use crate::args::JsonArgs;
use crate::backend;
use crate::failure::{Failure, memory};

#[derive(serde::Serialize)]
struct Machine {
    version: &'static str,
    optimised: bool,
    system: String,
    device: String,
    cores: usize,
    threads: usize,
    simd: Vec<&'static str>,
    memory_bytes: Option<u64>,
    memory_available_bytes: Option<u64>,
    gpu: bool,
    adapters: Vec<String>,
    methods: usize,
}

pub(crate) fn run(args: &JsonArgs) -> Result<String, Failure> {
    let machine = Machine {
        version: env!("CARGO_PKG_VERSION"),
        optimised: !cfg!(debug_assertions),
        system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
        device: backend::processor(),
        cores: std::thread::available_parallelism().map_or(1, |cores| cores.get()),
        threads: catoptric::parallel::thread_count(),
        simd: simd(),
        memory_bytes: memory::of_system("MemTotal"),
        memory_available_bytes: memory::of_system("MemAvailable"),
        gpu: cfg!(feature = "gpu"),
        adapters: backend::describe(),
        methods: catoptric::methods::all().len(),
    };
    if args.json {
        return pretty(&machine);
    }
    let gib =
        |bytes: Option<u64>| bytes.map_or("unknown".into(), |b| format!("{:.1} GiB", b as f64 / (1u64 << 30) as f64));
    let simd = if machine.simd.is_empty() { "none known".into() } else { machine.simd.join(" ") };
    let build = if machine.optimised { "" } else { " (debug build: times mean little)" };
    let mut rows = vec![
        vec!["version".into(), format!("{}{build}", machine.version)],
        vec!["system".into(), machine.system],
        vec!["processor".into(), machine.device],
        vec!["cores".into(), machine.cores.to_string()],
        vec!["threads".into(), machine.threads.to_string()],
        vec!["SIMD".into(), simd],
        vec!["memory".into(), format!("{}, {} free", gib(machine.memory_bytes), gib(machine.memory_available_bytes))],
        vec!["methods".into(), format!("{} (see `catoptric methods`)", machine.methods)],
    ];
    for (index, adapter) in machine.adapters.into_iter().enumerate() {
        rows.push(vec![if index == 0 { "GPU backend".into() } else { String::new() }, adapter]);
    }
    Ok(columns(&rows))
}

#[cfg(target_arch = "x86_64")]
fn simd() -> Vec<&'static str> {
    let features = [
        ("sse4.2", is_x86_feature_detected!("sse4.2")),
        ("avx", is_x86_feature_detected!("avx")),
        ("avx2", is_x86_feature_detected!("avx2")),
        ("fma", is_x86_feature_detected!("fma")),
        ("avx512f", is_x86_feature_detected!("avx512f")),
    ];
    features.into_iter().filter(|(_, present)| *present).map(|(name, _)| name).collect()
}

#[cfg(target_arch = "aarch64")]
fn simd() -> Vec<&'static str> {
    vec!["neon"]
}

#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
fn simd() -> Vec<&'static str> {
    Vec::new()
}
