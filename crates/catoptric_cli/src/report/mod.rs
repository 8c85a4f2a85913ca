//! The report of a comparison: a page, numbers and a plot.

mod page;
mod plot;

use crate::failure::Failure;
use crate::failure::text;
use crate::stats::{ErrorReport, Stats};
use catoptric::input::read_file;
use catoptric::methods::MethodInfo;
use catoptric::output;
use serde_json::{Map, Value};
use std::io::Write;
use std::path::Path;

/// The file with all numbers of a report.
const REPORT: &str = "report.json";
const MOST_REPORT_BYTES: u64 = 256 << 20;

/// The paths whose projections are measured, where tiles have drawn some of a method's.
pub(crate) const PROJECTION_REMARK: &str = "px, missing and invented are of the paths that the method's own geometry \
    has drawn; – where it has drawn none";

/// The contents of the report.
pub(crate) struct Report {
    /// The command that made it.
    pub(crate) command: String,
    /// The run of the reference that all are measured against.
    pub(crate) truth: Stats,
    /// The number of pixels that show a reflector or lens.
    pub(crate) reflector_pixels: usize,
    pub(crate) entries: Vec<Entry>,
}

/// One method, or one variant of it.
pub(crate) struct Entry {
    /// The argument of `--method`: `ID` or `ID:KEY=VALUE,...`.
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
    /// File name of the FLIP map; `None` for the reference itself.
    pub(crate) flip: Option<String>,
}

impl Measured {
    /// The mean FLIP that methods are ranked by: of the reflectors where there are any, else of the picture.
    pub(crate) fn ranking_error(&self) -> Option<f64> {
        self.error.reflector.or(self.error.image).map(|error| error.flip_mean)
    }
}

impl Report {
    /// True if tiles have drawn paths in the place of any method.
    pub(crate) fn any_left_to_tiles(&self) -> bool {
        self.measured().any(|(_, measured)| measured.stats.share_left_to_tiles() > 0.0)
    }

    /// The methods that drew the scene.
    pub(crate) fn measured(&self) -> impl Iterator<Item = (&Entry, &Measured)> {
        self.entries.iter().filter_map(|entry| match &entry.outcome {
            Outcome::Measured(measured) => Some((entry, measured.as_ref())),
            Outcome::Failed(_) => None,
        })
    }
}

/// Readable JSON with a line end, without characters that a terminal obeys.
pub(crate) fn pretty(value: &impl serde::Serialize) -> Result<String, Failure> {
    Ok(text::printable_json(serde_json::to_string_pretty(value)?) + "\n")
}

/// The names of the files of an earlier report in a folder; `None` if there is none.
pub(crate) fn files_of(folder: &Path) -> Option<Vec<String>> {
    let bytes = read_file(&folder.join(REPORT), MOST_REPORT_BYTES).ok()?;
    let entries: Vec<Value> = serde_json::from_slice(&bytes).ok()?;
    let is_ours = |entry: &Value| entry["label"].is_string() && entry["reference_ms"].is_number();
    if !entries.iter().all(is_ours) {
        return None;
    }
    let pictures = entries.iter().flat_map(|entry| [&entry["picture"], &entry["flip_picture"]]);
    // No path leads out of the folder.
    let pictures =
        pictures.filter_map(Value::as_str).filter(|name| !name.contains(['/', '\\']) && name.ends_with(".png"));
    Some(pictures.map(String::from).collect())
}

/// Writes `report.json`, `error_time.svg` and `report.html`.
pub(crate) fn write(folder: &Path, report: &Report) -> Result<(), Failure> {
    let plot = plot::error_against_time(report)?;
    let objects: Vec<EntryJson<'_>> = report.entries.iter().map(|entry| EntryJson::new(report, entry)).collect();
    let page = page::page(report, &plot).into_string();
    for (name, text) in [(REPORT, pretty(&objects)?), ("error_time.svg", plot.standalone()), ("report.html", page)] {
        output::write_file(&folder.join(name), |writer| writer.write_all(text.as_bytes()))?;
    }
    Ok(())
}

