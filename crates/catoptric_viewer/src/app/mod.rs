//! The window's content, in egui: what is shown, and what the user wants.

mod begin;
mod card;
mod hand;
mod keys;
mod link;
mod marks;
mod news;
mod panels;
mod picture;
mod settings;
mod state;
mod take_away;
mod theme;
mod words;

#[cfg(not(target_family = "wasm"))]
pub use link::StudioThread;
pub use link::{Link, Restarts};
pub use settings::read_settings;
pub use state::start::{FirstExposure, FirstEye, FirstView, Start};
pub use state::{Listener, Viewer, ViewerEvent};

use crate::studio::news::SceneSummary;
#[cfg(target_family = "wasm")]
use crate::studio::order::Beside;
use crate::studio::order::{Changes, Drawn, Opening, Order, Source, Wish, scene_of};
use crate::studio::places::Places;
use catoptric::error::RenderError;
use catoptric::framebuffer::Framebuffer;
use catoptric::methods::overlay::{Overlay, OverlayKind};
use catoptric::methods::{self, Quality};
use catoptric::tone::Display;
use eframe::egui::{self, Context, Ui};
use eframe::egui_wgpu::RenderState;
use glam::{DVec3, Vec3};
use state::Choice;
use state::clock::Clock;
use state::grip::Tool;
use state::history::History;
use state::navigator::Navigator;
use state::shown::{Shown, ShownPicture};
use std::collections::{BTreeMap, BTreeSet};
#[cfg(not(target_family = "wasm"))]
use std::path::Path;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::TryRecvError;
#[cfg(target_family = "wasm")]
use take_away::files;

impl Viewer {
    /// Opens the first scene; `device` is the window's, if the studio draws on it.
    pub fn new(link: Box<dyn Link>, device: Option<RenderState>, start: Start) -> Self {
        let choice = |method: &str| Choice { method: method.into(), settings: BTreeMap::new() };
        let right = start.against.clone().unwrap_or_else(|| "reference".into());
        let mut choices = [choice(&start.method), choice(&right)];
        choices[0].settings.insert(start.method.clone(), start.settings.clone());
        let mut viewer = Self {
            link,
            window: None,
            device,
            source: start.source.clone(),
            opened: Opening::default(),
            asked: BTreeMap::new(),
            loads: 0,
            reopening: None,
            bakes: Vec::new(),
            scene: None,
            navigator: None,
            camera: None,
            choices,
            samples: start.samples,
            order: start.order,
            display: Display::default(),
            divider: start.against.is_some().then_some(0.5),
            shows_heat: false,
            overlays: BTreeSet::new(),
            changes: Changes::default(),
            clock: Clock::default(),
            clip: None,
            shows_panels: start.panels,
            is_unfolded: false,
            is_narrow: false,
            title: String::new(),
            history: History::default(),
            failed: None,
            listener: None,
            remark: String::new(),
            saves: Vec::new(),
            #[cfg(not(target_family = "wasm"))]
            program: start.program.clone(),
            #[cfg(not(target_family = "wasm"))]
            errands: Vec::new(),
            #[cfg(not(target_family = "wasm"))]
            questions: Vec::new(),
            #[cfg(not(target_family = "wasm"))]
            has_dialogues: true,
            #[cfg(target_family = "wasm")]
            opening: None,
            tool: Tool::Turn,
            grip: None,
            light_in_hand: None,
            focus: None,
            picks: 0,
            rect: egui::Rect::NOTHING,
            size: [0, 0],
            sent: None,
            shown: Shown::default(),
            start,
        };
        viewer.open(viewer.source.clone());
        std::mem::take(&mut viewer.start.bakes).into_iter().for_each(|path| viewer.use_bake(path));
        viewer
    }

    /// The window, once it has been shown.
    pub fn window(&self) -> Option<&Context> {
        self.window.as_ref()
    }

    /// The picture that is wanted now; `None` until a scene is there.
    pub fn wish(&self) -> Option<&Wish> {
        self.sent.as_deref()
    }

    /// Where the eye is wanted, in the coordinates of the scene's file.
    pub fn eye(&self) -> Option<DVec3> {
        let eye = Vec3::from(self.wish()?.camera.world_from_camera.translation);
        Some(self.scene.as_ref()?.origin + eye.as_dvec3())
    }

    /// The picture of a side that is shown, in linear colours.
    pub fn picture(&self, side: usize) -> Option<&Framebuffer> {
        self.shown.pictures.get(side)?.as_ref()?.linear.as_deref()
    }

