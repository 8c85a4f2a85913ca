//! The size of drafts: as many pixels as keep the picture moving.

/// Drafts have these parts of the width and height.
const SCALES: [f32; 11] = [1.0, 0.875, 0.75, 0.625, 0.5, 0.4375, 0.375, 0.3125, 0.25, 0.1875, 0.125];

/// The time that drafts of all sides together may take, in milliseconds: fifteen in a second, with some left for the
/// window itself.
const BUDGET_MS: f64 = 55.0;

/// A finer scale is taken where it is expected to need less than this part of the budget, so that sizes do not swing.
const MARGIN: f64 = 0.85;

/// The share of a new measurement in the running mean.
const SHARE_OF_NEW: f64 = 0.4;

/// Times are expected to change with this power of the number of pixels where one scale alone was measured: a good part
/// of a frame's work is the same for any size.
const POWER: f64 = 0.5;

/// After so many frames at other scales a measurement is worth no more: much may have changed.
const MEMORY: u32 = 30;

/// How long a method takes for its frames, and the scale of drafts that follows from it.
#[derive(Clone, Debug)]
pub(super) struct Pace {
    /// For each scale the mean of the times, and the number of the last frame.
    measured: [Option<(f64, u32)>; SCALES.len()],
    frames: u32,
    /// Index of the last draft's scale.
    now: usize,
}

impl Default for Pace {
    fn default() -> Self {
        // Nobody knows what the first frame takes.
        Self { measured: [None; SCALES.len()], frames: 0, now: 8 }
    }
}

impl Pace {
    /// Takes note of a frame at a scale.
    pub(super) fn note(&mut self, scale: f32, ms: f64) {
        let Some(index) = SCALES.iter().position(|known| *known == scale) else { return };
        self.frames += 1;
        let mean = match self.measured[index] {
            Some((mean, at)) if self.frames - at <= MEMORY => mean + (ms - mean) * SHARE_OF_NEW,
            _ => ms,
        };
        self.measured[index] = Some((mean, self.frames));
    }

    /// The time that a frame at a scale is expected to take: as it was measured, else in line with the two nearest
    /// scales that were, else by the nearest.
    fn expected(&self, index: usize) -> Option<f64> {
        let pixels = |index: usize| f64::from(SCALES[index]).powi(2);
        let is_fresh = |(index, measured): (usize, Option<(f64, u32)>)| {
            measured.filter(|(_, at)| self.frames - at <= MEMORY).map(|(mean, _)| (index, mean))
        };
        let mut known: Vec<(usize, f64)> = self.measured.into_iter().enumerate().filter_map(is_fresh).collect();
        known.sort_by_key(|(other, _)| other.abs_diff(index));
        match known[..] {
            [] => None,
            [(nearest, ms), ..] if nearest == index => Some(ms),
            [(nearest, ms)] => Some(ms * (pixels(index) / pixels(nearest)).powf(POWER)),
            [(nearest, ms), (second, other), ..] => {
                let slope = (ms - other) / (pixels(nearest) - pixels(second));
                Some(ms + slope.max(0.0) * (pixels(index) - pixels(nearest)))
            }
        }
    }

    /// The scale of the next draft, with so many sides in view: at most a step finer than the last one.
    pub(super) fn scale(&mut self, sides: usize) -> f32 {
        let budget = BUDGET_MS / sides.max(1) as f64;
        let fits = |index: &usize| {
            let limit = if *index < self.now { budget * MARGIN } else { budget };
            self.expected(*index).is_some_and(|ms| ms <= limit)
        };
        if self.frames > 0 {
            self.now = (self.now.saturating_sub(1)..SCALES.len()).find(fits).unwrap_or(SCALES.len() - 1);
        }
        SCALES[self.now]
    }
}

/// A size at a scale, at least a pixel.
pub(super) fn scaled([width, height]: [u32; 2], scale: f32) -> [u32; 2] {
    [width, height].map(|length| ((length as f32 * scale).round() as u32).max(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Draws some drafts of which one of all pixels takes `fixed` and `rest` milliseconds, the latter in proportion to
    /// the pixels. Returns the scale of the last one.
    fn drafts(pace: &mut Pace, count: usize, sides: usize, [fixed, rest]: [f64; 2]) -> f32 {
        let mut last = 0.0;
        for _ in 0..count {
            last = pace.scale(sides);
            pace.note(last, fixed + rest * f64::from(last).powi(2));
        }
        last
    }

    #[test]
    fn drafts_are_as_fine_as_time_allows_and_do_not_swing() {
        let mut pace = Pace::default();
        assert_eq!(pace.scale(1), 0.25);
        // A half takes 55 ms if nothing is the same for all sizes.
        assert_eq!(drafts(&mut pace, 40, 1, [0.0, 180.0]), 0.5);
        assert_eq!(drafts(&mut pace, 40, 2, [0.0, 180.0]), 0.375);
        assert_eq!(drafts(&mut pace, 40, 1, [0.0, 1e5]), 0.125);
        assert_eq!(drafts(&mut pace, 100, 1, [0.0, 10.0]), 1.0);
        // Where a good part is the same for all sizes, coarse frames must not be taken for the measure of fine ones.
        let mut pace = Pace::default();
        assert_eq!(drafts(&mut pace, 40, 1, [25.0, 80.0]), 0.5);
        // The finer one that was too slow is tried again now and then, not every time.
        let slow = (0..300).filter(|_| drafts(&mut pace, 1, 1, [25.0, 80.0]) > 0.5).count();
        assert!(slow <= 16, "{slow}");
        // The part that is the same for all sizes may be too much for any: then drafts are as coarse as can be.
        assert_eq!(drafts(&mut pace, 40, 1, [200.0, 10.0]), 0.125);
        assert_eq!(scaled([1, 3], 0.125), [1, 1]);
    }
}
