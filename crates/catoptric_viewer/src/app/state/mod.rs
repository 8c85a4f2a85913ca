//! The window's state: data alone. What is done with it stands in the files above.

pub(super) mod clock;
#[cfg(not(target_family = "wasm"))]
pub(super) mod errand;
pub(super) mod file;
pub(super) mod grip;
pub(super) mod history;
pub(super) mod navigator;
pub(super) mod overlay;
#[cfg(not(target_family = "wasm"))]
pub(super) mod question;
pub(super) mod shortcuts;
pub(super) mod shown;
pub(super) mod start;

use super::link::Link;
use crate::studio::news::SceneSummary;
use crate::studio::order::{Changes, Opening, Source, Wish};
use catoptric::methods::overlay::OverlayKind;
use catoptric::tone::Display;
use catoptric_scenes::import::EnvironmentEdit;
use clock::Clock;
use eframe::egui::{self, Context};
use eframe::egui_wgpu::RenderState;
#[cfg(not(target_family = "wasm"))]
use errand::Errand;
use file::Saved;
use grip::{Grip, Tool};
use history::History;
use navigator::Navigator;
#[cfg(not(target_family = "wasm"))]
use question::Question;
use shown::{Failed, Shown};
use start::Start;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Something that who embeds a viewer may want to know.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ViewerEvent<'a> {
    /// A scene is shown: its name.
    Loaded(&'a str),
    /// The user was told something: what was left out of a file, or why it cannot be opened or drawn.
    Message(&'a str),
    /// A picture has all its pixels and samples.
    Sharp,
    /// A report was made: its page.
    Report(&'a Path),
}

/// Is told what happens in a viewer.
pub type Listener = Box<dyn Fn(ViewerEvent<'_>)>;

/// A method chosen for a side, with settings for every method that was ever chosen there.
#[derive(Clone, Debug)]
pub(in crate::app) struct Choice {
    pub(in crate::app) method: String,
    pub(in crate::app) settings: BTreeMap<String, toml::Table>,
}

/// The window's state.
pub struct Viewer {
    pub(in crate::app) link: Box<dyn Link>,
    /// The window, once it has been shown.
    pub(in crate::app) window: Option<Context>,
    /// The window's device, where pictures may lie.
    pub(in crate::app) device: Option<RenderState>,
    pub(in crate::app) start: Start,
    /// Where the scene that is shown comes from.
    pub(in crate::app) source: Source,
    /// How it was opened.
    pub(in crate::app) opened: Opening,
    /// Scenes that were asked for and have not come, with the numbers of their loads.
    pub(in crate::app) asked: BTreeMap<u64, (Source, Opening)>,
    /// The number of the last load.
    pub(in crate::app) loads: u64,
    /// The load that brings the present scene back to a studio that was started again.
    pub(in crate::app) reopening: Option<u64>,
    /// Bakes in use.
    pub(in crate::app) bakes: Vec<PathBuf>,
    pub(in crate::app) scene: Option<SceneSummary>,
    pub(in crate::app) navigator: Option<Navigator>,
    /// Index of the camera that was chosen last, until the user moves.
    pub(in crate::app) camera: Option<usize>,
    pub(in crate::app) choices: [Choice; 2],
    pub(in crate::app) samples: u32,
    /// `None`: the one that the scene needs.
    pub(in crate::app) order: Option<u32>,
    pub(in crate::app) display: Display,
    /// Where the divider is, from 0 to 1; `None`: the left side alone.
    pub(in crate::app) divider: Option<f32>,
    pub(in crate::app) shows_heat: bool,
    /// The overlay of the left side, as far as its method has it.
    pub(in crate::app) overlays: BTreeSet<OverlayKind>,
    pub(in crate::app) changes: Changes,
    pub(in crate::app) clock: Clock,
    /// The animation that plays alone.
    pub(in crate::app) clip: Option<usize>,
    pub(in crate::app) shows_panels: bool,
    /// The panels are unfolded where the window is too narrow for both.
    pub(in crate::app) is_unfolded: bool,
    /// The window is too narrow for panels beside the picture.
    pub(in crate::app) is_narrow: bool,
    /// The window's title, once it was set.
    pub(in crate::app) title: String,
    /// Steps of changes.
    pub(in crate::app) history: History,
    /// A scene that could not be opened.
    pub(in crate::app) failed: Option<Failed>,
    pub(in crate::app) listener: Option<Listener>,
    /// The status line's words on the processor.
    pub(in crate::app) remark: String,
    /// Files that are being saved.
    pub(in crate::app) saves: Vec<Saved>,
    /// The program that makes reports and bakes.
    #[cfg(not(target_family = "wasm"))]
    pub(in crate::app) program: Option<PathBuf>,
    /// The errand of the moment.
    #[cfg(not(target_family = "wasm"))]
    pub(in crate::app) errands: Vec<Errand>,
    /// Paths that the user is asked for.
    #[cfg(not(target_family = "wasm"))]
    pub(in crate::app) questions: Vec<Question>,
    /// The system shows dialogues, as far as is known.
    #[cfg(not(target_family = "wasm"))]
    pub(in crate::app) has_dialogues: bool,
    /// Files that are being chosen.
    #[cfg(target_family = "wasm")]
    pub(in crate::app) opening: Option<file::Choice>,
    pub(in crate::app) tool: Tool,
    pub(in crate::app) grip: Option<Grip>,
    /// How the environment is to be turned and scaled, as long as the hand changes it.
    pub(in crate::app) light_in_hand: Option<EnvironmentEdit>,
    /// The order to pick whose answer the view is to turn about.
    pub(in crate::app) focus: Option<u64>,
    /// The number of the last order to pick.
    pub(in crate::app) picks: u64,
    /// Where the picture is in the window, in points, and its size in pixels.
    pub(in crate::app) rect: egui::Rect,
    pub(in crate::app) size: [u32; 2],
    /// The last wish that was sent.
    pub(in crate::app) sent: Option<Arc<Wish>>,
    pub(in crate::app) shown: Shown,
}
