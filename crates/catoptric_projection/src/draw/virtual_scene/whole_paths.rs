//! Meshes of paths that are done as a whole, or not at all.

use super::super::virtual_mesh::Allowance;
use super::MadeMeshes;
use super::maker::{MeshMaker, PathObject};
use catoptric_core::progress::{Cancelled, Stage};
use catoptric_engine::method::projector::{PathBeginnings, VertexProjector};

/// Paths of one length may take one part of so many less than all of the work that is left, if there are longer ones.
/// Chosen, not measured.
const FOR_LONGER: u64 = 4;

/// A path may take this many times an even share of what is there for those of its length: most need less. Chosen, not
/// measured.
const EVEN_SHARES: u64 = 2;

impl<P: VertexProjector + ?Sized> MeshMaker<'_, P> {
    /// Makes the virtual meshes that are not kept from an earlier frame, path after path, short ones first. What is
    /// begun and takes more than there is for it is not whole, and what goes on from it is not begun; nor is what the
    /// projector leaves out.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub(super) fn add_whole(&self, pairs: &[PathObject], work: u64) -> Result<(MadeMeshes, PathBeginnings), Cancelled> {
        let mut paths: Vec<Vec<PathObject>> = vec![Vec::new(); self.projector.paths().len()];
        for key in pairs {
            paths[key.0 as usize].push(*key);
        }
        paths.retain(|pairs| !pairs.is_empty());
        paths.sort_by_key(|pairs| (self.length(pairs[0]), pairs[0]));
        let steps: u64 = pairs.iter().map(|key| self.steps(*key)).sum();
        let stage = Stage::begin(self.job.progress, "projecting", steps as usize)?;
        let (mut made, mut undone, mut remaining) = (MadeMeshes::default(), PathBeginnings::default(), work);
        self.projector.left_out().iter().filter_map(PathBeginnings::of).for_each(|beginning| undone.add(beginning));
        let lengths: Vec<&[Vec<PathObject>]> = paths.chunk_by(|a, b| self.length(a[0]) == self.length(b[0])).collect();
        for (number, of_length) in lengths.iter().enumerate() {
            let for_longer = if number + 1 < lengths.len() { remaining / FOR_LONGER } else { 0 };
            for (number, pairs) in of_length.iter().enumerate() {
                let there = remaining.saturating_sub(for_longer);
                let allowed = (EVEN_SHARES * there / (of_length.len() - number) as u64).min(there);
                let path = &self.projector.paths()[pairs[0].0 as usize];
                if undone.hold(path) {
                    self.forget(pairs);
                    continue;
                }
                let (taken, is_whole) = self.add_path(pairs, allowed, &mut made, &stage)?;
                remaining = remaining.saturating_sub(taken);
                if !is_whole {
                    PathBeginnings::of(path).into_iter().for_each(|beginning| undone.add(beginning));
                }
            }
        }
        Ok((made, undone))
    }

    /// Forgets meshes of earlier frames.
    fn forget(&self, pairs: &[PathObject]) {
        let mut meshes = self.scene.locked_meshes();
        for key in pairs {
            meshes.remove(key);
        }
    }

    /// Makes the meshes of one path, and returns the work that they took, and whether that was enough.
    fn add_path(
        &self,
        pairs: &[PathObject],
        allowed: u64,
        made: &mut MadeMeshes,
        stage: &Stage<'_>,
    ) -> Result<(u64, bool), Cancelled> {
        let mut taken = 0;
        for (number, &key) in pairs.iter().enumerate() {
            let remaining = allowed.saturating_sub(taken);
            if remaining == 0 {
                self.forget(&pairs[number..]);
                return Ok((taken, false));
            }
            let first = self.first_mesh(key, Allowance::for_whole(remaining), made, stage)?;
            taken += first.work;
            if first.is_coarse {
                self.forget(&pairs[number + 1..]);
                return Ok((taken, false));
            }
        }
        Ok((taken, true))
    }
}
