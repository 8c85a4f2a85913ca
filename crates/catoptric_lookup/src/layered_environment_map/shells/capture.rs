//! Layers as they are seen from the middle of their shells: textures that are projected, not inferred, and their
//! depths.

use super::distant_geometry::LayerSpecs;
use super::layers::LayerSpec;
use crate::layered_environment_map::settings::LayeredEnvironmentMapSettings;
use crate::layered_environment_map::shell::Shell;
use crate::layered_environment_map::texels::TexelLayout;
use crate::layered_environment_map::textures::depths::Depth;
use crate::layered_environment_map::textures::distances::Distances;
use crate::layered_environment_map::textures::maps::Layer;
use crate::layered_environment_map::textures::texture::LayerTexture;
use catoptric_core::parallel;
use catoptric_core::progress::{Cancelled, Progress, Stage};
use catoptric_core::scene::{Ray, RayDifferential};
use glam::{Vec2, Vec3, Vec4};

/// A layer's texels of the finest level.
struct CaptureTarget<'a> {
    shell: &'a Shell,
    layout: &'a TexelLayout,
    size: u32,
}

impl CaptureTarget<'_> {
    /// The direction from the centre to a place of a face, in texels.
    fn direction(&self, face: u32, texels: Vec2) -> Vec3 {
        let place = self.layout.place_of(face, texels * (2.0 / self.size as f32) - 1.0);
        self.shell.towards(place).normalize()
    }
}

/// Layers without textures: shells, with depths if `settings` ask for them.
fn bare_layers(
    settings: &LayeredEnvironmentMapSettings,
    apart: &LayerSpecs<'_>,
    strata: &[LayerSpec],
    progress: &dyn Progress,
) -> Result<Vec<Layer>, Cancelled> {
    let depths = if settings.depth { Some(depths(apart, strata, settings.size, progress)?) } else { None };
    let mut depths = depths.map(Vec::into_iter);
    let layer = |stratum: &LayerSpec| {
        let layout = stratum.shell.layout(settings.size);
        let depths = depths.as_mut().and_then(Iterator::next);
        let distances = depths.map(|depths| Distances::new(&stratum.shell, layout.clone(), &depths));
        let texture = LayerTexture { layout, texels: Vec::new() };
        Layer { center: apart.around.center, shell: stratum.shell, distances, texture }
    };
    Ok(strata.iter().map(layer).collect())
}

/// Layers with the textures that are seen from the middle of the shells.
pub(crate) fn projected_layers(
    settings: &LayeredEnvironmentMapSettings,
    apart: &LayerSpecs<'_>,
    strata: &[LayerSpec],
    progress: &dyn Progress,
) -> Result<Vec<Layer>, Cancelled> {
    let mut layers = bare_layers(settings, apart, strata, progress)?;
    let textures = textures(apart, strata, settings.size, settings.capture_samples, progress)?;
    layers.iter_mut().zip(textures).for_each(|(layer, texture)| layer.texture = texture);
    Ok(layers)
}

/// The groups of layers that are seen by the same rays: all that are looked up by directions, and each of the others
/// alone.
fn seen_together(strata: &[LayerSpec]) -> Vec<Vec<usize>> {
    let is_around = |number: &usize| matches!(strata[*number].shell, Shell::Around(_));
    let (around, alone): (Vec<usize>, Vec<usize>) = (0..strata.len()).partition(is_around);
    let around = (!around.is_empty()).then_some(around);
    around.into_iter().chain(alone.into_iter().map(|number| vec![number])).collect()
}

/// The number of rows that [`of_texels`] works out.
fn row_count(strata: &[LayerSpec], size: u32) -> usize {
    let faces = |together: &Vec<usize>| strata[together[0]].shell.layout(size).faces();
    seen_together(strata).iter().map(|together| (faces(together) * size) as usize).sum()
}

