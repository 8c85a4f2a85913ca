//! Inferred layers as work in units: those of a viewpoint each.

use super::INFO;
use super::infer::Inference;
use super::known::Known;
use super::maps::{Layer, LayeredMap};
use super::settings::{LayeredEnvironmentMapSettings, Textures};
use super::texels::Texture;
use crate::clock::Stopwatch;
use crate::error::RenderError;
use crate::methods::Quality;
use crate::methods::bake::{BakeUnit, BakeWork, Baked, UnitMaker};
use crate::progress::Silent;
use crate::scene::Scene;
use block_compression::half::f16;
use glam::Vec4;

/// The layout of a unit's bytes: layer after layer its texels, each as four half floats, the lowest byte of each first. Also how they are
/// inferred: it changes with what they hold.
const PAYLOAD_VERSION: u32 = 3;

/// Bytes of a texel.
const TEXEL_BYTES: usize = 8;

/// How much smaller the pictures of an estimate are.
const ESTIMATE_SHARES: [u32; 2] = [6, 3];

/// The layers of all viewpoints of a scene.
pub(super) struct LayersWork<'a> {
    scene: &'a Scene,
    settings: LayeredEnvironmentMapSettings,
    known: Known,
}

impl<'a> LayersWork<'a> {
    /// # Errors
    /// [`RenderError::Limit`] where there is nothing to be baked.
    pub(super) fn new(
        settings: &LayeredEnvironmentMapSettings,
        scene: &'a Scene,
        quality: Quality,
    ) -> Result<Self, RenderError> {
        let known = Known::new(settings, scene, quality.order);
        let problem = match () {
            () if quality.order == 0 => "order 0 shows no reflection: there is nothing to bake",
            () if known.groups.is_empty() => "the scene has no reflector and no lens: there is nothing to bake",
            () => {
                // What is seen from the middle, and what is made.
                known.check_memory(settings.size, 2)?;
                return Ok(Self { scene, settings: settings.clone(), known });
            }
        };
        Err(RenderError::Limit { method: INFO.id, problem: problem.into() })
    }
}

/// The number of a unit's group, and that of its viewpoint.
fn group_and_viewpoint(known: &Known, number: usize) -> Option<(usize, u32)> {
    let mut rest = number;
    for (index, group) in known.groups.iter().enumerate() {
        let count = group.viewspace.len() as usize;
        if rest < count {
            return Some((index, rest as u32));
        }
        rest -= count;
    }
    None
}

/// The number of the unit of a group's viewpoint.
fn unit_of(known: &Known, group: usize, viewpoint: u32) -> usize {
    known.groups[..group].iter().map(|group| group.viewspace.len() as usize).sum::<usize>() + viewpoint as usize
}

/// Bytes of a unit of a group.
fn unit_bytes(known: &Known, group: usize, size: u32) -> usize {
    known.groups[group].strata.iter().map(|stratum| stratum.shell.layout(size).texel_count() * TEXEL_BYTES).sum()
}

/// Whether a bake has the units of a scene.
///
/// # Errors
/// [`RenderError::Limit`] where it is one of other groups or sizes.
pub(super) fn check(
    known: &Known,
    settings: &LayeredEnvironmentMapSettings,
    baked: &dyn Baked,
) -> Result<(), RenderError> {
    let mut bytes = Vec::new();
    for (group, layers) in known.groups.iter().enumerate() {
        bytes.resize(bytes.len() + layers.viewspace.len() as usize, unit_bytes(known, group, settings.size));
    }
    let fits = baked.unit_count() == bytes.len()
        && bytes.iter().enumerate().all(|(number, bytes)| baked.unit(number).len() == *bytes);
    let (found, wanted) = (baked.unit_count(), bytes.len());
    let problem = format!("the baked file has {found} units where the scene needs {wanted}, or of another size");
    if fits { Ok(()) } else { Err(RenderError::Limit { method: INFO.id, problem }) }
}

/// The layers of a viewpoint from a bake that was checked; `bare` are those of the group, whatever their textures.
pub(super) fn baked_map(
    known: &Known,
    bare: &LayeredMap,
    baked: &dyn Baked,
    group: usize,
    viewpoint: u32,
) -> LayeredMap {
    let mut rest = baked.unit(unit_of(known, group, viewpoint)).as_chunks::<TEXEL_BYTES>().0;
    let layer = |bare: &Layer| {
        let layout = bare.texture.layout.clone();
        let texels;
        (texels, rest) = rest.split_at(layout.texel_count().min(rest.len()));
        let texels = texels.iter().map(|bytes| {
            let half = |k: usize| f16::from_le_bytes([bytes[2 * k], bytes[2 * k + 1]]).to_f32();
            Vec4::new(half(0), half(1), half(2), half(3))
        });
        let texture = Texture { layout, texels: texels.collect() };
        Layer { shell: bare.shell, distances: bare.distances.clone(), texture }
    };
    LayeredMap { center: bare.center, layers: bare.layers.iter().map(layer).collect() }
}

