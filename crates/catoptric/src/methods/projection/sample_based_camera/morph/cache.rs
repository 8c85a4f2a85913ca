//! What is known of points from frame to frame: their appearances at the nodes, as long as the eye stays among these
//! (Popescu, Sacks, Mei 2006, section VI: the projections of static vertices are reused with varying weights).

use super::sightings::Sightings;
use glam::Vec3;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Points are shared out among so many tables, so that threads seldom wait for each other.
const SHARDS: usize = 64;

/// The most points of a table: all take some hundred megabytes then. A full one is emptied. Chosen, not measured.
const MOST_POINTS: usize = (1 << 18) / SHARDS;

/// A path and a point.
type Key = (u32, [u32; 3]);

type Shard = HashMap<Key, Arc<[Sightings]>>;

/// Appearances of points at the nodes around an eye.
pub(super) struct SightingCache {
    shards: [Mutex<Shard>; SHARDS],
}

impl Default for SightingCache {
    fn default() -> Self {
        Self { shards: std::array::from_fn(|_| Mutex::default()) }
    }
}

impl SightingCache {
    fn shard(&self, [x, y, z]: [u32; 3]) -> MutexGuard<'_, Shard> {
        let mixed = x.wrapping_mul(0x9E37_79B1) ^ y.wrapping_mul(0x85EB_CA77) ^ z.wrapping_mul(0xC2B2_AE3D);
        self.shards[(mixed >> 20) as usize % SHARDS].lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A point's appearances on a path: those known, or else the ones that `look` finds.
    pub(super) fn get(&self, path: u32, point: Vec3, look: impl FnOnce() -> Arc<[Sightings]>) -> Arc<[Sightings]> {
        let bits = point.to_array().map(f32::to_bits);
        if let Some(known) = self.shard(bits).get(&(path, bits)) {
            return known.clone();
        }
        // Nobody waits while it is looked for.
        let found = look();
        let mut shard = self.shard(bits);
        if shard.len() >= MOST_POINTS {
            shard.clear();
        }
        shard.insert((path, bits), found.clone());
        found
    }

    /// The number of points.
    pub(super) fn count(&self) -> u64 {
        self.shards.iter().map(|shard| shard.lock().unwrap_or_else(PoisonError::into_inner).len() as u64).sum()
    }
}
