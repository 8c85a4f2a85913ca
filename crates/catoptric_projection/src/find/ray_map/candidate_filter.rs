//! Filter of a point's candidates.

use super::Candidate;
use glam::Vec2;

/// Places in the picture that are remembered for a point, unless the user of a filter wants another number; candidates
/// that lead elsewhere then are not tried. A bound on time; chosen, not measured.
const MAX_PLACES: usize = 16;

/// Samples tried for one appearance, unless the first ones decide. A bound on time; chosen, not measured.
const MAX_ATTEMPTS: u32 = 3;

/// Undecided samples tried for one point, as a share of the places: around points without any reflection every sample
/// at a silhouette leads to another place. A bound on time; chosen, not measured.
const UNSOLVED_SHARE: f32 = 0.5;

/// Samples that lead to the same sheet, to places that differ by less than this share of the way there, lead to one
/// appearance; nor are places distinct that are nearer than [`SAME_PX`]. Chosen, not measured.
const SAME_SHARE: f32 = 0.5;

/// See [`SAME_SHARE`], in pixels. Chosen, not measured.
const SAME_PX: f32 = 0.3;

/// Places that a point's candidates have led to. Several samples lead to each of its appearances, the nearest ones
/// most surely; they are identified by the place and the sheet that they lead to.
#[derive(Debug)]
pub struct CandidateFilter<const PLACES: usize = MAX_PLACES> {
    places: [AttemptPlace; PLACES],
    count: usize,
    unsolved: u32,
    /// True if a candidate has been refused because a limit was reached.
    cut_short: bool,
}

/// A place of the picture that candidates lead to.
#[derive(Clone, Copy, Debug, Default)]
struct AttemptPlace {
    px: Vec2,
    mirrored: bool,
    attempts: u32,
}

/// An attempt that is under way.
#[derive(Debug)]
pub struct Attempt(Option<usize>);

impl<const PLACES: usize> Default for CandidateFilter<PLACES> {
    fn default() -> Self {
        Self { places: [AttemptPlace::default(); PLACES], count: 0, unsolved: 0, cut_short: false }
    }
}

impl<const PLACES: usize> CandidateFilter<PLACES> {
    const MAX_UNSOLVED: u32 = (PLACES as f32 * UNSOLVED_SHARE) as u32;

    /// Begins an attempt with a candidate (the nearest come first); `None` if others have already led, or failed to
    /// lead, to where it leads. Candidates without a predicted place are always tried.
    #[inline]
    pub fn begin(&mut self, candidate: &Candidate) -> Option<Attempt> {
        let Some(reaching) = &candidate.reaching else { return Some(Attempt(None)) };
        let near2 = (SAME_SHARE * SAME_SHARE * reaching.distance2).max(SAME_PX * SAME_PX);
        let same = |place: &AttemptPlace| {
            place.mirrored == reaching.mirrored && place.px.distance_squared(reaching.place) <= near2
        };
        if self.cut_short && self.unsolved >= Self::MAX_UNSOLVED {
            return None;
        }
        let known = self.places[..self.count].iter().position(same);
        if self.unsolved >= Self::MAX_UNSOLVED {
            // More candidates for a place that has been tried to its end are no loss.
            self.cut_short |= known.is_none_or(|known| self.places[known].attempts < MAX_ATTEMPTS);
            return None;
        }
        let index = match known {
            Some(known) => known,
            None if self.count < PLACES => {
                self.places[self.count] = AttemptPlace { px: reaching.place, mirrored: reaching.mirrored, attempts: 0 };
                self.count += 1;
                self.count - 1
            }
            None => {
                self.cut_short = true;
                return None;
            }
        };
        let attempts = &mut self.places[index].attempts;
        *attempts += 1;
        (*attempts <= MAX_ATTEMPTS).then_some(Attempt(Some(index)))
    }

    /// True if a limit has kept a candidate from being tried that might lead to another appearance.
    pub fn is_cut_short(&self) -> bool {
        self.cut_short
    }

    /// Ends an attempt. If it was `resolved`, no other sample is tried for its place.
    #[inline]
    pub fn end(&mut self, attempt: Attempt, resolved: bool) {
        match attempt.0 {
            Some(index) if resolved => self.places[index].attempts = MAX_ATTEMPTS,
            _ => self.unsolved += u32::from(!resolved),
        }
    }
}
