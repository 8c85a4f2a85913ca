//! The command line.

mod pictures;
mod project;
mod report;
mod sequence;
mod submit;
mod tips;
mod tools;
mod variables;

pub(crate) use pictures::{Bits, PictureArgs, SequenceArgs};
pub(crate) use project::ProjectArgs;
pub(crate) use report::ReportArgs;
pub(crate) use sequence::{Sequence, turn_about};
pub(crate) use submit::BakeSubmitArgs;
#[cfg(feature = "cloud")]
pub(crate) use submit::Engine;
pub(crate) use tips::with_tip;
pub(crate) use tools::{DiffArgs, ExplainArgs, JsonArgs, ViewerArgs};
pub(crate) use variables::{from_variables, name_variable, with_variables};

pub(crate) use catoptric_options::{
    ChoiceArgs, DisplayArgs, EnvironmentArgs, GlassArgs, PoseArgs, SceneArgs, Shadows, ThinGlass, ViewArgs,
};

use crate::parse::{self, FileOrStream, Order};
use clap::{ArgAction, ArgMatches, Args, FromArgMatches, Parser, Subcommand, ValueEnum, ValueHint};
use clap_complete::Shell;
use std::path::PathBuf;
use std::time::Duration;

/// Reflections and refractions of near objects in curved mirrors and glass, by several methods, each measured
/// against a ray-traced reference.
#[derive(Parser)]
#[command(name = "catoptric", version, max_term_width = 100, disable_help_flag = true, disable_version_flag = true)]
#[command(after_help = "Example:\n  catoptric scenes\n  catoptric render SCENE -o picture.png\n\n\
    Environment variables stand for options that are not given: CATOPTRIC_THREADS; of `render` and `compare` \
    CATOPTRIC_SIZE, CATOPTRIC_SAMPLES, CATOPTRIC_ORDER, CATOPTRIC_BACKEND, CATOPTRIC_ADAPTER, CATOPTRIC_ENVIRONMENT, \
    CATOPTRIC_EXPOSURE, CATOPTRIC_TONE; of `render` CATOPTRIC_METHOD.")]
pub(crate) struct Cli {
    #[command(flatten)]
    pub(crate) global: Global,
    /// Print the version
    #[arg(long, short = 'V', action = ArgAction::Version, help_heading = "General")]
    version: Option<bool>,
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Args)]
#[command(next_help_heading = "General")]
pub(crate) struct Global {
    /// Print errors alone
    #[arg(long, short, global = true, conflicts_with = "verbose")]
    pub(crate) quiet: bool,
    /// Print times, counts and every warning
    #[arg(long, short, global = true, action = ArgAction::Count)]
    pub(crate) verbose: u8,
    /// Progress on standard error: bars where it is a terminal, or a line of JSON a step, for programs
    #[arg(long, value_enum, value_name = "HOW", default_value = "bars", global = true, conflicts_with = "quiet")]
    pub(crate) progress: ProgressChoice,
    /// Threads to work with [default: one for each core]
    #[arg(long, value_name = "N", global = true, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    /// Print help
    #[arg(long, short, global = true, action = ArgAction::Help)]
    help: Option<bool>,
}

/// How progress is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ProgressChoice {
    Bars,
    Lines,
}

