//! Meshes of all paths, however much there is to do: coarser ones where that is too much.

use super::super::virtual_mesh::Allowance;
use super::kept_meshes::{MadeMeshes, PathObject};
use super::maker::MeshMaker;
use catoptric_core::progress::{Cancelled, Stage};
use catoptric_engine::method::projector::VertexProjector;

/// The work that an object on a path may take first, in even shares of the work for its kind: most need less. Chosen,
/// not measured.
const EVEN_SHARES: u64 = 2;

/// The divisor of the largest share: an object on a path may take this part of the work that is left in the end, or an
/// even share if that is more. Chosen, not measured.
const LARGEST_SHARE: u64 = 3;

/// The factor between the work now and the first allowance from which on meshes are made again. Chosen, not measured.
const MUCH_MORE: u64 = 2;

impl<P: VertexProjector + ?Sized> MeshMaker<'_, P> {
    /// Makes the virtual meshes that are not kept from an earlier frame.
    ///
    /// All of them are made with about even shares of the work, then coarse ones again with the work that is left.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub(super) fn add_in_shares(&self, pairs: &[PathObject], work: u64) -> Result<MadeMeshes, Cancelled> {
        let steps: u64 = pairs.iter().map(|key| self.steps(*key)).sum();
        let stage = Stage::begin(self.job.progress, "projecting", steps as usize)?;
        let meshes = || self.scene.locked_meshes();
        let (mut made, mut remaining) = (MadeMeshes::default(), work);
        let mut coarse = Vec::new();
        // Each kind leaves half of the work for the kinds after it.
        let kinds: Vec<&[PathObject]> = pairs.chunk_by(|a, b| self.kind(*a) == self.kind(*b)).collect();
        for (kind, pairs) in kinds.iter().enumerate() {
            let mut of_kind = if kind + 1 < kinds.len() { remaining / 2 } else { remaining };
            for (number, &key) in pairs.iter().enumerate() {
                let allowed = (EVEN_SHARES * of_kind / (pairs.len() - number) as u64).min(of_kind);
                if allowed == 0 {
                    meshes().remove(&key);
                    made.left_out += 1;
                    continue;
                }
                let first = self.first_mesh(key, Allowance::for_all(allowed), &mut made, &stage)?;
                if first.is_coarse {
                    coarse.push((key, first.allowed));
                }
                of_kind = of_kind.saturating_sub(first.work);
                remaining = remaining.saturating_sub(first.work);
            }
        }
        self.refine(&coarse, remaining, &mut made)?;
        Ok(made)
    }

    /// Makes coarse meshes, given with their allowances, again with the work that is left.
    fn refine(&self, coarse: &[(PathObject, u64)], mut remaining: u64, made: &mut MadeMeshes) -> Result<(), Cancelled> {
        let meshes = || self.scene.locked_meshes();
        let steps: u64 = coarse.iter().map(|(key, _)| self.steps(*key)).sum();
        let stage = Stage::begin(self.job.progress, "projecting again", steps as usize)?;
        for (number, &(key, first_allowed)) in coarse.iter().enumerate() {
            let more = remaining / ((coarse.len() - number) as u64).min(LARGEST_SHARE);
            let is_again = more >= MUCH_MORE * first_allowed;
            let allowed = if is_again { more } else { first_allowed };
            let kept = meshes().get(&key).map(|kept| (kept.mesh.holds_with(allowed), kept.mesh.work));
            let work = match kept {
                Some((true, work)) => {
                    stage.advance(self.steps(key))?;
                    work
                }
                _ => {
                    let mesh = self.make(key, Allowance::for_all(allowed), &stage)?;
                    made.count(&mesh);
                    let work = mesh.work;
                    if let Some(kept) = meshes().get_mut(&key) {
                        kept.mesh = mesh;
                    }
                    work
                }
            };
            if is_again {
                remaining = remaining.saturating_sub(work);
            }
        }
        Ok(())
    }
}
