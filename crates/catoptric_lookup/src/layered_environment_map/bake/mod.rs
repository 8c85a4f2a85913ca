//! Layers as work in units: one of every viewpoint, layer and face.

pub(crate) mod stored;
pub(crate) mod table;

use super::inference::Inference;
use super::inference::least_squares::Residual;
use super::settings::{LayeredEnvironmentMapSettings, Textures};
use super::shells::groups::LensGroup;
use super::shells::layer_geometry::{LayerGeometry, PartShells};
use super::textures::maps::Layer;
use catoptric_core::clock::Stopwatch;
use catoptric_core::progress::Silent;
use catoptric_core::scene::Scene;
use catoptric_engine::error::RenderError;
use catoptric_engine::method::bake::{BakeUnit, BakeWork, MadeUnit, UnitMaker};
use catoptric_engine::method::{Quality, Settings};
use std::ops::Range;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use table::{LayersBatch, UnitTable};

/// The layout of a unit's bytes. The first unit has the shells. A unit of surfaces has, for a face, the bits of the
/// least depth, the steps of codes as a power of two and the distance of the nearest surface, then the codes of every
/// texel, front and back; and the textures if these are projected. Textures are texels of four half floats, level after
/// level from the finest; the lowest byte of each number comes first. Also how all of this is computed: the version
/// changes with the contents of units.
const PAYLOAD_VERSION: u32 = 8;

/// The factors by which the pictures of an estimate are smaller.
const ESTIMATE_SHARES: [u32; 2] = [6, 3];

/// The factor by which the textures of an estimate are smaller.
const ESTIMATED_TEXTURE_SHARE: u32 = 4;

/// Settings that projected textures do not depend on.
const OF_INFERENCE: [&str; 3] = ["picture_size", "neighbours", "direct"];

/// The layers of all viewpoints of a scene.
pub(super) struct LayersWork<'a> {
    scene: &'a Scene,
    settings: LayeredEnvironmentMapSettings,
    order: u32,
    /// Made when it is needed: not to compare a finished bake with the settings.
    known: OnceLock<LayerGeometry>,
}

impl<'a> LayersWork<'a> {
    /// # Errors
    /// [`RenderError::Limit`] where there is nothing to be baked.
    pub(super) fn new(
        settings: &LayeredEnvironmentMapSettings,
        scene: &'a Scene,
        quality: Quality,
    ) -> Result<Self, RenderError> {
        let problem = match () {
            () if quality.order == 0 => "order 0 shows no reflection: there is nothing to bake",
            () if !LensGroup::any(scene) => "the scene has no reflector and no lens: there is nothing to bake",
            () => {
                let (settings, order) = (settings.sized(), quality.order);
                return Ok(Self { scene, settings, order, known: OnceLock::new() });
            }
        };
        Err(RenderError::Limit { method: LayeredEnvironmentMapSettings::METHOD, problem: problem.into() })
    }

    fn known(&self) -> &LayerGeometry {
        self.known.get_or_init(|| LayerGeometry::new(&self.settings, self.scene, self.order))
    }

    fn shells(&self) -> Vec<u8> {
        let known = self.known();
        let part = |part: usize| PartShells {
            center: known.center_of(part),
            shells: known.strata_of(part).iter().map(|stratum| stratum.shell).collect(),
        };
        let parts: Vec<PartShells> = (0..known.part_count()).map(part).collect();
        stored::shells_to_bytes(known.groups.len(), known.viewpoint_count(), &parts)
    }

    fn table(&self) -> UnitTable {
        let known = self.known();
        let shells = |part: usize| known.strata_of(part).iter().map(|stratum| &stratum.shell).collect();
        let parts = (0..known.part_count()).map(shells);
        UnitTable::new(&self.settings, parts, known.groups.len(), known.viewpoint_count(), self.shells().len())
    }
}

impl BakeWork for LayersWork<'_> {
    fn payload_version(&self) -> u32 {
        PAYLOAD_VERSION
    }

    fn settings(&self) -> toml::Table {
        let mut table = self.settings.baked();
        if self.settings.textures == Textures::Projected {
            OF_INFERENCE.iter().for_each(|key| drop(table.remove(*key)));
        }
        table.insert("order".into(), i64::from(self.order).into());
        table
    }

    fn write_scene(&self, sink: &mut dyn FnMut(&[u8])) {
        self.scene.write_identity(|_| false, sink);
        // Cameras are no part of a scene's identity, but viewpoints are about its first one.
        let eye = self.scene.default_view(4, 3).eye();
        eye.to_array().iter().for_each(|along| sink(&along.to_le_bytes()));
    }

    fn units(&self) -> Result<Vec<BakeUnit>, RenderError> {
        // Inferred textures are in memory together with those projected from the centre.
        let made_at_once = if self.settings.textures == Textures::Inferred { 2 } else { 1 };
        self.known().check_memory(&self.settings, made_at_once)?;
        Ok(self.table().units())
    }

    fn maker<'b>(&'b self) -> Result<Box<dyn UnitMaker + 'b>, RenderError> {
        let projected = (0..self.known().part_count()).map(|_| Mutex::new(None)).collect();
        Ok(Box::new(LayersMaker { work: self, table: self.table(), projected }))
    }
}

