//! `catoptric compare`: methods side by side against the reference.

mod selection;
mod staging;
mod truth;

use super::columns;
use super::render::inputs::{files_of, named as named_inputs, refuse_inputs};
use crate::args::CompareArgs;
use crate::backend;
use crate::baked;
use crate::drawing::{Drawing, Shot, check_samples};
use crate::failure::{Failure, Output};
use crate::parse::Region;
use crate::report::{self, Crop, Entry, Measured, Outcome, Pictures, PlainNames, Reference, Report};
use crate::settings::{self, Chosen};
use crate::stats::Stats;
use crate::terminal::Terminal;
use catoptric::framebuffer::Framebuffer;
use catoptric::methods::projection::measure::round_trip::{RoundTrip, RoundTripOptions, round_trip_without};
use catoptric::methods::{self, Quality};
use catoptric::metrics::heat_map_rgb8;
use catoptric::output;
use catoptric::picture::{self, PictureFormat};
use clap::ArgMatches;
use selection::{REFERENCE, Selected};
use staging::Staging;
use std::collections::HashSet;
use std::ffi::OsString;
use std::io::Write;
use std::path::{Path, PathBuf};
use truth::{OtherPicture, Truth};

/// White between the parts of pictures that stand side by side, in pixels.
const GAP: usize = 2;
/// The name of the parts' picture, without its extension.
const CROP_STEM: &str = "crop";

/// A method that is to be drawn and measured.
struct Compared<'a> {
    wanted: &'a Selected,
    chosen: Chosen,
    /// True for the run that all are measured against.
    is_truth: bool,
    /// The beginning of its pictures' names.
    stem: String,
}

/// Compares; `words` are those of the command line, for the report.
pub(crate) fn run(
    args: &CompareArgs,
    options: &ArgMatches,
    (words, terminal): (&[OsString], &Terminal),
) -> Result<Output, Failure> {
    let selected = selection::select(&args.method, &args.set, args.reference.is_none())?;
    for wanted in &selected.methods {
        check_samples(args.draw.samples, methods::find(&wanted.id).map_err(Failure::usage)?)?;
    }
    check_crop(args)?;
    let other = args.reference.as_deref().map(|path| OtherPicture::read(path, args)).transpose()?;
    let shot = Shot::load(&args.scene, options, &args.view, &args.draw, args.frames, terminal)?;
    let ids: Vec<&str> = selected.methods.iter().map(|wanted| wanted.id.as_str()).collect();
    baked::check_methods(&shot.bakes, &ids)?;
    let truth_method = match other {
        None => Some(settings::choose(REFERENCE, &shot.model, &selected.truth)?),
        Some(_) => None,
    };
    let compared = compared(&selected.methods, &shot, truth_method.as_ref())?;
    let stems: Vec<String> = compared.iter().filter(|it| !it.is_truth).map(|it| it.stem.clone()).collect();
    let files = report::names(args.report.pictures.then_some(&stems), args.report.crop.is_some());
    let settings = selected.methods.iter().map(|wanted| &wanted.settings).chain([&selected.truth]);
    let settings = settings.flat_map(|settings| settings.values().filter_map(toml::Value::as_str));
    let inputs = named_inputs(&args.scene, &args.draw, settings);
    check_outputs(args, &files, inputs.clone())?;
    let plain = plain_names(args, words, files_of(inputs).into_keys());
    backend::remark(&args.draw, shot.gpu.as_ref(), terminal);
    let staging = Staging::new(&args.report.report, &files)?;
    // The report's folder, where they may be, is there now.
    [&args.report.csv, &args.report.latex].into_iter().flatten().try_for_each(|table| output::check_writable(table))?;

    let truth = match (other, &truth_method) {
        (None, Some(method)) => {
            terminal.set_subject(REFERENCE);
            let drawing = shot.draw_whole(method, terminal)?;
            Truth::of_drawing(&args.display, &drawing, stats(&shot, method, &drawing))?
        }
        (Some(other), _) => Truth::of_file(&args.display, other, &shot)?,
        (None, None) => return Err(nothing_to_measure_against()),
    };
    let (entries, crop) = measured(args, &shot, &truth, compared, terminal)?;
    let mut report = Report {
        command: command_line(words.iter().skip(1).map(|word| plain.of(&word.to_string_lossy()))),
        picture: png(&truth.shown)?,
        reflector_pixels: truth.reflector_pixels(),
        error_of_nothing: truth.error_of_nothing,
        reference: match (&truth.own, &args.reference) {
            (None, Some(path)) => Reference::File(file_name(path)),
            (own, _) => Reference::Traced(Box::new(own.clone().ok_or_else(nothing_to_measure_against)?)),
        },
        crop,
        entries,
    };
    // The scene's own warnings are said once, not of each method.
    let of_scene = &shot.model.warnings;
    let of_methods = report.measured().flat_map(|(entry, measured)| {
        let own = measured.stats.warnings.iter().filter(|text| !of_scene.contains(text));
        own.map(|text| named(&entry.label, text))
    });
    let warnings: Vec<String> = of_scene.iter().cloned().chain(of_methods).collect();
    let failures = report.entries.iter().filter_map(|entry| match &entry.outcome {
        Outcome::Failed(problem) => Some(format!("{} was left out: {problem}", entry.label)),
        Outcome::Measured(_) => None,
    });
    let failures: Vec<String> = failures.collect();
    terminal.warn(&warnings);
    terminal.warn(&truth.display.remark().into_iter().collect::<Vec<_>>());
    if !report.measured().any(|(entry, _)| entry.is_asked) {
        let reasons = failures.join("; ");
        return Err(Failure::input(format!("{}: no method could draw this scene: {reasons}", shot.model.name)));
    }
    terminal.errors(&failures);
    let text = summary(args, &report);
    plain.apply(&mut report);
    report::write(staging.path(), &report, args.report.pictures)?;
    staging.publish()?;
    for (path, bytes) in tables(args, &report) {
        output::write_file(path, |writer| writer.write_all(&bytes))?;
    }
    let code = u8::from(!failures.is_empty());
    Ok(Output { text: terminal.unless_quiet(text), code })
}

