//! The table of a bake of layers: its units, and their sizes in bytes.
//!
//! The first unit has the shells. Then come the surfaces of every part: the depths of each layer and face, and its
//! texture if textures are projected. Inferred textures follow, for every part, viewpoint, layer and face.

use crate::layered_environment_map::settings::{LayeredEnvironmentMapSettings, Textures};
use crate::layered_environment_map::shell::Shell;
use crate::layered_environment_map::textures::depths::DEPTH_BYTES;
use crate::layered_environment_map::textures::texture::TEXEL_BYTES;
use catoptric_engine::method::bake::BakeUnit;
use std::ops::Range;

/// Bytes before the depths of a face: the base and the steps of their codes, and the distance of the nearest surface,
/// for the whole layer.
pub(super) const DEPTHS_HEAD_BYTES: usize = 12;

/// A batch: the units that are made at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LayersBatch {
    /// The shells of all layers.
    Shells,
    /// The surfaces that are seen from the centre, of every layer and face of a part.
    Surfaces {
        /// The number of the part.
        part: usize,
    },
    /// The inferred textures of every layer and face of a part.
    Textures {
        /// The number of the part.
        part: usize,
        /// The viewpoint that they are for.
        viewpoint: u32,
    },
}

/// The units of a bake.
#[derive(Clone, Debug)]
pub struct UnitTable {
    /// The number of faces of every layer of every part.
    faces: Vec<Vec<u32>>,
    /// The groups, which are the first parts; another one is the layer that they share.
    groups: usize,
    viewpoints: u32,
    shells_bytes: usize,
    /// Bytes of depths, of a texture, and of all that is seen from the centre, of a face each.
    depths_bytes: usize,
    texture_bytes: usize,
    surface_bytes: usize,
    has_textures: bool,
}

impl UnitTable {
    /// The table of parts with these shells, which take `shells_bytes`, and of so many viewpoints.
    pub fn new<'a>(
        settings: &LayeredEnvironmentMapSettings,
        parts: impl Iterator<Item = Vec<&'a Shell>>,
        groups: usize,
        viewpoints: u32,
        shells_bytes: usize,
    ) -> Self {
        let size = settings.size;
        let faces = |shells: Vec<&Shell>| shells.into_iter().map(|shell| shell.layout(size).faces()).collect();
        let texels = |side: u32| (side * side) as usize;
        let levels = std::iter::successors(Some(size), |side| (*side > 1).then_some(side / 2));
        let texture_bytes = levels.map(texels).sum::<usize>() * TEXEL_BYTES;
        let depths_bytes = if settings.depth { DEPTHS_HEAD_BYTES + texels(size) * DEPTH_BYTES } else { 0 };
        let is_projected = settings.textures == Textures::Projected;
        Self {
            faces: parts.map(faces).collect(),
            groups,
            viewpoints,
            shells_bytes,
            depths_bytes,
            texture_bytes,
            surface_bytes: depths_bytes + if is_projected { texture_bytes } else { 0 },
            has_textures: !is_projected,
        }
    }

    /// Bytes of a face's depths, before its texture in a unit of surfaces.
    pub(super) fn depths_bytes(&self) -> usize {
        self.depths_bytes
    }

    /// Viewpoints that textures are inferred for.
    pub(super) fn viewpoints(&self) -> u32 {
        self.viewpoints
    }

    fn face_count(&self, part: usize) -> usize {
        self.faces[part].iter().sum::<u32>() as usize
    }

    /// The batches in the order of their units.
    pub fn batches(&self) -> impl Iterator<Item = LayersBatch> + '_ {
        let parts = 0..self.faces.len();
        let surfaces = parts.clone().filter(|_| self.surface_bytes > 0).map(|part| LayersBatch::Surfaces { part });
        let viewpoints = if self.has_textures { 0..self.viewpoints } else { 0..0 };
        let textures =
            move |part: usize| viewpoints.clone().map(move |viewpoint| LayersBatch::Textures { part, viewpoint });
        std::iter::once(LayersBatch::Shells).chain(surfaces).chain(parts.flat_map(textures))
    }

    /// The number of units of a batch.
    fn unit_count_of(&self, batch: LayersBatch) -> usize {
        match batch {
            LayersBatch::Shells => 1,
            LayersBatch::Surfaces { part } | LayersBatch::Textures { part, .. } => self.face_count(part),
        }
    }

    /// The batch whose first unit has a number.
    pub fn batch_at(&self, first: usize) -> Option<LayersBatch> {
        let mut next = 0;
        let begins = |batch: &LayersBatch| {
            let start = next;
            next += self.unit_count_of(*batch);
            start == first
        };
        self.batches().find(begins)
    }

    /// The numbers of a batch's units: layer after layer, face after face. Empty if it has no such batch.
    pub fn units_of(&self, batch: LayersBatch) -> Range<usize> {
        let faces_before = |part: usize| (0..part).map(|part| self.face_count(part)).sum::<usize>();
        let all_faces = faces_before(self.faces.len());
        let surfaces = if self.surface_bytes > 0 { all_faces } else { 0 };
        let first = match batch {
            LayersBatch::Shells => 0,
            LayersBatch::Surfaces { part } if self.surface_bytes > 0 => 1 + faces_before(part),
            LayersBatch::Textures { part, viewpoint } if self.has_textures && viewpoint < self.viewpoints => {
                let viewpoints = self.viewpoints as usize * faces_before(part);
                1 + surfaces + viewpoints + viewpoint as usize * self.face_count(part)
            }
            LayersBatch::Surfaces { .. } | LayersBatch::Textures { .. } => return 0..0,
        };
        first..first + self.unit_count_of(batch)
    }

    /// The units, in order.
    pub fn units(&self) -> Vec<BakeUnit> {
        let mut units = Vec::new();
        for batch in self.batches() {
            let (part, what, bytes) = match batch {
                LayersBatch::Shells => {
                    let bytes = self.shells_bytes as u64;
                    units.push(BakeUnit { name: "shells".into(), bytes, at_most: false, with_previous: false });
                    continue;
                }
                LayersBatch::Surfaces { part } => (part, "center".to_owned(), self.surface_bytes),
                LayersBatch::Textures { part, viewpoint } => {
                    (part, format!("viewpoint {viewpoint}"), self.texture_bytes)
                }
            };
            let whose = if part < self.groups { format!("group {part}") } else { "all groups".into() };
            let first = units.len();
            for (layer, faces) in self.faces[part].iter().enumerate() {
                for face in 0..*faces {
                    let name = format!("{whose}, {what}, layer {layer}, face {face}");
                    let (bytes, with_previous) = (bytes as u64, units.len() > first);
                    units.push(BakeUnit { name, bytes, at_most: false, with_previous });
                }
            }
        }
        units
    }
}
