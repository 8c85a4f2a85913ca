//! Layers as bytes, and layers from the bytes of a bake: all that drawing needs but the group of reflectors and lenses.

use super::table::{DEPTHS_HEAD_BYTES, LayersBatch, UnitTable};
use crate::layered_environment_map::settings::{LayeredEnvironmentMapSettings, Textures};
use crate::layered_environment_map::shell::{Quad, Shell};
use crate::layered_environment_map::shells::layer_geometry::{LayerGeometry, PartShells};
use crate::layered_environment_map::texels::TexelLayout;
use crate::layered_environment_map::textures::depths::Depths;
use crate::layered_environment_map::textures::distances::Distances;
use crate::layered_environment_map::textures::maps::Layer;
use crate::layered_environment_map::textures::texture::{LayerTexel, LayerTexture, TEXEL_BYTES};
use catoptric_core::math::Aabb;
use catoptric_core::scene::Scene;
use catoptric_engine::error::RenderError;
use catoptric_engine::light::parallax_proxy::ParallaxProxy;
use catoptric_engine::method::Settings;
use catoptric_engine::method::bake::Baked;
use glam::Vec3;
use std::sync::Arc;

/// Numbers of a shell, of any kind.
const SHELL_NUMBERS: usize = 12;

/// Words before the parts, of a part before its shells, and of a shell: its kind and its numbers.
const HEAD_WORDS: usize = 3;
const PART_WORDS: usize = 4;
const SHELL_WORDS: usize = 1 + SHELL_NUMBERS;

fn shell_words(shell: &Shell) -> [u32; SHELL_WORDS] {
    let mut words = [0; SHELL_WORDS];
    let [kind, numbers @ ..] = &mut words;
    let mut set = |number: u32, values: &[f32]| {
        *kind = number;
        numbers.iter_mut().zip(values).for_each(|(word, value)| *word = value.to_bits());
    };
    match *shell {
        Shell::Around(ParallaxProxy::Infinite) => set(0, &[]),
        Shell::Around(ParallaxProxy::Box(Aabb { min, max })) => set(1, &[min.x, min.y, min.z, max.x, max.y, max.z]),
        Shell::Around(ParallaxProxy::Sphere(radius)) => set(2, &[radius]),
        Shell::Around(ParallaxProxy::Cylinder { radius, bottom, top }) => set(3, &[radius, bottom, top]),
        Shell::Quad(Quad { middle, normal, right, up }) => {
            let all = [middle, normal, right, up].map(|vector| vector.to_array());
            set(4, all.as_flattened());
        }
    }
    words
}

/// `None` for words that are no shell.
fn shell_of(words: &[u32; SHELL_WORDS]) -> Option<Shell> {
    let [kind, numbers @ ..] = words;
    let numbers = numbers.map(f32::from_bits);
    if !numbers.iter().all(|number| number.is_finite()) {
        return None;
    }
    let vector = |at: usize| Vec3::new(numbers[at], numbers[at + 1], numbers[at + 2]);
    Some(match kind {
        0 => Shell::Around(ParallaxProxy::Infinite),
        1 => Shell::Around(ParallaxProxy::Box(Aabb { min: vector(0), max: vector(3) })),
        2 => Shell::Around(ParallaxProxy::Sphere(numbers[0])),
        3 => Shell::Around(ParallaxProxy::Cylinder { radius: numbers[0], bottom: numbers[1], top: numbers[2] }),
        4 => Shell::Quad(Quad { middle: vector(0), normal: vector(3), right: vector(6), up: vector(9) }),
        _ => return None,
    })
}

/// The shells of all parts as bytes: how many groups, parts and viewpoints there are, then every part.
pub fn shells_to_bytes(groups: usize, viewpoints: u32, parts: &[PartShells]) -> Vec<u8> {
    let mut words = vec![groups as u32, parts.len() as u32, viewpoints];
    for PartShells { center, shells } in parts {
        words.extend(center.to_array().map(f32::to_bits));
        words.push(shells.len() as u32);
        words.extend(shells.iter().flat_map(shell_words));
    }
    words.into_iter().flat_map(u32::to_le_bytes).collect()
}

