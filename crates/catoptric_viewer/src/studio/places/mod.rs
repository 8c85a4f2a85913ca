//! Where a picked point appears by other methods, in the same reflectors.
//!
//! The truth is the specular path itself, solved exactly. Listed are methods that map a point to its place: those of
//! the projection family that project points, and environment maps, whose look-up is turned round.

mod exact;
#[cfg(test)]
mod tests;

use super::mailbox::Mailbox;
use super::order::{Drawn, Wish};
use super::pick::Bounce;
use catoptric::clock::Stopwatch;
use catoptric::error::RenderError;
use catoptric::light::tracer::Tracer;
use catoptric::methods::lookup::environment_map::{EnvironmentMapSettings, MapPlaces};
use catoptric::methods::projector::{MAX_BOUNCES, Projections, SpecularPath};
use catoptric::methods::{self, Prepared, Quality, Settings};
use catoptric::optics::path::bundle::{Bounce as PathBounce, BounceKind};
use catoptric::progress::{Cancelled, Progress};
use catoptric::scene::{Scene, View};
use exact::{ExactPath, Found};
use glam::{DVec3, Vec2};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The methods that project points, those that take long last.
const PROJECTING: [&str; 5] =
    ["planar_mirror", "reflector_search", "path_perturbation", "explosion_map", "sample_based_camera"];

/// Shapes of the surround that environment maps are corrected for: values of the setting `parallax`.
const PARALLAXES: [&str; 3] = ["none", "box", "sphere"];

/// A method that takes longer is left out: what a click asks for is not worth more.
const LIMIT_MS: f64 = 400.0;

/// The exact path is the one that the ray has followed if it leaves the picture this near to it, in pixels.
const SAME_PATH_PX: f64 = 1.0;

/// Rays that leave a stand-in's place read the map beside the point by less than this: single precision. In radians.
const SAME_DIRECTION: f64 = 1e-3;

/// Where a method shows a point.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// The method's id, with what tells its variants apart.
    pub method: String,
    /// Pixels from the top left corner.
    pub position_px: [f32; 2],
    /// How far that is from the truth, in pixels.
    pub offset_px: f32,
    /// A caveat: what the place alone does not say; may be empty.
    pub remark: String,
}

/// Where a picked point appears.
#[derive(Clone, Debug, PartialEq)]
pub struct Places {
    /// The number of the order to pick.
    pub number: u64,
    /// The wish whose picture was picked in.
    pub wish: Arc<Wish>,
    /// Where it truly appears, in pixels.
    pub truth_px: [f32; 2],
    /// The truth was solved for; else it is where the ray that was followed leaves the picture.
    pub is_solved: bool,
    /// Methods, and where they show it: of several places the one nearest to the truth.
    pub list: Vec<Place>,
    /// Methods that map points but say nothing here, and why.
    pub silent: Vec<(String, String)>,
    /// Everything was asked.
    pub is_done: bool,
}

/// A question that is still to be asked.
#[derive(Clone, Debug, PartialEq)]
enum Question {
    /// The truth, and environment maps, whose places are found from it.
    Exact,
    Method(&'static str),
}

/// A search that goes on from turn to turn.
pub(super) struct PlaceSearch {
    places: Places,
    path: SpecularPath,
    /// The same as it was picked, without its end.
    picked: Vec<Bounce>,
    point: DVec3,
    /// The next question last.
    waiting: Vec<Question>,
    settings: BTreeMap<String, toml::Table>,
}

/// The scene that is searched in.
pub(super) struct SearchedScene<'a> {
    pub(super) scene: &'a Arc<Scene>,
    pub(super) tracer: &'a Tracer,
}

/// Methods that are ready for a scene: another point in the same picture costs next to nothing.
#[derive(Default)]
pub(super) struct ReadyMethods {
    methods: BTreeMap<&'static str, ReadyMethod>,
}

struct ReadyMethod {
    settings: toml::Table,
    scene: Arc<Scene>,
    quality: Quality,
    prepared: Box<dyn Prepared>,
}

