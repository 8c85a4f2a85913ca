//! The command lines of figures.

use crate::commands::{Line, Shot, settings_of};
use crate::stage::alone_if_cameras;

/// A line of a figure: scene, size, samples, order, method, settings.
pub(super) type Row<'a> = (&'a str, [u32; 2], u32, u32, &'a str, &'a str);

/// The line of what a [`Stage`](crate::stage::Stage) draws.
pub(super) fn of_stage((scene, size, samples, order, method, settings): Row<'_>) -> Line {
    line((scene, size, samples, order, method, &alone_if_cameras(method, settings)))
}

/// The line of a figure.
pub(super) fn line((scene, size, samples, order, method, settings): Row<'_>) -> Line {
    let settings = settings_of(settings);
    let settings: Vec<&str> = settings.iter().map(String::as_str).collect();
    Shot { scene: &format!("builtin:{scene}"), size, samples, order }.drawn(method, &settings)
}