/// Groups, viewpoints and parts of [`shells_to_bytes`]; `None` for other bytes.
pub fn shells_of_bytes(bytes: &[u8]) -> Option<(usize, u32, Vec<PartShells>)> {
    let (words, []) = bytes.as_chunks::<4>() else { return None };
    let words: Vec<u32> = words.iter().map(|word| u32::from_le_bytes(*word)).collect();
    let ([groups, count, viewpoints], mut rest) = words.split_first_chunk::<HEAD_WORDS>()?;
    let mut parts = Vec::new();
    for _ in 0..*count {
        let ([center @ .., shells], after) = rest.split_first_chunk::<PART_WORDS>()?;
        let (own, after) = after.split_at_checked((*shells as usize).checked_mul(SHELL_WORDS)?)?;
        let center = Vec3::from_array(center.map(f32::from_bits));
        let shells = own.as_chunks::<SHELL_WORDS>().0.iter().map(shell_of).collect::<Option<_>>()?;
        parts.push(PartShells { center: Some(center).filter(|center| center.is_finite())?, shells });
        rest = after;
    }
    let groups = Some(*groups as usize).filter(|groups| (parts.len().saturating_sub(1)..=parts.len()).contains(groups));
    rest.is_empty().then_some((groups?, *viewpoints, parts))
}

/// The texels of a face, level after level from the finest.
pub fn face_texels(layout: &TexelLayout, texels: &[LayerTexel], face: u32) -> impl Iterator<Item = LayerTexel> {
    layout.levels_of(face).flat_map(|level| texels[level].iter().copied())
}

/// The unit of a face of a layer as it is seen from the centre: its depths, if it has any, and its texture, if that is
/// kept.
pub(super) fn surface_bytes(layer: &Layer, face: u32, with_texture: bool) -> Vec<u8> {
    let mut bytes = Vec::new();
    if let Some(distances) = &layer.distances {
        let (depths, nearest) = distances.depths_and_nearest();
        let (words, base, shift) = depths.parts();
        let size = layer.texture.layout.size();
        let own = words.chunks_exact((size * size) as usize).nth(face as usize).unwrap_or_default();
        bytes.extend([base, shift, nearest.to_bits()].iter().chain(own).flat_map(|word| word.to_le_bytes()));
    }
    if with_texture {
        bytes.extend(texture_bytes(layer, face));
    }
    bytes
}

/// The unit of a face of a layer's texture.
pub(super) fn texture_bytes(layer: &Layer, face: u32) -> Vec<u8> {
    face_texels(&layer.texture.layout, &layer.texture.texels, face).flat_map(LayerTexel::to_bytes).collect()
}

/// The layers of a bake.
pub(crate) struct BakedLayers {
    units: Arc<dyn Baked>,
    table: UnitTable,
    groups: usize,
    parts: Vec<PartShells>,
}

impl BakedLayers {
    /// Opens a bake by its shells, and checks that it has the units that belong to them.
    ///
    /// # Errors
    /// [`RenderError::Limit`] where it has not.
    pub(crate) fn open(settings: &LayeredEnvironmentMapSettings, units: &Arc<dyn Baked>) -> Result<Self, RenderError> {
        let shells = units.unit(0);
        let (groups, viewpoints, parts) =
            shells_of_bytes(shells).ok_or_else(|| unfit("the first of the baked file's units has no shells"))?;
        let of_parts = parts.iter().map(|part| part.shells.iter().collect());
        let table = UnitTable::new(settings, of_parts, groups, viewpoints, shells.len());
        let wanted = table.units();
        let is_whole = |(number, unit): (usize, _)| {
            let unit: &catoptric_engine::method::bake::BakeUnit = unit;
            units.unit(number).len() as u64 == unit.bytes
        };
        if units.unit_count() != wanted.len() || !wanted.iter().enumerate().all(is_whole) {
            let (found, wanted) = (units.unit_count(), wanted.len());
            return Err(unfit(&format!(
                "the baked file has {found} units where its layers need {wanted}, or of another size"
            )));
        }
        Ok(Self { units: units.clone(), table, groups, parts })
    }

    /// The units of the bake.
    pub(crate) fn units(&self) -> Arc<dyn Baked> {
        self.units.clone()
    }

    /// The bake's shells about a scene's groups. Nothing but these groups can be met by rays.
    ///
    /// # Errors
    /// [`RenderError::Limit`] where it is about other groups or viewpoints.
    pub(crate) fn geometry(
        &self,
        settings: &LayeredEnvironmentMapSettings,
        scene: &Scene,
        order: u32,
    ) -> Result<LayerGeometry, RenderError> {
        let known = LayerGeometry::of_shells(settings, scene, order, (&self.parts, self.groups));
        self.check(&known)?;
        Ok(known)
    }

