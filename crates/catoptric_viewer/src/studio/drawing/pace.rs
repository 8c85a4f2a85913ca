//! The size of drafts: as many pixels as keep the picture moving.

/// Drafts have these parts of the width and height.
const SCALES: [f32; 7] = [1.0, 0.75, 0.5, 0.375, 0.25, 0.1875, 0.125];

/// The time that drafts of all sides together may take, in milliseconds: fifteen in a second, with some left for the
/// window itself.
const BUDGET_MS: f64 = 55.0;

/// A finer scale is taken where it is expected to need less than this part of the budget, so that sizes do not swing.
const MARGIN: f64 = 0.8;

/// The share of a new measurement in the running mean.
const SHARE_OF_NEW: f64 = 0.4;

/// How long a method takes for its frames, and the scale of drafts that follows from it.
#[derive(Clone, Debug, Default)]
pub(super) struct Pace {
    /// Milliseconds that a million pixels take.
    ms_a_megapixel: Option<f64>,
    scale: Option<f32>,
}

impl Pace {
    /// Takes note of a frame.
    pub(super) fn note(&mut self, pixels: u64, ms: f64) {
        let new = ms / (pixels.max(1) as f64 * 1e-6);
        self.ms_a_megapixel = Some(match self.ms_a_megapixel {
            Some(mean) => mean + (new - mean) * SHARE_OF_NEW,
            None => new,
        });
    }

    /// The scale of the next draft of a picture of this size, with so many sides in view.
    pub(super) fn scale(&mut self, [width, height]: [u32; 2], sides: usize) -> f32 {
        // The first frame: nobody knows what it takes.
        let Some(ms) = self.ms_a_megapixel else { return SCALES[4] };
        let budget = BUDGET_MS / sides.max(1) as f64;
        let expected = |scale: f32| ms * f64::from(width) * f64::from(height) * f64::from(scale).powi(2) * 1e-6;
        let now = self.scale.unwrap_or(SCALES[4]);
        let fits = |scale: &f32| expected(*scale) <= if *scale > now { budget * MARGIN } else { budget };
        let scale = SCALES.into_iter().find(fits).unwrap_or(SCALES[SCALES.len() - 1]);
        self.scale = Some(scale);
        scale
    }
}

/// A size at a scale, at least a pixel.
pub(super) fn scaled([width, height]: [u32; 2], scale: f32) -> [u32; 2] {
    [width, height].map(|length| ((length as f32 * scale).round() as u32).max(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drafts_are_as_fine_as_time_allows_and_do_not_swing() {
        let size = [1280, 720];
        let mut pace = Pace::default();
        assert_eq!(pace.scale(size, 1), 0.25);
        // A whole picture takes 220 ms: half of its width fits, for two sides a third.
        for _ in 0..30 {
            pace.note(1280 * 720, 220.0);
        }
        assert_eq!(pace.scale(size, 1), 0.375);
        for _ in 0..30 {
            pace.note(1280 * 720, 170.0);
        }
        assert_eq!(pace.scale(size, 1), 0.5);
        for _ in 0..30 {
            pace.note(1280 * 720, 215.0);
        }
        assert_eq!(pace.scale(size, 1), 0.5);
        assert_eq!(pace.scale(size, 2), 0.25);
        for _ in 0..30 {
            pace.note(1280 * 720, 1e5);
        }
        assert_eq!(pace.scale(size, 1), 0.125);
        for _ in 0..60 {
            pace.note(1280 * 720, 10.0);
        }
        assert_eq!(pace.scale(size, 1), 1.0);
        assert_eq!(scaled([1, 3], 0.125), [1, 1]);
    }
}