impl ReadyMethods {
    /// A method with settings, ready for a scene.
    fn get(
        &mut self,
        (id, settings): (&'static str, toml::Table),
        scene: &Arc<Scene>,
        quality: Quality,
        progress: &dyn Progress,
    ) -> Result<&mut dyn Prepared, RenderError> {
        let is_same = |known: &ReadyMethod| {
            known.settings == settings && Arc::ptr_eq(&known.scene, scene) && known.quality == quality
        };
        let ready = match self.methods.remove(id).filter(is_same) {
            Some(known) => known,
            None => {
                let prepared = methods::create(id, &settings)?.prepare(scene, quality, None, progress)?;
                ReadyMethod { settings, scene: scene.clone(), quality, prepared }
            }
        };
        Ok(&mut *self.methods.entry(id).or_insert(ready).prepared)
    }
}

impl PlaceSearch {
    /// A search for the point at the end of a picked path; `None` if that ends in nothing or is not mirrored.
    /// `settings` are those of the scene.
    pub(super) fn new(
        number: u64,
        wish: &Arc<Wish>,
        position_px: [f32; 2],
        picked: &[Bounce],
        settings: &BTreeMap<String, toml::Table>,
    ) -> Option<Self> {
        let (end, bounces) = picked.split_last()?;
        if end.kind.is_some() || bounces.is_empty() || bounces.len() > MAX_BOUNCES {
            return None;
        }
        let bounce = |bounce: &Bounce| Some(PathBounce { object: bounce.object, kind: bounce.kind? });
        let path = SpecularPath { bounces: bounces.iter().map(bounce).collect::<Option<_>>()? };
        let mut settings = settings.clone();
        for Drawn { method, settings: own, .. } in wish.sides.iter().rev() {
            settings.insert(method.clone(), own.clone());
        }
        let places = Places {
            number,
            wish: wish.clone(),
            truth_px: position_px,
            is_solved: false,
            list: Vec::new(),
            silent: Vec::new(),
            is_done: false,
        };
        let mut waiting = vec![Question::Exact];
        waiting.extend(PROJECTING.map(Question::Method));
        waiting.reverse();
        let (picked, point) = (bounces.to_vec(), end.position.as_dvec3());
        Some(Self { places, path, picked, point, waiting, settings })
    }

    pub(super) fn is_over(&self) -> bool {
        self.waiting.is_empty()
    }

    /// Asks the next question and returns what is known so far; `None` if something newer waits, and it must be asked
    /// again.
    pub(super) fn step(
        &mut self,
        searched: &SearchedScene<'_>,
        ready: &mut ReadyMethods,
        mailbox: &Mailbox,
    ) -> Option<Places> {
        let question = self.waiting.pop()?;
        let wish = self.places.wish.clone();
        let progress = Limit { mailbox, wish: &wish, watch: Stopwatch::new() };
        let view = searched.scene.view(&wish.camera, wish.size[0], wish.size[1]);
        let answered = match question {
            Question::Exact => self.solve(searched, &view),
            Question::Method(id) => self.ask_method(id, searched, &view, ready, &progress),
        };
        match answered {
            Ok(()) => {}
            Err(RenderError::Cancelled(_)) if progress.is_over() => {
                let why = format!("takes longer than {LIMIT_MS:.0} ms here");
                self.places.silent.push((question.name().into(), why));
            }
            Err(RenderError::Cancelled(_)) => {
                self.waiting.push(question);
                return None;
            }
            Err(error) => self.places.silent.push((question.name().into(), error.to_string())),
        }
        self.places.is_done = self.waiting.is_empty();
        Some(self.places.clone())
    }

    fn settings_of(&self, method: &str) -> toml::Table {
        self.settings.get(method).cloned().unwrap_or_default()
    }

    /// Adds a method's places: the nearest one to the truth, if any.
    fn add(&mut self, method: String, found: impl Iterator<Item = Vec2>, remark: &str) {
        let truth = Vec2::from(self.places.truth_px);
        let nearest = found.min_by(|a, b| a.distance(truth).total_cmp(&b.distance(truth)));
        match nearest {
            Some(at) => self.places.list.push(Place {
                method,
                position_px: at.to_array(),
                offset_px: at.distance(truth),
                remark: remark.into(),
            }),
            None => self.places.silent.push((method, "is not found to show it".into())),
        }
    }

    /// Where the path that was followed leaves the picture, exactly, and what environment maps make of it.
    fn solve(&mut self, searched: &SearchedScene<'_>, view: &View) -> Result<(), RenderError> {
        let bounces: Vec<_> = self.picked.iter().cloned().zip(self.path.bounces.iter().copied()).collect();
        let path = ExactPath::new(searched.scene, searched.tracer, view, self.places.truth_px, &bounces);
        let Some(path) = path else { return Ok(()) };
        let picked = Vec2::from(self.places.truth_px).as_dvec2();
        let truth = path.solved(self.point).filter(|found| found.px.distance(picked) < SAME_PATH_PX);
        let Some(truth) = truth else { return Ok(()) };
        (self.places.truth_px, self.places.is_solved) = (truth.px.as_vec2().to_array(), true);
        self.ask_maps(searched, view, &path, &truth)
    }