/// What inference gives is kept with no more digits than a bake has: both draw the same.
pub(super) fn rounded(mut map: LayeredMap) -> LayeredMap {
    for texel in map.layers.iter_mut().flat_map(|layer| &mut layer.texture.texels) {
        *texel = Vec4::from(texel.to_array().map(|value| half(value).to_f32()));
    }
    map
}

/// The nearest half float; what is too large becomes the largest.
fn half(value: f32) -> f16 {
    f16::from_f32(value.clamp(f16::MIN.to_f32(), f16::MAX.to_f32()))
}

impl BakeWork for LayersWork<'_> {
    fn payload_version(&self) -> u32 {
        PAYLOAD_VERSION
    }

    fn settings(&self) -> toml::Table {
        let settings = LayeredEnvironmentMapSettings { textures: Textures::Inferred, ..self.settings.clone() };
        let mut table = toml::Table::try_from(settings).unwrap_or_default();
        // How it is looked up is no part of it.
        for name in ["transfer", "edges", "tau", "angle_deg", "count_tests"] {
            table.remove(name);
        }
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
        for (number, group) in self.known.groups.iter().enumerate() {
            let bytes = unit_bytes(&self.known, number, self.settings.size) as u64;
            let unit = |viewpoint| BakeUnit { name: format!("group {number}, viewpoint {viewpoint}"), bytes };
            units.extend((0..group.viewspace.len()).map(unit));
        }
        units
    }

    fn maker<'b>(&'b self) -> Result<Box<dyn UnitMaker + 'b>, RenderError> {
        let projected = self.known.projected(&self.settings, self.scene, &Silent);
        Ok(Box::new(LayersMaker { work: self, projected }))
    }
}

/// Makes the layers of viewpoints.
struct LayersMaker<'a> {
    work: &'a LayersWork<'a>,
    /// Of every group.
    projected: Vec<LayeredMap>,
}

impl LayersMaker<'_> {
    fn infer(
        &self,
        settings: &LayeredEnvironmentMapSettings,
        group: usize,
        viewpoint: u32,
    ) -> Result<LayeredMap, RenderError> {
        let LayersWork { scene, known, .. } = self.work;
        let inference = Inference { scene, settings, known };
        let (map, _) = inference.infer(group, &self.projected[group], viewpoint, &Silent)?;
        Ok(map)
    }
}

impl UnitMaker for LayersMaker<'_> {
    fn make(&self, number: usize) -> Result<Vec<u8>, RenderError> {
        let Some((group, viewpoint)) = group_and_viewpoint(&self.work.known, number) else { return Ok(Vec::new()) };
        let map = self.infer(&self.work.settings, group, viewpoint)?;
        let texels = map.layers.iter().flat_map(|layer| &layer.texture.texels);
        Ok(texels.flat_map(|texel| texel.to_array()).flat_map(|value| half(value).to_le_bytes()).collect())
    }

    fn estimate_core_secs(&self) -> f64 {
        let size = self.work.settings.picture_size;
        let pixels = |size: u32| f64::from(size * size);
        let of_group = |group: usize| {
            // A part is for pixels, and a part is not.
            let [small, large] = ESTIMATE_SHARES.map(|share| {
                let picture_size = (size / share).max(16);
                let settings = LayeredEnvironmentMapSettings { picture_size, ..self.work.settings.clone() };
                let mut watch = Stopwatch::new();
                // An error will come up again when units are made.
                drop(self.infer(&settings, group, 0));
                (pixels(picture_size), watch.lap_ms() * 1e-3)
            });
            let slope = (large.1 - small.1) / (large.0 - small.0).max(1.0);
            let unit = large.1 + slope.max(0.0) * (pixels(size) - large.0);
            let cores = crate::parallel::thread_count() as f64;
            unit * cores * f64::from(self.work.known.groups[group].viewspace.len())
        };
        (0..self.work.known.groups.len()).map(of_group).sum()
    }
}