/// An entry of `report.json`: the stats of the run, how wrong its picture is, and the reference's time.
#[derive(serde::Serialize)]
#[serde(untagged)]
enum EntryJson<'a> {
    Measured {
        label: &'a str,
        variant: Option<&'a str>,
        #[serde(flatten)]
        stats: &'a Stats,
        error: &'a ErrorReport,
        reference_ms: f64,
        /// The reference's time of a frame divided by this one's; null if that is 0.
        speedup: f64,
        picture: &'a str,
        flip_picture: Option<&'a str>,
    },
    Failed {
        label: &'a str,
        variant: Option<&'a str>,
        version: &'static str,
        scene: &'a str,
        method: &'static str,
        settings: &'a Map<String, Value>,
        error: Option<()>,
        failed: &'a str,
        reference_ms: f64,
    },
}

impl<'a> EntryJson<'a> {
    fn new(report: &'a Report, entry: &'a Entry) -> Self {
        let (label, variant) = (entry.label.as_str(), entry.variant.as_deref());
        let reference_ms = report.truth.frame_ms.median;
        match &entry.outcome {
            Outcome::Measured(measured) => Self::Measured {
                label,
                variant,
                stats: &measured.stats,
                error: &measured.error,
                reference_ms,
                speedup: reference_ms / measured.stats.frame_ms.median,
                picture: &measured.picture,
                flip_picture: measured.flip.as_deref(),
            },
            Outcome::Failed(problem) => Self::Failed {
                label,
                variant,
                version: report.truth.version,
                scene: &report.truth.scene,
                method: entry.info.id,
                settings: &entry.settings,
                error: None,
                failed: problem,
                reference_ms,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stats::{Counts, FrameTimes, Times};

    fn stats() -> Stats {
        Stats {
            version: "0",
            scene: "a <scene>".into(),
            method: "reference",
            settings: Map::new(),
            backend: "cpu",
            device: "machine".into(),
            threads: 1,
            size: [4, 3],
            samples: 1,
            order: 1,
            frames: 1,
            motion: "none",
            setup_ms: Times(vec![("load".into(), 1.0)]),
            frame_ms: FrameTimes { first: 30.0, median: 10.0, min: 10.0, max: 30.0 },
            stages_ms: Times::default(),
            first_stages_ms: Times::default(),
            counts: Counts { named: [("rays".into(), 5)].into(), fallbacks: [("given_up".into(), 1234)].into() },
            drawn_by: None,
            bytes: Default::default(),
            warnings: vec!["something is <odd>".into()],
            choices: Vec::new(),
            error_px: None,
            noise: None,
        }
    }

    fn entry(label: &str, outcome: Outcome) -> Entry {
        let info = catoptric::methods::all()[0];
        Entry { label: label.into(), variant: None, info, settings: Map::new(), is_truth: false, outcome }
    }

    fn report() -> Report {
        let error = ErrorReport { image: None, reflector: None, projection_px: None };
        let measured = Measured { stats: stats(), error, picture: "a.png".into(), flip: Some("a-flip.png".into()) };
        let entries = vec![
            entry("drawn", Outcome::Measured(Box::new(measured))),
            entry("refused", Outcome::Failed("no <lenses> please".into())),
        ];
        Report { command: "catoptric compare 'a <scene>'".into(), truth: stats(), reflector_pixels: 0, entries }
    }

    #[test]
    fn a_method_that_fails_is_listed_with_its_message() {
        let report = report();
        let json: Vec<Value> =
            report.entries.iter().map(|entry| serde_json::to_value(EntryJson::new(&report, entry)).unwrap()).collect();
        assert_eq!(json[1]["failed"], "no <lenses> please");
        assert!(json[1]["error"].is_null() && json[1]["method"] == "reference" && json[1]["reference_ms"] == 10.0);
        assert!(json[0]["failed"].is_null() && json[0]["speedup"] == 1.0 && json[0]["counts"]["rays"] == 5);
        let plot = plot::error_against_time(&report).unwrap_or_else(|_| panic!("no plot"));
        let page = page::page(&report, &plot).into_string();
        for text in ["no &lt;lenses&gt; please", "something is &lt;odd&gt;", "given up", "a.png", "a-flip.png"] {
            assert!(page.contains(text), "{text}");
        }
        assert!(!page.contains("<scene>") && !page.contains("<odd>"));
    }
}
