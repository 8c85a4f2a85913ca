//! Frame sequences as units: every frame is drawn by itself, on any machine, and published as the file of a picture.

use super::amount::summary;
use super::place;
use super::recipe::{Recipe, read_recipe, whole};
use crate::args::{BakeFramesArgs, FrameFormat, Motion, ViewArgs};
use crate::baked;
use crate::drawing::{Shot, check_samples};
use crate::failure::{Failure, Output};
use crate::settings::{self, Chosen};
use crate::terminal::Terminal;
use catoptric::methods::{self, Quality};
use catoptric::output;
use catoptric::parallel;
use catoptric::picture::{self, PictureFormat};
use catoptric::progress::{Progress, Silent, Stage};
use catoptric_bake::unit::MAX_PAYLOAD_BYTES;
use catoptric_bake::{
    Check, Estimate, Identity, Payload, Plan, PlannedUnit, SCHEMA, Store, Work, for_each_unit, status,
};
use clap::ArgMatches;
use glam::Vec3;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::fs;
use std::io::Write;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The version of what a unit holds: the bytes of a picture's file.
const PAYLOAD_VERSION: u32 = 1;

/// Bytes of a picture's file besides its pixels, and the most that compression may add to these.
const HEAD_BYTES: u64 = 1 << 16;

/// An estimate's picture is so many times smaller in both directions.
const ESTIMATE_SCALE: u32 = 4;

/// A scene, a method and the frames of a sequence, as the command line gave them.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SequenceRecipe {
    sequence: Frames,
    of: Recipe,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Frames {
    frames: u32,
    motion: Motion,
    size: [u32; 2],
    camera: Option<String>,
    eye: Option<[f32; 3]>,
    target: Option<[f32; 3]>,
    up: Option<[f32; 3]>,
    fov: Option<f32>,
    samples: u32,
    /// By their whole paths.
    baked: Vec<PathBuf>,
    format: FrameFormat,
}

/// The frames of a sequence, ready to be drawn.
pub(super) struct Sequence<'a> {
    shot: Shot<'a>,
    chosen: Chosen,
    format: FrameFormat,
    size: [u32; 2],
    /// The hashes of the bakes that are looked up.
    baked: Vec<String>,
}

/// The recipe of a plan, if that is one of frames.
pub(super) fn recipe_of(plan: &Plan, file: &str) -> Result<Option<SequenceRecipe>, Failure> {
    if plan.recipe.get("sequence").is_none() {
        return Ok(None);
    }
    read_recipe(plan, file).map(Some)
}

/// Publishes a plan.
pub(super) fn plan(args: &BakeFramesArgs, options: &ArgMatches, terminal: &Terminal) -> Result<Output, Failure> {
    place::check(&args.output)?;
    let recipe = SequenceRecipe::new(args, options)?;
    let view = recipe.view();
    let sequence = recipe.sequence(&view, terminal)?;
    let identity = sequence.identity()?;
    if args.motion == Motion::Animation && args.frames > 1 && sequence.shot.model.animations.is_empty() {
        terminal.warn(&["the scene has no animation: all frames are the same; --motion eye moves the eye".into()]);
    }
    let store = place::create(&args.output)?;
    let plan = Plan { identity, recipe: serde_json::to_value(&recipe)?, estimate: sequence.estimate(terminal)? };
    plan.publish(&*store)?;
    let text = format!("{}: {}\n", args.output, summary(&plan, &status(&plan, &*store, Check::Sizes)?));
    Ok(terminal.unless_quiet(text).into())
}

/// Writes all frames into a folder, as pictures.
pub(super) fn write(
    recipe: &SequenceRecipe,
    plan: &Plan,
    store: &dyn Store,
    folder: &Path,
    terminal: &Terminal,
) -> Result<Output, Failure> {
    let fail = |path: &Path, problem: String| Failure::input(format!("{}: {problem}", path.display()));
    if folder.is_file() {
        return Err(fail(folder, "is a file; frames are written into a folder".into()));
    }
    let count = plan.identity.unit_count();
    let stage = Stage::begin(terminal, "writing frames", count as usize)?;
    let extension = recipe.sequence.format.extension();
    for_each_unit(plan, store, |number, bytes| -> Result<(), Failure> {
        if number == 0 {
            fs::create_dir_all(folder).map_err(|error| fail(folder, format!("cannot make the folder: {error}")))?;
        }
        let path = folder.join(format!("frame-{number:06}.{extension}"));
        output::write_file(&path, |writer| writer.write_all(bytes))?;
        Ok(stage.advance(1)?)
    })?;
    Ok(terminal.unless_quiet(format!("{}: {count} frames\n", folder.display())).into())
}

impl FrameFormat {
    fn extension(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Exr => "exr",
        }
    }

    fn picture(self) -> PictureFormat {
        match self {
            Self::Png => PictureFormat::Png,
            Self::Exr => PictureFormat::Exr,
        }
    }

    /// The most bytes of a picture's file.
    fn most_bytes(self, [width, height]: [u32; 2]) -> u64 {
        let a_pixel = if self == Self::Png { 3 } else { 16 };
        let pixels = u64::from(width) * u64::from(height) * a_pixel;
        // Rows begin with a byte of their own, and what does not get smaller is stored in blocks with heads.
        pixels + pixels / 256 + u64::from(height) * 16 + HEAD_BYTES
    }
}

