//! The studio's answers: pictures, times, messages.

use super::overlay::ShownOverlay;
use crate::studio::news::Picture;
use crate::studio::order::Wish;
use crate::studio::pick::Bounce;
use crate::studio::places::Places;
use catoptric::framebuffer::Framebuffer;
use catoptric::methods::Report;
use eframe::egui::{ColorImage, Context, TextureHandle, TextureId, TextureOptions};
use eframe::egui_wgpu::RenderState;
use std::collections::VecDeque;
use std::sync::Arc;

/// Frames whose times are shown.
pub(in crate::app) const HISTORY: usize = 200;

/// Messages that are kept.
const MESSAGES: usize = 20;

/// All that there is to show.
#[derive(Default)]
pub(in crate::app) struct Shown {
    pub(in crate::app) pictures: [Option<ShownPicture>; 2],
    pub(in crate::app) compared: Option<ShownComparison>,
    /// The last one of each kind.
    pub(in crate::app) overlays: Vec<ShownOverlay>,
    /// The stage of long work and its share.
    pub(in crate::app) busy: Option<(String, Option<f32>)>,
    /// Messages to the user, the newest last.
    pub(in crate::app) messages: VecDeque<Said>,
    /// The last thing that was done for the user, and when that was, in seconds of the window's clock.
    pub(in crate::app) noted: Option<(String, f64)>,
    pub(in crate::app) picked: Option<Picked>,
    /// The number of pictures of the left side so far.
    pub(in crate::app) pictures_shown: u64,
    /// The last frames of the left side.
    pub(in crate::app) frames: VecDeque<FrameTimes>,
}

/// A scene that could not be opened.
pub(in crate::app) struct Failed {
    /// The word that stands for it.
    pub(in crate::app) name: String,
    /// Why, and what to do about it.
    pub(in crate::app) reason: String,
}

/// A message to the user.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::app) struct Said {
    pub(in crate::app) text: String,
    /// True if this was done as the user wanted; else something is wrong.
    pub(in crate::app) is_done: bool,
}

/// A picture on the screen.
pub(in crate::app) struct ShownPicture {
    pub(in crate::app) image: ShownImage,
    pub(in crate::app) wish: Arc<Wish>,
    pub(in crate::app) size: [u32; 2],
    pub(in crate::app) linear: Option<Arc<Framebuffer>>,
    pub(in crate::app) rgba: Vec<u8>,
    pub(in crate::app) is_whole: bool,
    pub(in crate::app) samples: u32,
    pub(in crate::app) report: Report,
    pub(in crate::app) frame_ms: f64,
    pub(in crate::app) processor: String,
}

/// Where a picture's pixels are.
pub(in crate::app) enum ShownImage {
    /// The window has got them.
    Copied(TextureHandle),
    /// They are where they were drawn, on the window's device.
    Drawn {
        /// The window's name for the texture.
        id: TextureId,
        /// The same, which is given free with it.
        device: RenderState,
    },
}

impl ShownImage {
    /// The window's name for it.
    pub(in crate::app) fn id(&self) -> TextureId {
        match self {
            Self::Copied(handle) => handle.id(),
            Self::Drawn { id, .. } => *id,
        }
    }

    /// Puts other pixels into the window's texture.
    fn replace(&mut self, pixels: ColorImage) {
        if let Self::Copied(handle) = self {
            handle.set(pixels, TextureOptions::LINEAR);
        }
    }

    /// A texture of the window's device.
    fn drawn(texture: &wgpu::Texture, device: &RenderState) -> Self {
        let view = texture.create_view(&Default::default());
        let id = device.renderer.write().register_native_texture(&device.device, &view, wgpu::FilterMode::Linear);
        Self::Drawn { id, device: device.clone() }
    }
}

impl Drop for ShownImage {
    fn drop(&mut self) {
        if let Self::Drawn { id, device } = self {
            device.renderer.write().free_texture(id);
        }
    }
}

/// The heat map on the screen.
pub(in crate::app) struct ShownComparison {
    pub(in crate::app) texture: TextureHandle,
    pub(in crate::app) wish: Arc<Wish>,
    pub(in crate::app) flip_mean: f64,
    pub(in crate::app) over_0_1: f64,
}

/// The path of the ray through a place of the picture.
pub(in crate::app) struct Picked {
    pub(in crate::app) number: u64,
    pub(in crate::app) position_px: [f32; 2],
    pub(in crate::app) path: Vec<Bounce>,
    /// Where its end appears by several methods, in the picture that was picked in.
    pub(in crate::app) places: Option<Places>,
}

/// The times of a frame.
pub(in crate::app) struct FrameTimes {
    pub(in crate::app) stages_ms: Vec<(&'static str, f64)>,
    pub(in crate::app) frame_ms: f64,
    /// When it was shown, in seconds of the window's clock.
    pub(in crate::app) shown_at: f64,
}

impl Shown {
    /// Adds a message, unless it was the last one.
    pub(in crate::app) fn say(&mut self, message: impl Into<String>) {
        self.add(Said { text: message.into(), is_done: false });
    }

    /// Adds what was done for the user.
    pub(in crate::app) fn note(&mut self, message: String, now: f64) {
        self.noted = Some((message.clone(), now));
        self.add(Said { text: message, is_done: true });
    }

    fn add(&mut self, message: Said) {
        if self.messages.back() != Some(&message) {
            self.messages.push_back(message);
        }
        while self.messages.len() > MESSAGES {
            self.messages.pop_front();
        }
    }

    /// Puts a picture on the screen; `device` is the window's.
    pub(in crate::app) fn put(&mut self, ctx: &Context, device: Option<&RenderState>, picture: Picture) {
        let Picture { side, wish, is_whole, samples, size, linear, rgba, texture, report, frame_ms, processor } =
            picture;
        let Some(place) = self.pictures.get_mut(side) else { return };
        let image = match (texture, device) {
            (Some(texture), Some(device)) => ShownImage::drawn(&texture, device),
            _ => {
                let pixels = ColorImage::from_rgba_premultiplied(size.map(|length| length as usize), &rgba);
                match place.take().map(|before| before.image) {
                    Some(mut before @ ShownImage::Copied(_)) => {
                        before.replace(pixels);
                        before
                    }
                    _ => {
                        let name = format!("side {side}");
                        ShownImage::Copied(ctx.load_texture(name, pixels, TextureOptions::LINEAR))
                    }
                }
            }
        };
        if side == 0 {
            self.pictures_shown += 1;
            self.frames.push_back(FrameTimes {
                stages_ms: report.stages_ms.clone(),
                frame_ms,
                shown_at: ctx.input(|input| input.time),
            });
            while self.frames.len() > HISTORY {
                self.frames.pop_front();
            }
        }
        *place = Some(ShownPicture { image, wish, size, linear, rgba, is_whole, samples, report, frame_ms, processor });
    }

    /// Frames of the left side in a second, over the last one.
    pub(in crate::app) fn frames_a_second(&self, now: f64) -> f64 {
        self.frames.iter().rev().take_while(|frame| now - frame.shown_at < 1.0).count() as f64
    }
}
