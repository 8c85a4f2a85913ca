//! Orders, wishes and news as text and bytes, for a studio that shares no memory with the window: in browsers, a
//! worker.

use super::news::{Compared, News, ObjectSummary, Overlaid, Picture, SceneSummary};
use super::order::{Beside, Changes, Drawn, Order, RoleChange, Source, Wish};
use super::overlay_wire::{self, WireOverlay};
use super::pick::Bounce;
use super::places::{Place, Places};
use catoptric::framebuffer::Framebuffer;
use catoptric::math::Aabb;
use catoptric::methods::{Quality, Report};
use catoptric::optics::path::bundle::BounceKind;
use catoptric::scene::edits::Look;
use catoptric::scene::{Camera, Projection, Role};
use glam::{Affine3A, Vec3};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

/// A message: a line of JSON, and bytes that go with it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Message {
    /// The JSON.
    pub text: String,
    /// Pictures or files; empty where there are none.
    pub bytes: Vec<u8>,
}

/// A message that cannot be read.
#[derive(Debug, thiserror::Error)]
#[error("a message between window and worker cannot be read: {0}")]
pub struct WireError(String);

impl WireError {
    pub(super) fn new(problem: String) -> Self {
        Self(problem)
    }
}

/// What goes to the studio.
#[derive(Clone, Debug)]
pub enum Request {
    /// An order.
    Order(Order),
    /// A wish.
    Wish(Arc<Wish>),
}

#[derive(Serialize, Deserialize)]
enum WireRequest {
    Builtin {
        number: u64,
        spec: String,
    },
    /// The bytes are the file's, of this length, and those of the files beside it.
    Bytes {
        number: u64,
        name: String,
        length: usize,
        beside: Vec<(String, usize)>,
    },
    Pick {
        number: u64,
        position_px: [f32; 2],
    },
    Wish(Box<WireWish>),
}

#[derive(Serialize, Deserialize)]
struct WireWish {
    scene: u64,
    time: f32,
    roles: Vec<(String, String, Option<f32>)>,
    looks: Vec<(String, WireLook)>,
    moves: Vec<(String, [f32; 3])>,
    camera: WireCamera,
    size: [u32; 2],
    sides: Vec<(String, toml::Table, u32, u32)>,
    compares: bool,
    overlays: Vec<String>,
}

#[derive(Serialize, Deserialize)]
struct WireLook {
    color: Option<[f32; 3]>,
    roughness: Option<f32>,
    ior: Option<f32>,
}

#[derive(Serialize, Deserialize)]
struct WireCamera {
    name: String,
    other_name: String,
    place: [f32; 12],
    fov_y: Option<f32>,
    half_height: Option<f32>,
}

#[derive(Serialize, Deserialize)]
enum WireNews {
    Busy {
        stage: String,
        share: Option<f32>,
    },
    Remark {
        text: String,
    },
    Message {
        text: String,
    },
    Idle,
    Stopped {
        problem: String,
    },
    Loaded(WireScene),
    NotLoaded {
        number: u64,
        problem: String,
    },
    /// The bytes are the picture's, and those of its linear colours.
    Drawn(WirePicture),
    NotDrawn {
        wish: WireWish,
        side: usize,
        problem: String,
    },
    /// The bytes are the heat map's.
    Compared {
        wish: WireWish,
        flip_mean: f64,
        over_0_1: f64,
        size: [u32; 2],
    },
    Placed(WirePlaces),
    /// The bytes are the overlay's.
    Overlaid {
        wish: WireWish,
        overlay: WireOverlay,
        problem: Option<String>,
    },
    Picked {
        number: u64,
        path: Vec<WireBounce>,
    },
}

#[derive(Serialize, Deserialize)]
struct WirePlaces {
    number: u64,
    wish: WireWish,
    truth_px: [f32; 2],
    is_solved: bool,
    list: Vec<(String, [f32; 2], f32, String)>,
    silent: Vec<(String, String)>,
    is_done: bool,
}

impl From<Places> for WirePlaces {
    fn from(Places { number, wish, truth_px, is_solved, list, silent, is_done }: Places) -> Self {
        let place = |place: Place| (place.method, place.position_px, place.offset_px, place.remark);
        let (wish, list) = (WireWish::from(&*wish), list.into_iter().map(place).collect());
        Self { number, wish, truth_px, is_solved, list, silent, is_done }
    }
}

