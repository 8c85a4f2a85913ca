//! `catoptric project`: where scene points appear.

mod input;
mod npy;
mod output;
mod search;

use crate::args::{EnvironmentArgs, ProjectArgs, Shadows, ViewArgs};
use crate::failure::Failure;
use crate::terminal::Terminal;
use crate::{drawing, scene_source, settings};
use catoptric::error::did_you_mean;
use catoptric::methods::path_query::{FoundPath, PathSearch};
use catoptric::methods::projection::find::path_visibility::PathVisibility;
use catoptric::methods::projection::find::projected_paths::path_search;
use catoptric::methods::projector::MAX_BOUNCES;
use catoptric::methods::{self, Job, Quality};
use catoptric::progress::{Cancelled, Progress, Silent};
use catoptric::scene::roles::RoleRule;
use catoptric::scene::{Model, Projection, Role, Scene, View};
use catoptric::{output as files, parallel};
use clap::ArgMatches;
use glam::DVec3;
use input::Points;
use output::{Row, Table};
use std::io;
use std::sync::Arc;

/// Points that are read, projected and written together.
const CHUNK: usize = 16_384;
/// Points that a thread takes at a time.
const PIECE: usize = 128;
/// The size of the picture that approximate methods sample without `--size`.
const DEFAULT_SIZE: [u32; 2] = [1280, 720];

/// The counts of points by their outcome.
#[derive(Clone, Copy, Default)]
struct PointCounts {
    points: u64,
    reflections: u64,
    without: u64,
    infinite: u64,
    cut_short: u64,
}

/// The search and view for every point.
struct Query<'a> {
    search: &'a dyn PathSearch,
    /// `None` if nothing blocks, or if the search has left out blocked paths.
    visibility: Option<PathVisibility<'a>>,
    eye: DVec3,
    /// The picture in which bounce points have their pixels.
    view: Option<&'a View>,
    table: &'a Table,
    /// Where the scene's origin lies in the coordinates of points.
    origin: DVec3,
}

