//! `catoptric project`: where scene points appear.

mod camera;
mod grid;
mod input;
mod npy;
mod output;
mod query;
mod search;

use super::render::inputs::refuse_inputs;
use crate::args::{EnvironmentArgs, ProjectArgs, Shadows, ViewArgs};
use crate::failure::Failure;
use crate::parse::PointSource;
use crate::terminal::Terminal;
use crate::{drawing, scene_source, settings};
use camera::PinholeCamera;
use catoptric::error::did_you_mean;
use catoptric::methods::projection::find::path_visibility::PathVisibility;
use catoptric::methods::projection::find::projected_paths::path_search;
use catoptric::methods::{self, Job, Quality};
use catoptric::output as files;
use catoptric::progress::Silent;
use catoptric::scene::roles::RoleRule;
use catoptric::scene::{Model, Projection, Role, Scene, View};
use clap::ArgMatches;
use glam::DVec3;
use input::Points;
use output::Table;
use query::{PointCounts, Query, StreamError, stream};
use std::io;
use std::path::PathBuf;
use std::sync::Arc;

/// The size of the picture that approximate methods sample without `--size`.
const DEFAULT_SIZE: [u32; 2] = [1280, 720];

pub(crate) fn run(args: &ProjectArgs, options: &ArgMatches, terminal: &Terminal) -> Result<String, Failure> {
    check(args)?;
    let roles = scene_source::pose_roles(&args.pose, options)?;
    args.output.path().map_or(Ok(()), files::check_writable)?;
    args.write_camera.as_deref().map_or(Ok(()), files::check_writable)?;
    let table = match &args.points {
        PointSource::Table(table) => Some(Points::open(table)?),
        PointSource::Grid(_) => None,
    };
    let model = model(args, terminal)?;
    let scene = Arc::new(pose(args, &model, roles)?);
    let mut points = match (table, &args.points) {
        (None, PointSource::Grid(grid)) => Points::listed(grid::points(grid, &scene)?),
        (table, _) => table.ok_or_else(|| Failure::usage("--points: name a table"))?,
    };
    let objects = objects(&scene, args)?;
    let Seen { view, eye, camera } = seen(args, &scene)?;
    if args.write_camera.is_some() && camera.is_none() {
        return Err(Failure::usage("--write-camera needs the picture's --size"));
    }

    let given = args.set.iter().map(|(key, text)| (key.clone(), settings::value(text))).collect();
    let chosen = match args.method.as_str() {
        search::EXACT => None,
        id => Some(settings::choose(id, &model, &given)?),
    };
    terminal.set_subject(&args.method);
    let quality = Quality { samples: 1, order: args.order };
    let job = Job { scene: &scene, view: &view, quality, progress: terminal };
    let mut prepared = match &chosen {
        None => None,
        Some(chosen) => Some(chosen.method.prepare(&scene, quality, None, terminal)?),
    };
    let frame = match &mut prepared {
        None => None,
        Some(prepared) => {
            terminal.warn(&prepared.report().warnings);
            Some(prepared.frame(&view, terminal)?)
        }
    };
    let search = match &frame {
        None => search::exact_search(&job, eye, &objects, !args.ignore_visibility)?,
        Some(frame) => path_search(frame.as_ref(), &job, eye, &objects)?
            .ok_or_else(|| Failure::input(format!("--method {}: it does not say where points appear", args.method)))?,
    };
    let of_grid = matches!(args.points, PointSource::Grid(_));
    let table = Table::new(&args.output, search.paths(), &scene, args.order as usize, [args.jacobian, of_grid]);
    // The exact search looks itself.
    let visibility =
        (!args.ignore_visibility && args.method != search::EXACT).then(|| PathVisibility::of_scene(&scene));
    let (hiding, origin) = (PathVisibility::in_pictures(&scene), scene.origin);
    let (search, direct) = (search.as_ref(), args.direct);
    let query = Query { search, visibility, hiding, eye, camera, table: &table, direct, origin };
    let counts = write(args, &query, &mut points, terminal)?;
    if let (Some(path), Some(camera)) = (&args.write_camera, &query.camera) {
        camera.write(path, &scene)?;
    }
    terminal.warn(&model.warnings);
    terminal.warn(scene_source::remark_on_media(&args.method, &scene).iter());
    terminal.warn(cut_short_warning(&counts).iter());
    Ok(terminal.closing(summary(args, &counts), std::slice::from_ref(&args.output)))
}