impl WirePlaces {
    fn read(self) -> Result<Places, WireError> {
        let Self { number, wish, truth_px, is_solved, list, silent, is_done } = self;
        let place = |(method, position_px, offset_px, remark)| Place { method, position_px, offset_px, remark };
        let (wish, list) = (Arc::new(wish.read()?), list.into_iter().map(place).collect());
        Ok(Places { number, wish, truth_px, is_solved, list, silent, is_done })
    }
}

/// Object, place, whether light goes through (none: the path ends), distance, angle of incidence.
type WireBounce = (u32, [f32; 3], Option<bool>, f32, f32);

#[derive(Serialize, Deserialize)]
struct WireScene {
    number: u64,
    name: String,
    cameras: Vec<WireCamera>,
    objects: Vec<WireObject>,
    triangles: usize,
    duration: f32,
    bounds: [[f32; 3]; 2],
    settings: BTreeMap<String, toml::Table>,
    warnings: Vec<String>,
    load_ms: f64,
}

#[derive(Serialize, Deserialize)]
struct WireObject {
    name: String,
    material: String,
    role: String,
    ior: f32,
    look: WireLook,
    triangles: u32,
    bounds: [[f32; 3]; 2],
}

#[derive(Serialize, Deserialize)]
struct WirePicture {
    side: usize,
    wish: WireWish,
    is_whole: bool,
    samples: u32,
    size: [u32; 2],
    stages_ms: Vec<(String, f64)>,
    counts: Vec<(String, u64)>,
    fallbacks: Vec<(String, u64)>,
    warnings: Vec<String>,
    frame_ms: f64,
    processor: String,
    has_linear: bool,
}

/// A request as a message; `None` for files, which workers cannot read.
pub fn request(request: &Request) -> Option<Message> {
    let mut bytes = Vec::new();
    let wire = match request {
        Request::Wish(wish) => WireRequest::Wish(Box::new(WireWish::from(&**wish))),
        Request::Order(Order::Pick { number, position_px }) => {
            WireRequest::Pick { number: *number, position_px: *position_px }
        }
        Request::Order(Order::Load { number, source }) => match source {
            Source::Builtin(spec) => WireRequest::Builtin { number: *number, spec: spec.clone() },
            Source::Bytes { name, bytes: content, beside } => {
                bytes = content.to_vec();
                beside.0.values().for_each(|content| bytes.extend_from_slice(content));
                let beside = beside.0.iter().map(|(name, content)| (name.clone(), content.len())).collect();
                WireRequest::Bytes { number: *number, name: name.clone(), length: content.len(), beside }
            }
            Source::File(_) => return None,
        },
        Request::Order(Order::UseBake { .. }) => return None,
    };
    Some(Message { text: serde_json::to_string(&wire).ok()?, bytes })
}

/// The request that a message is.
///
/// # Errors
/// [`WireError`].
pub fn read_request(Message { text, bytes }: Message) -> Result<Request, WireError> {
    let wire: WireRequest = serde_json::from_str(&text).map_err(|error| WireError(error.to_string()))?;
    let load = |number, source| Request::Order(Order::Load { number, source });
    Ok(match wire {
        WireRequest::Builtin { number, spec } => load(number, Source::Builtin(spec)),
        WireRequest::Bytes { number, name, length, beside } => {
            let mut left = &bytes[..];
            let mut take = |length: usize| {
                let (taken, rest) =
                    left.split_at_checked(length).ok_or_else(|| WireError("bytes are missing".into()))?;
                left = rest;
                Ok::<_, WireError>(taken)
            };
            let content = take(length)?.into();
            let beside = beside.into_iter().map(|(name, length)| Ok((name, take(length)?.to_vec())));
            let beside = Beside(Arc::new(beside.collect::<Result<_, WireError>>()?));
            load(number, Source::Bytes { name, bytes: content, beside })
        }
        WireRequest::Pick { number, position_px } => Request::Order(Order::Pick { number, position_px }),
        WireRequest::Wish(wish) => Request::Wish(Arc::new(wish.read()?)),
    })
}

