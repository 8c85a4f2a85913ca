//! The frames that are drawn one after the other, and what moves between them.

use glam::{Affine3A, Quat, Vec3};
use std::ops::Range;

/// Frames a second where nothing else is asked for.
pub(crate) const FRAMES_PER_SECOND: f32 = 30.0;

/// Frames of a scene.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sequence {
    /// The first one, counted from 0.
    pub(crate) first: u32,
    /// How many there are.
    pub(crate) count: u32,
    pub(crate) frames_per_second: f32,
    /// The scene's animation plays, if it has one.
    pub(crate) plays_animation: bool,
    /// Frames in which the eye goes once around the middle of the scene.
    pub(crate) turn: Option<u32>,
}

impl From<u32> for Sequence {
    /// This many frames from the first, which stand still if no other motion is asked for.
    fn from(count: u32) -> Self {
        Self { first: 0, count, frames_per_second: FRAMES_PER_SECOND, plays_animation: false, turn: None }
    }
}

impl Sequence {
    /// The frames, counted from 0.
    pub(crate) fn frames(&self) -> Range<u32> {
        self.first..self.first + self.count
    }

    /// The time of a frame, in seconds, where the first of all is at a time.
    pub(crate) fn time_of(&self, frame: u32, of_first: f32) -> f32 {
        of_first + frame as f32 / self.frames_per_second
    }
}

/// A turn by an angle about a line through a point.
pub(crate) fn turn_about(pivot: Vec3, axis: Vec3, angle: f32) -> Affine3A {
    Affine3A::from_translation(pivot)
        * Affine3A::from_quat(Quat::from_axis_angle(axis, angle))
        * Affine3A::from_translation(-pivot)
}
