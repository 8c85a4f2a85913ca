//! The amount of work that a plan is, in words.

use catoptric_bake::{Estimate, Plan, Status};
use std::time::Duration;

/// A plan's units, bytes, core-hours and the time that the missing units take here.
pub(super) fn summary(plan: &Plan, found: &Status) -> String {
    let Estimate { core_hours, bytes } = plan.estimate;
    let to_make = found.to_make().len() as f64 / found.total.max(1) as f64;
    let threads = catoptric::parallel::thread_count();
    let wall = Duration::from_secs_f64(core_hours * 3600.0 * to_make / threads as f64);
    let mut text = format!("{} units, {}, about {core_hours:.3} core-hours", found.total, size(bytes));
    if found.complete > 0 {
        text += &format!("; {} are done", found.complete);
    }
    text + &format!("; {} left on {threads} threads", time(wall))
}

/// A number of bytes, in the unit that fits it.
pub(super) fn size(bytes: u64) -> String {
    match bytes {
        0..1_000_000 => format!("{:.1} kB", bytes as f64 / 1e3),
        1_000_000..1_000_000_000 => format!("{:.1} MB", bytes as f64 / 1e6),
        _ => format!("{:.2} GB", bytes as f64 / 1e9),
    }
}

/// A time, in the unit that fits it.
fn time(duration: Duration) -> String {
    match duration.as_secs() {
        0..100 => format!("{:.0} s", duration.as_secs_f64().max(1.0)),
        100..6000 => format!("{:.0} min", duration.as_secs_f64() / 60.0),
        secs => format!("{:.1} h", secs as f64 / 3600.0),
    }
}
