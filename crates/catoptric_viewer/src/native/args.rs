//! The command line: the program's own options of scenes, roles, views and exposure, and the window's.

use super::program;
use catoptric::methods::{self, setting_value};
use catoptric_options::parse::{self, Exposure, Order};
use catoptric_options::{
    DEFAULT_FOV_DEG, DisplayArgs, GlassArgs, SceneArgs, Shadows, ThinGlass, ViewArgs, role_words, rules,
};
use catoptric_viewer::app::{FirstExposure, FirstEye, FirstView, Start, read_settings};
use catoptric_viewer::studio::order::{Opening, RoleChange, Source};
use clap::{ArgMatches, CommandFactory, FromArgMatches, Parser, ValueEnum, ValueHint};
use glam::Vec3;
use std::path::PathBuf;

/// A scene in a window: drag a mirror ball, and compare methods with the ray-traced truth.
#[derive(Parser)]
#[command(version, max_term_width = 100)]
#[command(
    after_help = "Examples:\n  catoptric_viewer scene.glb\n  catoptric_viewer builtin:vase --against reference\n  \
    catoptric_viewer vase.glb --environment sky --lens 'Vase:1.5' --eye 0,1,3\n\n\
    What is drawn is what `catoptric render` draws with the same options. Reports and bakes are made by the program \
    `catoptric`: the file that CATOPTRIC_PROGRAM names, else the one beside this program, else the first on PATH."
)]
struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    glass: GlassArgs,
    #[command(flatten)]
    view: ViewArgs,
    #[command(flatten)]
    display: DisplayArgs,
    /// The method, with settings after a colon if wanted; `catoptric methods` lists them
    #[arg(long, value_name = "ID[:KEY=VALUE,...]", default_value = "auto", help_heading = "Method")]
    method: String,
    /// A setting of the method, over the scene's own (repeat)
    #[arg(long, value_name = "KEY=VALUE", value_parser = parse::key_value, help_heading = "Method")]
    set: Vec<(String, String)>,
    /// A second method to compare with, in a split view
    #[arg(long, value_name = "ID", help_heading = "Method")]
    against: Option<String>,
    /// Antialiasing samples a pixel
    #[arg(long, value_name = "N", default_value = "4", value_parser = samples, help_heading = "Method")]
    samples: u32,
    /// Highest number of reflections and refractions on a path, 0 to 16; `auto`: what the scene needs
    #[arg(long, value_name = "K", default_value = "auto", value_parser = parse::order, help_heading = "Method")]
    order: Order,
    /// A bake, for a method that uses it (repeat); `Bake...` makes some
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, help_heading = "Method")]
    baked: Vec<PathBuf>,
    /// Processor that draws
    #[arg(long, value_enum, default_value = "auto", help_heading = "Window")]
    backend: BackendChoice,
    /// The GPU, by a part of its name [default: the best]
    #[arg(long, value_name = "NAME", help_heading = "Window")]
    adapter: Option<String>,
    /// Draw the window, too, on the processor, which needs no graphics driver
    #[arg(long, conflicts_with = "adapter", help_heading = "Window")]
    software: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum BackendChoice {
    /// A real GPU, else the CPU
    Auto,
    Cpu,
    /// A GPU, or a driver that draws on the processor
    Gpu,
}

/// The beginning that the command line asks for.
pub(super) struct Wanted {
    pub(super) start: Start,
    /// The window's, in points.
    pub(super) size: [u32; 2],
    pub(super) backend: BackendChoice,
    pub(super) adapter: Option<String>,
    /// The processor draws the window.
    pub(super) is_software: bool,
}

fn samples(text: &str) -> Result<u32, String> {
    let counts = catoptric::raster::SAMPLE_COUNTS;
    let count = text.parse().ok().filter(|count| counts.contains(count));
    count.ok_or_else(|| format!("allowed are {}", counts.map(|count| count.to_string()).join(", ")))
}

