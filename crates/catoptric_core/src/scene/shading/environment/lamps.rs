//! Small bright parts of an environment. Where light is gathered over a lobe in a number of directions, these may lie
//! between them: they are looked at one by one.

use super::map::{EquirectangularMap, LightMap, direction, reductions};
use crate::math::portable::PortableMath;
use glam::{Vec2, Vec3};
use std::f32::consts::{PI, TAU};

/// Lamps lie in cells of a picture of so many columns and half as many rows.
const COLUMNS: usize = 64;

/// Light that is brighter than the mean radiance by this factor belongs to lamps.
const BRIGHT: f32 = 8.0;

/// A lamp has at least this share of all light, all of them together at least the other.
const LEAST_SHARE: f32 = 1e-3;
const LEAST_SHARE_OF_ALL: f32 = 0.02;

/// The light that comes from a small part of the sky, beyond what is usual.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lamp {
    /// The direction to its middle, unit length.
    pub towards: Vec3,
    /// Radiance times solid angle.
    pub light: Vec3,
    /// The sum of its channels.
    pub brightness: f32,
}

/// The lamps of an environment, and its radiance without them.
#[derive(Clone, Debug, PartialEq)]
pub struct Lamps {
    lamps: Vec<Lamp>,
    /// The radiance without theirs, reduced.
    rest: Vec<EquirectangularMap>,
    /// Which reduction of the picture the first of them is.
    finest: usize,
}

impl Lamps {
    /// The solid angle of a lamp, at most.
    pub const SOLID_ANGLE: f32 = (TAU / COLUMNS as f32) * (TAU / COLUMNS as f32);

    /// The most lamps: each is looked at from each point that is shaded.
    pub const MOST: usize = 96;

    /// All of them.
    #[inline]
    pub fn all(&self) -> &[Lamp] {
        &self.lamps
    }

    /// The environment's reductions without their light, from one on: the picture itself is number 0.
    pub fn rest(&self) -> (usize, impl ExactSizeIterator<Item = LightMap<'_>>) {
        (self.finest, self.rest.iter().map(EquirectangularMap::light_map))
    }

    /// The radiance without theirs at a position, blended between two reductions; 0 is the picture itself.
    pub(super) fn rest_at(&self, position: Vec2, level: f32) -> Vec3 {
        let level = (level - self.finest as f32).max(0.0);
        let (whole, between) = (level as usize, level - (level as usize) as f32);
        let at = |level: usize| self.rest[level.min(self.rest.len() - 1)].at(position);
        let fine = at(whole);
        if between > 0.0 { fine + (at(whole + 1) - fine) * between } else { fine }
    }

    /// The lamps in directions of the scene, from directions of the picture. What is left of it stays as it is.
    pub(super) fn turned(mut self, turn: impl Fn(Vec3) -> Vec3) -> Self {
        self.lamps.iter_mut().for_each(|lamp| lamp.towards = turn(lamp.towards));
        self
    }

    /// The lamps of a reduction of a picture of radiance, rows from the top; `None` if they do not matter.
    pub(super) fn new(level: usize, width: u32, height: u32, radiance: Vec<[f32; 3]>) -> Option<Self> {
        let (width, height) = (width as usize, height as usize);
        let (columns, rows) = (COLUMNS.min(width), (COLUMNS / 2).min(height));
        let cell_of = |index: usize| index / width * rows / height * columns + index % width * columns / width;
        let solid_angle = |row: usize| {
            let polar = |edge: usize| (edge as f32 / height as f32 * PI).cosine();
            TAU / width as f32 * (polar(row) - polar(row + 1))
        };
        let solid_angles: Vec<f32> = (0..height).map(solid_angle).collect();
        let texels = || radiance.iter().map(|radiance| Vec3::from(*radiance)).enumerate();
        let all: f32 = texels().map(|(index, radiance)| radiance.element_sum() * solid_angles[index / width]).sum();
        let usual = BRIGHT * all / (4.0 * PI);
        let beyond = |radiance: Vec3| radiance * (1.0 - usual / radiance.element_sum().max(usual));
        let mut cells = vec![(Vec3::ZERO, Vec3::ZERO); columns * rows];
        for (index, radiance) in texels() {
            let light = beyond(radiance) * solid_angles[index / width];
            if light != Vec3::ZERO {
                let [u, v] = [(index % width) as f32 + 0.5, (index / width) as f32 + 0.5];
                let (towards, sum) = &mut cells[cell_of(index)];
                *towards += direction(u / width as f32, v / height as f32) * light.element_sum();
                *sum += light;
            }
        }
        let light_of = |cell: &usize| cells[*cell].1.element_sum();
        let mut chosen: Vec<usize> = (0..cells.len()).filter(|cell| light_of(cell) > LEAST_SHARE * all).collect();
        chosen.sort_by(|one, other| light_of(other).total_cmp(&light_of(one)));
        chosen.truncate(Self::MOST);
        if chosen.iter().map(light_of).sum::<f32>() <= LEAST_SHARE_OF_ALL * all {
            return None;
        }
        let is_chosen: Vec<bool> = (0..cells.len()).map(|cell| chosen.contains(&cell)).collect();
        let rest = |(index, radiance): (usize, Vec3)| {
            let rest = if is_chosen[cell_of(index)] { radiance - beyond(radiance) } else { radiance };
            rest.to_array()
        };
        let rest = reductions(width, height, &texels().map(rest).collect::<Vec<_>>());
        let lamp = |cell: usize| {
            let (towards, light) = cells[cell];
            towards.try_normalize().map(|towards| Lamp { towards, light, brightness: light.element_sum() })
        };
        // The picture itself is not kept twice: it needs a reduction.
        let lamps = chosen.into_iter().filter_map(lamp).collect();
        (!rest.is_empty()).then_some(Self { lamps, rest, finest: level + 1 })
    }
}