fn nothing_to_measure_against() -> Failure {
    Failure::input("--reference: there is nothing to measure against")
}

/// The part of the pictures that is shown by itself lies in them.
fn check_crop(args: &CompareArgs) -> Result<(), Failure> {
    let [width, height] = args.view.size;
    match &args.report.crop {
        Some(crop) if !crop.is_within(args.view.size) => {
            let ([x, y], [w, h]) = (crop.corner, crop.size);
            let problem = format!("--crop {x},{y},{w},{h} is not within the pictures of --size {width}x{height}");
            Err(Failure::usage(problem))
        }
        _ => Ok(()),
    }
}

/// Refuses outputs that are inputs, or one file, before any work.
fn check_outputs(args: &CompareArgs, files: &[String], inputs: Vec<PathBuf>) -> Result<(), Failure> {
    let folder = &args.report.report;
    let mut names: Vec<String> = report::files_of(folder).unwrap_or_default();
    names.extend_from_slice(files);
    let in_folder: Vec<PathBuf> = names.iter().map(|name| folder.join(name)).collect();
    let tables: Vec<&Path> =
        [&args.report.csv, &args.report.latex].into_iter().flatten().map(PathBuf::as_path).collect();
    for (index, table) in tables.iter().enumerate() {
        let before = in_folder.iter().map(PathBuf::as_path).chain(tables[..index].iter().copied());
        if before.into_iter().any(|other| output::is_same_file(other, table)) {
            return Err(Failure::usage(format!("{} is named for two outputs", table.display())));
        }
    }
    let outputs = || in_folder.iter().map(PathBuf::as_path).chain(tables.iter().copied());
    if let Some(reference) = &args.reference
        && outputs().any(|output| output::is_same_file(output, reference))
    {
        let problem = "is the picture to measure against, and would be replaced; write to another place";
        return Err(Failure::usage(format!("--reference {}: {problem}", reference.display())));
    }
    refuse_inputs(outputs(), inputs)
}

