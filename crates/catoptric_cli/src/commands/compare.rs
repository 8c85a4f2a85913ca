//! `catoptric compare`: methods side by side against the reference.

mod selection;

use super::columns;
use super::display::Display;
use crate::args::CompareArgs;
use crate::backend;
use crate::baked;
use crate::drawing::{Drawing, Shot, check_samples};
use crate::failure::{Failure, Output};
use crate::report::{self, Entry, Measured, Outcome, Report};
use crate::settings::{self, Chosen};
use crate::stats::{ErrorReport, Stats};
use crate::terminal::Terminal;
use catoptric::framebuffer::Framebuffer;
use catoptric::light::path_tracer::specular_mask;
use catoptric::methods::projection::measure::round_trip::{
    RoundTrip, RoundTripError, RoundTripOptions, round_trip_without,
};
use catoptric::methods::{self, Quality};
use catoptric::metrics::{Comparison, heat_map_rgb8};
use catoptric::output::{self, NewFolders, TemporaryFolder};
use catoptric::picture;
use clap::ArgMatches;
use selection::Selected;
use std::collections::HashSet;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// The reference's picture, against which every method is measured.
struct Truth {
    drawing: Drawing,
    /// Of all pictures.
    display: Display,
    stats: Stats,
    /// The pixels that show a reflector or lens.
    mask: Vec<bool>,
    /// Projections are measured at every n-th pixel of every n-th row.
    projection_every: u32,
}

/// Compares; `words` are those of the command line, for the report.
pub(crate) fn run(
    args: &CompareArgs,
    options: &ArgMatches,
    (words, terminal): (&[OsString], &Terminal),
) -> Result<Output, Failure> {
    let selected = selection::select(&args.method, &args.set)?;
    for wanted in &selected.methods {
        check_samples(args.draw.samples, methods::find(&wanted.id).map_err(Failure::usage)?)?;
    }
    let shot = Shot::load(&args.scene, options, &args.view, &args.draw, args.frames, terminal)?;
    let truth_method = settings::choose("reference", &shot.model, &selected.truth)?;
    let mut methods = Vec::new();
    let ids: Vec<&str> = selected.methods.iter().map(|wanted| wanted.id.as_str()).collect();
    baked::check_methods(&shot.bakes, &ids)?;
    for wanted in &selected.methods {
        methods.push((wanted, settings::choose_baked(&wanted.id, &wanted.settings, &shot)?));
    }
    backend::remark(&args.draw, shot.gpu.as_ref(), terminal);
    let staging = Staging::new(&args.report)?;
    let folder = staging.path();

    terminal.set_subject("reference");
    let drawing = shot.draw_whole(&truth_method, terminal)?;
    let mask = specular_mask(&drawing.scene, &drawing.view);
    let stats = Stats::new(&shot, &truth_method, &drawing);
    let display = Display::new(&args.display, &drawing.scene, &drawing.view, &drawing.picture);
    picture::write(&folder.join("reference.png"), &display.of(&drawing.picture))?;
    let truth = Truth { drawing, display, stats, mask, projection_every: args.projection_every };

    let mut entries = Vec::new();
    let mut stems = HashSet::from(["reference".to_owned()]);
    for (wanted, chosen) in methods {
        terminal.set_subject(&wanted.label);
        let is_truth = chosen.info.id == "reference" && chosen.settings == truth_method.settings;
        let stem = if is_truth { "reference".to_owned() } else { unique(&mut stems, wanted.file_stem()) };
        let outcome = match measure(&shot, &truth, &chosen, is_truth, folder, &stem, terminal) {
            Ok(measured) => Outcome::Measured(Box::new(measured)),
            Err(Failure::Usage(problem)) => Outcome::Failed(problem),
            Err(Failure::Input(error)) => Outcome::Failed(error.to_string()),
        };
        entries.push(entry(wanted, &chosen, is_truth, outcome));
    }

    let report = Report {
        command: command_line(words.iter().skip(1).map(|word| word.to_string_lossy().into_owned())),
        truth: truth.stats,
        reflector_pixels: truth.mask.iter().filter(|set| **set).count(),
        entries,
    };
    report::write(folder, &report)?;
    // The scene's own warnings are said once, not of each method.
    let of_scene = &shot.model.warnings;
    let of_methods = report.measured().flat_map(|(entry, measured)| {
        let own = measured.stats.warnings.iter().filter(|text| !of_scene.contains(text));
        own.map(|text| format!("{}: {text}", entry.label))
    });
    let warnings: Vec<String> = of_scene.iter().cloned().chain(of_methods).collect();
    let failures = report.entries.iter().filter_map(|entry| match &entry.outcome {
        Outcome::Failed(problem) => Some(format!("{} was left out: {problem}", entry.label)),
        Outcome::Measured(_) => None,
    });
    let failures: Vec<String> = failures.collect();
    terminal.warn(&warnings);
    terminal.warn(&display.remark().into_iter().collect::<Vec<_>>());
    if report.measured().next().is_none() {
        let reasons = failures.join("; ");
        return Err(Failure::input(format!("{}: no method could draw this scene: {reasons}", shot.model.name)));
    }
    terminal.errors(&failures);
    staging.publish()?;
    let code = u8::from(!failures.is_empty());
    Ok(Output { text: terminal.unless_quiet(summary(args, &report)), code })
}

