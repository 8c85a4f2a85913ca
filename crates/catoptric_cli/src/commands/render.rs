//! `catoptric render`: a picture, or the frames of a sequence.

pub(super) mod inputs;
mod passes;
mod pictures;
mod plan;
pub(crate) mod watch;

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
use catoptric::methods;
use catoptric::output::{self, NewFolders};
use clap::ArgMatches;
use passes::Passes;
use pictures::Pictures;
use plan::Plan;
use std::io::{self, IsTerminal, Write};

pub(crate) fn run(args: &RenderArgs, options: &ArgMatches, terminal: &Terminal) -> Result<String, Failure> {
    let (id, variant) = args.method.split_once(':').map_or((args.method.as_str(), None), |(id, it)| (id, Some(it)));
    let method = methods::find(id).map_err(Failure::usage)?;
    check_samples(args.draw.samples, method)?;
    if args.draw.budget_ms.is_some() && id == "auto" {
        let problem = "`auto` draws what other methods leave when their time is up, and has no budget itself";
        return Err(Failure::usage(format!("--budget-ms: {problem}; name another --method")));
    }
    let plan = Plan::new(args, options)?;
    let outputs = outputs(args, &plan)?;
    let inputs = inputs::of_render(args);
    inputs::refuse_inputs(outputs.iter().filter_map(FileOrStream::path), inputs)?;
    let mut shot = Shot::load(&args.scene, options, &args.view, &args.draw, plan.sequence, terminal)?;
    if args.picture.transparent {
        shot.hide_background();
    }
    if args.picture.transparent || args.picture.layers {
        // Coverage and first surfaces are found as the CPU draws them.
        shot.gpu = None;
    }
    let mut given: toml::Table = args.set.iter().map(|(key, text)| (key.clone(), settings::value(text))).collect();
    given.extend(settings::of_variant(&args.method, variant)?);
    baked::check_methods(&shot.bakes, &[id])?;
    let chosen = shot.choose(id, &given)?;
    let _folders = make_writable(&outputs)?;
    backend::remark(&args.draw, shot.gpu.as_ref(), terminal);
    terminal.set_subject(id);
    let passes = Passes::new(&chosen, shot.quality)?;
    let mut pictures = Pictures { args, plan: &plan, passes, display: None };
    let drawing = match plan.writes_all {
        true => shot.draw_each(&chosen, &mut |frame, drawing| pictures.write(frame, drawing), terminal)?,
        false => shot.draw(&chosen, terminal)?,
    };
    if !plan.writes_all {
        let _ = pictures.write(0, &drawing)?;
    }
    let stats = Stats::new(&shot, &chosen, &drawing);
    if let Some(output) = &args.stats {
        let json = pretty(&stats)?;
        output.write(|writer| writer.write_all(json.as_bytes()))?;
    }
    let mut warnings = stats.warnings.clone();
    warnings.extend(scene_source::remark_on_media(id, &drawing.scene));
    warnings.extend(pictures.display.and_then(|display| display.remark()));
    warnings.extend(plan.remark(&shot));
    warnings.extend(slower_than_tracing(&shot, &stats, terminal)?);
    terminal.warn(&warnings);
    let mut text = summary(args, &stats, terminal.verbose);
    text += &plan.summary(&shot);
    Ok(terminal.closing(text, &outputs))
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

/// The files to be written, or standard output, each another one; of frames the first one's.
fn outputs(args: &RenderArgs, plan: &Plan) -> Result<Vec<FileOrStream>, Failure> {
    if args.output == FileOrStream::Stream && io::stdout().is_terminal() {
        let problem = "-o -: standard output is a terminal, which shows no pictures; lead it into a file or a program";
        return Err(Failure::usage(problem));
    }
    let first = plan.sequence.first;
    let outputs = [Some(plan.picture(args, first)), args.stats.clone(), plan.mask(args, first)];
    let outputs: Vec<_> = outputs.into_iter().flatten().collect();
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
