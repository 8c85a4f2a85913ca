//! The panoramic cameras at nodes: read from a baked file or built when a view first needs them, kept for the next
//! views.

use super::bake::BakedNodes;
use super::node_key::{NodeKey, WantedNode, of_node};
use super::places::{MirrorPlaces, Moment};
use super::sightings::{AroundEye, NodeAnswer, PointCache};
use crate::sample_based_camera::panorama::{PanoramaSettings, PanoramicCameras, PanoramicMirrors};
use catoptric_core::math::Aabb;
use catoptric_core::parallel;
use catoptric_core::progress::Progress;
use catoptric_engine::error::RenderError;
use glam::DAffine3;
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// The nodes that were built.
#[derive(Default)]
pub(super) struct NodeStore {
    nodes: HashMap<NodeKey, KnownNode>,
    /// Known appearances of points at the nodes around an eye; those of the last view.
    around_eyes: HashMap<Vec<NodeKey>, (u64, Arc<AroundEye>)>,
    /// True if nodes have been forgotten because something has moved: from then on they are built with room to move.
    have_room: bool,
    /// The objects at which their paths end, because these show environment maps.
    mapped: Vec<u32>,
    /// Nodes of a baked file.
    baked: Option<BakedNodes>,
    /// The number of the last view.
    views: u64,
}

struct KnownNode {
    cameras: Arc<PanoramicCameras>,
    /// When it was built, or baked.
    built: Arc<Moment>,
    /// Rays were tested as far as that.
    bounds: Aabb,
    bytes: u64,
    /// The last view that needed it.
    view: u64,
    /// Appearances of points at the node, at its present place.
    answers: Arc<PointCache<NodeAnswer>>,
}

impl KnownNode {
    /// The node's motion with its reflector since it was built; `None` if the node is no longer valid.
    fn motion(&self, key: NodeKey, now: &Arc<Moment>, scene: &Aabb) -> Option<DAffine3> {
        self.built.motion_of_node(now, key, (self.cameras.eye(), &self.bounds), scene)
    }
}

/// A node of a view.
pub(super) struct FoundNode {
    pub(super) cameras: Arc<PanoramicCameras>,
    /// The node's motion with its reflector since the cameras were built.
    pub(super) motion: DAffine3,
    /// Appearances of points at the node.
    pub(super) answers: Arc<PointCache<NodeAnswer>>,
}

/// Counts of the nodes of a view by their origin.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct NodeCounts {
    /// Nodes that had to be built.
    pub(super) built: u64,
    /// Nodes that were read from a baked file.
    pub(super) read: u64,
    /// Built nodes that a baked file should have, but whose bytes are wrong.
    pub(super) unreadable: u64,
}

/// The origin of a node.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Origin {
    Bake,
    /// Built, as there is no bake, or one of other places.
    Built,
    /// Built, as the bake's bytes are wrong.
    Unreadable,
}

impl NodeStore {
    /// Nodes of a baked file.
    pub(super) fn of_bake(baked: BakedNodes) -> Self {
        Self { baked: Some(baked), ..Self::default() }
    }

