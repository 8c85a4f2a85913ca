//! Answers about points on paths, kept from frame to frame.

use crate::find::work;
use glam::Vec3;
use rustc_hash::FxHashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Points are shared out among this many tables, so that threads seldom wait for each other.
const SHARDS: usize = 64;

/// The maximum number of points of a table: all of a cache take some tens of megabytes then. A full one is emptied.
/// Chosen, not measured.
const MOST_POINTS: usize = (1 << 17) / SHARDS;

/// A path and a point.
type Key = (u32, [u32; 3]);

/// The appearances of a point, and the work that it took to find them.
struct Known<T> {
    found: Arc<[T]>,
    work: u64,
}

type Shard<T> = FxHashMap<Key, Known<T>>;

/// A cache of the appearances of points on paths.
pub struct PointCache<T> {
    shards: [Mutex<Shard<T>>; SHARDS],
}

impl<T> Default for PointCache<T> {
    fn default() -> Self {
        Self { shards: std::array::from_fn(|_| Mutex::default()) }
    }
}

impl<T> PointCache<T> {
    fn shard(&self, [x, y, z]: [u32; 3]) -> MutexGuard<'_, Shard<T>> {
        let mixed = x.wrapping_mul(0x9E37_79B1) ^ y.wrapping_mul(0x85EB_CA77) ^ z.wrapping_mul(0xC2B2_AE3D);
        self.shards[(mixed >> 20) as usize % SHARDS].lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The known appearances of a point on a path, or else the result of `look`. Both cases count as the same work, so
    /// that a picture with limited work does not depend on those before.
    pub fn get(&self, path: u32, point: Vec3, look: impl FnOnce() -> Arc<[T]>) -> Arc<[T]> {
        let bits = point.to_array().map(f32::to_bits);
        if let Some(known) = self.shard(bits).get(&(path, bits)) {
            work::add(known.work);
            return known.found.clone();
        }
        // No thread waits for a lock meanwhile.
        let before = work::done();
        let found = look();
        let known = Known { found: found.clone(), work: work::since(before) };
        let mut shard = self.shard(bits);
        if shard.len() >= MOST_POINTS {
            shard.clear();
        }
        shard.insert((path, bits), known);
        found
    }

    /// The number of points.
    pub fn count(&self) -> u64 {
        self.shards.iter().map(|shard| shard.lock().unwrap_or_else(PoisonError::into_inner).len() as u64).sum()
    }
}