    /// True if everything that is wanted is shown, with all pixels and samples.
    pub fn is_sharp(&self) -> bool {
        if self.reopening.is_some() {
            return false;
        }
        let Some(wish) = &self.sent else { return false };
        let is_whole = |picture: &Option<ShownPicture>| {
            picture.as_ref().is_some_and(|picture| picture.is_whole && picture.wish.shows_same(wish))
        };
        self.shown.pictures.iter().take(wish.sides.len()).all(is_whole) && self.shown.busy.is_none()
    }

    /// Where the picture is in the window, in points.
    pub fn picture_rect(&self) -> egui::Rect {
        self.rect
    }

    /// The error of the left side against the right one, where it is shown: the mean of FLIP.
    pub fn flip_mean(&self) -> Option<f64> {
        let compared = self.shown.compared.as_ref()?;
        self.shows_same(&compared.wish).then_some(compared.flip_mean)
    }

    /// An overlay of the left side, if it is wanted and of the picture that is wanted now.
    pub fn overlay(&self, kind: OverlayKind) -> Option<&Overlay> {
        let shown = self.shown.overlays.iter().find(|shown| shown.overlay.kind == kind)?;
        (self.overlays.contains(&kind) && self.shows_same(&shown.wish)).then_some(&shown.overlay)
    }

    /// Where the picked point appears by several methods, if that was asked of the picture that is wanted now.
    pub fn places(&self) -> Option<&Places> {
        let places = self.shown.picked.as_ref()?.places.as_ref()?;
        self.shows_same(&places.wish).then_some(places)
    }

    /// True for wishes for the same pictures as the present one.
    fn shows_same(&self, wish: &Wish) -> bool {
        self.sent.as_ref().is_some_and(|sent| sent.shows_same(wish))
    }

    /// The wish that the picture of a side was drawn for, which may be older than the present one.
    pub fn picture_wish(&self, side: usize) -> Option<&Arc<Wish>> {
        Some(&self.shown.pictures.get(side)?.as_ref()?.wish)
    }

    /// The same as 8-bit sRGB, four bytes a pixel.
    pub fn pixels(&self, side: usize) -> Option<&[u8]> {
        self.shown.pictures.get(side)?.as_ref().map(|picture| picture.rgba.as_slice())
    }

    /// The number of pictures that the left side has shown of the scene.
    pub fn pictures_shown(&self) -> u64 {
        self.shown.pictures_shown
    }

    /// The name of the scene that is shown.
    pub fn scene_name(&self) -> Option<&str> {
        self.scene.as_ref().map(|scene| scene.name.as_str())
    }

    /// The processor that has drawn the left side.
    pub fn processor(&self) -> Option<&str> {
        self.shown.pictures[0].as_ref().map(|picture| picture.processor.as_str())
    }

    /// Tells somebody what happens from now on.
    pub fn listen(&mut self, listener: Listener) {
        self.listener = Some(listener);
    }

    fn tell(&self, event: ViewerEvent<'_>) {
        if let Some(listener) = &self.listener {
            listener(event);
        }
    }

    /// Tells the user something.
    fn say(&mut self, message: impl Into<String>) {
        let message = message.into();
        self.tell(ViewerEvent::Message(&message));
        self.shown.say(message);
    }

    /// Tells the user what was done.
    fn note(&mut self, message: impl Into<String>) {
        let message = message.into();
        self.tell(ViewerEvent::Message(&message));
        let now = self.window.as_ref().map_or(0.0, |window| window.input(|input| input.time));
        self.shown.note(message, now);
        self.wake_up();
    }

    /// Which processor draws, and why that one; empty where there is nothing to say.
    pub fn remarks(&self) -> &str {
        &self.remark
    }

    /// Says what draws, and why.
    pub fn remark(&mut self, remark: impl Into<String>) {
        self.remark = remark.into();
    }

    /// Chooses the method of a side: 0 is left, 1 right, where an empty name ends the split view.
    ///
    /// # Errors
    /// [`RenderError::UnknownMethod`].
    pub fn choose(&mut self, side: usize, method: &str) -> Result<(), RenderError> {
        if side == 1 {
            self.divider = (!method.is_empty()).then(|| self.divider.unwrap_or(0.5));
        }
        if let (Some(choice), false) = (self.choices.get_mut(side), method.is_empty()) {
            choice.method = methods::find(method)?.id.into();
        }
        self.wake_up();
        Ok(())
    }

