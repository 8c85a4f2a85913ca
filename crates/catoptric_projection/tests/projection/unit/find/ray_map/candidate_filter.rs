//! Selection of the candidates that are tried.

use catoptric_projection::find::ray_map::{Candidate, CandidateFilter, Reaching};
use glam::Vec2;

fn candidate(x: f32, distance: f32, mirrored: bool) -> Candidate {
    let reaching = Reaching { sample: 7, place: Vec2::new(x, 3.0), distance2: distance * distance, mirrored };
    Candidate { ray: 7, reaching: Some(reaching) }
}

#[test]
fn what_one_sample_told_no_other_is_asked() {
    let mut attempts: CandidateFilter = CandidateFilter::default();
    let first = attempts.begin(&candidate(10.0, 4.0, false)).unwrap();
    attempts.end(first, true);
    // This is the same place, within the uncertainty of one from eight pixels away.
    assert!(attempts.begin(&candidate(13.0, 8.0, false)).is_none());
    // Another sheet, another place, and a place that is surely another.
    for other in [candidate(10.0, 4.0, true), candidate(15.0, 8.0, false), candidate(10.5, 0.0, false)] {
        assert!(attempts.begin(&other).is_some(), "{other:?}");
    }
    let unknown = Candidate { ray: 1, reaching: None };
    assert!((0..50).all(|_| attempts.begin(&unknown).is_some()));
    assert!(!attempts.is_cut_short());
}

#[test]
fn samples_that_fail_are_followed_by_a_few_others() {
    let mut attempts: CandidateFilter = CandidateFilter::default();
    let mut fail = |x: f32| match attempts.begin(&candidate(x, 1.0, false)) {
        Some(attempt) => {
            attempts.end(attempt, false);
            true
        }
        None => false,
    };
    assert_eq!((0..10).filter(|_| fail(1.0)).count(), 3, "at one place");
    assert_eq!((0..5).filter(|&k| fail(100.0 + 10.0 * k as f32)).count(), 5, "of eight in all");
    fail(1.0);
    assert!(!attempts.is_cut_short(), "that place has been tried to its end");
    assert!(attempts.begin(&candidate(200.0, 1.0, false)).is_none(), "of eight in all");
    assert!(attempts.is_cut_short());
}

#[test]
fn places_are_bounded() {
    let mut attempts: CandidateFilter = CandidateFilter::default();
    let told = (0..100).filter(|&k| match attempts.begin(&candidate(10.0 * k as f32, 1.0, false)) {
        Some(attempt) => {
            attempts.end(attempt, true);
            true
        }
        None => false,
    });
    assert_eq!(told.count(), 16);
    assert!(attempts.is_cut_short());
}
