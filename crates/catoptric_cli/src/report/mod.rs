//! The report of a comparison: a page with its pictures, numbers, tables and a plot.

mod content;
mod export;
mod gallery;
mod markers;
mod page;
mod plain_names;
mod plot;
mod table;

pub(crate) use content::{Crop, Entry, Measured, Outcome, Pictures, Reference, Report};
pub(crate) use export::{csv, latex};
pub(crate) use plain_names::PlainNames;
pub(crate) use table::console;

use crate::failure::Failure;
use crate::failure::text;
use crate::stats::{ErrorReport, Stats};
use catoptric::input::read_file;
use catoptric::output;
use content::names_of;
use serde_json::{Map, Value};
use std::io::Write;
use std::path::Path;

/// The file with all numbers of a report.
const REPORT: &str = "report.json";
/// The page.
pub(crate) const PAGE: &str = "report.html";
const MOST_REPORT_BYTES: u64 = 256 << 20;
/// Separate files that belong to no method.
const REFERENCE_PICTURE: &str = "reference.png";
const PLOT: &str = "error_time.svg";
const CROP: &str = "crop.png";

/// The paths whose projections are measured, where tiles have drawn some of a method's.
pub(crate) const PROJECTION_REMARK: &str = "px, missing and invented are of the paths that the method's own geometry \
    has drawn; – where it has drawn none";

/// Readable JSON with a line end, without characters that a terminal obeys.
pub(crate) fn pretty(value: &impl serde::Serialize) -> Result<String, Failure> {
    Ok(text::printable_json(serde_json::to_string_pretty(value)?) + "\n")
}

/// The names of all files of a report whose methods have these names for pictures; without them, of the least.
pub(crate) fn names(stems: Option<&[String]>, has_crop: bool) -> Vec<String> {
    let mut names = vec![PAGE.to_owned(), REPORT.to_owned()];
    if let Some(stems) = stems {
        names.extend([REFERENCE_PICTURE, PLOT].map(String::from));
        names.extend(stems.iter().flat_map(|stem| names_of(stem)));
        names.extend(has_crop.then(|| CROP.to_owned()));
    }
    names
}

/// The names of the files of an earlier report in a folder; `None` if there is none.
pub(crate) fn files_of(folder: &Path) -> Option<Vec<String>> {
    let bytes = read_file(&folder.join(REPORT), MOST_REPORT_BYTES).ok()?;
    let entries: Vec<Value> = serde_json::from_slice(&bytes).ok()?;
    let is_ours = |entry: &Value| entry["label"].is_string() && entry.get("reference_ms").is_some();
    if entries.is_empty() || !entries.iter().all(is_ours) {
        return None;
    }
    let mut names = names(None, false);
    let is_listed = |entry: &&Value| entry["files"].is_array();
    match entries.iter().find(is_listed) {
        Some(entry) => names.extend(entry["files"].as_array().into_iter().flatten().filter_map(text_of)),
        // Reports of earlier versions list pictures alone, and always had these two.
        None => {
            names.extend([REFERENCE_PICTURE, PLOT].map(String::from));
            let pictures = entries.iter().flat_map(|entry| [&entry["picture"], &entry["flip_picture"]]);
            names.extend(pictures.filter_map(text_of));
        }
    }
    // No path leads out of the folder.
    names.retain(|name| {
        !name.contains(['/', '\\', ':']) && [".png", ".svg", ".html", ".json"].iter().any(|end| name.ends_with(end))
    });
    names.sort();
    names.dedup();
    Some(names)
}

fn text_of(value: &Value) -> Option<String> {
    value.as_str().map(String::from)
}

/// Writes `report.json` and `report.html`, and, `separate`, the pictures and the plot as files of their own.
pub(crate) fn write(folder: &Path, report: &Report, separate: bool) -> Result<(), Failure> {
    let plot = plot::error_against_time(report)?;
    let mut files: Vec<(String, &[u8])> = Vec::new();
    let plot_file = plot.standalone();
    if separate {
        files.push((REFERENCE_PICTURE.into(), &report.picture));
        files.push((PLOT.into(), plot_file.as_bytes()));
        for pictures in report.measured().filter_map(|(_, measured)| measured.pictures.as_ref()) {
            let [picture, flip] = pictures.names();
            files.extend([(picture, pictures.picture.as_slice()), (flip, pictures.flip.as_slice())]);
        }
        files.extend(report.crop.as_ref().map(|crop| (CROP.into(), crop.row.as_slice())));
    }
    let mut listed: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).chain([REPORT, PAGE]).collect();
    listed.sort_unstable();
    let asked = report.entries.iter().filter(|entry| entry.is_asked);
    let objects: Vec<EntryJson<'_>> = asked.map(|entry| EntryJson::new(report, entry, &listed, separate)).collect();
    let json = pretty(&objects)?;
    let page = page::page(report, &plot).into_string();
    files.extend([(REPORT.into(), json.as_bytes()), (PAGE.into(), page.as_bytes())]);
    for (name, bytes) in files {
        output::write_file(&folder.join(name), |writer| writer.write_all(bytes))?;
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
        /// Null where our own reference was not drawn.
        reference_ms: Option<f64>,
        /// The reference's time of a frame divided by this one's; null if that is 0, or without the reference.
        speedup: Option<f64>,
        /// The file that the picture was measured against; null for our own reference.
        reference_file: Option<&'a str>,
        /// Why the picture cannot be used; null for those that can.
        unusable: Option<&'static str>,
        /// Separate files of the pictures; null without them.
        picture: Option<String>,
        flip_picture: Option<String>,
        /// All files of the report.
        files: &'a [&'a str],
    },
    Failed {
        label: &'a str,
        variant: Option<&'a str>,
        version: &'static str,
        scene: Option<&'a str>,
        method: &'static str,
        settings: &'a Map<String, Value>,
        error: Option<()>,
        failed: &'a str,
        reference_ms: Option<f64>,
        reference_file: Option<&'a str>,
        files: &'a [&'a str],
    },
}

