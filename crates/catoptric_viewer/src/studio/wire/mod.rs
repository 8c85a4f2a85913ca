//! Orders, wishes and news as text and bytes, for a studio that shares no memory with the window: in browsers, a
//! worker.

mod error;
mod overlay;
mod picture;
mod places;
mod scene;
mod wish;

pub use error::WireError;

use super::news::{Compared, News, Overlaid};
use super::order::{Beside, Order, Source, Wish};
use super::pick::Bounce;
use catoptric::optics::path::bundle::BounceKind;
use glam::Vec3;
use overlay::WireOverlay;
use picture::{WirePicture, check_length};
use places::WirePlaces;
use scene::WireScene;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use wish::{WireOpening, WireWish};

/// A message: a line of JSON, and bytes that go with it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Message {
    /// The JSON.
    pub text: String,
    /// Pictures or files; empty where there are none.
    pub bytes: Vec<u8>,
}

/// A message to the studio, as the studio takes it.
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
        opening: WireOpening,
    },
    /// The bytes are the file's, of this length, and those of the files beside it.
    Bytes {
        number: u64,
        name: String,
        length: usize,
        beside: Vec<(String, usize)>,
        opening: WireOpening,
    },
    Pick {
        number: u64,
        position_px: [f32; 2],
    },
    Wish(Box<WireWish>),
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

/// Object, place, whether light goes through (none: the path ends), distance, angle of incidence.
type WireBounce = (u32, [f32; 3], Option<bool>, f32, f32);

/// A request as a message; `None` for files, which workers cannot read.
pub fn request(request: &Request) -> Option<Message> {
    let mut bytes = Vec::new();
    let wire = match request {
        Request::Wish(wish) => WireRequest::Wish(Box::new(WireWish::from(&**wish))),
        Request::Order(Order::Pick { number, position_px }) => {
            WireRequest::Pick { number: *number, position_px: *position_px }
        }
        Request::Order(Order::Load { number, source, opening }) => match source {
            Source::Builtin(spec) => {
                WireRequest::Builtin { number: *number, spec: spec.clone(), opening: WireOpening::from(opening) }
            }
            Source::Bytes { name, bytes: content, beside } => {
                bytes = content.to_vec();
                beside.0.values().for_each(|content| bytes.extend_from_slice(content));
                let beside = beside.0.iter().map(|(name, content)| (name.clone(), content.len())).collect();
                let (name, length, opening) = (name.clone(), content.len(), WireOpening::from(opening));
                WireRequest::Bytes { number: *number, name, length, beside, opening }
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
    let wire: WireRequest = serde_json::from_str(&text).map_err(|error| WireError::new(error.to_string()))?;
    let load = |number, source, opening: WireOpening| {
        Ok::<_, WireError>(Request::Order(Order::Load { number, source, opening: opening.read()? }))
    };
    Ok(match wire {
        WireRequest::Builtin { number, spec, opening } => load(number, Source::Builtin(spec), opening)?,
        WireRequest::Bytes { number, name, length, beside, opening } => {
            let mut left = &bytes[..];
            let mut take = |length: usize| {
                let (taken, rest) =
                    left.split_at_checked(length).ok_or_else(|| WireError::new("bytes are missing".into()))?;
                left = rest;
                Ok::<_, WireError>(taken)
            };
            let content = take(length)?.into();
            let beside = beside.into_iter().map(|(name, length)| Ok((name, take(length)?.to_vec())));
            let beside = Beside(Arc::new(beside.collect::<Result<_, WireError>>()?));
            load(number, Source::Bytes { name, bytes: content, beside }, opening)?
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
            let (overlay, written) = overlay::written(&overlay);
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
    let wire: WireNews = serde_json::from_str(&text).map_err(|error| WireError::new(error.to_string()))?;
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
