//! Meshes of paths that are done as a whole, or not at all.

use super::super::virtual_mesh::Allowance;
use super::failed_paths::WholePaths;
use super::kept_meshes::{MadeMeshes, PathObject};
use super::maker::MeshMaker;
use catoptric_core::progress::{Cancelled, Stage};
use catoptric_engine::method::projector::{PathBeginning, PathBeginnings, VertexProjector};

/// Paths of one length may take one part of this many less than all of the work that is left, if there are longer ones.
/// Chosen, not measured.
const FOR_LONGER: u64 = 4;

/// The work that a path may take, in even shares of the work for its length: most need less. Chosen, not measured.
const EVEN_SHARES: u64 = 2;

/// A path that would have had this many times the work, had others not failed before it, has had no fair try, unless it
/// is expected to need even more: it is tried again when they are not.
const FAIR_SHARES: u64 = 2;

/// The outcome of one path.
struct PathTry {
    /// The work that was done.
    taken: u64,
    /// If that was not enough: about the least that would have been.
    expected: Option<u64>,
}

/// The work of a frame that is left, and the work of failed paths in it.
struct RemainingWork {
    left: u64,
    /// Work of paths that failed: later frames, which do not try these paths, have it for others.
    wasted: u64,
}

impl RemainingWork {
    /// The work that one of so many paths may take, if so much is not for it.
    fn allowed(left: u64, for_others: u64, paths: usize) -> u64 {
        let there = left.saturating_sub(for_others);
        (EVEN_SHARES * there / paths as u64).min(there)
    }
}

impl<P: VertexProjector + ?Sized> MeshMaker<'_, P> {
    /// Makes the virtual meshes that are not kept from an earlier frame, path after path, short ones first. A path that
    /// takes more than the work left for it is incomplete, and longer paths that go on from it are not begun; nor are
    /// paths that the projector leaves out, and those not to be tried (`without`).
    ///
    /// # Errors
    /// [`Cancelled`].
    pub(super) fn add_whole(
        &self,
        pairs: &[PathObject],
        (work, without): (u64, &PathBeginnings),
    ) -> Result<(MadeMeshes, WholePaths), Cancelled> {
        let mut paths: Vec<Vec<PathObject>> = vec![Vec::new(); self.projector.paths().len()];
        for key in pairs {
            paths[key.0 as usize].push(*key);
        }
        paths.retain(|pairs| !pairs.is_empty());
        paths.sort_by_key(|pairs| (self.length(pairs[0]), pairs[0]));
        let steps: u64 = pairs.iter().map(|key| self.steps(*key)).sum();
        let stage = Stage::begin(self.job.progress, "projecting", steps as usize)?;
        let (mut made, mut found) = (MadeMeshes::default(), WholePaths::default());
        let is_wanted = |beginning: &PathBeginning| !without.contains(beginning);
        found.undone.extend(self.projector.left_out().iter().filter_map(PathBeginnings::of));
        let failed = self.projector.left_out_for_work().iter().filter_map(PathBeginnings::of);
        found.tries.failed.extend(failed.filter(is_wanted));
        let path_of = |pairs: &[PathObject]| &self.projector.paths()[pairs[0].0 as usize];
        let not_tried = |pairs: &&Vec<PathObject>| PathBeginnings::of(path_of(pairs)).filter(|own| !is_wanted(own));
        found.undone.extend(paths.iter().filter_map(|pairs| not_tried(&pairs)));
        let mut remaining = RemainingWork { left: work, wasted: 0 };
        let lengths: Vec<&[Vec<PathObject>]> = paths.chunk_by(|a, b| self.length(a[0]) == self.length(b[0])).collect();
        for (number, of_length) in lengths.iter().enumerate() {
            let for_longer = if number + 1 < lengths.len() { remaining.left / FOR_LONGER } else { 0 };
            let mut waiting = of_length.iter().filter(|pairs| not_tried(pairs).is_none()).count();
            for pairs in *of_length {
                let path = path_of(pairs);
                let Some(beginning) = PathBeginnings::of(path) else { continue };
                if !is_wanted(&beginning) {
                    self.forget(pairs);
                    continue;
                }
                let shares = waiting;
                waiting -= 1;
                if found.undone.hold(path) {
                    self.forget(pairs);
                    continue;
                }
                let allowed = RemainingWork::allowed(remaining.left, for_longer, shares);
                let PathTry { taken, expected } = self.add_path(pairs, allowed, &mut made, &stage)?;
                if let Some(expected) = expected {
                    let fair = RemainingWork::allowed(remaining.left + remaining.wasted, for_longer, shares);
                    if fair / FAIR_SHARES < allowed || fair < expected {
                        found.tries.failed.add(beginning.clone());
                    }
                    remaining.wasted += taken.min(remaining.left);
                    found.undone.add(beginning);
                } else {
                    found.tries.done.add(beginning);
                }
                remaining.left = remaining.left.saturating_sub(taken);
            }
        }
        // At a lens only one of the two paths may be complete.
        found.tries.done.retain(|own| !found.undone.contains(own));
        found.not_tried = found.undone.iter().filter(|own| !is_wanted(own)).count() as u64;
        Ok((made, found))
    }

    /// Forgets meshes of earlier frames.
    fn forget(&self, pairs: &[PathObject]) {
        let mut meshes = self.scene.locked_meshes();
        for key in pairs {
            meshes.remove(key);
        }
    }

    /// Makes the meshes of one path.
    fn add_path(
        &self,
        pairs: &[PathObject],
        allowed: u64,
        made: &mut MadeMeshes,
        stage: &Stage<'_>,
    ) -> Result<PathTry, Cancelled> {
        let mut taken = 0;
        for (number, &key) in pairs.iter().enumerate() {
            let remaining = allowed.saturating_sub(taken);
            if remaining == 0 {
                self.forget(&pairs[number..]);
                return Ok(PathTry { taken, expected: Some(taken) });
            }
            let first = self.first_mesh(key, Allowance::for_whole(remaining), made, stage)?;
            taken += first.work;
            if first.is_coarse {
                self.forget(&pairs[number + 1..]);
                let expected = taken - first.work + first.expected(self.scene.welded[key.1 as usize].points.len());
                return Ok(PathTry { taken, expected: Some(expected) });
            }
        }
        Ok(PathTry { taken, expected: None })
    }
}
