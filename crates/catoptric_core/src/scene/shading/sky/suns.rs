//! Suns of an environment: small parts of it that are much brighter than what is around them.

use crate::math::portable::PortableMath;
use crate::parallel;
use crate::scene::{Environment, Light, LightKind};
use glam::Vec3;
use std::f32::consts::{PI, TAU};

/// Suns that are found at most.
const MOST_SUNS: usize = 4;

/// A sun lies within this angle of its brightest texel; what is around it is taken from as far again.
const RADIUS: f32 = 6.0 * PI / 180.0;

/// The least share of all light that a sun has: fainter ones are left to the rest, as one sun costs a ray at each point
/// that it lights.
const LEAST_SHARE: f32 = 0.04;

/// A texel of an environment.
struct Texel {
    direction: Vec3,
    solid_angle: f32,
}

/// The texels of a picture of an environment, rows from the top.
fn texels(width: usize, height: usize) -> impl Iterator<Item = Texel> {
    (0..height).flat_map(move |row| {
        let polar = |edge: usize| (edge as f32 / height as f32 * PI).cosine();
        let solid_angle = TAU / width as f32 * (polar(row) - polar(row + 1));
        (0..width).map(move |column| {
            let [u, v] = [(column as f32 + 0.5) / width as f32, (row as f32 + 0.5) / height as f32];
            Texel { direction: Environment::direction(u, v), solid_angle }
        })
    })
}

/// The suns of a picture of radiance as lights, each with the irradiance of a surface that faces it; the rest of it.
pub(super) fn suns_and_rest(width: u32, height: u32, radiance: Vec<[f32; 3]>) -> (Vec<Light>, Vec<[f32; 3]>) {
    let mut rest = radiance;
    let texels: Vec<Texel> = texels(width as usize, height as usize).collect();
    let brightness = |radiance: &[f32; 3]| radiance.iter().sum::<f32>();
    let all: f32 = texels.iter().zip(&rest).map(|(texel, radiance)| texel.solid_angle * brightness(radiance)).sum();
    let mut suns = Vec::new();
    while suns.len() < MOST_SUNS {
        let brighter = |(index, most): (usize, f32), (at, radiance): (usize, &[f32; 3])| {
            let value = brightness(radiance);
            if value > most { (at, value) } else { (index, most) }
        };
        let (brightest, _) = rest.iter().enumerate().fold((0, 0.0), brighter);
        let middle = texels[brightest].direction;
        let (near, far) = (RADIUS.cosine(), (2.0 * RADIUS).cosine());
        let within = |least: f32, most: f32| {
            let cosine = |texel: &Texel| texel.direction.dot(middle);
            let is_in = move |(_, texel): &(usize, &Texel)| (least..most).contains(&cosine(texel));
            texels.iter().enumerate().filter(is_in)
        };
        let (mut around, mut solid_angle) = (Vec3::ZERO, 0.0);
        for (index, texel) in within(far, near) {
            around += Vec3::from(rest[index]) * texel.solid_angle;
            solid_angle += texel.solid_angle;
        }
        let around = around / solid_angle.max(f32::MIN_POSITIVE);
        let (mut light, mut towards) = (Vec3::ZERO, Vec3::ZERO);
        let mut dimmed = Vec::new();
        for (index, texel) in within(near, f32::INFINITY) {
            let above = (Vec3::from(rest[index]) - around).max(Vec3::ZERO);
            light += above * texel.solid_angle;
            towards += texel.direction * (above.element_sum() * texel.solid_angle);
            dimmed.push((index, Vec3::from(rest[index]) - above));
        }
        let Some(towards) = towards.try_normalize().filter(|_| light.element_sum() > LEAST_SHARE * all) else { break };
        for (index, radiance) in dimmed {
            rest[index] = radiance.to_array();
        }
        let kind = LightKind::Directional;
        suns.push(Light { kind, intensity: light, position: Vec3::ZERO, direction: -towards });
    }
    (suns, rest)
}

/// A part of the sky: the middle of its light, and all of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct SkyPart {
    pub(super) towards: Vec3,
    pub(super) light: Vec3,
}

/// A picture of radiance in twice so many parts at most: around directions that are spread evenly, and around as many
/// where its light is.
pub(super) fn parts(width: u32, height: u32, radiance: &[[f32; 3]], count: u32) -> Vec<SkyPart> {
    // Few texels say enough.
    let (columns, rows) = ((width as usize).min(256), (height as usize).min(128));
    let mut cells = vec![(Vec3::ZERO, Vec3::ZERO); columns * rows];
    for (index, (texel, radiance)) in texels(width as usize, height as usize).zip(radiance).enumerate() {
        let (row, column) = (index / width as usize, index % width as usize);
        let (row, column) = (row * rows / height as usize, column * columns / width as usize);
        let light = Vec3::from(*radiance) * texel.solid_angle;
        let (towards, all) = &mut cells[row * columns + column];
        *towards += texel.direction * light.element_sum();
        *all += light;
    }
    let mut middles: Vec<Vec3> = (0..count).map(|index| spread(index, count)).collect();
    let all: f32 = cells.iter().map(|(_, light)| light.element_sum()).sum();
    let mut passed = 0.0;
    for index in along_blocks(columns, rows) {
        let (towards, light) = cells[index];
        passed += light.element_sum();
        let is_due = passed * count as f32 > (middles.len() - count as usize + 1) as f32 * all;
        middles.extend(towards.try_normalize().filter(|_| is_due));
    }
    let nearest = parallel::map_collect(cells.len(), |cell| {
        let towards = cells[cell].0;
        let nearer = |one: (usize, f32), (index, middle): (usize, &Vec3)| {
            let cosine = middle.dot(towards);
            if cosine > one.1 { (index, cosine) } else { one }
        };
        middles.iter().enumerate().fold((0, f32::NEG_INFINITY), nearer).0
    });
    let mut sums = vec![(Vec3::ZERO, Vec3::ZERO); middles.len()];
    for ((towards, light), part) in cells.iter().zip(nearest) {
        sums[part].0 += *towards;
        sums[part].1 += *light;
    }
    let part = |(towards, light): (Vec3, Vec3)| Some(SkyPart { towards: towards.try_normalize()?, light });
    sums.into_iter().filter_map(part).collect()
}

/// Directions that are spread evenly: a spiral by the golden angle.
fn spread(index: u32, count: u32) -> Vec3 {
    let y = 1.0 - (2 * index + 1) as f32 / count as f32;
    let angle = index as f32 * (PI * (3.0 - 5f32.sqrt()));
    let radius = (1.0 - y * y).max(0.0).sqrt();
    Vec3::new(radius * angle.cosine(), y, radius * angle.sine())
}

/// The indices of all cells of a picture, along a way that stays in one place: blocks of rows, to and fro.
fn along_blocks(width: usize, height: usize) -> impl Iterator<Item = usize> {
    let block = (height / 16).max(1);
    (0..height.div_ceil(block)).flat_map(move |blocks| {
        let rows = blocks * block..((blocks + 1) * block).min(height);
        (0..width).flat_map(move |column| {
            let column = if blocks % 2 == 0 { column } else { width - 1 - column };
            rows.clone().map(move |row| row * width + column)
        })
    })
}