    /// Layers of every part, with the surfaces seen from their centres.
    ///
    /// # Errors
    /// [`RenderError::Limit`] for bytes that are no depths.
    pub(crate) fn layers(&self, settings: &LayeredEnvironmentMapSettings) -> Result<Vec<Vec<Layer>>, RenderError> {
        let of_part = |(part, PartShells { center, shells }): (usize, &PartShells)| {
            let mut numbers = self.table.units_of(LayersBatch::Surfaces { part });
            let layer = |shell: &Shell| {
                let layout = shell.layout(settings.size);
                let faces: Vec<&[u8]> =
                    numbers.by_ref().take(layout.faces() as usize).map(|number| self.units.unit(number)).collect();
                let distances = if settings.depth { Some(self.distances(&layout, &faces)?) } else { None };
                let texels = match settings.textures {
                    Textures::Projected => {
                        let behind = self.table.depths_bytes();
                        texels_of(&layout, faces.iter().map(|face| face.get(behind..).unwrap_or_default()))
                    }
                    Textures::Inferred => Vec::new(),
                };
                let texture = LayerTexture { layout, texels };
                Ok(Layer { center: *center, shell: *shell, distances, texture })
            };
            shells.iter().map(layer).collect::<Result<Vec<Layer>, RenderError>>()
        };
        self.parts.iter().enumerate().map(of_part).collect()
    }

    fn distances(&self, layout: &TexelLayout, faces: &[&[u8]]) -> Result<Distances, RenderError> {
        let wrong = || unfit("what the baked file's units have is no depths");
        let (mut words, mut heads) = (Vec::with_capacity(layout.finest_count()), Vec::new());
        for face in faces {
            let bytes = face.get(..self.table.depths_bytes()).unwrap_or_default();
            let (head, codes) = bytes.split_first_chunk::<DEPTHS_HEAD_BYTES>().ok_or_else(wrong)?;
            heads.push(head);
            words.extend(codes.as_chunks::<4>().0.iter().map(|word| u32::from_le_bytes(*word)));
        }
        let head = heads.first().filter(|first| heads.iter().all(|head| head == *first)).ok_or_else(wrong)?;
        let number = |at: usize| u32::from_le_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]);
        let (base, shift, nearest) = (number(0), number(4), f32::from_bits(number(8)));
        let depths = Depths::of_parts(words, base, shift).filter(|_| nearest >= 0.0).ok_or_else(wrong)?;
        Ok(Distances::of_parts(layout.clone(), depths, nearest))
    }

    /// The layers of a part for a viewpoint; `bare` are the same layers, whatever their textures.
    pub(crate) fn of_viewpoint(&self, bare: &[Layer], part: usize, viewpoint: u32) -> Vec<Layer> {
        let mut numbers = self.table.units_of(LayersBatch::Textures { part, viewpoint });
        let layer = |bare: &Layer| {
            let layout = bare.texture.layout.clone();
            let faces = numbers.by_ref().take(layout.faces() as usize).map(|number| self.units.unit(number));
            let texels = texels_of(&layout, faces);
            Layer { distances: bare.distances.clone(), texture: LayerTexture { layout, texels }, ..*bare }
        };
        bare.iter().map(layer).collect()
    }

    /// Checks that it is about a scene's groups and viewpoints.
    ///
    /// # Errors
    /// [`RenderError::Limit`] where it is not.
    fn check(&self, known: &LayerGeometry) -> Result<(), RenderError> {
        let (found, needed) = (self.groups, known.groups.len());
        let viewpoints = self.table.viewpoints();
        match found == needed && viewpoints == known.viewpoint_count() {
            true => Ok(()),
            false => Err(unfit(&format!(
                "the baked file has units of {found} groups and {viewpoints} viewpoints where the scene has {needed} \
                 and {}",
                known.viewpoint_count()
            ))),
        }
    }
}

fn unfit(problem: &str) -> RenderError {
    RenderError::Limit { method: LayeredEnvironmentMapSettings::METHOD, problem: format!("{problem}; bake again") }
}

/// A texture's texels of those of its faces.
pub fn texels_of<'a>(layout: &TexelLayout, faces: impl Iterator<Item = &'a [u8]>) -> Vec<LayerTexel> {
    let mut texels = vec![LayerTexel::default(); layout.texel_count()];
    for (face, bytes) in faces.enumerate() {
        let mut stored = bytes.as_chunks::<TEXEL_BYTES>().0.iter();
        for level in layout.levels_of(face as u32) {
            texels[level].iter_mut().zip(&mut stored).for_each(|(texel, bytes)| *texel = LayerTexel::of_bytes(*bytes));
        }
    }
    texels
}
