//! Reflection morphing (Popescu, Sacks, Mei 2006, section VI): cameras stand at the nodes of a grid around every
//! reflector, and of each point the appearances at the four nodes around the eye are blended.

mod agreement;
pub(crate) mod bake;
mod blend;
pub(crate) mod grid;
mod mean;
pub(crate) mod node_key;
mod nodes;
pub(crate) mod places;
pub(crate) mod sightings;
mod steady;

pub(super) use bake::NodesWork;
pub use grid::nodes_around;

use super::at_eye::{SampleBasedCamera, ViewCameras};
use super::hybrid::MappedReflectors;
use super::panorama::{PanoramaSettings, PanoramicMirrors};
use super::rays::extent::extent;
use super::settings::{Ambiguous, Blend, SampleBasedCameraSettings, margin_px};
use crate::draw::MapsInView;
use crate::draw::prepared::{Context, MeshProjection};
use crate::draw::stages::{Stages, mirror_tracer};
use crate::draw::virtual_mesh::{Ends, MeshQuality, SteadySource};
use crate::draw::virtual_scene::MirrorState;
use crate::draw::work_limit::WorkLimit;
use crate::find::ray_map::{RayField, ViewField};
use bake::BakedNodes;
use blend::{BlendedPath, BlendedReflector, MorphProjector};
use catoptric_core::scene::{PreciseView, Projection, Scene, View};
use catoptric_engine::error::RenderError;
use catoptric_engine::light::tracer::Tracer;
use catoptric_engine::method::bake::Baked;
use catoptric_engine::method::projector::SpecularPath;
use catoptric_engine::method::{MethodInfo, Quality, Report};
use catoptric_engine::optics::path::bundle::{Bounce, BounceKind};
use glam::UVec3;
use grid::NodeGrid;
use node_key::{NodeKey, WantedNode, cameras_of, counts_of};
use nodes::{FoundNode, NodeCounts, NodeStore};
use places::{Carried, MirrorPlaces};
use sightings::{AroundEye, Node};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

/// Nodes are built for this many reflectors of a view at the most, those that appear largest: it takes some tenths of a
/// second each. Chosen, not measured.
const MOST_REFLECTORS: usize = 8;

/// The method with its settings.
#[derive(Clone)]
pub(super) struct Morphing {
    /// The method with cameras at the eye, for paths that are not blended.
    at_runtime: SampleBasedCamera,
    /// Nodes along each axis.
    counts: UVec3,
}

/// The mirrors of a scene, and the nodes that were built for them.
pub(super) struct MorphMirrors {
    tracer: Arc<Tracer>,
    nodes: Arc<Mutex<NodeStore>>,
    /// The mirrors' places now, and when the grids were laid out.
    places: MirrorPlaces,
}

/// The nodes and paths that a view is blended from.
pub(super) struct MorphView {
    /// The reflectors that have nodes around the eye.
    reflectors: Vec<ReflectorInView>,
    paths: Vec<SpecularPath>,
    /// The numbers at the nodes of the blended paths, which come first.
    blended: Vec<BlendedPath>,
    /// The cameras at the eye for the rest, and the numbers of these there: only for points one by one.
    at_eye: Option<ViewCameras>,
    in_cameras_at_eye: Vec<u32>,
    /// Paths that some node does not know, and reflectors in whose grid the eye is not.
    left_out: Vec<SpecularPath>,
    /// Reflectors in view that have no nodes about this eye.
    beyond_grid: u64,
    /// Paths on which the nodes do not agree: tiles draw them, too, and points are looked for from the eye.
    disagreeing: u64,
    /// The reflectors that show environment maps: paths end at them.
    environment: MappedReflectors,
    counts: NodeCounts,
    /// Nodes that are kept, and their bytes.
    kept: [u64; 2],
}

/// A reflector with nodes.
struct ReflectorInView {
    /// The nodes around the eye, with their weights.
    nodes: Vec<(f32, FoundNode)>,
    /// Known appearances of points at these nodes.
    known: Arc<AroundEye>,
}

/// The context for cameras at the eye.
fn at_eye<'a>(context: &Context<'a, Morphing>) -> Context<'a, SampleBasedCamera> {
    let Context { scene, virtual_scene, mirrors, view, order, work, without, is_for_picture, .. } = *context;
    // Blended paths go on where cameras would leave something out.
    let ends = Ends::Followed;
    Context { scene, virtual_scene, mirrors: &mirrors.tracer, view, order, work, without, is_for_picture, ends }
}

