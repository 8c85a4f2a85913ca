//! Pipelines, made when they are first asked for; those that were used last are kept.

use std::collections::HashMap;
use std::hash::Hash;
use std::sync::{Mutex, PoisonError};

/// The most pipelines of a kind that are kept: for a dozen scenes of different features. Drivers hold up to tens of
/// megabytes for each, and programs may draw scene after scene.
const MOST_KEPT: usize = 96;

/// Pipelines of a kind by what they are for. Those that recorded work needs live on until it is done.
#[derive(Debug)]
pub(crate) struct Kept<K, P> {
    known: Mutex<Known<K, P>>,
}

#[derive(Debug)]
struct Known<K, P> {
    /// The number of times that a pipeline was asked for.
    time: u64,
    /// Pipelines, each with the last time.
    pipelines: HashMap<K, (u64, P)>,
}

impl<K, P> Default for Kept<K, P> {
    fn default() -> Self {
        Self { known: Mutex::new(Known { time: 0, pipelines: HashMap::new() }) }
    }
}

impl<K: Copy + Eq + Hash, P: Clone> Kept<K, P> {
    /// The pipeline for something, made if it is not there.
    pub(crate) fn get(&self, key: K, make: impl FnOnce() -> P) -> P {
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let Known { time, pipelines } = &mut *known;
        *time += 1;
        let (last, pipeline) = pipelines.entry(key).or_insert_with(|| (0, make()));
        *last = *time;
        let pipeline = pipeline.clone();
        if pipelines.len() > MOST_KEPT {
            let oldest = pipelines.iter().min_by_key(|(_, (last, _))| *last).map(|(key, _)| *key);
            oldest.and_then(|key| pipelines.remove(&key));
        }
        pipeline
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    #[test]
    fn those_used_last_are_kept() {
        let (kept, made) = (Kept::<usize, usize>::default(), Cell::new(0));
        let get = |key: usize| {
            kept.get(key, || {
                made.set(made.get() + 1);
                10 * key
            })
        };
        for key in 0..3 * MOST_KEPT {
            assert_eq!(get(key), 10 * key);
            assert_eq!(get(7), 70, "used again and again");
        }
        assert_eq!(made.get(), 3 * MOST_KEPT, "each was made once");
        assert_eq!(kept.known.lock().unwrap().pipelines.len(), MOST_KEPT);
        get(3 * MOST_KEPT - 1);
        assert_eq!(made.get(), 3 * MOST_KEPT, "the last is there");
        get(0);
        assert_eq!(made.get(), 3 * MOST_KEPT + 1, "the first is not");
    }
}
