//! Memory that is left, so that what cannot fit is refused before work begins.

use super::Failure;
use std::fs;

/// The least memory that a picture takes while it is drawn and written, in bytes a pixel: `auto` took 36, the reference
/// 45, of 4096 x 4096 pixels.
const BYTES_A_PIXEL: u64 = 36;

/// A line of the system's memory table, in bytes, where it has one.
pub(crate) fn of_system(name: &str) -> Option<u64> {
    kibibytes(&fs::read_to_string("/proc/meminfo").ok()?, name)
}

/// Refuses pictures that do not fit into the memory that is left, where the system tells that.
pub(crate) fn check_picture([width, height]: [u32; 2]) -> Result<(), Failure> {
    let needed = u64::from(width) * u64::from(height) * BYTES_A_PIXEL;
    match left().filter(|left| needed > *left) {
        None => Ok(()),
        Some(left) => Err(Failure::input(format!(
            "--size {width}x{height}: such a picture needs {} of memory, and {} are left: choose a smaller one",
            text(needed),
            text(left)
        ))),
    }
}

/// Bytes that this process can still take: of the machine, of its container, of its own limit.
fn left() -> Option<u64> {
    let number = |path: &str| fs::read_to_string(path).ok()?.trim().parse::<u64>().ok();
    let of_container = || {
        let used = number("/sys/fs/cgroup/memory.current")?;
        // Pages of files are given up when memory is needed.
        let table = fs::read_to_string("/sys/fs/cgroup/memory.stat").ok()?;
        let lines = table.lines().filter_map(|line| line.split_once(' '));
        let reclaimable: u64 = lines
            .filter(|(name, _)| matches!(*name, "active_file" | "inactive_file"))
            .filter_map(|(_, bytes)| bytes.trim().parse::<u64>().ok())
            .sum();
        Some(number("/sys/fs/cgroup/memory.max")?.saturating_sub(used.saturating_sub(reclaimable)))
    };
    [of_system("MemAvailable"), of_container(), of_process()].into_iter().flatten().min()
}

/// The bytes that the limit of this process's addresses leaves.
fn of_process() -> Option<u64> {
    let limits = fs::read_to_string("/proc/self/limits").ok()?;
    let limit = limits.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    let limit: u64 = limit.split_whitespace().next()?.parse().ok()?;
    Some(limit.saturating_sub(kibibytes(&fs::read_to_string("/proc/self/status").ok()?, "VmSize")?))
}

/// A number of kibibytes in one of the system's tables, in bytes.
fn kibibytes(table: &str, name: &str) -> Option<u64> {
    let line = table.lines().find(|line| line.split(':').next() == Some(name))?;
    line.split_whitespace().nth(1)?.parse::<u64>().ok()?.checked_mul(1024)
}

fn text(bytes: u64) -> String {
    format!("{:.1} GiB", bytes as f64 / (1u64 << 30) as f64)
}