/// News as a message.
pub fn news(news: News) -> Option<Message> {
    let mut bytes = Vec::new();
    let wire = match news {
        News::Busy { stage, share } => WireNews::Busy { stage, share },
        News::Remark { text } => WireNews::Remark { text },
        News::Message { text } => WireNews::Message { text },
        News::Idle => WireNews::Idle,
        News::Stopped { problem } => WireNews::Stopped { problem },
        // Told by those who start studios, not by studios.
        News::Restarted { .. } => return None,
        News::Loaded(summary) => WireNews::Loaded(WireScene::from(&*summary)),
        News::NotLoaded { number, problem } => WireNews::NotLoaded { number, problem },
        News::Drawn(picture) => {
            let wire = WirePicture::from(&*picture);
            bytes = picture.rgba;
            if let Some(linear) = picture.linear.filter(|_| wire.has_linear) {
                bytes.extend_from_slice(bytemuck::cast_slice(&linear.pixels));
            }
            WireNews::Drawn(wire)
        }
        News::NotDrawn { wish, side, problem } => WireNews::NotDrawn { wish: WireWish::from(&*wish), side, problem },
        News::Compared(compared) => {
            let Compared { wish, flip_mean, over_0_1, heat_rgb, size } = *compared;
            bytes = heat_rgb;
            WireNews::Compared { wish: WireWish::from(&*wish), flip_mean, over_0_1, size }
        }
        News::Placed(places) => WireNews::Placed(WirePlaces::from(*places)),
        News::Overlaid(overlaid) => {
            let Overlaid { wish, overlay, problem } = *overlaid;
            let (overlay, written) = overlay_wire::written(&overlay);
            bytes = written;
            WireNews::Overlaid { wish: WireWish::from(&*wish), overlay, problem }
        }
        News::Picked { number, path } => {
            let bounce = |bounce: &Bounce| {
                let transmits = bounce.kind.map(|kind| kind == BounceKind::Transmit);
                (bounce.object, bounce.position.to_array(), transmits, bounce.distance, bounce.incidence_deg)
            };
            WireNews::Picked { number, path: path.iter().map(bounce).collect() }
        }
    };
    Some(Message { text: serde_json::to_string(&wire).ok()?, bytes })
}

/// The news that a message is.
///
/// # Errors
/// [`WireError`].
pub fn read_news(Message { text, bytes }: Message) -> Result<News, WireError> {
    let wire: WireNews = serde_json::from_str(&text).map_err(|error| WireError(error.to_string()))?;
    Ok(match wire {
        WireNews::Busy { stage, share } => News::Busy { stage, share },
        WireNews::Remark { text } => News::Remark { text },
        WireNews::Message { text } => News::Message { text },
        WireNews::Idle => News::Idle,
        WireNews::Stopped { problem } => News::Stopped { problem },
        WireNews::Loaded(scene) => News::Loaded(Box::new(scene.read()?)),
        WireNews::NotLoaded { number, problem } => News::NotLoaded { number, problem },
        WireNews::Drawn(picture) => News::Drawn(Box::new(picture.read(bytes)?)),
        WireNews::NotDrawn { wish, side, problem } => News::NotDrawn { wish: Arc::new(wish.read()?), side, problem },
        WireNews::Compared { wish, flip_mean, over_0_1, size } => {
            check_length(bytes.len(), size, 3)?;
            let wish = Arc::new(wish.read()?);
            News::Compared(Box::new(Compared { wish, flip_mean, over_0_1, heat_rgb: bytes, size }))
        }
        WireNews::Placed(places) => News::Placed(Box::new(places.read()?)),
        WireNews::Overlaid { wish, overlay, problem } => {
            let (wish, overlay) = (Arc::new(wish.read()?), overlay.read(&bytes)?);
            News::Overlaid(Box::new(Overlaid { wish, overlay, problem }))
        }
        WireNews::Picked { number, path } => {
            let kind = |transmits| if transmits { BounceKind::Transmit } else { BounceKind::Reflect };
            let bounce = |(object, position, transmits, distance, incidence_deg): WireBounce| {
                let (position, kind) = (Vec3::from_array(position), transmits.map(kind));
                Bounce { object, position, kind, distance, incidence_deg }
            };
            News::Picked { number, path: path.into_iter().map(bounce).collect() }
        }
    })
}