/// Refuses options that do not go together.
fn check(args: &ProjectArgs) -> Result<(), Failure> {
    if args.method != search::EXACT {
        methods::find(&args.method).map_err(Failure::usage)?;
        if args.camera_file().is_some() {
            return Err(Failure::usage("--camera FILE.json works with the exact search: leave out --method"));
        }
    } else if let Some((key, _)) = args.set.first() {
        return Err(Failure::usage(format!("--set {key}: the exact search has no settings; choose a --method")));
    }
    if args.camera_file().is_some() && args.fov.is_some() {
        return Err(Failure::usage("--fov: the camera's file says it; leave it out"));
    }
    let outputs = [("--output", args.output.path()), ("--write-camera", args.write_camera.as_deref())];
    let inputs = [("--points", args.points.path()), ("--camera", args.camera_file())];
    for (output, written) in outputs {
        for (input, read) in inputs {
            if let (Some(written), Some(read)) = (written, read)
                && files::is_same_file(written, read)
            {
                return Err(Failure::usage(format!("{} is both {input} and {output}", read.display())));
            }
        }
    }
    if let [(_, Some(one)), (_, Some(other))] = outputs
        && files::is_same_file(one, other)
    {
        return Err(Failure::usage(format!("{} is both --output and --write-camera", one.display())));
    }
    let written = outputs.iter().filter_map(|(_, path)| *path);
    let settings = args.set.iter().map(|(_, value)| PathBuf::from(value));
    refuse_inputs(written, [args.scene.clone()].into_iter().chain(settings).collect())?;
    if args.eye.is_some() && args.eye == args.target {
        return Err(Failure::usage("--eye and --target are the same point: move one of them"));
    }
    Ok(())
}

/// Writes the answers for all points.
fn write(
    args: &ProjectArgs,
    query: &Query<'_>,
    points: &mut Points,
    terminal: &Terminal,
) -> Result<PointCounts, Failure> {
    // Errors of the points are distinguished from errors of the written file.
    let mut problem = None;
    let mut counts = PointCounts::default();
    let written = args.output.write(|writer| {
        let mut sink = query.table.begin(writer)?;
        let streamed = stream(points, query, terminal, |rows| sink.write(rows));
        match streamed {
            Ok(sum) => {
                counts = sum;
                sink.finish()
            }
            Err(StreamError::Points(failure)) => {
                problem = Some(failure);
                Err(io::Error::other("the points cannot be read"))
            }
            Err(StreamError::Cancelled(cancelled)) => {
                problem = Some(cancelled.into());
                Err(io::Error::other("cancelled"))
            }
            Err(StreamError::Output(error)) => Err(error),
        }
    });
    problem.map_or(Ok(()), Err)?;
    written?;
    Ok(counts)
}

/// The scene's model, with the animation that plays.
fn model(args: &ProjectArgs, terminal: &Terminal) -> Result<Model, Failure> {
    let mut model = scene_source::load(&args.scene, &args.pose.choice, &EnvironmentArgs::default(), false)?;
    scene_source::choose_animation(&args.pose.choice, &mut model)?;
    terminal.warn(scene_source::remark_on_time(&model, args.pose.time).iter());
    Ok(model)
}

/// The scene with what `--reflector` makes mirrors.
fn pose(args: &ProjectArgs, model: &Model, mut roles: Vec<RoleRule>) -> Result<Scene, Failure> {
    let pose = |roles: &[RoleRule]| scene_source::pose(model, args.pose.time, roles, Shadows::Off, None, &Silent);
    let scene = pose(&roles)?;
    let mirrors = made_mirrors(&scene, &args.reflector)?;
    if mirrors.is_empty() {
        return Ok(scene);
    }
    roles.extend(mirrors);
    pose(&roles)
}

/// The rules that make mirrors of what patterns name and is no reflector or lens.
fn made_mirrors(scene: &Scene, patterns: &[String]) -> Result<Vec<RoleRule>, Failure> {
    let mut rules = Vec::new();
    for pattern in patterns {
        let rule = RoleRule::new(pattern, Role::Reflector, None)
            .map_err(|error| Failure::usage(format!("--reflector: {error}")))?;
        let matches =
            |object: &u32| rule.matches(&scene.objects[*object as usize].name, &scene.material_of(*object).name);
        let mut found = (0..scene.objects.len() as u32).filter(matches).peekable();
        if found.peek().is_some() && !found.any(|object| scene.role_of(object).is_specular()) {
            rules.push(rule);
        }
    }
    Ok(rules)
}

