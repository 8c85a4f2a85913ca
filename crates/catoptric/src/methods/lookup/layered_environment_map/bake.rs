//! Inferred layers as work in units: those of a viewpoint each.

use super::INFO;
use super::inference::Inference;
use super::inference::least_squares::Residual;
use super::settings::{LayeredEnvironmentMapSettings, Textures};
use super::shells::layer_geometry::LayerGeometry;
use super::textures::maps::Layer;
use super::textures::texture::{LayerTexel, LayerTexture, TEXEL_BYTES};
use crate::clock::Stopwatch;
use crate::error::RenderError;
use crate::methods::bake::{BakeUnit, BakeWork, Baked, MadeUnit, UnitMaker};
use crate::methods::{Quality, Settings};
use crate::progress::Silent;
use crate::scene::Scene;

/// The layout of a unit's bytes: layer after layer its texels, each as four half floats, the lowest byte of each
/// first. Also how they are
/// inferred: it changes with what they hold.
const PAYLOAD_VERSION: u32 = 7;

/// How much smaller the pictures of an estimate are.
const ESTIMATE_SHARES: [u32; 2] = [6, 3];

/// The layers of all viewpoints of a scene.
pub(super) struct LayersWork<'a> {
    scene: &'a Scene,
    settings: LayeredEnvironmentMapSettings,
    known: LayerGeometry,
}

impl<'a> LayersWork<'a> {
    /// # Errors
    /// [`RenderError::Limit`] where there is nothing to be baked.
    pub(super) fn new(
        settings: &LayeredEnvironmentMapSettings,
        scene: &'a Scene,
        quality: Quality,
    ) -> Result<Self, RenderError> {
        let known = LayerGeometry::new(settings, scene, quality.order);
        let problem = match () {
            () if quality.order == 0 => "order 0 shows no reflection: there is nothing to bake",
            () if known.groups.is_empty() => "the scene has no reflector and no lens: there is nothing to bake",
            () => {
                // What is seen from the middle, and what is made.
                known.check_memory(settings, 2)?;
                return Ok(Self { scene, settings: settings.clone(), known });
            }
        };
        Err(RenderError::Limit { method: INFO.id, problem: problem.into() })
    }
}

/// The part that a unit is of, and its viewpoint.
fn part_and_viewpoint(known: &LayerGeometry, number: usize) -> Option<(usize, u32)> {
    let count = known.viewpoint_count();
    let part = number.checked_div(count as usize).filter(|part| *part < known.part_count())?;
    Some((part, (number % count as usize) as u32))
}

/// Bytes of a unit of a part.
fn unit_bytes(known: &LayerGeometry, part: usize, size: u32) -> usize {
    known.strata_of(part).iter().map(|stratum| stratum.shell.layout(size).texel_count() * TEXEL_BYTES).sum()
}

/// Checks that a bake has the units of a scene.
///
/// # Errors
/// [`RenderError::Limit`] where it is one of other groups or sizes.
pub(super) fn check(
    known: &LayerGeometry,
    settings: &LayeredEnvironmentMapSettings,
    baked: &dyn Baked,
) -> Result<(), RenderError> {
    let viewpoints = known.viewpoint_count() as usize;
    let (found, wanted) = (baked.unit_count(), known.part_count() * viewpoints);
    let is_whole = |number: usize| baked.unit(number).len() == unit_bytes(known, number / viewpoints, settings.size);
    let fits = found == wanted && (0..wanted).all(is_whole);
    let problem = format!("the baked file has {found} units where the scene needs {wanted}, or of another size");
    if fits { Ok(()) } else { Err(RenderError::Limit { method: INFO.id, problem }) }
}

/// The layers of a part and a viewpoint from a bake that was checked; `bare` are the same layers, whatever their
/// textures.
pub(super) fn baked_layers(
    known: &LayerGeometry,
    bare: &[Layer],
    baked: &dyn Baked,
    part: usize,
    viewpoint: u32,
) -> Vec<Layer> {
    let number = part * known.viewpoint_count() as usize + viewpoint as usize;
    let mut rest = baked.unit(number).as_chunks::<TEXEL_BYTES>().0;
    let layer = |bare: &Layer| {
        let layout = bare.texture.layout.clone();
        let texels;
        (texels, rest) = rest.split_at(layout.texel_count().min(rest.len()));
        let texture =
            LayerTexture { layout, texels: texels.iter().map(|bytes| LayerTexel::of_bytes(*bytes)).collect() };
        Layer { distances: bare.distances.clone(), texture, ..*bare }
    };
    bare.iter().map(layer).collect()
}

