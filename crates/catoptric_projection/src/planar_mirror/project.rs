//! Appearances of scene points in flat mirrors.

use super::chain::{Chain, ChainStart};
use crate::draw::flat_mirrors::{MirrorPath, Mirrors};
use catoptric_core::scene::{PictureTransform, Projection as ViewProjection, Scene, View};
use catoptric_engine::method::projector::{Projection, Projections, SpecularPath, VertexProjector};
use glam::Vec3;
use std::collections::HashMap;

/// Extension of a mirror beyond its border, as a share of its object's size. Chosen, not measured.
const BEYOND_BORDER: f32 = 0.1;

/// Projects points into the mirrors in view.
pub(super) struct MirrorProjector<'a> {
    scene: &'a Scene,
    mirrors: &'a Mirrors,
    source: ChainStart,
    near: f32,
    paths: Vec<SpecularPath>,
    /// The chains of each path: flat parts of one object share their paths.
    chains: Vec<Vec<SeenChain>>,
}

struct SeenChain {
    chain: Chain,
    picture: PictureTransform,
}

impl<'a> MirrorProjector<'a> {
    /// A projector for the mirror paths that can be seen in a view (parents before children).
    pub(super) fn new(scene: &'a Scene, mirrors: &'a Mirrors, view: &View, seen: &[MirrorPath]) -> Self {
        let eye = view.eye().as_dvec3();
        let source = match view.projection {
            ViewProjection::Perspective { .. } => ChainStart::Point(eye),
            ViewProjection::Orthographic { .. } => {
                ChainStart::Parallel(eye, -Vec3::from(view.world_from_view.matrix3.z_axis).as_dvec3())
            }
        };
        let mut projector = Self { scene, mirrors, source, near: view.near, paths: Vec::new(), chains: Vec::new() };
        let mut known: HashMap<SpecularPath, usize> = HashMap::new();
        let mut all: Vec<Option<Chain>> = Vec::with_capacity(seen.len());
        for path in seen {
            let chain = match (path.parent, path.mirror) {
                (Some(parent), Some(mirror)) => all[parent as usize].and_then(|chain| chain.extended(mirror)),
                _ => Some(Chain::default()),
            };
            all.push(chain);
            if let Some(chain) = chain.filter(|chain| chain.length > 0) {
                let (paths, chains) = (&mut projector.paths, &mut projector.chains);
                let index = *known.entry(chain.path(mirrors)).or_insert_with_key(|path| {
                    paths.push(path.clone());
                    chains.push(Vec::new());
                    paths.len() - 1
                });
                chains[index].push(SeenChain { chain, picture: view.picture_from_moved(&path.world_from_scene) });
            }
        }
        projector
    }

    fn appearance(&self, path: u32, seen: &SeenChain, point: Vec3) -> Option<Projection> {
        let unfolded = seen.chain.unfold(self.mirrors, self.source, point.as_dvec3())?;
        for (&plane, bounce) in seen.chain.planes().iter().zip(&unfolded.bounces) {
            let bounds = self.scene.objects[self.mirrors.planes[plane as usize].object as usize].bounds;
            let margin = Vec3::splat(BEYOND_BORDER * bounds.diagonal());
            let at = bounce.as_vec3();
            if at.cmplt(bounds.min - margin).any() || at.cmpgt(bounds.max + margin).any() {
                return None;
            }
        }
        let in_front = seen.picture.apply(point).depth >= self.near;
        if !in_front {
            return None;
        }
        let (image_px, image_change) = seen.picture.pixel_with_change(point)?;
        Some(Projection {
            path,
            focal_index: 0,
            image_px,
            image_change,
            path_length: unfolded.image.distance(unfolded.eye) as f32,
            reflection_point: unfolded.bounces[0].as_vec3(),
            last_segment: unfolded.bounces.last().map_or(0.0, |last| last.distance(point.as_dvec3()) as f32),
            error_px: 0.0,
        })
    }
}

impl VertexProjector for MirrorProjector<'_> {
    fn paths(&self) -> &[SpecularPath] {
        &self.paths
    }

    fn project_on(&self, path: u32, points: &[Vec3], found: &mut Projections) {
        let chains = self.chains.get(path as usize).map_or(&[][..], Vec::as_slice);
        found.extend(points, |point, found| {
            if point.is_finite() {
                found.extend(chains.iter().filter_map(|seen| self.appearance(path, seen, point)));
            }
        });
    }
}
