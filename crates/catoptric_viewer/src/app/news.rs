//! Reads what the studio tells.

use super::state::overlay::ShownOverlay;
use super::state::shown::{Failed, Shown, ShownComparison};
use super::state::{Viewer, ViewerEvent};
use crate::studio::news::{Compared, News, SceneSummary};
use crate::studio::order::{Changes, Opening, Order};
use eframe::egui::{ColorImage, Context, TextureOptions};

/// The act that users are asked to repeat once drawing has stopped: words for the message.
const AGAIN: &str = if cfg!(target_family = "wasm") { "load the page" } else { "start the program" };

impl Viewer {
    /// Takes all news in.
    pub(super) fn read_news(&mut self, ctx: &Context) {
        while let Some(news) = self.link.news() {
            match news {
                News::Busy { stage, share } => self.shown.busy = Some((stage, share)),
                News::Remark { text } => self.remark(text),
                News::Message { text } => self.say(text),
                News::Idle => self.shown.busy = None,
                News::Restarted { problem } => self.recover(&problem),
                News::Stopped { problem } => {
                    (self.shown.busy, self.reopening) = (None, None);
                    self.say(format!("drawing has stopped because of an error; please {AGAIN} again: {problem}"));
                }
                News::Loaded(summary) => self.take_scene(*summary),
                News::NotLoaded { number, problem } => {
                    if let Some((source, _)) = self.asked.remove(&number) {
                        self.failed = Some(Failed { name: source.word(), reason: problem.clone() });
                    }
                    self.say(problem);
                    match self.reopening {
                        Some(reopening) if reopening == number => self.reopening = None,
                        // The load that brings the scene back was forgotten for this one.
                        Some(_) => self.reopen(),
                        None => {}
                    }
                }
                News::Drawn(picture) => {
                    if self.is_current(picture.wish.scene) {
                        picture.report.warnings.iter().for_each(|warning| self.shown.say(warning.as_str()));
                        let is_whole = picture.is_whole;
                        self.shown.put(ctx, self.device.as_ref(), *picture);
                        if is_whole {
                            self.tell(ViewerEvent::Sharp);
                        }
                    }
                }
                News::NotDrawn { wish, side, problem } => {
                    if self.is_current(wish.scene) {
                        self.shown.pictures[side.min(1)] = None;
                        self.say(problem);
                    }
                }
                News::Compared(compared) => self.put_comparison(ctx, *compared),
                News::Placed(places) => {
                    if let Some(picked) = self.shown.picked.as_mut().filter(|picked| picked.number == places.number) {
                        picked.places = Some(*places);
                    }
                }
                News::Overlaid(mut overlaid) => {
                    if self.shows_same(&overlaid.wish) {
                        overlaid.problem.take().into_iter().for_each(|problem| self.say(problem));
                        self.shown.overlays.retain(|shown| shown.overlay.kind != overlaid.overlay.kind);
                        self.shown.overlays.push(ShownOverlay::new(ctx, *overlaid));
                    }
                }
                News::Picked { number, path } => {
                    if let Some(picked) = self.shown.picked.as_mut().filter(|picked| picked.number == number) {
                        picked.path = path;
                    }
                    self.turn_about_picked(number);
                }
            }
        }
    }

    fn is_current(&self, scene: u64) -> bool {
        self.scene.as_ref().is_some_and(|summary| summary.number == scene)
    }

    /// Has a studio that was started again show what was shown before: first of all it needs the scene.
    fn recover(&mut self, problem: &str) {
        self.shown.busy = None;
        self.say(format!("drawing has failed and was started again: {problem}"));
        for path in self.bakes.clone() {
            self.link.send(Order::UseBake { path });
        }
        let mut lost = std::mem::take(&mut self.asked);
        if let Some(reopening) = self.reopening.take() {
            lost.remove(&reopening);
        }
        if self.scene.is_some() {
            // One of them may be why it has failed.
            for (source, _) in lost.into_values() {
                self.say(format!("`{}` was not opened because of that; please open it again", source.word()));
            }
            self.reopen();
        } else if let Some((_, (source, opening))) = lost.pop_last() {
            self.open_as(source, opening);
        }
    }

    /// Loads the scene that is shown, which keeps its changes and its camera.
    fn reopen(&mut self) {
        self.light(self.opened.clone());
    }

    /// Opens the scene that is shown in another way, in other light for instance; its changes and its camera stay.
    pub(super) fn light(&mut self, opening: Opening) {
        self.open_as(self.source.clone(), opening);
        self.reopening = Some(self.loads);
    }

    /// Takes a scene that was loaded.
    fn take_scene(&mut self, summary: SceneSummary) {
        // Nobody waits any more for what was asked of a studio that has failed.
        if !self.asked.contains_key(&summary.number) {
            return;
        }
        if self.reopening.take() == Some(summary.number) {
            if let Some((_, opened)) = self.asked.remove(&summary.number) {
                self.opened = opened;
            }
            (self.sent, self.scene) = (None, Some(summary));
        } else {
            self.begin_scene(summary);
        }
    }

    /// Shows a scene that was loaded.
    fn begin_scene(&mut self, summary: SceneSummary) {
        // Scenes that were asked for before this one will not come any more.
        let later = self.asked.split_off(&(summary.number + 1));
        if let Some(source) = std::mem::replace(&mut self.asked, later).remove(&summary.number) {
            (self.source, self.opened) = source;
        }
        self.shown = Shown::default();
        summary.warnings.iter().for_each(|warning| self.say(warning.as_str()));
        (self.changes, self.history, self.failed) = (Changes::default(), Default::default(), None);
        self.begin_view(&summary);
        self.tell(ViewerEvent::Loaded(&summary.name));
        (self.sent, self.scene) = (None, Some(summary));
    }

    fn put_comparison(&mut self, ctx: &Context, compared: Compared) {
        let Compared { wish, flip_mean, over_0_1, heat_rgb, size } = compared;
        // The comparison may be of another picture than the one that is wanted now.
        if !self.shows_same(&wish) {
            return;
        }
        let image = ColorImage::from_rgb(size.map(|length| length as usize), &heat_rgb);
        let texture = ctx.load_texture("heat map", image, TextureOptions::LINEAR);
        self.shown.compared = Some(ShownComparison { texture, wish, flip_mean, over_0_1 });
    }
}