fn entry(wanted: &Selected, chosen: &Chosen, is_truth: bool, outcome: Outcome) -> Entry {
    Entry {
        label: wanted.label.clone(),
        variant: wanted.variant.clone(),
        info: chosen.info,
        settings: settings::effective(chosen.info, &chosen.settings),
        is_truth,
        outcome,
    }
}

/// Draws and measures one method and writes its pictures.
fn measure(
    shot: &Shot<'_>,
    truth: &Truth,
    chosen: &Chosen,
    is_truth: bool,
    folder: &Path,
    stem: &str,
    terminal: &Terminal,
) -> Result<Measured, Failure> {
    let drawn;
    let (drawing, stats, projection_px) = if is_truth {
        (&truth.drawing, truth.stats.clone(), None)
    } else {
        let mut new = shot.draw(chosen, terminal)?;
        let projection_px = projection_error(shot.quality, &mut new, truth.projection_every, terminal)?;
        drawn = new;
        let stats = Stats::new(shot, chosen, &drawn);
        (&drawn, stats, projection_px)
    };
    let display = &truth.display;
    let comparison = Comparison::new(&display.exposed(&drawing.picture), &display.exposed(&truth.drawing.picture))?;
    let error = ErrorReport { image: comparison.whole(), reflector: comparison.masked(&truth.mask)?, projection_px };
    let (picture_name, flip_name) = (format!("{stem}.png"), format!("{stem}-flip.png"));
    if !is_truth {
        let shown = display.of(&drawing.picture);
        write_pictures(folder, (&picture_name, &shown), (&flip_name, &comparison))?;
    }
    let flip = (!is_truth).then_some(flip_name);
    Ok(Measured { stats, error, picture: picture_name, flip })
}

/// The method's projection error in pixels, by round trips on the paths that its own geometry has drawn; returns `None`
/// if it projects no points, and if something else has drawn all paths that are seen.
fn projection_error(
    quality: Quality,
    drawing: &mut Drawing,
    every: u32,
    terminal: &Terminal,
) -> Result<Option<RoundTrip>, Failure> {
    let Drawing { scene, view, prepared, .. } = drawing;
    let frame = prepared.frame(view, terminal)?;
    let Some(projector) = frame.projector() else { return Ok(None) };
    let options = RoundTripOptions { order: quality.order, every };
    let left = frame.paths_left(terminal)?;
    let found = round_trip_without(scene, view, (projector.as_ref(), &left), options, terminal)?;
    Ok(Some(found).filter(|found| left.is_empty() || found.all.count > 0))
}

fn write_pictures(
    folder: &Path,
    (picture_name, picture): (&str, &Framebuffer),
    (flip_name, comparison): (&str, &Comparison),
) -> Result<(), Failure> {
    picture::write(&folder.join(picture_name), picture)?;
    let heat = heat_map_rgb8(&comparison.flip);
    picture::write_rgb8(&folder.join(flip_name), comparison.width, comparison.height, &heat)?;
    Ok(())
}

/// A hidden folder beside the report's files, in which they are made before any of them appears.
struct Staging {
    // In this order: the report's folder goes if it is empty then.
    hidden: TemporaryFolder,
    _new: NewFolders,
    folder: PathBuf,
    /// Files of the report that is replaced.
    earlier: Vec<String>,
}