#[derive(Subcommand)]
pub(crate) enum Command {
    /// Draw a picture, or the frames of a sequence
    #[command(after_help = "Examples:\n  \
        catoptric render room.glb -o room.png --size 640x360 --camera 0\n  \
        catoptric render watch.glb -o turn-####.png --turntable 120\n  \
        catoptric render film.glb -o frame-####.png --frames 1..240 --motion animation\n  \
        catoptric render film.glb -o - --frames 1..240 | \\\n      \
        ffmpeg -f image2pipe -framerate 30 -i - film.mp4\n  \
        catoptric render watch.glb -o watch.webp --transparent\n  \
        catoptric render room.glb -o room.exr --method reference --samples 16 \\\n      \
        --eye -2,1,3 --target 0,1,0 --fov 40\n  \
        catoptric render room.glb -o - | magick - room.webp\n  \
        catoptric render room.toml -o room.png --size 640x360 --watch\n\n\
        A file that is really called `-` is `./-`.")]
    Render(Box<RenderArgs>),
    /// Draw methods side by side, measure them against the reference, and write a report
    #[command(after_help = "Examples:\n  \
        catoptric compare room.glb --report report --size 640x360\n  \
        catoptric compare room.glb --report report --method environment_map \\\n      \
        --method environment_map:parallax=box\n  \
        catoptric compare room.glb --report report --reference mitsuba.exr \\\n      \
        --crop 300,120,96,64 --csv table.csv\n\n\
        A method may be given several times with settings after a colon: ID:KEY=VALUE,KEY=VALUE. Open `report.html` \
        of that folder in any browser: it is one file, which can be sent and printed. A picture of 8 bits as \
        --reference is compared with what `render` writes as .png, with --exposure 0 and --tone none unless these are \
        given. Exit code 1: some method failed; the report says why.")]
    Compare(Box<CompareArgs>),
    /// Find where scene points appear in mirrors and through glass
    #[command(after_help = "Examples:\n  \
        catoptric project room.toml --reflector ball --eye -2,1,3 \\\n      \
        --points points.csv -o paths.csv\n  \
        catoptric project room.glb --camera 0 --size 640x480 --order 2 --jacobian \\\n      \
        --points points.npy -o paths.npy\n  \
        catoptric project room.toml --points - -o - <points.csv | gzip >paths.csv.gz\n  \
        catoptric project room.glb --points grid:board:0.05 --camera camera.json \\\n      \
        --direct -o paths.jsonl\n\n\
        Points: a table whose header names x, y and z (other columns are ignored), or of three numbers a row without \
        a header, separated by commas, semicolons, tabs or blanks, with # before comments; or an NPY array of N x 3 \
        floats or whole numbers. Scene units. Every coordinate must be a finite number of at most 1e12, else the row \
        is named.\n\n\
        Output: a row a path, by point and path length, with the columns point (from 0), kinds (R or T a bounce), \
        path, focal_index, path_length (optical), residual, image_x, image_y (of the first bounce), x1, y1, z1, x2, \
        ... and, with --jacobian, j11, j12, ... j33: d(first bounce point)/d(scene point), row by row; visible (1 if \
        nothing hides the point along the path, walls neither), in_picture (1 within the picture of --size), \
        blocked_by (the first object in the way) and, for grids, point_x, point_y, point_z. CSV, JSON lines, or a \
        structured NPY array (absent values are NaN there). image_x and image_y are in pixels from the upper left \
        corner of the picture, y downwards: the middle of the first pixel is 0.5, 0.5 (OpenCV's pixels, as in camera \
        files, are smaller by 0.5). focal_index counts the focal \
        points that light passes on the path. A `>` in a name is written `\\>`; names that begin as formulas do have \
        an apostrophe before them in CSV. Points with infinitely many paths have no row. Only \
        reflectors and lenses keep a path from having a row.")]
    Project(Box<ProjectArgs>),
    /// Precompute what a method looks up, in units that survive interruptions
    #[command(after_help = "Examples:\n  \
        catoptric bake room.toml --method light_field --set preset=full -o room.bake\n  \
        catoptric render room.toml --method light_field --baked room.bake \\\n      \
        -o room.png\n\n\
        Interrupted, it goes on where it was when it is started again. Exit code 75: stopped before the end.\n\n\
        Examples, on several machines that share a folder:\n  \
        catoptric bake plan room.toml --method light_field --set preset=full \\\n      \
        -o room.parts\n  \
        catoptric bake run room.parts --shard 0/4   (one of these for each of 4)\n  \
        catoptric bake status room.parts            (code 0: complete, 3: not yet)\n  \
        catoptric bake merge room.parts -o room.bake\n\n\
        Object stores (s3://, gs://, az://) and the scripts of clusters (`submit`) are in programs with the feature \
        `cloud`, which is off by default: cargo install catoptric_cli --features cloud")]
    Bake(BakeArgs),
    /// Measure how far two pictures differ
    #[command(after_help = "Examples:\n  \
        catoptric diff picture.png reference.png -o heat.png\n  \
        catoptric diff new.exr old.exr --max-flip 0.01 --json\n\n\
        FLIP is the difference that is seen when one picture flickers with the other, 0 to 1. Exit code 0: measured, \
        3: more than --max-flip. Where one is linear (.exr) and the other is not, the linear one is made what \
        `render` writes as .png, with --exposure 0 and --tone none.")]
    Diff(DiffArgs),
    /// List the methods with their settings
    #[command(after_help = "Example:\n  catoptric methods --json")]
    Methods(JsonArgs),
    /// Explain a method: its idea, costs, faults and most useful settings
    #[command(after_help = "Example:\n  catoptric explain light_field")]
    Explain(ExplainArgs),
    /// Show what is in a scene
    #[command(after_help = "Example:\n  catoptric info room.glb --reflector 'Mirror*'")]
    Info(InfoArgs),
    /// List the built-in scenes with their parameters
    #[command(after_help = "Example:\n  catoptric scenes --json")]
    Scenes(JsonArgs),
    /// Open a scene in the viewer, a program of its own (`catoptric_viewer`)
    #[command(after_help = "Example:\n  catoptric view room.glb --against reference\n\n\
        It takes the options of `render` for the scene, roles, the view, exposure and the method. \
        The viewer is the file that the environment variable CATOPTRIC_VIEWER names, else the one beside this program, \
        else the first on PATH. Exit codes are the viewer's.")]
    View(ViewerArgs),
    /// Show what this machine offers
    #[command(after_help = "Example:\n  catoptric doctor")]
    Doctor(JsonArgs),
    /// Print a script that completes commands and options in a shell
    #[command(after_help = "Example:\n  catoptric completions bash \\\n      \
            > ~/.local/share/bash-completion/completions/catoptric")]
    Completions(CompletionsArgs),
}

#[derive(Args)]
pub(crate) struct CompletionsArgs {
    /// The shell
    #[arg(help_heading = "Output")]
    pub(crate) shell: Shell,
}

/// The quality and number of frames.
#[derive(Args)]
#[command(next_help_heading = "Method")]
pub(crate) struct DrawArgs {
    #[command(flatten)]
    pub(crate) glass: GlassArgs,
    /// Fail where something would not be drawn as the file says, instead of warning
    #[arg(long, help_heading = "Scene")]
    pub(crate) strict: bool,
    /// Antialiasing samples a pixel
    #[arg(long, alias = "spp", value_name = "N", default_value = "4")]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub(crate) samples: u32,
    /// Highest number of reflections and refractions on a path, 0 to 16; what lies beyond is black. `auto`: what the
    /// scene needs, 4 or 8; with --baked 2
    #[arg(long, value_name = "K", default_value = "auto", value_parser = parse::order)]
    pub(crate) order: Order,
    /// Motion from frame to frame: nothing, the eye around its target by 1 degree, or the animation by 1/30 s
    #[arg(long, value_enum, default_value = "none", help_heading = "View")]
    pub(crate) motion: Motion,
    /// Processor that draws
    #[arg(long, value_enum, default_value = "auto")]
    pub(crate) backend: Backend,
    /// The GPU, by a part of its name (`catoptric doctor` lists them) [default: the best]
    #[arg(long, value_name = "NAME")]
    pub(crate) adapter: Option<String>,
    /// Time a frame may take in milliseconds, of any method but `auto`: what is not done by then is drawn by that, and
    /// counted [default: none]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=3_600_000))]
    pub(crate) budget_ms: Option<u32>,
    /// A merged bake for the method (repeat)
    #[arg(long, value_name = "FILE", value_parser = parse::file())]
    pub(crate) baked: Vec<PathBuf>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Motion {
    None,
    Eye,
    Animation,
}

impl Motion {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Eye => "eye",
            Self::Animation => "animation",
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Backend {
    Cpu,
    Gpu,
    Auto,
}

#[derive(Args)]
pub(crate) struct RenderArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    #[command(flatten)]
    pub(crate) view: ViewArgs,
    #[command(flatten)]
    pub(crate) draw: DrawArgs,
    #[command(flatten)]
    pub(crate) sequence: SequenceArgs,
    /// The method, with settings after a colon if wanted; `catoptric methods` lists them
    #[arg(long, value_name = "ID[:KEY=VALUE,...]", default_value = "auto", help_heading = "Method", display_order = 0)]
    pub(crate) method: String,
    /// A setting of the method, over the scene's own (repeat)
    #[arg(long, value_name = "KEY=VALUE", value_parser = parse::key_value, help_heading = "Method", display_order = 0)]
    pub(crate) set: Vec<(String, String)>,
    /// File of the picture: .png, .jpg or .webp (sRGB), or .exr (linear RGBA floats). A name such as frame-####.png or
    /// frame-%04d.png has a place for the number of a frame: every frame is written. `-`: PNG to standard output,
    /// frames of a range one after the other
    #[arg(long, short, value_name = "FILE", value_parser = parse::picture_path(), value_hint = ValueHint::FilePath)]
    #[arg(help_heading = "Output")]
    pub(crate) output: FileOrStream,
    #[command(flatten)]
    pub(crate) display: DisplayArgs,
    /// Write times and counts to this file (JSON); `-`: to standard output
    #[arg(long, value_name = "FILE", value_parser = parse::file_or_stream(), value_hint = ValueHint::FilePath)]
    #[arg(help_heading = "Output")]
    pub(crate) stats: Option<FileOrStream>,
    /// Draw again whenever the scene's files change, until interrupted: SCENE, the files that it names, the
    /// environment and bakes
    #[arg(long, help_heading = "Output")]
    pub(crate) watch: bool,
    #[command(flatten)]
    pub(crate) picture: PictureArgs,
}

#[derive(Args)]
pub(crate) struct CompareArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    #[command(flatten)]
    pub(crate) view: ViewArgs,
    #[command(flatten)]
    pub(crate) draw: DrawArgs,
    /// Frames a method; times are their median, the last one is compared
    #[arg(long, value_name = "N", default_value = "3", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    #[arg(help_heading = "View")]
    pub(crate) frames: u32,
    #[command(flatten)]
    pub(crate) report: ReportArgs,
    #[command(flatten)]
    pub(crate) display: DisplayArgs,
    /// Measure against this picture of the same view and size (.exr, .hdr or .png), such as another renderer's, in
    /// place of our own reference. Methods are then drawn without it, and where they project points is not measured
    #[arg(long, value_name = "FILE", value_parser = parse::file(), value_hint = ValueHint::FilePath)]
    #[arg(help_heading = "Method")]
    pub(crate) reference: Option<PathBuf>,
    /// A method, with settings after a colon (repeat) [default: all]
    #[arg(long, value_name = "ID[:KEY=VALUE,...]", help_heading = "Method", display_order = 0)]
    pub(crate) method: Vec<String>,
    /// Measure where methods project points at every N-th pixel of every N-th row; 1 is all
    #[arg(long, value_name = "N", default_value = "1", value_parser = clap::value_parser!(u32).range(1..=1024))]
    #[arg(help_heading = "Method", conflicts_with = "reference")]
    pub(crate) projection_every: u32,
    /// A setting of one method, or of every method that has it (repeat)
    #[arg(long, value_name = "[ID.]KEY=VALUE", value_parser = parse::key_value)]
    #[arg(help_heading = "Method", display_order = 0)]
    pub(crate) set: Vec<(String, String)>,
}

/// All of a bake at once, or one step of it.
pub(crate) enum BakeArgs {
    All(Box<BakeAllArgs>),
    Step(Box<BakeStep>),
}

// By hand: the options of all at once are required unless a step is named, and that cannot be derived.
impl FromArgMatches for BakeArgs {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        match matches.subcommand_name() {
            Some(_) => BakeStep::from_arg_matches(matches).map(|step| Self::Step(Box::new(step))),
            None => BakeAllArgs::from_arg_matches(matches).map(|args| Self::All(Box::new(args))),
        }
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl Args for BakeArgs {
    fn augment_args(command: clap::Command) -> clap::Command {
        let command = BakeStep::augment_subcommands(BakeAllArgs::augment_args(command));
        command.args_conflicts_with_subcommands(true).subcommand_negates_reqs(true)
    }

    fn augment_args_for_update(command: clap::Command) -> clap::Command {
        Self::augment_args(command)
    }
}

/// The steps of a bake, one by one.
#[derive(Subcommand)]
pub(crate) enum BakeStep {
    /// Write the plan of a bake and print its estimated costs
    #[command(after_help = "Example:\n  catoptric bake plan room.toml --method light_field -o room.parts")]
    Plan(BakePlanArgs),
    /// Plan the frames of a sequence: `run`, `status` and `submit` make them, `merge` writes them into a folder
    #[command(after_help = "Example:\n  \
        catoptric bake frames room.glb --frames 240 --samples 16 -o room.parts\n  \
        catoptric bake run room.parts --shard 0/4   (one of these for each of 4)\n  \
        catoptric bake merge room.parts -o room     (room/frame-000000.png and so on)\n\n\
        Every frame is drawn by itself, as if it were the first, so it does not depend on who draws it.")]
    Frames(BakeFramesArgs),
    /// Make the units of a plan that are missing
    #[command(after_help = "Examples:\n  catoptric bake run room.parts\n  \
        catoptric bake run room.parts --shard 2/8 --max-time 50m\n\n\
        Units that are done are skipped, whoever made them. While it works it prints a JSON line a unit on standard \
        error, or shows a bar where that is a terminal.")]
    Run(BakeRunArgs),
    /// Say how far a bake has come; exit code 0: complete, 3: not yet
    #[command(after_help = "Example:\n  catoptric bake status room.parts --missing")]
    Status(BakeStatusArgs),
    /// Write the cameras of a light field's views, for another renderer to make the pictures
    #[command(after_help = "Example:\n  \
        catoptric bake views room.toml --method light_field \\\n      \
        --set st=16 --set uv=64 -o views/views.toml\n  \
        (make the pictures)\n  \
        catoptric bake room.toml --method light_field --set st=16 --set uv=64 \\\n      \
        --set views=views/views.toml -o room.bake")]
    Views(BakeViewsArgs),
    /// Merge all units into one file
    #[command(after_help = "Example:\n  catoptric bake merge room.parts -o room.bake")]
    Merge(BakeMergeArgs),
    /// Have a cluster make the units and merge them
    #[command(after_help = "Examples:\n  \
        catoptric bake submit room.parts --engine slurm --dry-run\n  \
        catoptric bake submit room.parts --engine slurm --tasks 40 -o room.bake \\\n      \
        -- --partition=long --time=4:00:00\n\n\
        bake.sbatch is an array of tasks, each makes a shard of the units. Once they have ended finish.sbatch merges, \
        or first submits the units that are missing again, at most twice. Both are written beside the plan, and so \
        are the messages of the tasks.")]
    Submit(BakeSubmitArgs),
}

#[derive(Args)]
pub(crate) struct BakeViewsArgs {
    #[command(flatten)]
    pub(crate) what: BakeWhatArgs,
    /// File of the manifest; pictures are looked for beside it
    #[arg(long, short, value_name = "FILE.toml", value_parser = parse::file(), help_heading = "Output")]
    pub(crate) output: PathBuf,
}

/// The contents of a bake.
#[derive(Args)]
pub(crate) struct BakeWhatArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    /// The method; `catoptric methods` lists which bake
    #[arg(long, value_name = "ID", help_heading = "Method", display_order = 0)]
    pub(crate) method: String,
    /// Settings of the method, over the scene's own (TOML, KEY = VALUE a line)
    #[arg(long, short = 'c', value_name = "FILE.toml", value_parser = parse::file(), help_heading = "Method")]
    pub(crate) config: Option<PathBuf>,
    /// A setting of the method, over those of the scene and the file (repeat)
    #[arg(long, value_name = "KEY=VALUE", value_parser = parse::key_value, help_heading = "Method", display_order = 0)]
    pub(crate) set: Vec<(String, String)>,
    /// Highest number of reflections and refractions on a path
    #[arg(long, value_name = "K", default_value = "2", value_parser = clap::value_parser!(u32).range(0..=16))]
    #[arg(help_heading = "Method")]
    pub(crate) order: u32,
}

#[derive(Args)]
pub(crate) struct BakeAllArgs {
    #[command(flatten)]
    pub(crate) what: BakeWhatArgs,
    /// File of the bake; units are kept in FILE.parts until all are made
    #[arg(long, short, value_name = "FILE", value_parser = parse::file(), help_heading = "Output")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) stop: StopArgs,
}

/// When a bake pauses.
#[derive(Args)]
#[command(next_help_heading = "General")]
pub(crate) struct StopArgs {
    /// Stop before the next unit after this time, such as 50m or 1h30m
    #[arg(long, value_name = "TIME", value_parser = parse::duration)]
    pub(crate) max_time: Option<Duration>,
}

#[derive(Args)]
pub(crate) struct BakePlanArgs {
    #[command(flatten)]
    pub(crate) what: BakeWhatArgs,
    /// The place that plan and units go to: a folder, created if absent, or s3://bucket/prefix, gs://bucket/prefix or
    /// az://container/prefix
    #[arg(long, short, value_name = "PLACE", value_parser = parse::place(), help_heading = "Output")]
    pub(crate) output: String,
}

#[derive(Args)]
pub(crate) struct BakeFramesArgs {
    #[command(flatten)]
    pub(crate) what: BakeWhatArgs,
    #[command(flatten)]
    pub(crate) view: ViewArgs,
    /// Frames to draw
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000), help_heading = "View")]
    pub(crate) frames: u32,
    /// Motion from frame to frame: nothing, the eye around its target by 1 degree, or the animation by 1/30 s
    #[arg(long, value_enum, default_value = "animation", help_heading = "View")]
    pub(crate) motion: Motion,
    /// Antialiasing samples a pixel
    #[arg(long, value_name = "N", default_value = "4", value_parser = clap::value_parser!(u32).range(1..=4096))]
    #[arg(help_heading = "Method")]
    pub(crate) samples: u32,
    /// A merged bake for the method (repeat)
    #[arg(long, value_name = "FILE", value_parser = parse::file(), help_heading = "Method")]
    pub(crate) baked: Vec<PathBuf>,
    /// The kind of the pictures
    #[arg(long, value_enum, default_value = "png", help_heading = "Output")]
    pub(crate) format: FrameFormat,
    /// The place that plan and frames go to: a folder, created if absent, or s3://bucket/prefix, gs://bucket/prefix or
    /// az://container/prefix
    #[arg(long, short, value_name = "PLACE", value_parser = parse::place(), help_heading = "Output")]
    pub(crate) output: String,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum FrameFormat {
    /// 8-bit sRGB
    Png,
    /// Linear RGBA floats
    Exr,
}