impl SequenceRecipe {
    fn new(args: &BakeFramesArgs, options: &ArgMatches) -> Result<Self, Failure> {
        let BakeFramesArgs { what, view, frames, motion, samples, baked, format, .. } = args;
        let method = methods::find(&what.method).map_err(Failure::usage)?;
        check_samples(*samples, method)?;
        let ViewArgs { size, camera, eye, target, up, fov } = view;
        let numbers = |vector: &Option<Vec3>| vector.map(|vector| vector.to_array());
        let sequence = Frames {
            frames: *frames,
            motion: *motion,
            size: *size,
            camera: camera.clone(),
            eye: numbers(&eye.map(|eye| eye.as_vec3())),
            target: numbers(&target.map(|target| target.as_vec3())),
            up: numbers(up),
            fov: *fov,
            samples: *samples,
            baked: baked.iter().map(|path| whole(path)).collect(),
            format: *format,
        };
        let recipe = Self { sequence, of: Recipe::new(what, options)? };
        let (most, allowed) = (format.most_bytes(*size), MAX_PAYLOAD_BYTES);
        if most > allowed {
            let [width, height] = size;
            return Err(Failure::usage(format!(
                "--size {width}x{height}: a frame as .{} may take {most} bytes, {allowed} are allowed; use --format \
                 png, or a smaller size",
                format.extension()
            )));
        }
        Ok(recipe)
    }

    /// Where the frames are seen from.
    pub(super) fn view(&self) -> ViewArgs {
        let Frames { size, camera, eye, target, up, fov, .. } = &self.sequence;
        let [eye, target] = [eye, target].map(|point| point.map(|point| Vec3::from_array(point).as_dvec3()));
        let up = up.map(Vec3::from_array);
        ViewArgs { size: *size, camera: camera.clone(), eye, target, up, fov: *fov }
    }

    /// Loads the scene and the bakes.
    pub(super) fn sequence<'a>(&self, view: &'a ViewArgs, progress: &dyn Progress) -> Result<Sequence<'a>, Failure> {
        let Frames { frames, motion, size, samples, baked, format, .. } = &self.sequence;
        let (method, given, order) = self.of.method();
        let (model, moment) = self.of.model()?;
        let shelf = baked::open(baked)?;
        baked::check_methods(&shelf, &[method])?;
        let hashes = shelf.files().map(|(_, file)| file.plan_hash().to_string()).collect();
        let quality = Quality { samples: *samples, order };
        let shot = Shot::of(model, moment, (view, *motion, (*frames).into()), quality, shelf, progress)?;
        let chosen = shot.choose(method, given)?;
        if let Some(unfit) = &chosen.unfit {
            return Err(Failure::input(unfit));
        }
        Ok(Sequence { shot, chosen, format: *format, size: *size, baked: hashes })
    }
}

impl Sequence<'_> {
    /// Everything that the frames depend on.
    ///
    /// The scene counts at the first, the middle and the last frame: posing it for all would take as long as drawing.
    pub(super) fn identity(&self) -> Result<Identity, Failure> {
        let Shot { frames, motion, quality, .. } = &self.shot;
        let mut hasher = blake3::Hasher::new();
        for frame in [0, frames / 2, frames - 1] {
            let scene = self.shot.scene_of_frame(frame)?;
            scene.write_identity(|_| false, &mut |piece| {
                hasher.update(piece);
            });
            let view = self.shot.frame_view(&scene, frame)?;
            hasher.update(format!("{:?} {:?}", view.world_from_view, view.projection).as_bytes());
        }
        let (format, size) = (self.format, self.size);
        let unit = |frame: u32| PlannedUnit {
            name: format!("frame {frame}"),
            bytes: format.most_bytes(size),
            at_most: true,
            with_previous: false,
        };
        let identity = Identity {
            schema: SCHEMA,
            method: self.chosen.info.id.into(),
            payload_version: PAYLOAD_VERSION,
            settings: json!({
                "frames": frames, "motion": motion, "size": size, "samples": quality.samples, "order": quality.order,
                "format": format, "baked": self.baked,
                "method": settings::effective(self.chosen.info, &self.chosen.settings),
            }),
            scene_hash: hasher.finalize().to_hex().to_string(),
            program_version: env!("CARGO_PKG_VERSION").into(),
            units: (0..*frames).map(unit).collect(),
        };
        identity.validate(&identity.method)?;
        Ok(identity)
    }

    /// The costs, by a small picture of the frame in the middle.
    fn estimate(&self, progress: &dyn Progress) -> Result<Estimate, Failure> {
        let begun = Instant::now();
        let picture = self.shot.draw_frame(&self.chosen, self.shot.frames / 2, ESTIMATE_SCALE, progress)?;
        let bytes =
            picture::encode(self.format.picture(), &picture).map_err(|error| Failure::input(error.to_string()))?.len();
        let frames = f64::from(self.shot.frames) * f64::from(ESTIMATE_SCALE * ESTIMATE_SCALE);
        let secs = begun.elapsed().as_secs_f64() * parallel::thread_count() as f64 * frames;
        Ok(Estimate { core_hours: secs / 3600.0, bytes: (bytes as f64 * frames) as u64 })
    }
}

impl Work for Sequence<'_> {
    fn batch(&self, numbers: Range<u64>) -> Result<Vec<Payload>, String> {
        let frame = |number: u64| {
            let frame = u32::try_from(number).map_err(|error| error.to_string())?;
            let picture = self.shot.draw_frame(&self.chosen, frame, 1, &Silent).map_err(|failure| failure.message())?;
            let bytes = picture::encode(self.format.picture(), &picture).map_err(|error| error.to_string())?;
            Ok(Payload { bytes, note: None })
        };
        numbers.map(frame).collect()
    }
}