/// The reflectors and lenses that paths may touch.
fn objects(scene: &Scene, args: &ProjectArgs) -> Result<Vec<u32>, Failure> {
    let (option, patterns) =
        if args.only.is_empty() { ("--reflector", &args.reflector) } else { ("--only", &args.only) };
    let specular = scene.specular_objects();
    let name = |object: &u32| scene.objects[*object as usize].name.as_str();
    if specular.is_empty() && !args.direct {
        let remedy = "name some by --reflector or --lens, or by [role] in a scene file";
        return Err(Failure::input(format!("{}: no object is a reflector or lens: {remedy}", scene.name)));
    }
    let mut wanted = vec![patterns.is_empty(); scene.objects.len()];
    for pattern in patterns {
        let rule = RoleRule::new(pattern, Role::Reflector, None)
            .map_err(|error| Failure::usage(format!("{option}: {error}")))?;
        let matches = |object: &u32| rule.matches(name(object), &scene.material_of(*object).name);
        let found: Vec<u32> = specular.iter().copied().filter(matches).collect();
        if found.is_empty() {
            let mut names: Vec<&str> = specular.iter().map(name).collect();
            names.dedup();
            let hint = did_you_mean(pattern, names.iter().copied());
            let known = names.join(", ");
            return Err(Failure::input(format!(
                "{}: {option} {pattern}: matches no object or material{hint}; reflectors and lenses are: {known}",
                scene.name
            )));
        }
        for object in found {
            wanted[object as usize] = true;
        }
    }
    Ok(specular.into_iter().filter(|object| wanted[*object as usize]).collect())
}

/// The eye, and the pictures that it sees.
struct Seen {
    /// The view that approximate methods sample.
    view: View,
    /// The exact eye, in the scene's coordinates.
    eye: DVec3,
    /// The camera in whose picture bounce points have their pixels.
    camera: Option<PinholeCamera>,
}

fn seen(args: &ProjectArgs, scene: &Scene) -> Result<Seen, Failure> {
    let eye = args.eye;
    let local = |eye: DVec3| eye - scene.origin;
    let read = args.camera_file().map(|path| PinholeCamera::read(path, args.size, scene)).transpose()?;
    let view_args = ViewArgs {
        size: args.size.unwrap_or(DEFAULT_SIZE),
        camera: args.camera.as_deref().filter(|_| read.is_none()).map(|name| name.to_string_lossy().into_owned()),
        eye: eye.filter(|_| args.target.is_some()),
        target: args.target,
        up: args.up,
        fov: args.fov,
    };
    let mut camera = drawing::camera(&view_args, scene)?;
    if let Some(eye) = eye {
        camera.world_from_camera.translation = local(eye).as_vec3().into();
    }
    if let Some(read) = read {
        let camera_of_file = eye.map_or(read.clone(), |eye| read.moved_to(local(eye)));
        let [width, height] = view_args.size;
        camera.projection = Projection::Perspective { fov_y: 1.0 };
        let view = scene.view(&camera, width, height);
        return Ok(Seen { view, eye: camera_of_file.eye, camera: Some(camera_of_file) });
    }
    if let Projection::Orthographic { .. } = camera.projection
        && (eye.is_none() || args.size.is_some())
    {
        let remedy = if eye.is_none() { "give --eye" } else { "give --target, or leave out --size" };
        let problem = format!("{}: camera `{}` is orthographic and has no eye: {remedy}", scene.name, camera.name);
        return Err(Failure::input(problem));
    }
    let [width, height] = view_args.size;
    let view = scene.view(&camera, width, height);
    let eye = eye.map_or_else(|| view.eye().as_dvec3(), local);
    let camera = args.size.and_then(|_| PinholeCamera::of_view(&view)).map(|camera| camera.moved_to(eye));
    Ok(Seen { view, eye, camera })
}

/// The warning about searches that a limit has cut short.
fn cut_short_warning(counts: &PointCounts) -> Option<String> {
    let PointCounts { points, cut_short, .. } = *counts;
    (cut_short > 0)
        .then(|| format!("the search was cut short for {cut_short} of {points} points: paths may be missing"))
}

fn summary(args: &ProjectArgs, counts: &PointCounts) -> String {
    let PointCounts { points, reflections, in_sight, without, infinite, .. } = counts;
    let output = args.output.output_name();
    let direct = if args.direct { format!(", {in_sight} points in direct sight") } else { String::new() };
    format!(
        "{output}: {points} points, {reflections} reflections, {without} points without any, {infinite} points with \
        infinitely many{direct}\n"
    )
}