#[derive(Args)]
pub(crate) struct BakeRunArgs {
    /// The place of the plan: a folder, or s3://bucket/prefix, gs://.. or az://..
    #[arg(value_name = "PLACE", value_parser = parse::place(), help_heading = "Scene")]
    pub(crate) place: String,
    /// Make every n-th unit from the i-th on, or `auto`: as the scheduler's variables say [default: all]
    #[arg(long, value_name = "I/N or auto", help_heading = "General")]
    pub(crate) shard: Option<String>,
    /// Make these units alone: their numbers, one a line, as `status --missing` prints them; shards divide the list
    #[arg(long, value_name = "FILE", value_parser = parse::file(), help_heading = "General")]
    pub(crate) units: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) stop: StopArgs,
}

#[derive(Args)]
pub(crate) struct BakeStatusArgs {
    /// The place of the plan: a folder, or s3://bucket/prefix, gs://.. or az://..
    #[arg(value_name = "PLACE", value_parser = parse::place(), help_heading = "Scene")]
    pub(crate) place: String,
    /// Print JSON
    #[arg(long, help_heading = "Output")]
    pub(crate) json: bool,
    /// Print the numbers of the units that are to be made, one a line
    #[arg(long, conflicts_with = "json", help_heading = "Output")]
    pub(crate) missing: bool,
    /// Read all units whole, not their sizes alone
    #[arg(long, help_heading = "General")]
    pub(crate) verify: bool,
}

#[derive(Args)]
pub(crate) struct BakeMergeArgs {
    /// The place of the plan: a folder, or s3://bucket/prefix, gs://.. or az://..
    #[arg(value_name = "PLACE", value_parser = parse::place(), help_heading = "Scene")]
    pub(crate) place: String,
    /// File of the bake; of frames the folder of the pictures
    #[arg(long, short, value_name = "FILE", value_parser = parse::file(), help_heading = "Output")]
    pub(crate) output: PathBuf,
}

#[derive(Args)]
pub(crate) struct InfoArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    #[command(flatten)]
    pub(crate) format: JsonArgs,
}