    /// Where environment maps show the point: one reflection alone is theirs.
    fn ask_maps(
        &mut self,
        searched: &SearchedScene<'_>,
        view: &View,
        path: &ExactPath<'_>,
        truth: &Found,
    ) -> Result<(), RenderError> {
        let SearchedScene { scene, tracer } = *searched;
        let [PathBounce { object, kind: BounceKind::Reflect }] = self.path.bounces[..] else { return Ok(()) };
        let order = self.places.wish.sides.iter().map(|side| side.quality.order).max().unwrap_or(1);
        for parallax in PARALLAXES {
            let mut table = self.settings_of("environment_map");
            table.insert("parallax".into(), parallax.into());
            let maps = MapPlaces::new(&EnvironmentMapSettings::from_table(&table)?, scene, order);
            let name = match parallax {
                "none" => "environment_map".to_owned(),
                shape => format!("environment_map ({shape})"),
            };
            let Some(stand_in) = maps.stand_in(object, self.point) else {
                self.places.silent.push((name, "its map shows no objects".into()));
                continue;
            };
            let is_read = |found: &Found| {
                let missed = maps.angle_missed(object, found.last, found.leaving, self.point);
                missed.is_some_and(|angle| angle < SAME_DIRECTION) && is_seen(scene, tracer, view, object, found.last)
            };
            let found = path.followed(truth, self.point, stand_in).filter(is_read).map(|found| found.px.as_vec2());
            let is_shown = maps.is_shown(scene, tracer, object, self.point);
            let remark = if is_shown { "" } else { "hidden from the map's centre: something else is shown there" };
            self.add(name, found.into_iter(), remark);
        }
        Ok(())
    }

    /// Where a method of the projection family makes the point appear.
    fn ask_method(
        &mut self,
        id: &'static str,
        searched: &SearchedScene<'_>,
        view: &View,
        ready: &mut ReadyMethods,
        progress: &Limit<'_>,
    ) -> Result<(), RenderError> {
        let quality = Quality { samples: 1, order: self.path.bounces.len() as u32 };
        let prepared = ready.get((id, self.settings_of(id)), searched.scene, quality, progress)?;
        let frame = prepared.frame(view, progress)?;
        let Some(projector) = frame.projector() else { return Ok(()) };
        let mut found = Projections::default();
        match projector.paths().iter().position(|path| *path == self.path) {
            Some(path) => projector.project_on(path as u32, &[self.point.as_vec3()], &mut found),
            None => {
                self.places.silent.push((id.into(), "does not draw this path".into()));
                return Ok(());
            }
        }
        progress.at(id, 1, 1)?;
        self.add(id.into(), found.all().iter().map(|one| one.image_px), "");
        Ok(())
    }
}

impl Question {
    fn name(&self) -> &'static str {
        match self {
            Self::Exact => "truth",
            Self::Method(id) => id,
        }
    }
}

/// True if nothing hides a point of an object from the eye.
fn is_seen(scene: &Scene, tracer: &Tracer, view: &View, object: u32, point: DVec3) -> bool {
    /// A hit this near to the point, as a share of the distance, is of its own surface.
    const OWN: f32 = 1e-2;
    let Some(px) = view.pixel_of_exact(point) else { return false };
    let ray = view.ray(px.x as f32, px.y as f32);
    let Some(hit) = tracer.first_hit(scene, &ray, view.near) else { return false };
    let distance = point.as_vec3().distance(ray.origin);
    tracer.point(scene, &ray, &hit).object == object && (hit.distance() - distance).abs() <= OWN * distance
}

/// Ends work where something newer waits or it takes too long.
struct Limit<'a> {
    mailbox: &'a Mailbox,
    wish: &'a Wish,
    watch: Stopwatch,
}

impl Limit<'_> {
    fn is_over(&self) -> bool {
        self.watch.elapsed_ms() > LIMIT_MS
    }
}

impl Progress for Limit<'_> {
    fn at(&self, _stage: &str, _done: u64, _of: u64) -> Result<(), Cancelled> {
        let waits = self.mailbox.waits_outside(true) || self.mailbox.supersedes(self.wish, 0, true);
        if waits || self.is_over() { Err(Cancelled) } else { Ok(()) }
    }
}
