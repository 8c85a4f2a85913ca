//! Nodes as work in units: one of every node.

use super::grid::NodeGrid;
use super::node_key::{NodeKey, cameras_of, counts_of, of_node};
use super::places::{MirrorPlaces, Moment};
use crate::sample_based_camera::hybrid;
use crate::sample_based_camera::panorama::{PanoramaSettings, PanoramicCameras, PanoramicMirrors};
use crate::sample_based_camera::settings::{Mode, SampleBasedCameraSettings};
use catoptric_core::clock::Stopwatch;
use catoptric_core::math::Aabb;
use catoptric_core::parallel;
use catoptric_core::progress::Silent;
use catoptric_core::scene::Scene;
use catoptric_engine::error::RenderError;
use catoptric_engine::method::bake::{BakeUnit, BakeWork, Baked, MadeUnit, UnitMaker};
use catoptric_engine::method::{Quality, Settings};
use glam::{UVec3, Vec3};
use std::ops::Range;
use std::sync::{Arc, OnceLock};

/// The layout of a unit's bytes; also how the contents are computed: the version changes with them.
const PAYLOAD_VERSION: u32 = 2;

/// A node with more bytes is refused. Those of the default settings have about 0.3 MB on `two_spheres`, 3 on `teapot`.
const MOST_BYTES: u64 = 48 << 20;

/// Nodes that are made for an estimate at the most, this many at once, for as long as they take no longer than this.
const ESTIMATED_NODES: usize = 16;
const ESTIMATED_AT_ONCE: usize = 4;
const ESTIMATE_MS: f64 = 1000.0;

/// The nodes of all grids.
#[derive(Clone, Debug)]
pub struct NodeTable {
    /// Reflectors with their boxes and grids, whose nodes are numbered one grid after the other.
    pub grids: Vec<(u32, Aabb, NodeGrid)>,
    /// The highest order of their paths.
    pub order: u32,
    /// Nodes of a grid.
    pub counts: UVec3,
}

impl NodeTable {
    fn new((counts, reach): (UVec3, f32), scene: &Scene, mapped: &[bool], order: u32) -> Self {
        let reflectors = scene.specular_objects().into_iter().filter(|&object| !mapped[object as usize]);
        let grids = reflectors.map(|object| {
            let bounds = scene.objects[object as usize].bounds;
            (object, bounds, NodeGrid::around(&bounds, counts, reach))
        });
        Self { grids: grids.collect(), order, counts }
    }

    fn nodes_of_grid(&self) -> usize {
        self.counts.element_product() as usize
    }

    /// The number of nodes.
    pub fn count(&self) -> usize {
        self.grids.len() * self.nodes_of_grid()
    }

    /// The number of a node.
    pub fn number(&self, NodeKey { reflector, node, order }: NodeKey) -> Option<usize> {
        let grid = self.grids.iter().position(|(object, ..)| *object == reflector)?;
        let UVec3 { x, y, .. } = self.counts;
        (order == self.order && node.cmplt(self.counts).all())
            .then_some(grid * self.nodes_of_grid() + ((node.z * y + node.y) * x + node.x) as usize)
    }

    /// The node of a number, its place, and whether views use it: not within the box of its own reflector.
    pub fn node(&self, number: usize) -> Option<(NodeKey, Vec3, bool)> {
        let of_grid = self.nodes_of_grid();
        let (reflector, bounds, grid) = self.grids.get(number / of_grid)?;
        let (rest, UVec3 { x, y, .. }) = ((number % of_grid) as u32, self.counts);
        let node = UVec3::new(rest % x, rest / x % y, rest / (x * y));
        let place = grid.place(node);
        Some((NodeKey { reflector: *reflector, node, order: self.order }, place, !bounds.contains(place)))
    }
}

/// The nodes of a scene's reflectors and lenses.
pub(in super::super) struct NodesWork<'a> {
    scene: &'a Scene,
    settings: SampleBasedCameraSettings,
    /// True for each object that shows an environment map.
    mapped: Vec<bool>,
    table: NodeTable,
}

