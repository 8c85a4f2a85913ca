//! Which frames of which files a command line asks for, before any work.

use crate::args::{Backend, Bits, Motion, RenderArgs, Sequence};
use crate::drawing::Shot;
use crate::failure::Failure;
use crate::parse::{FileOrStream, FramesWanted, NamePattern};
use catoptric::picture::PictureFormat;
use clap::ArgMatches;
use clap::parser::ValueSource;
use std::path::Path;

/// The files of a command line.
pub(super) struct Plan {
    pub(super) format: PictureFormat,
    pub(super) sequence: Sequence,
    /// Every frame is written, not the last one alone.
    pub(super) writes_all: bool,
    picture: Option<NamePattern>,
    mask: Option<NamePattern>,
}

impl Plan {
    pub(super) fn new(args: &RenderArgs, options: &ArgMatches) -> Result<Self, Failure> {
        let format = format(args)?;
        check_region(args)?;
        let picture = pattern(args.output.path())?;
        let mask = pattern(args.picture.mask.as_deref())?;
        let is_stream = args.output == FileOrStream::Stream;
        let (first, count, is_sequence) = match (args.sequence.frames, args.sequence.turntable) {
            (_, Some(count)) => (0, count, true),
            (Some(FramesWanted::Range(first, last)), None) => (first - 1, last + 1 - first, true),
            (Some(FramesWanted::Count(count)), None) => (0, count, picture.is_some()),
            (None, None) if picture.is_some() => {
                let problem = format!(
                    "-o {}: which frames? Say --frames 1..240, or --turntable 120 for the eye to go once around",
                    args.output.output_name()
                );
                return Err(Failure::usage(problem));
            }
            (None, None) => (0, 1, false),
        };
        let unnamed = |option: &str, path: &Path| {
            let form = with_hashes(path);
            let problem = format!("{option} {}: many pictures need many names, such as", path.display());
            Err(Failure::usage(format!("{problem} {option} {form}")))
        };
        match (args.output.path(), &args.picture.mask) {
            (Some(path), _) if is_sequence && picture.is_none() => return unnamed("-o", path),
            (_, Some(path)) if is_sequence && mask.is_none() => return unnamed("--mask", path),
            (_, Some(path)) if !is_sequence && mask.is_some() => {
                let problem = "has a place for the number of a frame, and one picture is written";
                return Err(Failure::usage(format!("--mask {}: {problem}", path.display())));
            }
            _ => {}
        }
        let writes_all = is_sequence && (is_stream || picture.is_some());
        let is_motion_given = options.value_source("motion") != Some(ValueSource::DefaultValue);
        let sequence = Sequence {
            first,
            count,
            frames_per_second: args.sequence.fps,
            plays_animation: writes_all && !is_motion_given && args.sequence.turntable.is_none(),
            turn: args.sequence.turntable,
        };
        Ok(Self { format, sequence, writes_all, picture, mask })
    }

    /// The picture of a frame, counted from 0.
    pub(super) fn picture(&self, args: &RenderArgs, frame: u32) -> FileOrStream {
        match &self.picture {
            Some(pattern) => FileOrStream::File(pattern.path(frame + 1)),
            None => args.output.clone(),
        }
    }

    /// The mask of a frame, counted from 0.
    pub(super) fn mask(&self, args: &RenderArgs, frame: u32) -> Option<FileOrStream> {
        let path = args.picture.mask.as_ref()?;
        Some(FileOrStream::File(self.mask.as_ref().map_or_else(|| path.clone(), |pattern| pattern.path(frame + 1))))
    }

    /// The frames that were written, and what moved.
    pub(super) fn summary(&self, shot: &Shot<'_>) -> String {
        if !self.writes_all {
            return String::new();
        }
        let Sequence { first, count, plays_animation, turn, .. } = self.sequence;
        let motion = match (turn, shot.motion) {
            (Some(_), _) => "the eye goes once around".into(),
            (None, Motion::Animation) if plays_animation => {
                "motion animation, as the scene has one (--motion none holds it still)".into()
            }
            (None, motion) => format!("motion {}", motion.name()),
        };
        format!("frames {} to {}, {motion}\n", first + 1, first + count)
    }

    /// A warning where nothing moves, unless that is what was asked for.
    pub(super) fn remark(&self, shot: &Shot<'_>) -> Option<String> {
        let is_animated = !shot.model.animations.is_empty();
        let moves = self.sequence.turn.is_some() || shot.motion == Motion::Eye || is_animated;
        let is_wanted = shot.motion == Motion::None && !self.sequence.plays_animation;
        (self.writes_all && self.sequence.count > 1 && !moves && !is_wanted).then(|| {
            "the scene has no animation: all frames are the same; --motion eye or --turntable N moves the eye".into()
        })
    }
}

fn pattern(path: Option<&Path>) -> Result<Option<NamePattern>, Failure> {
    path.map_or(Ok(None), |path| NamePattern::of(path).map_err(Failure::usage))
}

/// The format of the pictures, and whether they can hold what is asked for.
fn format(args: &RenderArgs) -> Result<PictureFormat, Failure> {
    let picture = &args.picture;
    let format = args.output.path().and_then(PictureFormat::from_path).unwrap_or(PictureFormat::Png);
    let name = args.output.output_name();
    let wrong = |option: &str, problem: &str| Err(Failure::usage(format!("{option}: {name}: {problem}")));
    if picture.bits.is_some() && format != PictureFormat::Png {
        return wrong("--bits", "PNG pictures alone have a choice of 8 or 16 bits; EXR pictures have --half");
    }
    if picture.half && !format.is_linear() {
        return wrong("--half", "EXR pictures alone have floats; PNG pictures have --bits 16");
    }
    if picture.layers && !format.is_linear() {
        return wrong("--layers", "EXR pictures alone have layers; use a name that ends in .exr");
    }
    if picture.transparent && format == PictureFormat::Jpeg {
        return wrong("--transparent", "JPEG pictures are never transparent; use a name that ends in .png or .webp");
    }
    for (option, is_given) in [("--transparent", picture.transparent), ("--layers", picture.layers)] {
        if is_given && args.draw.backend == Backend::Gpu {
            return Err(Failure::usage(format!("{option} is drawn on the CPU alone; leave --backend gpu out")));
        }
        if is_given && args.draw.budget_ms.is_some() {
            return Err(Failure::usage(format!("{option} takes two drawings of a frame; leave --budget-ms out")));
        }
    }
    Ok(match format {
        PictureFormat::Png if picture.bits == Some(Bits::Sixteen) => PictureFormat::Png16,
        PictureFormat::Exr if picture.half => PictureFormat::ExrHalf,
        format => format,
    })
}

fn check_region(args: &RenderArgs) -> Result<(), Failure> {
    let [width, height] = args.view.size;
    match &args.picture.region {
        Some(region) if !region.is_within(args.view.size) => {
            let ([x, y], [w, h]) = (region.corner, region.size);
            let problem = format!("--region {x},{y},{w},{h} is not within the picture of --size {width}x{height}");
            Err(Failure::usage(problem))
        }
        _ => Ok(()),
    }
}

/// The name with a place for numbers.
fn with_hashes(path: &Path) -> String {
    let part = |part: Option<&std::ffi::OsStr>| part.map(|part| part.to_string_lossy().into_owned());
    let name = format!(
        "{}-####.{}",
        part(path.file_stem()).unwrap_or_default(),
        part(path.extension()).unwrap_or_else(|| "png".into())
    );
    path.with_file_name(name).display().to_string()
}