    /// Gives the method of a side settings over the scene's, as [`read_settings`] reads them, in place of those that
    /// the user gave it.
    ///
    /// # Errors
    /// Words about what the method does not take.
    pub fn configure(&mut self, side: usize, text: &str) -> Result<(), String> {
        let Some(Choice { method, settings }) = self.choices.get_mut(side) else { return Ok(()) };
        let info = methods::find(method).map_err(|error| error.to_string())?;
        settings.insert(info.id.into(), read_settings(info, text)?);
        self.wake_up();
        Ok(())
    }

    /// Puts the divider of the split view, from 0 (left) to 1.
    pub fn set_divider(&mut self, share: f32) {
        self.divider = Some(share.clamp(0.02, 0.98));
    }

    /// The messages that the user was shown, the newest last.
    pub fn messages(&self) -> impl Iterator<Item = &str> {
        self.shown.messages.iter().map(|message| message.text.as_str())
    }

    /// Loads a scene; the one that is shown stays until it is there.
    pub fn open(&mut self, source: Source) {
        let opening = self.opening_of(&source);
        self.open_as(source, opening);
    }

    /// The same, in a certain way.
    fn open_as(&mut self, source: Source, opening: Opening) {
        self.loads += 1;
        self.asked.insert(self.loads, (source.clone(), opening.clone()));
        self.link.send(Order::Load { number: self.loads, source, opening });
        self.wake_up();
    }