impl Staging {
    fn new(folder: &Path) -> Result<Self, Failure> {
        let fail = |error: std::io::Error| {
            Failure::input(format!("--report {}: cannot write into the folder: {error}", folder.display()))
        };
        let mut new = NewFolders::default();
        new.create(folder).map_err(fail)?;
        let earlier = match report::files_of(folder) {
            Some(earlier) => earlier,
            None => {
                let is_foreign = |name: std::ffi::OsString| !output::is_temporary(&name.to_string_lossy());
                let mut names =
                    std::fs::read_dir(folder).map_err(fail)?.filter_map(|entry| Some(entry.ok()?.file_name()));
                if let Some(name) = names.find(|name| is_foreign(name.clone())) {
                    let name = name.display();
                    return Err(Failure::usage(format!(
                        "--report {}: the folder has other files, such as `{name}`; name a new or empty one",
                        folder.display()
                    )));
                }
                Vec::new()
            }
        };
        let hidden = TemporaryFolder::within(folder).map_err(fail)?;
        Ok(Self { hidden, _new: new, folder: folder.into(), earlier })
    }

    fn path(&self) -> &Path {
        self.hidden.path()
    }

    /// Moves all files to where they belong, the page last.
    fn publish(self) -> Result<(), Failure> {
        let fail = |error: std::io::Error| {
            Failure::input(format!("--report {}: cannot move files into it: {error}", self.folder.display()))
        };
        let mut names = Vec::new();
        for entry in std::fs::read_dir(self.path()).map_err(fail)? {
            names.push(entry.map_err(fail)?.file_name());
        }
        names.sort_by_key(|name| name == "report.html");
        for name in self.earlier.iter().filter(|name| !names.iter().any(|new| new == name.as_str())) {
            // A file that is missing already is as good as removed.
            let _ = std::fs::remove_file(self.folder.join(name));
        }
        for name in names {
            output::move_file(&self.path().join(&name), &self.folder.join(&name)).map_err(fail)?;
        }
        Ok(())
    }
}

fn unique(taken: &mut HashSet<String>, stem: String) -> String {
    let mut name = stem.clone();
    let mut number = 2;
    while !taken.insert(name.clone()) {
        name = format!("{stem}-{number}");
        number += 1;
    }
    name
}

/// The command as it can be typed again.
fn command_line(words: impl Iterator<Item = String>) -> String {
    let quoted = words.map(|word| output::shell_word(&word));
    std::iter::once("catoptric".to_owned()).chain(quoted).collect::<Vec<_>>().join(" ")
}

fn summary(args: &CompareArgs, report: &Report) -> String {
    let header = [
        "method",
        "FLIP reflectors",
        "drawn by",
        "FLIP picture",
        "RMSE picture",
        "px p50",
        "px p99",
        "missing",
        "invented",
        "frame ms",
    ];
    let mut rows = vec![header.map(String::from).to_vec()];
    for (entry, measured) in report.measured() {
        let flip = |error: &Option<catoptric::metrics::PictureError>| {
            error.map_or("none".into(), |error| format!("{:.4}", error.flip_mean))
        };
        let projection = measured.error.projection_px.as_ref().map(|error| error.all);
        let pixels = |part: fn(&RoundTripError) -> Option<f64>| {
            projection.as_ref().and_then(part).map_or("–".into(), |error| format!("{error:.4}"))
        };
        let share = |part: fn(&RoundTripError) -> f64| {
            projection.as_ref().map(part).map_or("–".into(), |share| format!("{:.2} %", share * 100.0))
        };
        rows.push(vec![
            entry.label.clone(),
            flip(&measured.error.reflector),
            measured.stats.drawn_by.map_or("–".into(), |drawn_by| drawn_by.words()),
            flip(&measured.error.image),
            measured.error.image.map_or("none".into(), |error| format!("{:.5}", error.rmse)),
            pixels(|error| error.p50),
            pixels(|error| error.p99),
            share(|error| error.missing),
            share(|error| error.invented),
            format!("{:.1}", measured.stats.frame_ms.median),
        ]);
    }
    let remark = if report.any_left_to_tiles() { format!("{}\n", report::PROJECTION_REMARK) } else { String::new() };
    format!("{}{remark}{}\n", columns(&rows), args.report.join("report.html").display())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn command_lines_can_be_typed_again() {
        let words = ["compare", "builtin:a?b=1&c=2", "--lens", "Glass *:1.5", "it's", ""].map(String::from);
        let line = command_line(words.into_iter());
        assert_eq!(line, r"catoptric compare 'builtin:a?b=1&c=2' --lens 'Glass *:1.5' 'it'\''s' ''");
    }

    #[test]
    fn stems_are_unique() {
        let mut taken = HashSet::from(["reference".to_owned()]);
        assert_eq!(unique(&mut taken, "a".into()), "a");
        assert_eq!(unique(&mut taken, "a".into()), "a-2");
        assert_eq!(unique(&mut taken, "reference".into()), "reference-2");
    }
}