impl BakeWork for LayersWork<'_> {
    fn payload_version(&self) -> u32 {
        PAYLOAD_VERSION
    }

    fn settings(&self) -> toml::Table {
        let settings = LayeredEnvironmentMapSettings { textures: Textures::Inferred, ..self.settings.clone() };
        let mut table = settings.baked();
        table.insert("order".into(), i64::from(self.known.order).into());
        table
    }

    fn write_scene(&self, sink: &mut dyn FnMut(&[u8])) {
        self.scene.write_identity(|_| false, sink);
        // Cameras are no part of a scene's identity.
        self.known.groups.iter().for_each(|group| sink(format!("{:?}", group.viewspace).as_bytes()));
    }

    fn units(&self) -> Vec<BakeUnit> {
        let mut units = Vec::new();
        for part in 0..self.known.part_count() {
            let bytes = unit_bytes(&self.known, part, self.settings.size) as u64;
            let whose = match part < self.known.groups.len() {
                true => format!("group {part}"),
                false => "all groups".into(),
            };
            let unit = |viewpoint| BakeUnit { name: format!("{whose}, viewpoint {viewpoint}"), bytes };
            units.extend((0..self.known.viewpoint_count()).map(unit));
        }
        units
    }

    fn maker<'b>(&'b self) -> Result<Box<dyn UnitMaker + 'b>, RenderError> {
        let projected = self.known.projected(&self.settings, self.scene, &Silent)?;
        Ok(Box::new(LayersMaker { work: self, projected }))
    }
}

/// Makes the layers of viewpoints.
struct LayersMaker<'a> {
    work: &'a LayersWork<'a>,
    /// Layers of every part.
    projected: Vec<Vec<Layer>>,
}

impl LayersMaker<'_> {
    fn infer(
        &self,
        settings: &LayeredEnvironmentMapSettings,
        part: usize,
        viewpoint: u32,
    ) -> Result<(Vec<Layer>, Vec<Residual>), RenderError> {
        let LayersWork { scene, known, .. } = self.work;
        Inference { scene, settings, known }.infer(part, &self.projected[part], viewpoint, &Silent)
    }
}

impl UnitMaker for LayersMaker<'_> {
    fn make(&self, number: usize) -> Result<MadeUnit, RenderError> {
        let Some((part, viewpoint)) = part_and_viewpoint(&self.work.known, number) else {
            return Ok(MadeUnit::default());
        };
        let (layers, residuals) = self.infer(&self.work.settings, part, viewpoint)?;
        let bytes = layers.iter().flat_map(|layer| &layer.texture.texels).flat_map(|texel| texel.to_bytes()).collect();
        let residuals = residuals
            .iter()
            .map(|Residual { before, after, steps }| format!("{before:.4} to {after:.4} in {steps} steps"));
        let note = format!("residuals {}", residuals.collect::<Vec<_>>().join(", "));
        Ok(MadeUnit { bytes, note: Some(note) })
    }

    fn estimate_core_secs(&self) -> f64 {
        let size = self.work.settings.picture_size;
        let pixels = |size: u32| f64::from(size * size);
        let of_part = |part: usize| {
            // A part is for pixels, and a part is not.
            let [small, large] = ESTIMATE_SHARES.map(|share| {
                let picture_size = (size / share).max(16);
                let settings = LayeredEnvironmentMapSettings { picture_size, ..self.work.settings.clone() };
                let mut watch = Stopwatch::new();
                // An error will come up again when units are made.
                drop(self.infer(&settings, part, 0));
                (pixels(picture_size), watch.lap_ms() * 1e-3)
            });
            let slope = (large.1 - small.1) / (large.0 - small.0).max(1.0);
            let unit = large.1 + slope.max(0.0) * (pixels(size) - large.0);
            let cores = crate::parallel::thread_count() as f64;
            unit * cores * f64::from(self.work.known.viewpoint_count())
        };
        (0..self.work.known.part_count()).map(of_part).sum()
    }
}