/// Values of every texel of every layer's finest level. `fill` is told the texel (face, column, row) and, as bits, the
/// layers whose values it is to set, of which there are as many as layers.
fn of_texels<T: Copy + Send + Sync>(
    strata: &[LayerSpec],
    size: u32,
    blank: T,
    stage: &Stage<'_>,
    fill: impl Fn(&CaptureTarget<'_>, [u32; 3], u32, &mut [T]) + Sync,
) -> Result<Vec<Vec<T>>, Cancelled> {
    let mut found = vec![Vec::new(); strata.len()];
    for together in seen_together(strata) {
        let shell = &strata[together[0]].shell;
        let layout = shell.layout(size);
        let target = CaptureTarget { shell, layout: &layout, size };
        let wanted = together.iter().fold(0u32, |bits, number| bits | 1 << number);
        let row = |row: usize| {
            let mut values = vec![blank; strata.len() * size as usize];
            for (x, values) in values.chunks_exact_mut(strata.len()).enumerate() {
                fill(&target, [row as u32 / size, x as u32, row as u32 % size], wanted, values);
            }
            stage.advance(1).map(|()| values)
        };
        let rows = parallel::map_collect((layout.faces() * size) as usize, row);
        let rows = rows.into_iter().collect::<Result<Vec<_>, _>>()?;
        for number in together {
            let own = rows.iter().flat_map(|row| row.iter().skip(number).step_by(strata.len()).copied());
            found[number] = own.collect();
        }
    }
    Ok(found)
}

/// The textures of layers, seen from the centre with a square number of rays a texel.
fn textures(
    apart: &LayerSpecs<'_>,
    strata: &[LayerSpec],
    size: u32,
    samples: u32,
    progress: &dyn Progress,
) -> Result<Vec<LayerTexture>, Cancelled> {
    let stage = Stage::begin(progress, "capturing layers", row_count(strata, size))?;
    let center = apart.around.center;
    let count = samples.isqrt();
    let step = 1.0 / count as f32;
    let fill = |target: &CaptureTarget<'_>, [face, x, y]: [u32; 3], wanted: u32, seen: &mut [Vec4]| {
        for sample in 0..count * count {
            let within = Vec2::new((sample % count) as f32, (sample / count) as f32) + 0.5;
            let at = Vec2::new(x as f32, y as f32) + within * step;
            let direction = target.direction(face, at);
            let turned = |by: Vec2| target.direction(face, at + by * step) - direction;
            let (direction_dx, direction_dy) = (turned(Vec2::X), turned(Vec2::Y));
            let change = RayDifferential { direction_dx, direction_dy, ..RayDifferential::default() };
            apart.add_seen(&Ray { origin: center, direction }, Some(&change), wanted, seen);
        }
        seen.iter_mut().for_each(|seen| *seen /= (count * count) as f32);
    };
    let texels = of_texels(strata, size, Vec4::ZERO, &stage, fill)?;
    let texture = |(stratum, mut texels): (&LayerSpec, Vec<Vec4>)| {
        let layout = stratum.shell.layout(size);
        texels.resize(layout.texel_count(), Vec4::ZERO);
        layout.fill_coarser(&mut texels);
        LayerTexture::new(layout, &texels)
    };
    Ok(strata.iter().zip(texels).map(texture).collect())
}

/// The depths of layers in the middles of their texels: the begin and the end of the surface there.
fn depths(
    apart: &LayerSpecs<'_>,
    strata: &[LayerSpec],
    size: u32,
    progress: &dyn Progress,
) -> Result<Vec<Vec<Depth>>, Cancelled> {
    let stage = Stage::begin(progress, "measuring layers", row_count(strata, size))?;
    let center = apart.around.center;
    let fill = |target: &CaptureTarget<'_>, [face, x, y]: [u32; 3], wanted: u32, depths: &mut [Depth]| {
        let direction = target.direction(face, Vec2::new(x as f32, y as f32) + 0.5);
        apart.each_depth(&Ray { origin: center, direction }, wanted, |number, [front, back]| {
            let distance = strata[number].shell.distance(Vec3::ZERO, direction);
            let depth = Depth { front: front / distance, back: back / distance };
            depths[number] = if depth.front > 0.0 { depth } else { Depth::NOTHING };
        });
    };
    of_texels(strata, size, Depth::NOTHING, &stage, fill)
}