/// The command line, with what is different from the program's.
fn command() -> clap::Command {
    Args::command()
        .mut_arg("scene", |arg| arg.required(false).default_value("builtin:sphere_room"))
        .mut_arg("size", |arg| arg.default_value("1440x860").help("Size of the window, panels included"))
        .allow_negative_numbers(true)
}

/// Reads the command line; ends the program for those that are wrong or ask for help.
///
/// # Errors
/// Words about options that do not go together, and about methods and settings that do not exist.
pub(super) fn read() -> Result<Wanted, String> {
    let options = command().get_matches();
    let args = Args::from_arg_matches(&options).unwrap_or_else(|error| error.exit());
    wanted(args, &options)
}

fn wanted(args: Args, options: &ArgMatches) -> Result<Wanted, String> {
    if args.software && args.backend == BackendChoice::Gpu {
        return Err("a window drawn by the processor (--software) has no GPU for --backend gpu".into());
    }
    let Args { scene, glass, view, display, method, set, against, samples, order, baked, backend, adapter, software } =
        args;
    let (id, given) = method.split_once(':').unwrap_or((&method, ""));
    let find = |id: &str| methods::find(id).map_err(|error| error.to_string());
    let info = find(id)?;
    against.as_deref().map(find).transpose()?;
    let mut settings = read_settings(info, given).map_err(|problem| format!("--method {method}: {problem}"))?;
    settings.extend(set.into_iter().map(|(key, value)| (key, setting_value(&value))));
    (info.effective)(&settings).map_err(|error| format!("--set: {error}"))?;
    let source = Source::of_word(scene.scene.to_str().ok_or("SCENE: the name is no Unicode; rename the file")?);
    let start = Start {
        source,
        opening: opening(&scene, glass, options)?,
        method: id.into(),
        settings,
        against,
        samples,
        order: match order {
            Order::Auto => None,
            Order::Exact(order) => Some(order),
        },
        view: first_view(&scene, &view, display)?,
        panels: true,
        bakes: baked,
        program: program::find(),
    };
    Ok(Wanted { start, size: view.size, backend, adapter, is_software: software })
}

fn opening(scene: &SceneArgs, glass: GlassArgs, options: &ArgMatches) -> Result<Opening, String> {
    let rules = rules(&role_words(&scene.reflector, &scene.pose, options))?;
    Ok(Opening {
        environment: scene.environment.environment.clone(),
        environment_edit: scene.environment.edit(),
        variant: scene.pose.choice.variant.clone(),
        allow_outside: scene.pose.choice.allow_outside,
        has_solid_glass: glass.thin_glass == Some(ThinGlass::Solid),
        lacks_shadows: scene.shadows == Shadows::Off,
        lacks_bounces: scene.shadows == Shadows::Direct,
        roles: rules.iter().map(RoleChange::from).collect(),
    })
}

