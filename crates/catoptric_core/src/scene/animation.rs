//! Animation: the values of channels between their keys, as glTF interpolates them.

use super::model::{Animation, Channel, ChannelValues, Interpolation, LocalTransform, Model};
use crate::error::SceneError;
use crate::math::portable::between_turns;
use glam::{Quat, Vec3};

impl Model {
    /// The index of the animation of this name, else of the one with this index.
    ///
    /// # Errors
    /// [`SceneError::Unknown`], with a list of those that there are.
    pub fn animation_index(&self, wanted: &str) -> Result<usize, SceneError> {
        let names = || self.animations.iter().map(|animation| animation.name.as_str());
        let named = names().position(|name| name == wanted && !name.is_empty());
        let by_index = || wanted.parse().ok().filter(|index| *index < self.animations.len());
        named.or_else(by_index).ok_or_else(|| {
            let listed: Vec<String> = names().enumerate().map(|(index, name)| format!("{index} `{name}`")).collect();
            let listed = if listed.is_empty() { "none in this scene".into() } else { listed.join(", ") };
            SceneError::unknown("animation", wanted, names(), listed)
        })
    }
}

impl Animation {
    /// The time of its last key, in seconds; 0 without keys.
    pub fn duration(&self) -> f32 {
        self.channels.iter().filter_map(|channel| channel.times.last().copied()).fold(0.0, f32::max)
    }
}

impl ChannelValues {
    /// A number for the property that the values are of.
    pub(super) fn property(&self) -> u8 {
        match self {
            Self::Translation(_) => 0,
            Self::Rotation(_) => 1,
            Self::Scale(_) => 2,
            Self::Weights { .. } => 3,
        }
    }
}

/// The keys around a time: their indices, the position between them (0..1), and their distance in seconds.
struct KeySpan {
    left: usize,
    right: usize,
    position: f32,
    duration: f32,
}

impl Channel {
    fn span(&self, time: f32) -> Option<KeySpan> {
        let last = self.times.len().checked_sub(1)?;
        let right = self.times.partition_point(|key| *key <= time).min(last);
        let left = if self.times[right] <= time { right } else { right.saturating_sub(1) };
        let duration = self.times[right] - self.times[left];
        let position = if duration > 0.0 { ((time - self.times[left]) / duration).clamp(0.0, 1.0) } else { 0.0 };
        Some(KeySpan { left, right, position, duration })
    }

    /// The value at a time. `None` when there are too few values for the keys.
    fn value<T: Copy>(
        &self,
        span: &KeySpan,
        values: &[T],
        add: impl Fn(T, T) -> T,
        scale: impl Fn(T, f32) -> T,
        between: impl Fn(T, T, f32) -> T,
    ) -> Option<T> {
        match self.interpolation {
            Interpolation::Step => values.get(span.left).copied(),
            Interpolation::Linear => Some(between(*values.get(span.left)?, *values.get(span.right)?, span.position)),
            Interpolation::CubicSpline => {
                let (v0, v1) = (*values.get(span.left * 3 + 1)?, *values.get(span.right * 3 + 1)?);
                let (out0, in1) = (*values.get(span.left * 3 + 2)?, *values.get(span.right * 3)?);
                let [h00, h10, h01, h11] = hermite(span.position);
                let values = add(scale(v0, h00), scale(v1, h01));
                let tangents = add(scale(out0, h10 * span.duration), scale(in1, h11 * span.duration));
                Some(add(values, tangents))
            }
        }
    }

    /// Sets a node's transform or weights to their values at a time.
    pub(super) fn apply(&self, time: f32, local: &mut LocalTransform, weights: &mut Option<Vec<f32>>) {
        let Some(span) = self.span(time) else { return };
        let vector = |values: &[Vec3]| self.value(&span, values, |a, b| a + b, |a, s| a * s, Vec3::lerp);
        match (&self.values, local) {
            (ChannelValues::Weights { targets, numbers }, _) => {
                let at = |index: usize, target: usize| numbers.get(index * targets + target).copied();
                let value = |target: usize| match self.interpolation {
                    Interpolation::Step => at(span.left, target),
                    Interpolation::Linear => {
                        let (a, b) = (at(span.left, target)?, at(span.right, target)?);
                        Some(a + (b - a) * span.position)
                    }
                    Interpolation::CubicSpline => {
                        let [h00, h10, h01, h11] = hermite(span.position);
                        let d = span.duration;
                        let left = at(span.left * 3 + 1, target)? * h00 + at(span.left * 3 + 2, target)? * h10 * d;
                        Some(left + at(span.right * 3 + 1, target)? * h01 + at(span.right * 3, target)? * h11 * d)
                    }
                };
                if let Some(values) = (0..*targets).map(value).collect::<Option<Vec<f32>>>() {
                    *weights = Some(values);
                }
            }
            (ChannelValues::Translation(values), LocalTransform::Parts { translation, .. }) => {
                *translation = vector(values).unwrap_or(*translation);
            }
            (ChannelValues::Scale(values), LocalTransform::Parts { scale, .. }) => {
                *scale = vector(values).unwrap_or(*scale);
            }
            (ChannelValues::Rotation(values), LocalTransform::Parts { rotation, .. }) => {
                let slerp = |a: Quat, b: Quat, t: f32| between_turns(a.normalize(), b.normalize(), t);
                let value = self.value(&span, values, |a, b| a + b, |a, s| a * s, slerp);
                *rotation = value.filter(|q| q.is_finite()).unwrap_or(*rotation);
            }
            // glTF forbids animating a node that has a matrix; the matrix stays.
            (_, LocalTransform::Matrix(_) | LocalTransform::Rigid { .. }) => {}
        }
    }
}

/// The weights of a cubic Hermite spline: left value, left tangent, right value, right tangent.
fn hermite(t: f32) -> [f32; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [2.0 * t3 - 3.0 * t2 + 1.0, t3 - 2.0 * t2 + t, -2.0 * t3 + 3.0 * t2, t3 - t2]
}