/// The methods with their settings and the names of their pictures.
fn compared<'a>(
    methods: &'a [Selected],
    shot: &Shot<'_>,
    truth: Option<&Chosen>,
) -> Result<Vec<Compared<'a>>, Failure> {
    let mut stems = HashSet::from([REFERENCE, CROP_STEM].map(String::from));
    let compared = methods.iter().map(|wanted| {
        let chosen = shot.choose(&wanted.id, &wanted.settings)?;
        let is_truth = truth.is_some_and(|truth| chosen.info.id == REFERENCE && chosen.settings == truth.settings);
        let stem = if is_truth { REFERENCE.to_owned() } else { unique(&mut stems, wanted.file_stem()) };
        Ok(Compared { wanted, chosen, is_truth, stem })
    });
    compared.collect()
}

/// Draws and measures all methods; an entry for the truth is there in any case. The crop has all of them.
fn measured(
    args: &CompareArgs,
    shot: &Shot<'_>,
    truth: &Truth,
    compared: Vec<Compared<'_>>,
    terminal: &Terminal,
) -> Result<(Vec<Entry>, Option<Crop>), Failure> {
    let mut row = args.report.crop.map(|region| Row { region, parts: vec![part(&truth.shown, region)] });
    let mut entries = Vec::new();
    if let Some(stats) = &truth.own
        && !compared.iter().any(|it| it.is_truth)
    {
        let chosen = settings::choose(REFERENCE, &shot.model, &toml::Table::new())?;
        let outcome = Outcome::Measured(Box::new(measured_truth(truth, stats)?));
        let (settings, info) = (stats.settings.clone(), chosen.info);
        let label = REFERENCE.to_owned();
        entries.push(Entry { label, variant: None, info, settings, is_truth: true, is_asked: false, outcome });
    }
    for it in compared {
        terminal.set_subject(&it.wanted.label);
        let result = match &truth.own {
            Some(stats) if it.is_truth => measured_truth(truth, stats),
            _ => measure(shot, truth, &it, args.projection_every, row.as_mut(), terminal),
        };
        let outcome = match result {
            Ok(measured) => Outcome::Measured(Box::new(measured)),
            Err(Failure::Usage(problem)) => Outcome::Failed(problem),
            Err(Failure::Input(error)) => Outcome::Failed(error.to_string()),
        };
        entries.push(Entry {
            label: it.wanted.label.clone(),
            variant: it.wanted.variant.clone(),
            info: it.chosen.info,
            settings: settings::effective(it.chosen.info, &it.chosen.settings),
            is_truth: it.is_truth,
            is_asked: true,
            outcome,
        });
    }
    let crop = row.map(|row| row.finish(&truth.shown)).transpose()?;
    Ok((entries, crop))
}

fn measured_truth(truth: &Truth, stats: &Stats) -> Result<Measured, Failure> {
    Ok(Measured { stats: stats.clone(), error: truth.own_errors()?, unusable: None, pictures: None })
}

/// Draws and measures one method.
fn measure(
    shot: &Shot<'_>,
    truth: &Truth,
    it: &Compared<'_>,
    every: u32,
    row: Option<&mut Row>,
    terminal: &Terminal,
) -> Result<Measured, Failure> {
    let mut drawing = shot.draw(&it.chosen, terminal)?;
    // Where points appear is known by paths of our own reference.
    let projection_px = match truth.own {
        Some(_) => projection_error(shot.quality, &mut drawing, every, terminal)?,
        None => None,
    };
    let (comparison, mut error) = truth.compare(&drawing.picture)?;
    error.projection_px = projection_px;
    let shown = truth.display.of(&drawing.picture);
    let ranking_error = error.reflector.or(error.image).map(|error| error.flip_mean);
    let crop = row.map(|row| row.add(&shown)).transpose()?;
    let flip = picture::encode_rgb8(comparison.width, comparison.height, &heat_map_rgb8(&comparison.flip));
    let pictures = Pictures { stem: it.stem.clone(), picture: png(&shown)?, flip: flip.map_err(in_memory)?, crop };
    let unusable = truth.fault(&shown, ranking_error);
    Ok(Measured { stats: stats(shot, &it.chosen, &drawing), error, unusable, pictures: Some(pictures) })
}