impl Morphing {
    /// The method with its settings.
    ///
    /// # Errors
    /// [`RenderError::Setting`] for a grid that is none.
    pub(super) fn new(info: &'static MethodInfo, settings: SampleBasedCameraSettings) -> Result<Self, RenderError> {
        let counts = counts_of(&settings)?;
        Ok(Self { at_runtime: SampleBasedCamera { info, settings }, counts })
    }

    fn settings(&self) -> &SampleBasedCameraSettings {
        &self.at_runtime.settings
    }

    /// The cameras at the eye.
    ///
    /// # Errors
    /// As [`MeshProjection::view_data`].
    fn cameras_at_eye(&self, context: &Context<'_, Self>, stages: &mut Stages<'_>) -> Result<ViewCameras, RenderError> {
        self.at_runtime.view_data(&at_eye(context), stages)
    }

    /// The reflectors and lenses in view, the largest first, as they appear.
    fn in_view(scene: &Scene, view: &View, margin_px: f32) -> Vec<u32> {
        let (field, picture) = (&ViewField::new(view, margin_px), PreciseView::new(view));
        let [width, height] = field.size_px().map(f64::from);
        let size = |object: u32| match extent(&scene.objects[object as usize].bounds, field) {
            Some([low, high]) => {
                let length = |axis: usize, most: f64| high[axis].min(most) - low[axis].max(0.0);
                let (across, down) = (length(0, width), length(1, height));
                if across > 0.0 && down > 0.0 { across * down } else { 0.0 }
            }
            // The reflector is behind the eye, or in part.
            None => {
                let mut corners = scene.objects[object as usize].bounds.corners().into_iter();
                let is_before = corners.any(|corner| picture.depth_of(corner.as_dvec3()) > 0.0);
                if is_before { width * height } else { 0.0 }
            }
        };
        let mut found: Vec<(f64, u32)> =
            scene.specular_objects().into_iter().map(|object| (size(object), object)).collect();
        found.retain(|(size, _)| *size > 0.0);
        found.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        found.into_iter().map(|(_, object)| object).collect()
    }

    /// The nodes around the eye in a reflector's grid with their weights; `None` beyond it, and where a node is in the
    /// reflector's box: it may see the reflector from within.
    fn nodes_of(
        &self,
        places: &MirrorPlaces,
        reflector: u32,
        view: &View,
        order: u32,
    ) -> Option<Vec<(f32, WantedNode)>> {
        if !matches!(view.projection, Projection::Perspective { .. }) {
            return None;
        }
        let bounds = places.box_of_grid(reflector);
        let grid = NodeGrid::around(bounds, self.counts, self.settings().grid_reach);
        let corners = grid.tetrahedron(places.place_in_grid(reflector, view.eye()))?;
        let wanted = corners.into_iter().map(|(node, weight)| {
            let place = grid.place(node);
            let is_outside = !bounds.contains(place);
            is_outside.then_some((weight, (NodeKey { reflector, node, order }, place)))
        });
        wanted.collect()
    }
}

impl MorphView {
    /// Sorts out which paths every node of their reflector knows.
    fn find_paths(&mut self) {
        let mut known: BTreeMap<SpecularPath, (usize, Vec<Option<u32>>)> = BTreeMap::new();
        for (reflector, ReflectorInView { nodes, .. }) in self.reflectors.iter().enumerate() {
            for (number, (_, node)) in nodes.iter().enumerate() {
                for (index, path) in node.cameras.paths().iter().enumerate() {
                    let entry = known.entry(path.clone()).or_insert_with(|| (reflector, vec![None; nodes.len()]));
                    entry.1[number] = Some(index as u32);
                }
            }
        }
        for (path, (reflector, in_nodes)) in known {
            match in_nodes.into_iter().collect() {
                Some(in_nodes) => {
                    self.paths.push(path);
                    self.blended.push(BlendedPath { reflector, in_nodes });
                }
                None => self.left_out.push(path),
            }
        }
    }

    /// Leaves out the paths that are not blended.
    fn leave_out_unless(&mut self, are_blended: Vec<bool>) {
        let paths = std::mem::take(&mut self.paths).into_iter().zip(std::mem::take(&mut self.blended));
        for ((path, blended), is_blended) in paths.zip(are_blended) {
            if is_blended {
                self.paths.push(path);
                self.blended.push(blended);
            } else {
                self.left_out.push(path);
                self.disagreeing += 1;
            }
        }
    }

    /// Leaves out paths that no node knows, by their first bounce: both paths of a lens are left out, if one is.
    fn leave_out_unknown(&mut self, objects: &[u32], order: u32) {
        let first = |path: &SpecularPath| path.bounces.first().map(|bounce| bounce.object);
        for &object in objects.iter().filter(|_| order > 0) {
            if !self.paths.iter().chain(&self.left_out).any(|path| first(path) == Some(object)) {
                let kind = BounceKind::Reflect;
                self.left_out.push(SpecularPath { bounces: vec![Bounce { object, kind }] });
            }
        }
    }