/// Refuses pictures whose bytes do not fill them.
fn check_length(length: usize, [width, height]: [u32; 2], bytes_a_pixel: usize) -> Result<(), WireError> {
    let wanted = (width as usize).checked_mul(height as usize).and_then(|pixels| pixels.checked_mul(bytes_a_pixel));
    if wanted == Some(length) {
        return Ok(());
    }
    Err(WireError(format!("{length} bytes for a picture of {width} x {height} pixels")))
}

fn role_of(name: &str) -> Result<Role, WireError> {
    let all = [Role::Diffuse, Role::Reflector, Role::Lens, Role::Coated];
    let found = all.into_iter().find(|role| role.name() == name);
    found.ok_or_else(|| WireError(format!("there is no role `{name}`")))
}

impl From<&Wish> for WireWish {
    fn from(wish: &Wish) -> Self {
        let Wish { scene, time, changes: Changes { roles, looks, moves }, camera, size, sides, compares, overlays } =
            wish;
        let side = |Drawn { method, settings, quality }: &Drawn| {
            (method.clone(), settings.clone(), quality.samples, quality.order)
        };
        let role = |change: &RoleChange| (change.name.clone(), change.role.name().to_owned(), change.ior);
        Self {
            scene: *scene,
            time: *time,
            roles: roles.iter().map(role).collect(),
            looks: looks.iter().map(|(name, look)| (name.clone(), WireLook::from(look))).collect(),
            moves: moves.iter().map(|(name, by)| (name.clone(), by.to_array())).collect(),
            camera: WireCamera::from(camera),
            size: *size,
            sides: sides.iter().map(side).collect(),
            compares: *compares,
            overlays: overlays.iter().map(|kind| kind.name().into()).collect(),
        }
    }
}

impl WireWish {
    fn read(self) -> Result<Wish, WireError> {
        let Self { scene, time, roles, looks, moves, camera, size, sides, compares, overlays } = self;
        let role =
            |(name, role, ior): (String, String, Option<f32>)| Ok(RoleChange { name, role: role_of(&role)?, ior });
        let side = |(method, settings, samples, order)| Drawn { method, settings, quality: Quality { samples, order } };
        let changes = Changes {
            roles: roles.into_iter().map(role).collect::<Result<_, WireError>>()?,
            looks: looks.into_iter().map(|(name, look)| (name, look.read())).collect(),
            moves: moves.into_iter().map(|(name, by)| (name, Vec3::from_array(by))).collect(),
        };
        let (camera, sides) = (camera.read()?, sides.into_iter().map(side).collect());
        let overlays = overlays.iter().map(|name| overlay_wire::kind_of(name)).collect::<Result<_, _>>()?;
        Ok(Wish { scene, time, changes, camera, size, sides, compares, overlays })
    }
}

impl From<&Look> for WireLook {
    fn from(Look { color, roughness, ior }: &Look) -> Self {
        Self { color: color.map(|color| color.to_array()), roughness: *roughness, ior: *ior }
    }
}

impl WireLook {
    fn read(self) -> Look {
        Look { color: self.color.map(Vec3::from_array), roughness: self.roughness, ior: self.ior }
    }
}

impl From<&Camera> for WireCamera {
    fn from(Camera { name, other_name, world_from_camera, projection }: &Camera) -> Self {
        let (fov_y, half_height) = match projection {
            Projection::Perspective { fov_y } => (Some(*fov_y), None),
            Projection::Orthographic { half_height } => (None, Some(*half_height)),
        };
        let (name, other_name, place) = (name.clone(), other_name.clone(), world_from_camera.to_cols_array());
        Self { name, other_name, place, fov_y, half_height }
    }
}

impl WireCamera {
    fn read(self) -> Result<Camera, WireError> {
        let projection = match (self.fov_y, self.half_height) {
            (Some(fov_y), None) => Projection::Perspective { fov_y },
            (None, Some(half_height)) => Projection::Orthographic { half_height },
            _ => return Err(WireError("a camera has one projection".into())),
        };
        let world_from_camera = Affine3A::from_cols_array(&self.place);
        Ok(Camera { name: self.name, other_name: self.other_name, world_from_camera, projection })
    }
}

fn corners(bounds: &Aabb) -> [[f32; 3]; 2] {
    [bounds.min.to_array(), bounds.max.to_array()]
}

fn read_bounds([min, max]: [[f32; 3]; 2]) -> Aabb {
    Aabb { min: Vec3::from_array(min), max: Vec3::from_array(max) }
}