    /// The nodes that a view needs, in their order: known ones, then those of the baked file, and the rest is built.
    /// Other nodes are kept as far as they fit into so many bytes, those that were needed last first.
    ///
    /// # Errors
    /// As [`PanoramicCameras::new`].
    pub(super) fn get(
        &mut self,
        wanted: &[WantedNode],
        (mirrors, places): (&PanoramicMirrors<'_>, &MirrorPlaces),
        settings: &PanoramaSettings,
        (scene, bytes): (Aabb, u64),
        progress: &dyn Progress,
    ) -> Result<(Vec<FoundNode>, NodeCounts), RenderError> {
        self.around_eyes.retain(|_, (view, _)| *view == self.views);
        self.views += 1;
        if self.mapped != settings.environment_mapped {
            self.mapped.clone_from(&settings.environment_mapped);
            self.nodes.clear();
            self.around_eyes.clear();
        }
        let now = places.now();
        let before = self.nodes.len();
        self.nodes.retain(|key, node| node.motion(*key, now, &scene).is_some());
        self.have_room |= self.nodes.len() < before;
        let have_room = self.have_room;
        let mut seen = HashSet::new();
        let missing: Vec<&WantedNode> =
            wanted.iter().filter(|(key, _)| !self.nodes.contains_key(key) && seen.insert(*key)).collect();
        self.around_eyes.retain(|nodes, _| nodes.iter().all(|node| !seen.contains(node)));
        let baked = self.baked.as_ref().filter(|baked| baked.maps(&self.mapped));
        let found =
            parallel::map_stage(progress, "building nodes", missing.len(), |index| -> Result<_, RenderError> {
                let (key, place) = *missing[index];
                let settings = of_node(settings, key);
                let baked = baked.filter(|baked| baked.holds_for(key, place, now, &scene));
                if let Some(baked) = baked
                    && let Some(read) = baked.node(key, place, &settings)
                {
                    return Ok((read, baked.built().clone(), baked.bounds(), Origin::Bake));
                }
                let origin = if baked.is_some() { Origin::Unreadable } else { Origin::Built };
                let place = places.place_now(key.reflector, place);
                let bounds = if have_room { now.roomy_box(key.reflector, &scene) } else { scene };
                let settings = PanoramaSettings { bounds: Some(bounds), ..settings };
                let cameras = PanoramicCameras::new(mirrors, place, &settings, progress)?.compact();
                Ok((cameras, now.clone(), bounds, origin))
            })?;
        let mut counts = NodeCounts::default();
        for ((key, _), found) in missing.into_iter().zip(found) {
            let (cameras, built, bounds, origin) = found?;
            *(if origin == Origin::Bake { &mut counts.read } else { &mut counts.built }) += 1;
            counts.unreadable += u64::from(origin == Origin::Unreadable);
            let (bytes, cameras) = (cameras.byte_count(), Arc::new(cameras));
            let known = KnownNode { cameras, built, bounds, bytes, view: self.views, answers: Default::default() };
            self.nodes.insert(*key, known);
        }
        let mut found = Vec::with_capacity(wanted.len());
        for (key, _) in wanted {
            if let Some(node) = self.nodes.get_mut(key) {
                node.view = self.views;
                let motion = node.motion(*key, now, &scene).unwrap_or(DAffine3::IDENTITY);
                found.push(FoundNode { cameras: node.cameras.clone(), motion, answers: node.answers.clone() });
            }
        }
        // Nodes keep points for this view and the next: points that neither needs have just gone out of use.
        let unused = self.nodes.values_mut().filter(|node| node.view + 2 == self.views);
        unused.for_each(|node| node.answers = Default::default());
        self.forget(bytes);
        Ok((found, counts))
    }

    /// Known appearances of points at the nodes around the eye of the last view.
    pub(super) fn around_eye(&mut self, nodes: Vec<NodeKey>) -> Arc<AroundEye> {
        let known = self.around_eyes.entry(nodes).or_default();
        known.0 = self.views;
        known.1.clone()
    }

    /// Drops the appearances of points: mirrors have moved.
    pub(super) fn forget_points(&mut self) {
        self.around_eyes.clear();
        self.nodes.values_mut().for_each(|node| node.answers = Default::default());
    }

    /// Forgets the nodes that were needed longest ago, but for those of the last view, until the rest fits.
    fn forget(&mut self, most_bytes: u64) {
        let mut bytes = self.byte_count();
        if bytes <= most_bytes {
            return;
        }
        let mut old: Vec<(u64, [u32; 3], NodeKey)> =
            self.nodes.iter().map(|(key, node)| (node.view, key.node.to_array(), *key)).collect();
        old.retain(|(view, ..)| *view < self.views);
        old.sort_by_key(|(view, node, key)| (*view, key.reflector, *node, key.order));
        for (.., key) in old {
            if bytes <= most_bytes {
                break;
            }
            bytes -= self.nodes.remove(&key).map_or(0, |node| node.bytes);
        }
    }

    /// The bytes of all cameras.
    pub(super) fn byte_count(&self) -> u64 {
        self.nodes.values().map(|node| node.bytes).sum()
    }

    /// The number of nodes.
    pub(super) fn count(&self) -> u64 {
        self.nodes.len() as u64
    }
}