impl<'a> EntryJson<'a> {
    fn new(report: &'a Report, entry: &'a Entry, files: &'a [&'a str], separate: bool) -> Self {
        let (label, variant) = (entry.label.as_str(), entry.variant.as_deref());
        let reference_ms = report.reference_ms();
        let reference_file = match &report.reference {
            Reference::Traced(_) => None,
            Reference::File(name) => Some(name.as_str()),
        };
        match &entry.outcome {
            Outcome::Measured(measured) => {
                let names = measured.pictures.as_ref().map(Pictures::names).filter(|_| separate);
                let (picture, flip_picture) = match names {
                    Some([picture, flip]) => (Some(picture), Some(flip)),
                    None => ((separate && entry.is_truth).then(|| REFERENCE_PICTURE.to_owned()), None),
                };
                Self::Measured {
                    label,
                    variant,
                    stats: &measured.stats,
                    error: &measured.error,
                    reference_ms,
                    speedup: reference_ms.map(|reference_ms| reference_ms / measured.stats.frame_ms.median),
                    reference_file,
                    unusable: measured.unusable,
                    picture,
                    flip_picture,
                    files,
                }
            }
            Outcome::Failed(problem) => Self::Failed {
                label,
                variant,
                version: env!("CARGO_PKG_VERSION"),
                scene: report.any_run().map(|run| run.scene.as_str()),
                method: entry.info.id,
                settings: &entry.settings,
                error: None,
                failed: problem,
                reference_ms,
                reference_file,
                files,
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
        let settings = Map::new();
        Entry { label: label.into(), variant: None, info, settings, is_truth: false, is_asked: true, outcome }
    }

    fn report() -> Report {
        let error = ErrorReport { image: None, reflector: None, projection_px: None };
        let picture = b"picture".to_vec();
        let pictures = Pictures { stem: "a".into(), picture: picture.clone(), flip: b"flip".to_vec(), crop: None };
        let measured = Measured { stats: stats(), error, unusable: None, pictures: Some(pictures) };
        let entries = vec![
            entry("drawn", Outcome::Measured(Box::new(measured))),
            entry("refused", Outcome::Failed("no <lenses> please".into())),
        ];
        let command = "catoptric compare 'a <scene>'".into();
        let reference = Reference::Traced(Box::new(stats()));
        Report { command, reference, picture, reflector_pixels: 0, error_of_nothing: None, crop: None, entries }
    }

    #[test]
    fn a_method_that_fails_is_listed_with_its_message() {
        let report = report();
        let json = |entry| serde_json::to_value(EntryJson::new(&report, entry, &["report.html"], true)).unwrap();
        let json: Vec<Value> = report.entries.iter().map(json).collect();
        assert_eq!(json[1]["failed"], "no <lenses> please");
        assert!(json[1]["error"].is_null() && json[1]["method"] == "reference" && json[1]["reference_ms"] == 10.0);
        assert!(json[0]["failed"].is_null() && json[0]["speedup"] == 1.0 && json[0]["counts"]["rays"] == 5);
        assert!(json[0]["picture"] == "a.png" && json[0]["flip_picture"] == "a-flip.png");
        let plot = plot::error_against_time(&report).unwrap_or_else(|_| panic!("no plot"));
        let page = page::page(&report, &plot).into_string();
        // "flip" in base64.
        for text in
            ["no &lt;lenses&gt; please", "something is &lt;odd&gt;", "given up", "data:image/png;base64,ZmxpcA=="]
        {
            assert!(page.contains(text), "{text}");
        }
        assert!(!page.contains("<scene>") && !page.contains("<odd>"));
    }
}