impl<'a> NodesWork<'a> {
    /// # Errors
    /// [`RenderError::Setting`] for settings that do not fit the scene, [`RenderError::Limit`] where there is nothing
    /// to be baked.
    pub(in super::super) fn new(
        settings: SampleBasedCameraSettings,
        scene: &'a Scene,
        quality: Quality,
    ) -> Result<Self, RenderError> {
        let limit = |problem: &str| {
            Err(RenderError::Limit { method: SampleBasedCameraSettings::METHOD, problem: problem.into() })
        };
        if settings.mode == Mode::Runtime {
            return limit("mode = \"runtime\" builds its cameras for every view: bake with mode=morph");
        }
        let counts = counts_of(&settings)?;
        let mapped = hybrid::named(&settings, scene)?;
        let table = NodeTable::new((counts, settings.grid_reach), scene, &mapped, quality.order);
        match () {
            () if quality.order == 0 => limit("order 0 shows no reflection: there is nothing to bake"),
            () if table.grids.is_empty() => limit("the scene has no reflector and no lens: there is nothing to bake"),
            () => Ok(Self { scene, settings, mapped, table }),
        }
    }
}

impl BakeWork for NodesWork<'_> {
    fn payload_version(&self) -> u32 {
        PAYLOAD_VERSION
    }

    fn settings(&self) -> toml::Table {
        let mut table = self.settings.baked();
        table.insert("order".into(), i64::from(self.table.order).into());
        table
    }

    fn write_scene(&self, sink: &mut dyn FnMut(&[u8])) {
        let scene = self.scene;
        scene.write_identity(|object| !scene.role_of(object).is_specular(), sink);
        // Objects that move among the mirrors are no part of it, as long as they stay within the box.
        let Aabb { min, max } = scene.bounds;
        sink(format!("{:?} {} {min:?} {max:?}", scene.specular_objects(), scene.objects.len()).as_bytes());
        sink(&scene.near().to_le_bytes());
    }

    fn units(&self) -> Result<Vec<BakeUnit>, RenderError> {
        let unit = |number: usize| {
            let (NodeKey { reflector, node, .. }, _, is_used) = self.table.node(number)?;
            let UVec3 { x, y, z } = node;
            let name = format!("{}, node {x} {y} {z}", self.scene.objects[reflector as usize].name);
            let bytes = if is_used { MOST_BYTES } else { 0 };
            Some(BakeUnit { name, bytes, at_most: is_used, with_previous: false })
        };
        Ok((0..self.table.count()).filter_map(unit).collect())
    }

    fn maker<'b>(&'b self) -> Result<Box<dyn UnitMaker + 'b>, RenderError> {
        let environment_mapped = hybrid::numbers(&self.mapped);
        let settings = PanoramaSettings { environment_mapped, ..cameras_of(&self.settings) };
        let (table, mirrors) = (&self.table, PanoramicMirrors::new(self.scene));
        Ok(Box::new(NodeMaker { table, mirrors, settings, sample: OnceLock::new() }))
    }
}

/// Makes nodes.
struct NodeMaker<'a> {
    table: &'a NodeTable,
    mirrors: PanoramicMirrors<'a>,
    settings: PanoramaSettings,
    /// Seconds and bytes of all nodes, about.
    sample: OnceLock<(f64, f64)>,
}

