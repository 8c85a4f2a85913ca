//! Layers as they are seen from the middle of their shells: textures that are projected, not inferred, and how far away what they show is.

use super::depths::Depth;
use super::distances::Distances;
use super::layers::Stratum;
use super::maps::Layer;
use super::settings::LayeredEnvironmentMapSettings;
use super::shell::Shell;
use super::surroundings::Strata;
use super::texels::Layout;
use super::texture::Texture;
use crate::parallel;
use crate::progress::Progress;
use crate::scene::{Ray, RayDifferential};
use glam::{Vec2, Vec3, Vec4};

/// A layer's texels of the finest level.
struct Target<'a> {
    shell: &'a Shell,
    layout: &'a Layout,
    size: u32,
}

impl Target<'_> {
    /// The direction from the centre to a place of a face, in texels.
    fn direction(&self, face: u32, texels: Vec2) -> Vec3 {
        let place = self.layout.place_of(face, texels * (2.0 / self.size as f32) - 1.0);
        self.shell.towards(place).normalize()
    }
}

/// Layers without textures; none of them knows more of what it shows than its shell where `settings` say so.
pub(super) fn bare_layers(
    settings: &LayeredEnvironmentMapSettings,
    apart: &Strata<'_>,
    strata: &[Stratum],
    progress: &dyn Progress,
) -> Vec<Layer> {
    let mut depths = settings.depth.then(|| depths(apart, strata, settings.size, progress).into_iter());
    let layer = |stratum: &Stratum| {
        let layout = stratum.shell.layout(settings.size);
        let depths = depths.as_mut().and_then(Iterator::next);
        let distances = depths.map(|depths| Distances::new(&stratum.shell, layout.clone(), &depths));
        let texture = Texture { layout, texels: Vec::new() };
        Layer { center: apart.around.center, shell: stratum.shell, distances, texture }
    };
    strata.iter().map(layer).collect()
}

/// Layers with the textures that are seen from the middle of the shells.
pub(super) fn projected_layers(
    settings: &LayeredEnvironmentMapSettings,
    apart: &Strata<'_>,
    strata: &[Stratum],
    progress: &dyn Progress,
) -> Vec<Layer> {
    let mut layers = bare_layers(settings, apart, strata, progress);
    let textures = textures(apart, strata, settings.size, settings.capture_samples, progress);
    layers.iter_mut().zip(textures).for_each(|(layer, texture)| layer.texture = texture);
    layers
}

/// Which layers are seen by the same rays: all that are looked up by directions, and each of the others alone.
fn seen_together(strata: &[Stratum]) -> Vec<Vec<usize>> {
    let is_around = |number: &usize| matches!(strata[*number].shell, Shell::Around(_));
    let (around, alone): (Vec<usize>, Vec<usize>) = (0..strata.len()).partition(is_around);
    let around = (!around.is_empty()).then_some(around);
    around.into_iter().chain(alone.into_iter().map(|number| vec![number])).collect()
}

/// How many rows [`of_texels`] works out.
fn row_count(strata: &[Stratum], size: u32) -> u64 {
    let faces = |together: &Vec<usize>| strata[together[0]].shell.layout(size).faces();
    seen_together(strata).iter().map(|together| u64::from(faces(together) * size)).sum()
}

/// Something of every texel of every layer's finest level. `fill` is told the texel (face, column, row) and, as bits, the layers whose
/// values it is to set, of which there are as many as layers.
fn of_texels<T: Copy + Send + Sync>(
    strata: &[Stratum],
    size: u32,
    blank: T,
    progress: &dyn Progress,
    fill: impl Fn(&Target<'_>, [u32; 3], u32, &mut [T]) + Sync,
) -> Vec<Vec<T>> {
    let mut found = vec![Vec::new(); strata.len()];
    for together in seen_together(strata) {
        let shell = &strata[together[0]].shell;
        let layout = shell.layout(size);
        let target = Target { shell, layout: &layout, size };
        let wanted = together.iter().fold(0u32, |bits, number| bits | 1 << number);
        let row = |row: usize| {
            let mut values = vec![blank; strata.len() * size as usize];
            for (x, values) in values.chunks_exact_mut(strata.len()).enumerate() {
                fill(&target, [row as u32 / size, x as u32, row as u32 % size], wanted, values);
            }
            progress.advance(1);
            values
        };
        let rows = parallel::map_collect((layout.faces() * size) as usize, row);
        for number in together {
            let own = rows.iter().flat_map(|row| row.iter().skip(number).step_by(strata.len()).copied());
            found[number] = own.collect();
        }
    }
    found
}

/// The textures of layers, seen from the centre with a square number of rays a texel.
fn textures(apart: &Strata<'_>, strata: &[Stratum], size: u32, samples: u32, progress: &dyn Progress) -> Vec<Texture> {
    progress.begin("capturing layers", row_count(strata, size));
    let center = apart.around.center;
    let count = samples.isqrt();
    let step = 1.0 / count as f32;
    let fill = |target: &Target<'_>, [face, x, y]: [u32; 3], wanted: u32, seen: &mut [Vec4]| {
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
    let texels = of_texels(strata, size, Vec4::ZERO, progress, fill);
    progress.end();
    let texture = |(stratum, mut texels): (&Stratum, Vec<Vec4>)| {
        let layout = stratum.shell.layout(size);
        texels.resize(layout.texel_count(), Vec4::ZERO);
        layout.fill_coarser(&mut texels);
        Texture::new(layout, &texels)
    };
    strata.iter().zip(texels).map(texture).collect()
}

/// How far away what layers show in their texels' middles is, and how far it reaches behind that.
fn depths(apart: &Strata<'_>, strata: &[Stratum], size: u32, progress: &dyn Progress) -> Vec<Vec<Depth>> {
    progress.begin("measuring layers", row_count(strata, size));
    let center = apart.around.center;
    let fill = |target: &Target<'_>, [face, x, y]: [u32; 3], wanted: u32, depths: &mut [Depth]| {
        let direction = target.direction(face, Vec2::new(x as f32, y as f32) + 0.5);
        apart.each_depth(&Ray { origin: center, direction }, wanted, |number, [front, back]| {
            let distance = strata[number].shell.distance(Vec3::ZERO, direction);
            let depth = Depth { front: front / distance, back: back / distance };
            depths[number] = if depth.front > 0.0 { depth } else { Depth::NOTHING };
        });
    };
    let found = of_texels(strata, size, Depth::NOTHING, progress, fill);
    progress.end();
    found
}
