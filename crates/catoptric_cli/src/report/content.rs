//! The contents of a report.

use crate::parse::Region;
use crate::stats::{ErrorReport, Stats};
use catoptric::methods::MethodInfo;
use serde_json::{Map, Value};

/// The contents of the report.
pub(crate) struct Report {
    /// The command that made it.
    pub(crate) command: String,
    pub(crate) reference: Reference,
    /// The reference's picture as it is shown, PNG.
    pub(crate) picture: Vec<u8>,
    /// The number of pixels that show a reflector or lens.
    pub(crate) reflector_pixels: usize,
    /// The mean FLIP, where methods are ranked, of the reference's picture with black in that place.
    pub(crate) error_of_nothing: Option<f64>,
    pub(crate) crop: Option<Crop>,
    /// With our own reference one of them is the truth.
    pub(crate) entries: Vec<Entry>,
}

/// The origin of the picture that all are measured against.
pub(crate) enum Reference {
    /// The run of our own reference.
    Traced(Box<Stats>),
    /// The name of a file.
    File(String),
}

/// A part of all pictures, shown side by side.
pub(crate) struct Crop {
    pub(crate) region: Region,
    /// The reference's picture, PNG.
    pub(crate) picture: Vec<u8>,
    /// All side by side, the reference first, PNG.
    pub(crate) row: Vec<u8>,
}

/// One method, or one variant of it.
pub(crate) struct Entry {
    /// The argument of `--method`: `ID` or `ID:KEY=VALUE,...`.
    pub(crate) label: String,
    pub(crate) variant: Option<String>,
    pub(crate) info: &'static MethodInfo,
    pub(crate) settings: Map<String, Value>,
    /// True for the run that all are measured against.
    pub(crate) is_truth: bool,
    /// True if it was to be compared; others are shown in tables alone.
    pub(crate) is_asked: bool,
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
    /// Why the picture cannot be used; `None` for pictures that can.
    pub(crate) unusable: Option<&'static str>,
    /// The pictures; `None` for the reference itself.
    pub(crate) pictures: Option<Pictures>,
}

/// A method's pictures, PNG.
pub(crate) struct Pictures {
    /// The beginning of their names as separate files.
    pub(crate) stem: String,
    pub(crate) picture: Vec<u8>,
    pub(crate) flip: Vec<u8>,
    pub(crate) crop: Option<Vec<u8>>,
}

impl Pictures {
    pub(super) fn names(&self) -> [String; 2] {
        names_of(&self.stem)
    }
}

impl Measured {
    /// The mean FLIP that methods are ranked by: of the reflectors where there are any, else of the picture.
    pub(crate) fn ranking_error(&self) -> Option<f64> {
        self.error.reflector.or(self.error.image).map(|error| error.flip_mean)
    }
}

impl Entry {
    pub(crate) fn measured(&self) -> Option<&Measured> {
        match &self.outcome {
            Outcome::Measured(measured) => Some(measured),
            Outcome::Failed(_) => None,
        }
    }
}

impl Report {
    /// True if tiles have drawn paths in the place of any method.
    pub(crate) fn any_left_to_tiles(&self) -> bool {
        self.measured().any(|(_, measured)| measured.stats.share_left_to_tiles() > 0.0)
    }

    /// The methods that drew the scene.
    pub(crate) fn measured(&self) -> impl Iterator<Item = (&Entry, &Measured)> {
        self.entries.iter().filter_map(|entry| Some((entry, entry.measured()?)))
    }

    /// The methods without the run that all are measured against, and their numbers for colours and shapes.
    pub(super) fn methods(&self) -> impl Iterator<Item = (usize, &Entry)> {
        self.entries.iter().filter(|entry| !entry.is_truth).enumerate()
    }

    /// The reference's time of a frame: of the truth, else of the method `reference` where it is compared.
    pub(crate) fn reference_ms(&self) -> Option<f64> {
        match &self.reference {
            Reference::Traced(stats) => Some(stats.frame_ms.median),
            Reference::File(_) => {
                let is_reference = |(entry, _): &(&Entry, &Measured)| entry.info.id == "reference";
                self.measured().find(is_reference).map(|(_, measured)| measured.stats.frame_ms.median)
            }
        }
    }

    /// Warnings of every one of several runs: they are about the scene.
    pub(super) fn warnings_of_all(&self) -> Vec<&str> {
        let runs: Vec<&Stats> = self.measured().map(|(_, measured)| &measured.stats).collect();
        let Some((first, others)) = runs.split_first().filter(|(_, others)| !others.is_empty()) else {
            return Vec::new();
        };
        let is_of_all = |text: &&String| others.iter().all(|run| run.warnings.contains(text));
        first.warnings.iter().filter(is_of_all).map(String::as_str).collect()
    }

    /// A run, for what is the same in all of them; `None` where nothing was drawn.
    pub(super) fn any_run(&self) -> Option<&Stats> {
        match &self.reference {
            Reference::Traced(stats) => Some(stats),
            Reference::File(_) => self.measured().next().map(|(_, measured)| &measured.stats),
        }
    }
}

/// The names of a method's separate pictures.
pub(super) fn names_of(stem: &str) -> [String; 2] {
    [format!("{stem}.png"), format!("{stem}-flip.png")]
}
