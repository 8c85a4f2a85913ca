//! The rays of a row of the map, by the paths that they take.

use super::follow::Bounces;
use super::grid_ray::GridRay;
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

/// Index of no cell of the map.
pub(in super::super) const NO_CELL: u32 = u32::MAX;

/// Place of a ray in the grid. Apart from the ray itself: sorting looks at these alone.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct GridEntry {
    /// The column and row of its cell.
    pub(in super::super) cell: [u32; 2],
    /// The cells between whose rays it was looked for; [`NO_CELL`] for regular rays.
    pub(in super::super) between: [u32; 2],
    /// Index of its path among those of its row.
    pub(super) path: u32,
}

/// The rays of one row.
#[derive(Default)]
pub(in super::super) struct RowEntries {
    /// The paths that occur.
    pub(super) paths: Vec<Bounces>,
    pub(in super::super) entries: Vec<GridEntry>,
    pub(in super::super) rays: Vec<GridRay>,
    /// The numbers of the entries, path by path, and where each path starts.
    by_path: Vec<u32>,
    starts: Vec<usize>,
    pub(super) traced: u64,
}

impl RowEntries {
    /// The numbers of a path's entries.
    pub(in super::super) fn of_path(&self, path: u32) -> &[u32] {
        &self.by_path[self.starts[path as usize]..self.starts[path as usize + 1]]
    }

    /// With the numbers of every path's entries, and how many rays were traced.
    pub(super) fn finished(mut self, traced: u64) -> Self {
        self.traced = traced;
        self.starts = vec![0; self.paths.len() + 1];
        for entry in &self.entries {
            self.starts[entry.path as usize + 1] += 1;
        }
        for path in 0..self.paths.len() {
            self.starts[path + 1] += self.starts[path];
        }
        let mut next = self.starts.clone();
        self.by_path = vec![0; self.entries.len()];
        for (number, entry) in self.entries.iter().enumerate() {
            let next = &mut next[entry.path as usize];
            self.by_path[*next] = number as u32;
            *next += 1;
        }
        self
    }
}

/// Numbers of paths.
pub(super) type PathNumbers = HashMap<Bounces, u32, BuildHasherDefault<SignatureHasher>>;

/// Signatures are mixed already.
#[derive(Default)]
pub(super) struct SignatureHasher(u64);

impl Hasher for SignatureHasher {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.write_u64(self.0.rotate_left(8) ^ u64::from(byte));
        }
    }

    fn write_u64(&mut self, number: u64) {
        self.0 = number;
    }
}
