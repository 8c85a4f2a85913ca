//! Paths that took more work than a frame has for them: not every frame tries them again.
//!
//! The work of a path depends on how large its first mirror appears, and from which side. A path that has failed is
//! therefore not tried again before the view has changed by [`CHANGED`] or anything has moved, nor within some frames,
//! twice as many after every further failure; or before frames have twice the work. All of that is counted in frames
//! and work, so the same sequence of frames gives the same pictures.

use catoptric_core::math::Aabb;
use catoptric_core::scene::{Projection, Scene, View};
use catoptric_engine::method::projector::{PathBeginning, PathBeginnings};
use glam::Vec3;
use std::collections::BTreeMap;

/// A view has changed where its eye has moved by this share of its distance from the path's first mirror, where it has
/// turned by this angle in radians, or where its pixels have become smaller or larger by this share. Either way the
/// mirror is seen from the side by about this angle, or larger by less than twice its area, which work goes by: then a
/// path that took too much work probably still does.
const CHANGED: f32 = 0.25;

/// Frames with this many times the work try again. Below the difference is no more than that of two views that are
/// alike.
const MUCH_MORE_WORK: u64 = 2;

/// Frames without a try after the first failure, and the most after many. Trying always costs about as much as a
/// frame: even where everything moves all the time it adds no more than an eighth, and in the end next to nothing.
const FIRST_WAIT: u64 = 8;
const LONGEST_WAIT: u64 = 256;

/// The failures of paths so far.
#[derive(Clone, Debug, Default)]
pub(crate) struct FailedPaths {
    /// The number of the frame.
    frame: u64,
    failures: BTreeMap<PathBeginning, PathFailure>,
}

/// A path's last failure.
#[derive(Clone, Debug)]
struct PathFailure {
    view: View,
    /// The bounding box of its first mirror.
    bounds: Aabb,
    /// The work of the frame.
    work: u64,
    frame: u64,
    /// Frames without a try.
    wait: u64,
    /// Anything has moved since.
    is_outdated: bool,
}

impl PathFailure {
    /// True if a view differs much from the one in which the path has failed.
    fn has_changed(&self, now: &View) -> bool {
        let same_kind = match (self.view.projection, now.projection) {
            (Projection::Perspective { .. }, Projection::Perspective { .. }) => true,
            (Projection::Orthographic { .. }, Projection::Orthographic { .. }) => true,
            (Projection::Perspective { .. }, Projection::Orthographic { .. })
            | (Projection::Orthographic { .. }, Projection::Perspective { .. }) => false,
        };
        let scale = self.view.pixel_size() / now.pixel_size();
        let (eye, moved) = (self.view.eye(), self.view.eye().distance(now.eye()));
        // Within the mirror's box its size stands in for the distance.
        let distance = (self.bounds.center() - eye).length().max(0.5 * self.bounds.diagonal());
        let axes = |view: &View| [view.world_from_view.matrix3.z_axis, view.world_from_view.matrix3.y_axis];
        let turned = axes(&self.view).into_iter().zip(axes(now));
        // The chord of an angle is about that angle.
        let most_turned = turned.map(|(then, now)| then.distance(now)).fold(0.0, f32::max);
        // Values that are not numbers count as changed.
        let is_like = same_kind
            && scale.max(1.0 / scale) <= 1.0 + CHANGED
            && moved <= CHANGED * distance
            && most_turned <= CHANGED;
        !is_like
    }
}

impl FailedPaths {
    /// Begins a frame of a view with so much work, and returns the paths that it does not try.
    pub(crate) fn begin_frame(&mut self, view: &View, work: u64) -> PathBeginnings {
        self.frame += 1;
        let mut known = PathBeginnings::default();
        for (beginning, failure) in &self.failures {
            let has_changed = failure.is_outdated || failure.has_changed(view);
            let is_due = has_changed && self.frame - failure.frame > failure.wait;
            if !is_due && work < MUCH_MORE_WORK.saturating_mul(failure.work) {
                known.add(beginning.clone());
            }
        }
        known
    }

    /// Something has moved: work may have changed in any view.
    pub(crate) fn outdate(&mut self) {
        self.failures.values_mut().for_each(|failure| failure.is_outdated = true);
    }

    /// Notes the outcomes of a frame's tries: paths that failed, and paths that did not.
    pub(super) fn note(&mut self, tries: &PathTries, (scene, view): (&Scene, &View), work: u64) {
        self.failures.retain(|beginning, _| !tries.done.contains(beginning));
        for beginning in tries.failed.iter() {
            let known = self.failures.get(beginning);
            if known.is_some_and(|known| known.frame == self.frame) {
                continue;
            }
            let wait = known.map_or(FIRST_WAIT, |known| (2 * known.wait).min(LONGEST_WAIT));
            let first = beginning.0.first().map_or(beginning.1, |bounce| bounce.object);
            let none = Aabb { min: Vec3::ZERO, max: Vec3::ZERO };
            let bounds = scene.objects.get(first as usize).map_or(none, |object| object.bounds);
            let (view, frame) = (view.clone(), self.frame);
            let failure = PathFailure { view, bounds, work, frame, wait, is_outdated: false };
            self.failures.insert(beginning.clone(), failure);
        }
    }
}

/// The paths of a frame that are done as a whole or not at all.
#[derive(Debug, Default)]
pub(super) struct WholePaths {
    /// Paths that are left to something else.
    pub(super) undone: PathBeginnings,
    /// The number of these that were not tried, as they have failed before.
    pub(super) not_tried: u64,
    pub(super) tries: PathTries,
}

/// The outcomes of the paths that a frame has tried.
#[derive(Debug, Default)]
pub(super) struct PathTries {
    /// Paths that are drawn completely.
    pub(super) done: PathBeginnings,
    /// Paths that took more work than is allowed, though others had left enough for a fair try.
    pub(super) failed: PathBeginnings,
}
