//! Search of all paths over flat mirrors to a point, in closed form.

use super::chain::{Chain, ChainStart};
use super::settings::PlanarMirrorSettings;
use crate::draw::flat_mirrors::Mirrors;
use catoptric_core::scene::Scene;
use catoptric_engine::error::RenderError;
use catoptric_engine::method::Settings;
use catoptric_engine::method::path_query::{FoundPath, PathSearch, SearchOutcome};
use catoptric_engine::method::projector::{MAX_BOUNCES, SpecularPath};
use glam::{DMat3, DVec3};
use std::collections::HashMap;

/// The maximum number of sequences of mirrors that are accepted: each is tried for every point. Chosen, not measured.
const MAX_CHAINS: usize = 1 << 16;

/// Finds all paths over the flat mirrors of a scene: exactly, in double precision. Curved reflectors and lenses
/// have no part in them.
pub struct MirrorSearch<'a> {
    /// The scene.
    pub scene: &'a Scene,
    mirrors: &'a Mirrors,
    eye: DVec3,
    paths: Vec<SpecularPath>,
    chains: Vec<ChainOfPath>,
}

struct ChainOfPath {
    chain: Chain,
    /// Flat parts of one object share their paths.
    path: u32,
    image_change: DMat3,
}

impl<'a> MirrorSearch<'a> {
    /// A search for paths of one to `order` bounces (at most [`MAX_BOUNCES`]) on these objects alone.
    ///
    /// # Errors
    /// [`RenderError::Limit`] where there are more than 65,536 sequences of mirrors.
    pub fn new(
        scene: &'a Scene,
        mirrors: &'a Mirrors,
        eye: DVec3,
        order: u32,
        objects: &[u32],
    ) -> Result<Self, RenderError> {
        let mut search = Self { scene, mirrors, eye, paths: Vec::new(), chains: Vec::new() };
        let usable: Vec<u32> = (0..mirrors.planes.len() as u32)
            .filter(|&plane| objects.contains(&mirrors.planes[plane as usize].object))
            .collect();
        let mut known: HashMap<SpecularPath, u32> = HashMap::new();
        let mut last = vec![Chain::default()];
        for _ in 0..order.min(MAX_BOUNCES as u32) {
            let mut longer = Vec::new();
            for chain in &last {
                // A plane never shows itself.
                let next = usable.iter().filter(|plane| chain.planes().last() != Some(plane));
                longer.extend(next.filter_map(|&plane| chain.extended(plane)));
                if search.chains.len() + longer.len() > MAX_CHAINS {
                    let problem = format!(
                        "more than {MAX_CHAINS} sequences of flat mirrors; allow fewer mirrors or a lower order"
                    );
                    return Err(RenderError::Limit { method: PlanarMirrorSettings::METHOD, problem });
                }
            }
            for &chain in &longer {
                let path = chain.path(mirrors);
                let paths = &mut search.paths;
                let path = *known.entry(path).or_insert_with_key(|path| {
                    paths.push(path.clone());
                    paths.len() as u32 - 1
                });
                search.chains.push(ChainOfPath { chain, path, image_change: chain.image_change(mirrors) });
            }
            last = longer;
        }
        Ok(search)
    }

    fn path(&self, candidate: &ChainOfPath, point: DVec3) -> Option<FoundPath> {
        let chain = &candidate.chain;
        let unfolded = chain.unfold(self.mirrors, ChainStart::Point(self.eye), point)?;
        let bounces = &unfolded.bounces[..chain.length];
        let on_mirrors = |(plane, at): (&u32, &DVec3)| self.mirrors.contains(self.scene, *plane, *at);
        if !chain.planes().iter().zip(bounces).all(on_mirrors) {
            return None;
        }
        // The line from the eye to the image meets the first mirror at x = e + s (p' - e), s = h_e / (h_e - h_p').
        let first = &self.mirrors.planes[chain.planes()[0] as usize];
        let (height, depth) = (first.height(self.eye), first.height(unfolded.image));
        let share = height / (height - depth);
        let tilt = (unfolded.image - self.eye) * (share / (height - depth));
        let n = first.normal;
        let turned = DMat3::from_cols(tilt * n.x, tilt * n.y, tilt * n.z);
        let jacobian = (DMat3::from_diagonal(DVec3::splat(share)) + turned) * candidate.image_change;
        let ends = |index: usize| {
            let before = if index == 0 { self.eye } else { bounces[index - 1] };
            (before, bounces.get(index + 1).copied().unwrap_or(point))
        };
        let residual = |index: usize| {
            let (before, after) = ends(index);
            let normal = self.mirrors.planes[chain.planes()[index] as usize].normal;
            let at = bounces[index];
            (before - at).normalize_or_zero().reject_from_normalized(normal)
                + (after - at).normalize_or_zero().reject_from_normalized(normal)
        };
        let residual = (0..chain.length).map(|index| residual(index).length()).fold(0.0, f64::max);
        let found = FoundPath {
            path: candidate.path,
            bounce_count: chain.length,
            bounce_points: unfolded.bounces,
            focal_index: 0,
            optical_length: unfolded.image.distance(self.eye),
            residual,
            jacobian,
        };
        (found.optical_length.is_finite() && jacobian.is_finite()).then_some(found)
    }
}

impl PathSearch for MirrorSearch<'_> {
    fn paths(&self) -> &[SpecularPath] {
        &self.paths
    }

    fn search(&self, point: DVec3, found: &mut Vec<FoundPath>) -> SearchOutcome {
        let start = found.len();
        if point.is_finite() {
            found.extend(self.chains.iter().filter_map(|candidate| self.path(candidate, point)));
        }
        let own = &mut found[start..];
        own.sort_by(|a, b| a.optical_length.total_cmp(&b.optical_length).then(a.path.cmp(&b.path)));
        SearchOutcome { found: own.len(), ..SearchOutcome::default() }
    }
}
