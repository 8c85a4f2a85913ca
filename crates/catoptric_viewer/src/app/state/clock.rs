//! The time in the scene's animations.

use eframe::egui::Context;

/// Plays animations, over and over.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::app) struct Clock {
    time: f32,
    /// The length of the animations in seconds; 0 without any.
    duration: f32,
    plays: bool,
}

impl Clock {
    /// Begins with the animations of another scene.
    pub(in crate::app) fn begin(&mut self, duration: f32) {
        *self = Self { time: 0.0, duration: duration.max(0.0), plays: false };
    }

    /// The time now, in seconds.
    pub(in crate::app) fn time(&self) -> f32 {
        self.time
    }

    /// The length of the animations; 0 without any.
    pub(in crate::app) fn duration(&self) -> f32 {
        self.duration
    }

    /// True while they play.
    pub(in crate::app) fn plays(&self) -> bool {
        self.plays
    }

    /// Goes to a time.
    pub(in crate::app) fn set(&mut self, time: f32) {
        self.time = time.clamp(0.0, self.duration);
    }

    /// Plays or stops.
    pub(in crate::app) fn toggle(&mut self) {
        self.plays = !self.plays && self.duration > 0.0;
    }

    /// Goes on by the time since the window's last frame. Returns true while it plays.
    pub(in crate::app) fn advance(&mut self, ctx: &Context) -> bool {
        if self.plays {
            let step = ctx.input(|input| input.stable_dt).min(0.1);
            self.time = (self.time + step) % self.duration.max(1e-3);
        }
        self.plays
    }
}