impl NodeMaker<'_> {
    fn node(&self, number: usize) -> Result<Option<Vec<u8>>, RenderError> {
        let Some((key, place, is_used)) = self.table.node(number) else { return Ok(None) };
        if !is_used {
            return Ok(Some(Vec::new()));
        }
        let cameras = PanoramicCameras::new(&self.mirrors, place, &of_node(&self.settings, key), &Silent)?;
        let bytes = cameras.to_bytes();
        if bytes.len() as u64 <= MOST_BYTES {
            return Ok(Some(bytes));
        }
        let problem = format!(
            "a node takes {} bytes, {MOST_BYTES} are allowed; make node_size smaller, or finest_ray_px larger",
            bytes.len()
        );
        Err(RenderError::Limit { method: SampleBasedCameraSettings::METHOD, problem })
    }

    /// Seconds of one core and bytes of all nodes, by those of a few.
    fn sampled(&self) -> (f64, f64) {
        *self.sample.get_or_init(|| {
            let count = self.table.count();
            // The sampled nodes are as far apart as they can be, whatever the numbers of rows are.
            let number = |index: usize| ((index as f64 + 0.5) * 0.618_033_988_75).fract() * count as f64;
            let (mut watch, mut spent_ms, mut bytes, mut made) = (Stopwatch::new(), 0.0, 0, 0);
            while made < ESTIMATED_NODES && spent_ms < ESTIMATE_MS {
                let node = |index: usize| self.node(number(made + index) as usize);
                let nodes = parallel::map_collect(ESTIMATED_AT_ONCE, node);
                bytes += nodes.into_iter().flatten().flatten().map(|node| node.len()).sum::<usize>();
                made += ESTIMATED_AT_ONCE;
                spent_ms += watch.lap_ms();
            }
            let seconds = spent_ms * 1e-3 * parallel::thread_count() as f64;
            let share = count as f64 / made as f64;
            (seconds * share, bytes as f64 * share)
        })
    }
}

impl UnitMaker for NodeMaker<'_> {
    fn make(&self, batch: Range<usize>) -> Result<Vec<MadeUnit>, RenderError> {
        let mut made = Vec::new();
        for number in batch {
            made.extend(self.node(number)?.map(|bytes| MadeUnit { bytes, note: None }));
        }
        Ok(made)
    }

    fn estimate_core_secs(&self) -> f64 {
        self.sampled().0
    }

    fn estimate_bytes(&self) -> Option<u64> {
        Some(self.sampled().1 as u64)
    }
}

/// The nodes of a baked file: read one by one, when a view needs them.
pub(super) struct BakedNodes {
    units: Arc<dyn Baked>,
    table: NodeTable,
    /// Objects that show environment maps.
    mapped: Vec<u32>,
    /// The scene's box: rays were tested as far as that.
    bounds: Aabb,
    /// The mirrors' places for which they were baked.
    built: Arc<Moment>,
    object_count: usize,
}

impl BakedNodes {
    /// Opens the baked nodes of a scene.
    ///
    /// # Errors
    /// [`RenderError::Setting`] for settings that do not fit the scene, [`RenderError::Limit`] where the file has
    /// another number of nodes.
    pub(super) fn new(
        (settings, counts): (&SampleBasedCameraSettings, UVec3),
        (scene, places): (&Scene, &MirrorPlaces),
        order: u32,
        units: Arc<dyn Baked>,
    ) -> Result<Self, RenderError> {
        let mapped = hybrid::named(settings, scene)?;
        let table = NodeTable::new((counts, settings.grid_reach), scene, &mapped, order);
        let (found, wanted) = (units.unit_count(), table.count());
        if found != wanted {
            let problem = format!("the baked file has {found} units where the scene needs {wanted} nodes");
            return Err(RenderError::Limit { method: SampleBasedCameraSettings::METHOD, problem });
        }
        let mapped = hybrid::numbers(&mapped);
        let (bounds, built) = (scene.bounds, places.now().clone());
        Ok(Self { units, table, mapped, bounds, built, object_count: scene.objects.len() })
    }

    /// True if these objects show environment maps.
    pub(super) fn maps(&self, mapped: &[u32]) -> bool {
        self.mapped == mapped
    }

    /// True while nothing leaves the box, and the mirrors are where they were, from a node about a place.
    pub(super) fn holds_for(&self, key: NodeKey, place: Vec3, now: &Moment, scene: &Aabb) -> bool {
        self.built.motion_of_node(now, key, (place, &self.bounds), scene).is_some()
    }

    /// The mirrors' places for which they were baked.
    pub(super) fn built(&self) -> &Arc<Moment> {
        &self.built
    }

    /// A node, if the file has it.
    pub(super) fn node(&self, key: NodeKey, place: Vec3, settings: &PanoramaSettings) -> Option<PanoramicCameras> {
        let bytes = self.units.unit(self.table.number(key)?);
        PanoramicCameras::of_bytes(bytes, place, self.object_count, settings)
    }

    /// The bounds for which its nodes hold.
    pub(super) fn bounds(&self) -> Aabb {
        self.bounds
    }
}
