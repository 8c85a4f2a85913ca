//! `catoptric render`: one picture.

pub(crate) mod watch;

use super::display::Display;
use super::{columns, pretty};
use crate::args::RenderArgs;
use crate::backend;
use crate::baked;
use crate::drawing::{Shot, check_samples};
use crate::failure::Failure;
use crate::parse::FileOrStream;
use crate::scene_source;
use crate::settings;
use crate::stats::Stats;
use crate::terminal::Terminal;
use catoptric::light::path_tracer::specular_mask;
use catoptric::methods;
use catoptric::output::{self, NewFolders};
use catoptric::picture::{self, PictureFormat};
use clap::ArgMatches;
use std::io::{self, IsTerminal, Write};

pub(crate) fn run(args: &RenderArgs, options: &ArgMatches, terminal: &Terminal) -> Result<String, Failure> {
    let method = methods::find(&args.method).map_err(Failure::usage)?;
    check_samples(args.draw.samples, method)?;
    let outputs = outputs(args)?;
    let shot = Shot::load(&args.scene, options, &args.view, &args.draw, args.frames, terminal)?;
    let given = args.set.iter().map(|(key, text)| (key.clone(), settings::value(text))).collect();
    baked::check_methods(&shot.bakes, &[&args.method])?;
    let chosen = settings::choose_baked(&args.method, &given, &shot)?;
    let _folders = make_writable(&outputs)?;
    backend::remark(&args.draw, shot.gpu.as_ref(), terminal);
    terminal.set_subject(&args.method);
    let drawing = shot.draw(&chosen, terminal)?;
    let stats = Stats::new(&shot, &chosen, &drawing);
    let format = args.output.path().and_then(PictureFormat::from_path).unwrap_or(PictureFormat::Png);
    let display = (format == PictureFormat::Png)
        .then(|| Display::new(&args.display, &drawing.scene, &drawing.view, &drawing.picture));
    let shown = display.map(|display| display.of(&drawing.picture));
    let shown = shown.as_ref().unwrap_or(&drawing.picture);
    args.output.write(|writer| writer.write_all(&picture::encode(format, shown)?))?;
    if let Some(path) = &args.mask {
        let mask = specular_mask(&drawing.scene, &drawing.view);
        picture::write_mask(path, drawing.view.width, drawing.view.height, &mask)?;
    }
    if let Some(output) = &args.stats {
        let json = pretty(&stats)?;
        output.write(|writer| writer.write_all(json.as_bytes()))?;
    }
    let mut warnings = stats.warnings.clone();
    warnings.extend(scene_source::remark_on_media(&args.method, &drawing.scene));
    warnings.extend(display.and_then(|display| display.remark()));
    warnings.extend(slower_than_tracing(&shot, &stats, terminal)?);
    terminal.warn(&warnings);
    Ok(terminal.closing(summary(args, &stats, terminal.verbose), &outputs))
}

/// Frames that are faster are not compared with the reference, in milliseconds.
const NOTICED_MS: f64 = 1000.0;

/// A frame that takes more than this many times as long as the reference is worth a word.
const MUCH_SLOWER: f64 = 10.0;

/// A warning where a frame has taken much longer than the reference would.
fn slower_than_tracing(shot: &Shot<'_>, stats: &Stats, terminal: &Terminal) -> Result<Option<String>, Failure> {
    let first = stats.frame_ms.first;
    if first < NOTICED_MS || ["reference", "auto"].contains(&stats.method) {
        return Ok(None);
    }
    let reference = shot.reference_ms(terminal)?;
    let id = stats.method;
    Ok((first > MUCH_SLOWER * reference).then(|| {
        format!("`{id}` took {first:.0} ms, the reference would take about {reference:.0} ms: try --method auto")
    }))
}

/// The files to be written, or standard output, each another one.
fn outputs(args: &RenderArgs) -> Result<Vec<FileOrStream>, Failure> {
    if args.output == FileOrStream::Stream && io::stdout().is_terminal() {
        let problem = "-o -: standard output is a terminal, which shows no pictures; lead it into a file or a program";
        return Err(Failure::usage(problem));
    }
    let mask = args.mask.clone().map(FileOrStream::File);
    let outputs: Vec<_> = [Some(args.output.clone()), args.stats.clone(), mask].into_iter().flatten().collect();
    for (index, one) in outputs.iter().enumerate() {
        if let Some(other) = outputs[..index].iter().find(|other| one.is_same_output(other)) {
            let same = one == other;
            let (one, other) = (one.output_name(), other.output_name());
            let problem = if same { format!("{one} is") } else { format!("{other} and {one} are one file,") };
            return Err(Failure::usage(format!("{problem} named for two outputs")));
        }
    }
    Ok(outputs)
}

/// Makes the folders of the outputs, and finds outputs that cannot be written before the work is done.
fn make_writable(outputs: &[FileOrStream]) -> Result<NewFolders, Failure> {
    let mut folders = NewFolders::default();
    for path in outputs.iter().filter_map(FileOrStream::path) {
        if let Some(folder) = path.parent() {
            let fail =
                |error: io::Error| Failure::input(format!("{}: cannot make its folder: {error}", path.display()));
            folders.create(folder).map_err(fail)?;
        }
        output::check_writable(path)?;
    }
    Ok(folders)
}

fn summary(args: &RenderArgs, stats: &Stats, verbose: bool) -> String {
    let [width, height] = stats.size;
    let time = &stats.frame_ms;
    let mut text = format!(
        "{}: {}, {width}x{height}, {} samples, order {}: {:.1} ms",
        args.output.output_name(),
        stats.method,
        stats.samples,
        stats.order,
        time.median
    );
    if stats.frames > 1 {
        text += &format!(" a frame ({:.1} to {:.1} over {} frames)", time.min, time.max, stats.frames);
    }
    if let Some(noise) = stats.noise {
        text += &format!(", noise {noise:.4}");
    }
    text += "\n";
    if let Some(chosen) = stats.chosen() {
        text += &format!("reflectors: {chosen}\n");
    }
    if verbose {
        for way in &stats.choices {
            text += &format!("  `{}`: {}, {}\n", way.object, way.method, way.reason);
        }
        if let Some(error_px) = stats.error_px {
            text += &format!("  largest error of a bundle of rays: {error_px:.3} px\n");
        }
        let ms = |times: &[(String, f64)], kind: &str| -> Vec<Vec<String>> {
            times.iter().map(|(name, time)| vec![format!("  {kind} {name}"), format!("{time:.2} ms")]).collect()
        };
        let mut rows = ms(&stats.setup_ms.0, "setup");
        rows.extend(ms(&stats.stages_ms.0, "frame"));
        let counts = stats.counts.named.iter().map(|(name, count)| vec![format!("  {name}"), count.to_string()]);
        rows.extend(counts);
        let fallbacks = stats.counts.fallbacks.iter();
        rows.extend(fallbacks.map(|(name, count)| vec![format!("  fallback {name}"), count.to_string()]));
        rows.extend(stats.bytes.iter().map(|(name, count)| vec![format!("  bytes {name}"), count.to_string()]));
        text += &columns(&rows);
    }
    text
}