/// Makes the layers of viewpoints.
struct LayersMaker<'a> {
    work: &'a LayersWork<'a>,
    table: UnitTable,
    /// Layers of every part that was needed, as seen from its centre: textures are inferred over these.
    projected: Vec<Mutex<Option<Arc<Vec<Layer>>>>>,
}

impl LayersMaker<'_> {
    fn captured(&self, settings: &LayeredEnvironmentMapSettings, part: usize) -> Result<Vec<Layer>, RenderError> {
        let LayersWork { scene, .. } = self.work;
        Ok(self.work.known().projected_part(settings, scene, part, &Silent)?)
    }

    fn projected(&self, part: usize) -> Result<Arc<Vec<Layer>>, RenderError> {
        let mut kept = self.projected[part].lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(layers) = &*kept {
            return Ok(layers.clone());
        }
        let layers = Arc::new(self.captured(&self.work.settings, part)?);
        *kept = Some(layers.clone());
        Ok(layers)
    }

    fn infer(
        &self,
        settings: &LayeredEnvironmentMapSettings,
        part: usize,
        viewpoint: u32,
    ) -> Result<(Vec<Layer>, Vec<Residual>), RenderError> {
        let (scene, known) = (self.work.scene, self.work.known());
        Inference { scene, settings, known }.infer(part, &self.projected(part)?, viewpoint, &Silent)
    }

    /// Time that one core takes for the surfaces seen from a part's centre, in seconds.
    fn capture_core_secs(&self, part: usize) -> f64 {
        let share = ESTIMATED_TEXTURE_SHARE.min(self.work.settings.size / 8);
        let settings =
            LayeredEnvironmentMapSettings { size: self.work.settings.size / share, ..self.work.settings.clone() };
        let mut watch = Stopwatch::new();
        // An error will come up again when units are made.
        drop(self.captured(&settings, part));
        watch.lap_ms() * 1e-3 * f64::from(share * share) * catoptric_core::parallel::thread_count() as f64
    }

    /// Time that one core takes for a viewpoint's textures of a part.
    fn viewpoint_core_secs(&self, part: usize) -> f64 {
        let size = self.work.settings.picture_size;
        let pixels = |size: u32| f64::from(size * size);
        // Made before the clock starts.
        drop(self.projected(part));
        // A part is for pixels, and a part is not.
        let [small, large] = ESTIMATE_SHARES.map(|share| {
            let picture_size = (size / share).max(16);
            let settings = LayeredEnvironmentMapSettings { picture_size, ..self.work.settings.clone() };
            let mut watch = Stopwatch::new();
            drop(self.infer(&settings, part, 0));
            (pixels(picture_size), watch.lap_ms() * 1e-3)
        });
        let slope = (large.1 - small.1) / (large.0 - small.0).max(1.0);
        let unit = large.1 + slope.max(0.0) * (pixels(size) - large.0);
        unit * catoptric_core::parallel::thread_count() as f64
    }
}

/// A unit of each face of layers.
fn of_faces(layers: &[Layer], unit: impl Fn(&Layer, u32) -> Vec<u8>) -> Vec<MadeUnit> {
    let faces = layers.iter().flat_map(|layer| (0..layer.texture.layout.faces()).map(move |face| (layer, face)));
    faces.map(|(layer, face)| MadeUnit { bytes: unit(layer, face), note: None }).collect()
}

impl UnitMaker for LayersMaker<'_> {
    fn make(&self, batch: Range<usize>) -> Result<Vec<MadeUnit>, RenderError> {
        let is_projected = self.work.settings.textures == Textures::Projected;
        Ok(match self.table.batch_at(batch.start) {
            None => Vec::new(),
            Some(LayersBatch::Shells) => vec![MadeUnit { bytes: self.work.shells(), note: None }],
            Some(LayersBatch::Surfaces { part }) if is_projected => {
                let layers = self.captured(&self.work.settings, part)?;
                of_faces(&layers, |layer, face| stored::surface_bytes(layer, face, true))
            }
            Some(LayersBatch::Surfaces { part }) => {
                of_faces(&self.projected(part)?, |layer, face| stored::surface_bytes(layer, face, false))
            }
            Some(LayersBatch::Textures { part, viewpoint }) => {
                let (layers, residuals) = self.infer(&self.work.settings, part, viewpoint)?;
                let mut units = of_faces(&layers, stored::texture_bytes);
                let residuals = residuals
                    .iter()
                    .map(|Residual { before, after, steps }| format!("{before:.4} to {after:.4} in {steps} steps"));
                if let Some(first) = units.first_mut() {
                    first.note = Some(format!("residuals {}", residuals.collect::<Vec<_>>().join(", ")));
                }
                units
            }
        })
    }

    fn estimate_core_secs(&self) -> f64 {
        let known = self.work.known();
        let of_part = |part: usize| {
            let viewpoints = match self.work.settings.textures {
                Textures::Projected => 0.0,
                Textures::Inferred => f64::from(known.viewpoint_count()) * self.viewpoint_core_secs(part),
            };
            self.capture_core_secs(part) + viewpoints
        };
        (0..known.part_count()).map(of_part).sum()
    }
}