/// The run, of a scene that has no folder in its name.
fn stats(shot: &Shot<'_>, chosen: &Chosen, drawing: &Drawing) -> Stats {
    let stats = Stats::new(shot, chosen, drawing);
    let is_file = !stats.scene.starts_with("builtin:");
    Stats { scene: if is_file { file_name(Path::new(&stats.scene)) } else { stats.scene }, ..stats }
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).display().to_string()
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

/// Parts of all pictures, side by side.
struct Row {
    region: Region,
    /// 8-bit sRGB, three numbers a pixel.
    parts: Vec<Vec<u8>>,
}

impl Row {
    /// Adds the part of a picture, and gives it by itself.
    fn add(&mut self, shown: &Framebuffer) -> Result<Vec<u8>, Failure> {
        let part = part(shown, self.region);
        let [width, height] = self.region.size;
        let png = picture::encode_rgb8(width, height, &part).map_err(in_memory)?;
        self.parts.push(part);
        Ok(png)
    }

    fn finish(mut self, reference: &Framebuffer) -> Result<Crop, Failure> {
        let first = self.add(reference)?;
        self.parts.pop();
        let [width, height] = self.region.size.map(|side| side as usize);
        let whole_width = (width + GAP) * self.parts.len() - GAP;
        let mut pixels = vec![255; 3 * whole_width * height];
        for (index, part) in self.parts.iter().enumerate() {
            for (line, from) in pixels.chunks_exact_mut(3 * whole_width).zip(part.chunks_exact(3 * width)) {
                let left = 3 * index * (width + GAP);
                line[left..left + 3 * width].copy_from_slice(from);
            }
        }
        let row = picture::encode_rgb8(whole_width as u32, height as u32, &pixels).map_err(in_memory)?;
        Ok(Crop { region: self.region, picture: first, row })
    }
}

/// A part of a picture as it is shown, 8-bit sRGB.
fn part(shown: &Framebuffer, region: Region) -> Vec<u8> {
    let [width, height] = region.size;
    Framebuffer::of_pixels(width, height, region.of(&shown.pixels, shown.width)).to_srgb8()
}

fn png(shown: &Framebuffer) -> Result<Vec<u8>, Failure> {
    picture::encode(PictureFormat::Png, shown).map_err(in_memory)
}

fn in_memory(error: std::io::Error) -> Failure {
    Failure::input(format!("a picture of the report cannot be encoded: {error}"))
}

/// A warning with the method's name before it.
fn named(label: &str, warning: &str) -> String {
    let id = label.split(':').next().unwrap_or(label);
    match warning.strip_prefix(id).is_some_and(|rest| rest.starts_with(':')) {
        true => warning.to_owned(),
        false => format!("{label}: {warning}"),
    }
}

/// The names of files that texts of the report have without their folders.
fn plain_names(args: &CompareArgs, words: &[OsString], inputs: impl Iterator<Item = PathBuf>) -> PlainNames {
    let files = [&args.report.report].into_iter().chain(&args.reference).cloned();
    PlainNames::new(words, files.chain(inputs))
}

/// The files of the table, and what they hold.
fn tables<'a>(args: &'a CompareArgs, report: &Report) -> Vec<(&'a Path, Vec<u8>)> {
    let csv = args.report.csv.as_deref().map(|path| (path, report::csv(report)));
    let latex = args.report.latex.as_deref().map(|path| (path, report::latex(report).into_bytes()));
    csv.into_iter().chain(latex).collect()
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
    let mut text = columns(&report::console(report));
    for (entry, measured) in report.measured() {
        if let Some(reason) = measured.unusable {
            text += &format!("{}: the picture is {reason}\n", entry.label);
        }
    }
    if let Reference::File(name) = &report.reference {
        text += &format!("measured against {name}\n");
    }
    if report.any_left_to_tiles() {
        text += report::PROJECTION_REMARK;
        text += "\n";
    }
    for path in [&args.report.csv, &args.report.latex].into_iter().flatten() {
        text += &format!("{}\n", path.display());
    }
    text + &format!("{}\n", args.report.report.join(report::PAGE).display())
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