    /// Takes the paths that are not blended from cameras at the eye.
    fn add_from_eye(&mut self, cameras: ViewCameras) {
        for (number, group) in (0..).zip(&cameras.grid.groups) {
            if !self.paths.contains(&group.path) {
                self.paths.push(group.path.clone());
                self.in_cameras_at_eye.push(number);
            }
        }
        self.left_out.clear();
        self.at_eye = Some(cameras);
    }
}

impl MeshProjection for Morphing {
    type Mirrors = MorphMirrors;
    type ViewData = MorphView;
    type Projector<'a> = MorphProjector<'a>;

    fn info(&self) -> &'static MethodInfo {
        self.at_runtime.info
    }

    fn mirrors(
        &self,
        scene: &Scene,
        _: Quality,
        old: Option<&MorphMirrors>,
        stages: &mut Stages<'_>,
    ) -> Result<MorphMirrors, RenderError> {
        let tracer = mirror_tracer(scene, old.map(|old| &old.tracer), stages)?;
        let (nodes, places) = match old {
            Some(old) => (old.nodes.clone(), old.places.clone()),
            None => (Default::default(), MirrorPlaces::new(scene)),
        };
        Ok(MorphMirrors { tracer, nodes, places })
    }

    /// Nodes move with their reflectors.
    fn take_moved(&self, mirrors: &mut MorphMirrors, old: &MorphMirrors, (scene, now): (&Scene, &MirrorState)) {
        if let Some(places) = old.places.at(scene, now) {
            old.nodes.lock().unwrap_or_else(PoisonError::into_inner).forget_points();
            (mirrors.nodes, mirrors.places) = (old.nodes.clone(), places);
        }
    }

    fn take_bake(
        &self,
        mirrors: &mut MorphMirrors,
        scene: &Scene,
        quality: Quality,
        bake: Arc<dyn Baked>,
    ) -> Result<(), RenderError> {
        let baked = BakedNodes::new((self.settings(), self.counts), (scene, &mirrors.places), quality.order, bake)?;
        mirrors.nodes = Arc::new(Mutex::new(NodeStore::of_bake(baked)));
        Ok(())
    }

    fn view_data(&self, context: &Context<'_, Self>, stages: &mut Stages<'_>) -> Result<MorphView, RenderError> {
        let Context { scene, virtual_scene, mirrors, view, order, .. } = *context;
        let margin_px = margin_px(self.settings());
        let environment = MappedReflectors::new(self.settings(), scene, &ViewField::new(view, margin_px))?;
        let mut objects = Self::in_view(scene, view, margin_px);
        objects.retain(|&object| !environment.mapped[object as usize]);
        let largest = objects.iter().take(MOST_REFLECTORS);
        let around: Vec<Vec<(f32, WantedNode)>> =
            largest.filter_map(|&object| self.nodes_of(&mirrors.places, object, view, order)).collect();
        let wanted: Vec<WantedNode> = around.iter().flatten().map(|(_, node)| *node).collect();
        let panoramic = PanoramicMirrors::of(scene, mirrors.tracer.clone(), virtual_scene.topologies());
        let mut store = mirrors.nodes.lock().unwrap_or_else(PoisonError::into_inner);
        let limits = (scene.bounds, u64::from(self.settings().node_memory) << 20);
        let settings = PanoramaSettings { environment_mapped: environment.objects(), ..cameras_of(self.settings()) };
        let panoramic = (&panoramic, &mirrors.places);
        let (found, counts) = store.get(&wanted, panoramic, &settings, limits, stages.progress)?;
        let kept = [store.count(), store.byte_count()];
        let mut found = found.into_iter();
        let of_reflector = |nodes: &Vec<(f32, WantedNode)>| ReflectorInView {
            known: store.around_eye(nodes.iter().map(|(_, (key, _))| *key).collect()),
            nodes: nodes.iter().map(|(weight, _)| *weight).zip(found.by_ref()).collect(),
        };
        let reflectors: Vec<ReflectorInView> = around.iter().map(of_reflector).collect();
        drop(store);
        stages.lap("nodes");
        let mut found = MorphView {
            beyond_grid: (objects.len() - reflectors.len()) as u64,
            reflectors,
            paths: Vec::new(),
            blended: Vec::new(),
            at_eye: None,
            in_cameras_at_eye: Vec::new(),
            left_out: Vec::new(),
            disagreeing: 0,
            environment,
            counts,
            kept,
        };
        found.find_paths();
        // The paper's mean is drawn wherever there are nodes, and by nothing else.
        let blends_all = self.settings().blend == Blend::Mean;
        if !blends_all {
            let probes = agreement::probes(scene);
            let are_blended = self.projector(context, &found).are_blended(&probes);
            found.leave_out_unless(are_blended);
            stages.lap("agreement");
        }
        if context.is_for_picture {
            found.leave_out_unknown(&objects, order);
        } else if !blends_all {
            found.add_from_eye(self.cameras_at_eye(context, stages)?);
        }
        Ok(found)
    }

    fn is_complete(&self, data: &MorphView) -> bool {
        data.left_out.is_empty()
    }

    fn fits(&self, context: &Context<'_, Self>, data: &MorphView) -> Result<bool, RenderError> {
        let field = ViewField::new(context.view, margin_px(self.settings()));
        data.environment.fits(self.settings(), context.scene, &field)
    }

    /// Captures the environment maps.
    fn complete(
        &self,
        context: &Context<'_, Self>,
        data: &mut MorphView,
        stages: &mut Stages<'_>,
    ) -> Result<(), RenderError> {
        data.environment.complete(self.settings(), (context.scene, context.order), stages)
    }

    fn forget_objects(&self, data: &mut MorphView) {
        data.environment.forget();
    }

    fn maps<'a>(&self, data: &'a MorphView) -> MapsInView<'a> {
        data.environment.in_view()
    }

    fn describe(&self, data: &MorphView, report: &mut Report) {
        data.environment.describe(report);
        report
            .counts
            .insert("nodes_blended", data.reflectors.iter().map(|reflector| reflector.nodes.len() as u64).sum());
        report.counts.insert("nodes_built", data.counts.built);
        report.counts.insert("nodes_read", data.counts.read);
        report.counts.insert("nodes_kept", data.kept[0]);
        report.bytes.insert("nodes", data.kept[1]);
        let known = data.reflectors.iter().map(|reflector| reflector.known.points.count());
        report.counts.insert("cached_points", known.sum());
        let steady = data.reflectors.iter().map(|reflector| reflector.known.meshes.byte_count());
        report.bytes.insert("steady_vertices", steady.sum());
        report.add_fallback("unreadable_nodes", data.counts.unreadable);
        report.add_fallback("reflectors_without_nodes", data.beyond_grid);
        report.add_fallback("paths_without_nodes", (data.left_out.len() as u64).saturating_sub(data.disagreeing));
        report.add_fallback("paths_of_disagreeing_nodes", data.disagreeing);
    }

    fn work_limit(&self) -> WorkLimit {
        self.settings().work_limit()
    }

    fn mesh_quality(&self, view: &View) -> MeshQuality {
        MeshQuality::new(view, self.settings().edge_error_px, self.settings().piece_px)
    }

    fn steady<'a>(projector: &'a MorphProjector<'_>) -> Option<&'a dyn SteadySource> {
        Some(projector)
    }

    fn projector<'a>(&'a self, context: &Context<'a, Self>, data: &'a MorphView) -> MorphProjector<'a> {
        let Context { scene, virtual_scene, mirrors, view, order, .. } = *context;
        let panoramic = PanoramicMirrors::of(scene, mirrors.tracer.clone(), virtual_scene.topologies());
        let of_reflector = |ReflectorInView { nodes, known }: &'a ReflectorInView| {
            // A view's nodes were built for this scene's objects.
            let node = |(weight, FoundNode { cameras, motion, answers }): &'a (f32, FoundNode)| {
                let (projector, carried) = (cameras.projector(&panoramic).ok()?, Carried::new(motion));
                Some(Node { weight: *weight, projector, carried, answers })
            };
            BlendedReflector { nodes: nodes.iter().filter_map(node).collect(), known }
        };
        let cameras_at_eye = data.at_eye.as_ref().map(|cameras| self.at_runtime.projector(&at_eye(context), cameras));
        MorphProjector {
            cameras_at_eye,
            in_cameras_at_eye: &data.in_cameras_at_eye,
            reflectors: data.reflectors.iter().map(of_reflector).collect(),
            paths: &data.paths,
            blended: &data.blended,
            left_out: &data.left_out,
            eye: view.eye().as_dvec3(),
            view: view.clone(),
            precise_view: PreciseView::new(view),
            scene,
            tracer: mirrors.tracer.clone(),
            surfaces: virtual_scene.surfaces(scene),
            order,
            polish: self.settings().polish,
            cures: self.settings().ambiguous == Ambiguous::Cured,
            blend: self.settings().blend,
            counts: Default::default(),
        }
    }
}
