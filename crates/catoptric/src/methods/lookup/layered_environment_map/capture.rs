//! Textures of layers as they are seen from the middle of their shells: projected, not inferred.

use super::layers::Stratum;
use super::surroundings::Strata;
use super::texels::Texture;
use crate::parallel;
use crate::progress::Progress;
use crate::scene::{Ray, RayDifferential};
use glam::{Vec2, Vec4};

/// The texture of a layer, seen from the centre with a square number of rays a texel.
pub(super) fn projected(
    strata: &Strata<'_>,
    number: usize,
    stratum: &Stratum,
    size: u32,
    samples: u32,
    progress: &dyn Progress,
) -> Texture {
    let (layout, shell) = (stratum.shell.layout(size), stratum.shell);
    let center = strata.around.group.center();
    let count = samples.isqrt();
    let step = 2.0 / (size * count) as f32;
    let row = |row: usize| {
        let (face, y) = (row as u32 / size, row as u32 % size);
        let texel = |x: u32| {
            let towards = |at: Vec2| shell.towards(layout.place_of(face, at));
            let sample = |sample: u32| {
                let within = Vec2::new((sample % count) as f32, (sample / count) as f32) + 0.5;
                let at = (Vec2::new(x as f32, y as f32) * count as f32 + within) * step - 1.0;
                let direction = towards(at).normalize();
                let turned = |by: Vec2| towards(at + by * step).normalize() - direction;
                let (direction_dx, direction_dy) = (turned(Vec2::X), turned(Vec2::Y));
                let change = RayDifferential { direction_dx, direction_dy, ..RayDifferential::default() };
                strata.seen(number, &Ray { origin: center, direction }, Some(&change))
            };
            (0..count * count).map(sample).sum::<Vec4>() / (count * count) as f32
        };
        let texels: Vec<Vec4> = (0..size).map(texel).collect();
        progress.advance(1);
        texels
    };
    let mut texels = parallel::map_collect((layout.faces() * size) as usize, row).concat();
    texels.resize(layout.texel_count(), Vec4::ZERO);
    layout.fill_coarser(&mut texels);
    Texture { layout, texels }
}