fn first_view(scene: &SceneArgs, view: &ViewArgs, display: DisplayArgs) -> Result<FirstView, String> {
    if view.eye.is_some() && view.eye == view.target {
        return Err("--eye and --target are the same point: move one of them".into());
    }
    let eye = view.eye.map(|position| FirstEye {
        position,
        target: view.target,
        up: view.up.unwrap_or(Vec3::Y),
        fov_deg: view.fov.unwrap_or(DEFAULT_FOV_DEG),
    });
    Ok(FirstView {
        camera: view.camera.clone(),
        eye,
        fov_deg: view.fov,
        time: scene.pose.time,
        animation: scene.pose.choice.animation.clone(),
        exposure: match display.exposure {
            None => FirstExposure::Fitting,
            Some(Exposure::Auto) => FirstExposure::Automatic,
            Some(Exposure::Stops(stops)) => FirstExposure::Stops(stops),
        },
        curve: display.tone.map(Into::into),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use catoptric::scene::Role;
    use catoptric::tone::ToneCurve;
    use clap::Command;
    use std::collections::BTreeSet;

    fn read(line: &str) -> Result<Wanted, String> {
        let words = ["catoptric_viewer"].into_iter().chain(line.split(' ').filter(|word| !word.is_empty()));
        let options = command().try_get_matches_from(words);
        let options = options.map_err(|error| error.to_string())?;
        wanted(Args::from_arg_matches(&options).map_err(|error| error.to_string())?, &options)
    }

    #[test]
    fn a_scene_is_opened_and_seen_as_the_options_say() {
        let line = "vase.glb --environment sky --environment-rotation -90 --reflector Ball --lens Vase:1.5 \
                    --diffuse Ball* --time 1.5 --animation Walk --eye -2,1,3 --target 0,1,0 --fov 35 --exposure -1 \
                    --method environment_map:size=64 --set parallax=box --order 3 --thin-glass solid --shadows off";
        let Wanted { start, .. } = read(line).unwrap();
        assert_eq!(start.source, Source::File("vase.glb".into()));
        let Opening { environment, environment_edit, roles, has_solid_glass, lacks_shadows, .. } = start.opening;
        assert_eq!((environment, environment_edit.rotation_deg), (Some("sky".into()), Some(-90.0)));
        assert!(has_solid_glass && lacks_shadows);
        let change = |name: &str, role, ior| RoleChange { name: name.into(), role, ior };
        let [mirror, glass] = [change("Ball", Role::Reflector, None), change("Vase", Role::Lens, Some(1.5))];
        assert_eq!(roles, [mirror, glass, change("Ball*", Role::Diffuse, None)]);
        assert_eq!((start.method.as_str(), start.order), ("environment_map", Some(3)));
        assert_eq!(start.settings, toml::from_str("size = 64\nparallax = 'box'").unwrap());
        let FirstView { eye, time, animation, exposure, curve, .. } = start.view;
        assert_eq!((time, animation.as_deref()), (1.5, Some("Walk")));
        assert_eq!((exposure, curve), (FirstExposure::Stops(-1.0), None));
        let eye = eye.unwrap();
        assert_eq!((eye.position.to_array(), eye.fov_deg, eye.up), ([-2.0, 1.0, 3.0], 35.0, Vec3::Y));
    }

    #[test]
    fn without_options_a_built_in_scene_is_shown_as_it_is() {
        let Wanted { start, size, .. } = read("").unwrap();
        assert_eq!((start.source.word().as_str(), size), ("builtin:sphere_room", [1440, 860]));
        assert_eq!((start.opening, start.view, start.order), (Opening::default(), FirstView::default(), None));
        assert_eq!(read("--tone agx").unwrap().start.view.curve, Some(ToneCurve::Agx));
    }

    #[test]
    fn what_does_not_go_together_is_told_in_words() {
        let problem = |line: &str| read(line).err().unwrap();
        assert!(problem("--method rays").contains("rays"));
        assert!(problem("--set parallax=box").contains("--set"));
        assert!(problem("--eye 0,1,0 --target 0,1,0").contains("the same point"));
        assert!(problem("--lens Vase:99").contains("--lens"));
        assert!(problem("--environment -").contains("standard stream"));
    }

    /// Every option of scenes, views and exposure of the shared definition is here, under its own name.
    #[test]
    fn the_options_are_those_that_the_program_has() {
        let names = |command: &Command| -> BTreeSet<String> {
            command.get_arguments().map(|arg| arg.get_id().to_string()).collect()
        };
        let mut shared = Command::new("");
        for add in [
            <SceneArgs as clap::Args>::augment_args,
            <GlassArgs as clap::Args>::augment_args,
            <ViewArgs as clap::Args>::augment_args,
            <DisplayArgs as clap::Args>::augment_args,
        ] {
            shared = add(shared);
        }
        let (shared, own) = (names(&shared), names(&command()));
        assert!(shared.len() > 20 && shared.is_subset(&own), "{shared:?} {own:?}");
    }
}
