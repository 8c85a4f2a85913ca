//! News that the studio tells the window.

use super::order::Wish;
use catoptric::framebuffer::Framebuffer;
use catoptric::math::Aabb;
use catoptric::methods::Report;
use catoptric::methods::overlay::Overlay;
use catoptric::scene::edits::Look;
use catoptric::scene::{Camera, Role};
use catoptric::tone::Display;
use glam::DVec3;
use std::sync::Arc;

/// One object of the scene, for lists and for what is picked.
#[derive(Clone, Debug)]
pub struct ObjectSummary {
    /// Name of its node.
    pub name: String,
    /// Name of its material.
    pub material: String,
    /// The role that the file gives it.
    pub role: Role,
    /// Index of refraction.
    pub ior: f32,
    /// The parts of the object's look that can be changed, as the file gives them.
    pub look: Look,
    /// Number of its triangles.
    pub triangles: u32,
    /// The box around it at time 0.
    pub bounds: Aabb,
}

/// An animation of the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct ClipSummary {
    /// The name; may be empty.
    pub name: String,
    /// The time of its last key, in seconds.
    pub duration: f32,
}

/// The contents of a scene, for the window.
#[derive(Clone, Debug)]
pub struct SceneSummary {
    /// The load's number.
    pub number: u64,
    /// The scene's name.
    pub name: String,
    /// The cameras of the file; where there is none, one that frames the scene.
    pub cameras: Vec<Camera>,
    /// All objects, in the scene's order.
    pub objects: Vec<ObjectSummary>,
    /// Number of triangles.
    pub triangles: usize,
    /// The scene's animations.
    pub clips: Vec<ClipSummary>,
    /// The box around everything at time 0.
    pub bounds: Aabb,
    /// Settings of methods that the file brings along.
    pub settings: std::collections::BTreeMap<String, toml::Table>,
    /// The parts that were left out or mended while reading.
    pub warnings: Vec<String>,
    /// Where its origin lies in the coordinates of its file.
    pub origin: DVec3,
    /// Light comes from infinity.
    pub has_environment: bool,
    /// The order that it needs.
    pub order_needed: u32,
    /// The exposure and tone mapping that suit the picture from the first camera.
    pub display: Display,
    /// The exposure, in stops, that makes it of middle brightness from its first camera.
    pub automatic_stops: f32,
    /// The time that loading took, in milliseconds.
    pub load_ms: f64,
}

impl SceneSummary {
    /// The last time of an animation, or of all; 0 without any.
    pub fn duration(&self, clip: Option<usize>) -> f32 {
        let played = self.clips.iter().enumerate().filter(|(index, _)| clip.is_none_or(|clip| clip == *index));
        played.map(|(_, clip)| clip.duration).fold(0.0, f32::max)
    }
}

/// A picture of one side.
#[derive(Clone, Debug)]
pub struct Picture {
    /// 0: left, 1: right.
    pub side: usize,
    /// The wish that it answers.
    pub wish: Arc<Wish>,
    /// True if the picture has all pixels and samples that were wished for; else it is a draft.
    pub is_whole: bool,
    /// Samples a pixel.
    pub samples: u32,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Linear colours; `None` where they would be carried too far.
    pub linear: Option<Arc<Framebuffer>>,
    /// The same as 8-bit sRGB, four bytes a pixel; empty where there is a texture.
    pub rgba: Vec<u8>,
    /// The same as a texture of the window's device.
    pub texture: Option<wgpu::Texture>,
    /// Times of stages and counts.
    pub report: Report,
    /// All of its time in milliseconds.
    pub frame_ms: f64,
    /// The processor that drew it.
    pub processor: String,
}

/// The difference of the two sides.
#[derive(Clone, Debug)]
pub struct Compared {
    /// The wish that it answers.
    pub wish: Arc<Wish>,
    /// Mean of LDR-FLIP: 0 (equal) to 1.
    pub flip_mean: f64,
    /// The share of pixels with a channel off by more than 0.1.
    pub over_0_1: f64,
    /// The heat map of FLIP, three bytes a pixel.
    pub heat_rgb: Vec<u8>,
    /// Width and height of the heat map, in pixels.
    pub size: [u32; 2],
}

/// Something to be shown over the left side.
#[derive(Clone, Debug)]
pub struct Overlaid {
    /// The wish that it answers.
    pub wish: Arc<Wish>,
    /// The overlay; an empty one if it could not be made.
    pub overlay: Overlay,
    /// Why it could not be made.
    pub problem: Option<String>,
}

/// Something that happened in the studio.
#[derive(Clone, Debug)]
pub enum News {
    /// Long work goes on: the name of its stage and the share that is done, where that is known.
    Busy {
        /// The stage.
        stage: String,
        /// 0 to 1.
        share: Option<f32>,
    },
    /// A line for below the picture: which processor draws from now on, and why.
    Remark {
        /// The words.
        text: String,
    },
    /// Something that the user should know.
    Message {
        /// In words.
        text: String,
    },
    /// Nothing is left to do.
    Idle,
    /// The studio has failed, and a new one has taken its place, which knows nothing of what was asked of the other.
    Restarted {
        /// The reason.
        problem: String,
    },
    /// The studio has failed and does nothing any more.
    Stopped {
        /// The reason.
        problem: String,
    },
    /// A scene was loaded.
    Loaded(Box<SceneSummary>),
    /// A scene could not be loaded: its number and the reason. The one before stays.
    NotLoaded {
        /// The load's number.
        number: u64,
        /// The reason and the remedy.
        problem: String,
    },
    /// A picture is there.
    Drawn(Box<Picture>),
    /// A side cannot be drawn: the wish, the side, and the reason.
    NotDrawn {
        /// The wish.
        wish: Arc<Wish>,
        /// 0: left, 1: right.
        side: usize,
        /// The reason.
        problem: String,
    },
    /// Both sides were compared.
    Compared(Box<Compared>),
    /// Where the picked point appears by several methods, as far as that is known.
    Placed(Box<super::places::Places>),
    /// An overlay is there.
    Overlaid(Box<Overlaid>),
    /// The answer to [`Order::Pick`](super::order::Order::Pick): the objects at a place of the picture.
    Picked {
        /// The order's number.
        number: u64,
        /// The objects along the ray's path and where it meets them; empty where nothing is seen.
        path: Vec<super::pick::Bounce>,
    },
}

/// Receives news, from any thread.
pub type Tell = Arc<dyn Fn(News) + Send + Sync>;