impl From<&SceneSummary> for WireScene {
    fn from(summary: &SceneSummary) -> Self {
        let object = |object: &ObjectSummary| WireObject {
            name: object.name.clone(),
            material: object.material.clone(),
            role: object.role.name().into(),
            ior: object.ior,
            look: WireLook::from(&object.look),
            triangles: object.triangles,
            bounds: corners(&object.bounds),
        };
        Self {
            number: summary.number,
            name: summary.name.clone(),
            cameras: summary.cameras.iter().map(WireCamera::from).collect(),
            objects: summary.objects.iter().map(object).collect(),
            triangles: summary.triangles,
            duration: summary.duration,
            bounds: corners(&summary.bounds),
            settings: summary.settings.clone(),
            warnings: summary.warnings.clone(),
            load_ms: summary.load_ms,
        }
    }
}

impl WireScene {
    fn read(self) -> Result<SceneSummary, WireError> {
        let object = |object: WireObject| {
            Ok(ObjectSummary {
                name: object.name,
                material: object.material,
                role: role_of(&object.role)?,
                ior: object.ior,
                look: object.look.read(),
                triangles: object.triangles,
                bounds: read_bounds(object.bounds),
            })
        };
        Ok(SceneSummary {
            number: self.number,
            name: self.name,
            cameras: self.cameras.into_iter().map(WireCamera::read).collect::<Result<_, _>>()?,
            objects: self.objects.into_iter().map(object).collect::<Result<_, WireError>>()?,
            triangles: self.triangles,
            duration: self.duration,
            bounds: read_bounds(self.bounds),
            settings: self.settings,
            warnings: self.warnings,
            load_ms: self.load_ms,
        })
    }
}

impl From<&Picture> for WirePicture {
    fn from(picture: &Picture) -> Self {
        let Report { stages_ms, counts, fallbacks, warnings, .. } = &picture.report;
        let owned = |(name, count): (&&'static str, &u64)| ((*name).to_owned(), *count);
        Self {
            side: picture.side,
            wish: WireWish::from(&*picture.wish),
            is_whole: picture.is_whole,
            samples: picture.samples,
            size: picture.size,
            stages_ms: stages_ms.iter().map(|(name, ms)| ((*name).to_owned(), *ms)).collect(),
            counts: counts.iter().map(owned).collect(),
            fallbacks: fallbacks.iter().map(owned).collect(),
            warnings: warnings.clone(),
            frame_ms: picture.frame_ms,
            processor: picture.processor.clone(),
            // Drafts are neither saved nor compared.
            has_linear: picture.is_whole && picture.linear.is_some(),
        }
    }
}

impl WirePicture {
    fn read(self, mut rgba: Vec<u8>) -> Result<Picture, WireError> {
        let [width, height] = self.size;
        let mut linear = None;
        check_length(rgba.len(), self.size, if self.has_linear { 20 } else { 4 })?;
        if self.has_linear {
            let floats = rgba.split_off(width as usize * height as usize * 4);
            let pixels = bytemuck::pod_collect_to_vec(&floats);
            linear = Some(Arc::new(Framebuffer { width, height, pixels }));
        }
        let named = |(name, count): (String, u64)| (kept(name), count);
        let report = Report {
            stages_ms: self.stages_ms.into_iter().map(|(name, ms)| (kept(name), ms)).collect(),
            counts: self.counts.into_iter().map(named).collect(),
            fallbacks: self.fallbacks.into_iter().map(named).collect(),
            warnings: self.warnings,
            ..Report::default()
        };
        Ok(Picture {
            side: self.side,
            wish: Arc::new(self.wish.read()?),
            is_whole: self.is_whole,
            samples: self.samples,
            size: self.size,
            linear,
            rgba,
            texture: None,
            report,
            frame_ms: self.frame_ms,
            processor: self.processor,
        })
    }
}

/// The name of a stage or count, of which there are a few dozen in the whole program: kept for good, once each.
fn kept(name: String) -> &'static str {
    static NAMES: Mutex<BTreeMap<String, &'static str>> = Mutex::new(BTreeMap::new());
    let mut names = NAMES.lock().unwrap_or_else(PoisonError::into_inner);
    names.entry(name).or_insert_with_key(|name| Box::leak(name.clone().into_boxed_str()))
}
