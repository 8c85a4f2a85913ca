//! The report of a comparison: a page, numbers and a plot.

mod page;
mod plot;

use crate::commands::pretty;
use crate::failure::Failure;
use crate::stats::{ErrorReport, Stats};
use catoptric::methods::MethodInfo;
use catoptric::picture;
use serde_json::{Map, Value, json};
use std::io::Write;
use std::path::Path;

/// Everything that the report says.
pub(crate) struct Report {
    /// The command that made it.
    pub(crate) command: String,
    /// The run of the reference that all are measured against.
    pub(crate) truth: Stats,
    /// How many pixels show a reflector or lens.
    pub(crate) reflector_pixels: usize,
    pub(crate) entries: Vec<Entry>,
}

/// One method, or one variant of it.
pub(crate) struct Entry {
    /// As it was asked for: `ID` or `ID:KEY=VALUE,...`.
    pub(crate) label: String,
    pub(crate) variant: Option<String>,
    pub(crate) info: &'static MethodInfo,
    pub(crate) settings: Map<String, Value>,
    /// It is the run that all are measured against.
    pub(crate) is_truth: bool,
    pub(crate) outcome: Outcome,
}

pub(crate) enum Outcome {
    Measured(Box<Measured>),
    /// Why the method could not draw the scene.
    Failed(String),
}

pub(crate) struct Measured {
    pub(crate) stats: Stats,
    pub(crate) error: ErrorReport,
    /// File name of the picture in the report's folder.
    pub(crate) picture: String,
    /// File name of the FLIP map; none for the truth itself.
    pub(crate) flip: Option<String>,
}

impl Measured {
    /// The mean FLIP that methods are ranked by: of the reflectors where there are any, else of the picture.
    pub(crate) fn ranking_error(&self) -> Option<f64> {
        self.error.reflector.or(self.error.image).map(|error| error.flip_mean)
    }
}

impl Report {
    /// The methods that drew the scene.
    pub(crate) fn measured(&self) -> impl Iterator<Item = (&Entry, &Measured)> {
        self.entries.iter().filter_map(|entry| match &entry.outcome {
            Outcome::Measured(measured) => Some((entry, measured.as_ref())),
            Outcome::Failed(_) => None,
        })
    }
}

/// Writes `report.json`, `error_time.svg` and `report.html`.
pub(crate) fn write(folder: &Path, report: &Report) -> Result<(), Failure> {
    let plot = plot::error_against_time(report)?;
    let objects = report.entries.iter().map(|entry| json_of(report, entry)).collect::<Result<Vec<Value>, _>>()?;
    let page = page::page(report, &plot).into_string();
    for (name, text) in
        [("report.json", pretty(&objects)?), ("error_time.svg", plot.standalone()), ("report.html", page)]
    {
        picture::write_file(&folder.join(name), |writer| writer.write_all(text.as_bytes()))?;
    }
    Ok(())
}

fn json_of(report: &Report, entry: &Entry) -> Result<Value, Failure> {
    let reference_ms = report.truth.frame_ms.median;
    let mut object = match &entry.outcome {
        Outcome::Measured(measured) => {
            let mut object = serde_json::to_value(&measured.stats)?;
            object["error"] = serde_json::to_value(&measured.error)?;
            object["speedup"] = json!(reference_ms / measured.stats.frame_ms.median);
            object["picture"] = json!(measured.picture);
            object["flip_picture"] = json!(measured.flip);
            object
        }
        Outcome::Failed(problem) => json!({
            "version": report.truth.version,
            "scene": report.truth.scene,
            "method": entry.info.id,
            "settings": entry.settings,
            "error": null,
            "failed": problem,
        }),
    };
    object["label"] = json!(entry.label);
    object["variant"] = json!(entry.variant);
    object["reference_ms"] = json!(reference_ms);
    Ok(object)
}