    /// Opens a file: a scene, or a bake by its extension.
    #[cfg(not(target_family = "wasm"))]
    fn open_file(&mut self, path: &Path) {
        match path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("bake")) {
            true => self.use_bake(path.into()),
            false => self.open(Source::File(path.into())),
        }
    }

    /// Has a bake used wherever it fits.
    fn use_bake(&mut self, path: PathBuf) {
        self.bakes.push(path.clone());
        self.link.send(Order::UseBake { path });
    }

    /// Has the window shown again, which rests where nothing happens in it.
    fn wake_up(&self) {
        if let Some(window) = &self.window {
            window.request_repaint();
        }
    }

    /// Shows everything for a frame of the window.
    pub fn show(&mut self, ui: &mut Ui) {
        self.window.get_or_insert_with(|| {
            theme::set(ui.ctx());
            ui.ctx().clone()
        });
        self.read_news(ui.ctx());
        self.take_dropped_files(ui.ctx());
        self.follow_saves();
        #[cfg(target_family = "wasm")]
        self.follow_opening();
        #[cfg(not(target_family = "wasm"))]
        {
            self.follow_dialogues();
            self.follow_errands();
        }
        self.follow_keys(ui.ctx());
        if self.shows_panels {
            panels::show(self, ui);
        }
        picture::show(self, ui);
        card::show(self, ui.ctx());
        #[cfg(not(target_family = "wasm"))]
        self.show_question(ui.ctx());
        if !ui.input(|input| input.pointer.any_down()) {
            self.history.record(&self.changes);
        }
        self.name_window(ui.ctx());
        self.send_wish(ui.ctx());
    }

    /// Has the window's title name what is shown.
    fn name_window(&mut self, ctx: &Context) {
        // Titles of pages are the page's.
        if cfg!(target_family = "wasm") {
            return;
        }
        let name = match &self.scene {
            Some(_) => self.source.short_name(),
            None => return,
        };
        let title = format!("{name} - catoptric");
        if self.title != title {
            ctx.send_viewport_cmd(egui::ViewportCommand::Title(title.clone()));
            self.title = title;
        }
    }

    /// Tells the studio what is wanted now, if that has changed.
    fn send_wish(&mut self, ctx: &Context) {
        if self.clock.advance(ctx) {
            ctx.request_repaint();
        }
        let (Some(scene), Some(navigator)) = (&self.scene, &self.navigator) else { return };
        if self.size.contains(&0) {
            return;
        }
        let mut sides = vec![self.drawn(0, scene)];
        if self.divider.is_some() {
            sides.push(self.drawn(1, scene));
        }
        let wish = Wish {
            scene: scene.number,
            time: self.clock.time(),
            clip: self.clip,
            changes: self.changes_in_force(),
            camera: navigator.camera().clone(),
            size: self.size,
            sides,
            has_automatic_order: self.order.is_none(),
            display: self.display,
            compares: self.shows_heat && self.divider.is_some(),
            overlays: self.overlays.iter().copied().collect(),
        };
        if self.sent.as_deref() != Some(&wish) {
            let wish = Arc::new(wish);
            self.sent = Some(wish.clone());
            self.link.wish(wish);
        }
    }

    /// The user's changes over the roles that the scene was opened with.
    fn changes_in_force(&self) -> Changes {
        let mut changes = self.changes.clone();
        changes.roles.splice(0..0, self.opened.roles.iter().cloned());
        changes
    }

    /// The method of a side, with the scene's settings and the user's over them, and the quality.
    fn drawn(&self, side: usize, scene: &SceneSummary) -> Drawn {
        let Choice { method, settings } = &self.choices[side];
        let mut all = scene.settings.get(method).cloned().unwrap_or_default();
        all.extend(settings.get(method).cloned().unwrap_or_default());
        // Bakes have the order 2, where none was named.
        let needed = if self.bakes.is_empty() { scene.order_needed } else { 2 };
        let quality = Quality { samples: self.samples, order: self.order.unwrap_or(needed) };
        Drawn { method: method.clone(), settings: all, quality }
    }

    fn take_dropped_files(&mut self, ctx: &Context) {
        let dropped = ctx.input(|input| input.raw.dropped_files.clone());
        if dropped.is_empty() {
            return;
        }
        #[cfg(not(target_family = "wasm"))]
        {
            let names: Vec<String> = dropped.iter().map(|file| file.path().display().to_string()).collect();
            if let Some(scene) = scene_of(names.iter().map(String::as_str)) {
                self.open_file(dropped[scene].path());
            }
        }
        #[cfg(target_family = "wasm")]
        {
            self.opening = Some(files::read_dropped(dropped));
            ctx.request_repaint();
        }
    }

    /// Learns what has become of files that are saved.
    fn follow_saves(&mut self) {
        for save in std::mem::take(&mut self.saves) {
            match save.try_recv() {
                Ok(Ok(path)) => self.note(format!("saved to {}", path.display())),
                Ok(Err(problem)) => self.say(problem),
                Err(TryRecvError::Empty) => self.saves.push(save),
                Err(TryRecvError::Disconnected) => {}
            }
        }
    }

    /// Learns what has become of files that are being chosen.
    #[cfg(target_family = "wasm")]
    fn follow_opening(&mut self) {
        let Some(opening) = &self.opening else { return };
        match opening.try_recv() {
            Ok(Ok(contents)) => self.open_contents(contents),
            Ok(Err(problem)) => self.say(problem),
            Err(TryRecvError::Empty) => return,
            Err(TryRecvError::Disconnected) => {}
        }
        self.opening = None;
    }

    /// Opens that of several files which is a scene.
    #[cfg(target_family = "wasm")]
    fn open_contents(&mut self, mut contents: Vec<(String, Vec<u8>)>) {
        let Some(scene) = scene_of(contents.iter().map(|(name, _)| name.as_str())) else { return };
        let (name, bytes) = contents.swap_remove(scene);
        let beside = Beside(Arc::new(contents.into_iter().collect()));
        self.open(Source::Bytes { name, bytes: bytes.into(), beside });
    }

    fn frame_all(&mut self) {
        if let (Some(scene), Some(navigator)) = (&self.scene, &mut self.navigator) {
            navigator.frame(&scene.bounds);
            self.camera = None;
        }
    }

    fn toggle_panels(&mut self) {
        if self.shows_panels && self.is_narrow {
            self.is_unfolded = !self.is_unfolded;
        } else {
            self.shows_panels = !self.shows_panels;
        }
    }

    fn toggle_split(&mut self) {
        self.divider = if self.divider.is_some() { None } else { Some(0.5) };
        self.shown.compared = None;
    }

    fn toggle_heat(&mut self) {
        self.shows_heat = !self.shows_heat;
        if self.shows_heat && self.divider.is_none() {
            self.divider = Some(0.5);
        }
    }

    /// Looks through a camera of the scene, by its index.
    fn take_camera(&mut self, index: usize) {
        if let Some(scene) = &self.scene
            && let Some(camera) = scene.cameras.get(index)
        {
            self.navigator = Some(Navigator::new(camera.clone(), &scene.bounds));
            self.camera = Some(index);
        }
    }
}

impl eframe::App for Viewer {
    fn ui(&mut self, ui: &mut Ui, _frame: &mut eframe::Frame) {
        self.show(ui);
    }

    #[cfg(target_family = "wasm")]
    fn as_any_mut(&mut self) -> Option<&mut dyn std::any::Any> {
        Some(self)
    }

    fn clear_color(&self, _visuals: &egui::Visuals) -> [f32; 4] {
        [0.0, 0.0, 0.0, 1.0]
    }
}