pub(crate) fn run(args: &ProjectArgs, options: &ArgMatches, terminal: &Terminal) -> Result<String, Failure> {
    if args.method != search::EXACT {
        methods::find(&args.method).map_err(Failure::usage)?;
    } else if let Some((key, _)) = args.set.first() {
        return Err(Failure::usage(format!("--set {key}: the exact search has no settings; choose a --method")));
    }
    if let (Some(points), Some(output)) = (args.points.path(), args.output.path())
        && files::is_same_file(points, output)
    {
        return Err(Failure::usage(format!("{} is both --points and --output", points.display())));
    }
    if args.eye.is_some() && args.eye == args.target {
        return Err(Failure::usage("--eye and --target are the same point: move one of them"));
    }
    let roles = scene_source::pose_roles(&args.pose, options)?;
    args.output.path().map_or(Ok(()), files::check_writable)?;
    let mut points = Points::open(&args.points)?;
    let model = model(args, terminal)?;
    let scene = Arc::new(pose(args, &model, roles)?);
    let objects = objects(&scene, &args.reflector)?;
    let (view, eye) = view(args, &scene)?;

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
    let table = Table::new(&args.output, search.paths(), &scene, args.order as usize, args.jacobian);
    // The exact search looks itself.
    let visibility =
        (!args.ignore_visibility && args.method != search::EXACT).then(|| PathVisibility::of_scene(&scene));
    let view = args.size.map(|_| &view);
    let origin = scene.origin;
    let query = Query { search: search.as_ref(), visibility, eye, view, table: &table, origin };

    // Errors of the points are distinguished from errors of the written file.
    let mut problem = None;
    let mut counts = PointCounts::default();
    let written = args.output.write(|writer| {
        let mut sink = table.begin(writer)?;
        let streamed = stream(&mut points, &query, terminal, |rows| sink.write(rows));
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
    if let Some(problem) = problem {
        return Err(problem);
    }
    written?;
    terminal.warn(&model.warnings);
    terminal.warn(scene_source::remark_on_media(&args.method, &scene).iter());
    terminal.warn(cut_short_warning(&counts).iter());
    Ok(terminal.closing(summary(args, &counts), std::slice::from_ref(&args.output)))
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
fn objects(scene: &Scene, patterns: &[String]) -> Result<Vec<u32>, Failure> {
    let specular = scene.specular_objects();
    let name = |object: &u32| scene.objects[*object as usize].name.as_str();
    if specular.is_empty() {
        let remedy = "name some by --reflector or --lens, or by [role] in a scene file";
        return Err(Failure::input(format!("{}: no object is a reflector or lens: {remedy}", scene.name)));
    }
    let mut wanted = vec![patterns.is_empty(); scene.objects.len()];
    for pattern in patterns {
        let rule = RoleRule::new(pattern, Role::Reflector, None)
            .map_err(|error| Failure::usage(format!("--reflector: {error}")))?;
        let matches = |object: &u32| rule.matches(name(object), &scene.material_of(*object).name);
        let found: Vec<u32> = specular.iter().copied().filter(matches).collect();
        if found.is_empty() {
            let mut names: Vec<&str> = specular.iter().map(name).collect();
            names.dedup();
            let hint = did_you_mean(pattern, names.iter().copied());
            let known = names.join(", ");
            return Err(Failure::input(format!(
                "{}: --reflector {pattern}: matches no object or material{hint}; reflectors and lenses are: {known}",
                scene.name
            )));
        }
        for object in found {
            wanted[object as usize] = true;
        }
    }
    Ok(specular.into_iter().filter(|object| wanted[*object as usize]).collect())
}

/// The view in which bounce points have their pixels, and the exact eye.
fn view(args: &ProjectArgs, scene: &Scene) -> Result<(View, DVec3), Failure> {
    let eye = args.eye;
    let view_args = ViewArgs {
        size: args.size.unwrap_or(DEFAULT_SIZE),
        camera: args.camera.clone(),
        eye: eye.filter(|_| args.target.is_some()),
        target: args.target,
        up: args.up,
        fov: args.fov,
    };
    let mut camera = drawing::camera(&view_args, scene)?;
    if let Some(eye) = eye {
        camera.world_from_camera.translation = (eye - scene.origin).as_vec3().into();
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
    let exact_eye = args.eye.map_or_else(|| view.eye().as_dvec3(), |eye| eye - scene.origin);
    Ok((view, exact_eye))
}

enum StreamError {
    Cancelled(Cancelled),
    Points(Failure),
    Output(io::Error),
}

/// Reads, projects and writes chunk by chunk: the next is read while one is projected.
fn stream(
    points: &mut Points,
    query: &Query<'_>,
    progress: &dyn Progress,
    mut write: impl FnMut(&[u8]) -> io::Result<()>,
) -> Result<PointCounts, StreamError> {
    let mut counts = PointCounts::default();
    let mut chunk = points.read(CHUNK).map_err(StreamError::Points)?;
    while !chunk.is_empty() {
        let first = counts.points;
        let (pieces, next) = rayon::join(|| query.answer(first, &chunk), || points.read(CHUNK));
        for (rows, piece) in &pieces {
            write(rows).map_err(StreamError::Output)?;
            counts.points += piece.points;
            counts.reflections += piece.reflections;
            counts.without += piece.without;
            counts.infinite += piece.infinite;
            counts.cut_short += piece.cut_short;
        }
        chunk = next.map_err(StreamError::Points)?;
        progress.at("projecting", points.bytes_read(), points.total_bytes()).map_err(StreamError::Cancelled)?;
    }
    Ok(counts)
}

impl Query<'_> {
    /// The rows of a chunk of points, in pieces, in order.
    fn answer(&self, first: u64, chunk: &[DVec3]) -> Vec<(Vec<u8>, PointCounts)> {
        parallel::map_init_collect(chunk.len().div_ceil(PIECE), Vec::new, |found, piece| {
            let start = piece * PIECE;
            let points = &chunk[start..(start + PIECE).min(chunk.len())];
            let mut rows = self.table.rows();
            let mut counts = PointCounts { points: points.len() as u64, ..PointCounts::default() };
            for (index, &point) in points.iter().enumerate() {
                found.clear();
                let point = point - self.origin;
                let outcome = self.search.search(point, found);
                counts.cut_short += u64::from(outcome.cut_short);
                if outcome.infinite {
                    counts.infinite += 1;
                    continue;
                }
                found.retain(|path| self.is_visible(path, point));
                counts.reflections += found.len() as u64;
                counts.without += u64::from(found.is_empty());
                for path in found.iter() {
                    let image = self.view.and_then(|view| view.pixel_of_exact(path.bounce_points[0]));
                    rows.push(&Row { point: first + (start + index) as u64, path, image });
                }
            }
            (rows.into_bytes(), counts)
        })
    }

    fn is_visible(&self, path: &FoundPath, point: DVec3) -> bool {
        self.visibility.as_ref().is_none_or(|visibility| {
            let bounces = &path.bounce_points[..path.bounce_count.min(MAX_BOUNCES)];
            visibility.is_visible(self.eye, point, &self.search.paths()[path.path as usize], bounces)
        })
    }
}

/// The warning about searches that a limit has cut short.
fn cut_short_warning(counts: &PointCounts) -> Option<String> {
    let PointCounts { points, cut_short, .. } = *counts;
    (cut_short > 0)
        .then(|| format!("the search was cut short for {cut_short} of {points} points: paths may be missing"))
}

fn summary(args: &ProjectArgs, counts: &PointCounts) -> String {
    let PointCounts { points, reflections, without, infinite, .. } = counts;
    let output = args.output.output_name();
    format!(
        "{output}: {points} points, {reflections} reflections, {without} points without any, {infinite} points with \
        infinitely many\n"
    )
}
