//! Means over places near each other that face the same way, within what each of them sees alike.

use crate::parallel;
use glam::{IVec3, Vec3, Vec4};
use std::collections::HashMap;

/// Cells are no larger and no smaller than these parts of the scene.
const LARGEST_CELL: f32 = 1.0 / 8.0;
const SMALLEST_CELL: f32 = 1.0 / 1024.0;

/// A side of a surface at a place.
pub(super) struct Facing {
    pub(super) position: Vec3,
    /// Unit normal of that side.
    pub(super) normal: Vec3,
    /// Places so near see about the same.
    pub(super) reach: f32,
}

/// The cells, of several sizes, to which places belong: each place to those that are no larger than its reach. So its
/// mean, over cells about as large, is that of places which see as far at least.
pub(super) struct Neighbourhoods {
    /// The cells that each place adds to, and those that it reads, with weights.
    added: Vec<Vec<(u32, f32)>>,
    read: Vec<Vec<(u32, f32)>>,
    cell_count: usize,
}

/// The size of a cell, as an exponent of two; a cell of that size; one of the six axes.
type Cell = (i32, IVec3, u8);

impl Neighbourhoods {
    /// Finds them for the places of a scene of a size; `None` shares nothing.
    pub(super) fn new(places: &[Option<Facing>], size: f32) -> Self {
        let [smallest, largest] = [SMALLEST_CELL, LARGEST_CELL].map(|part| exponent((part * size).max(1e-30)));
        let level = |place: &Facing| exponent(place.reach).clamp(smallest, largest);
        let mut cells: HashMap<Cell, u32> = HashMap::new();
        let mut added = Vec::with_capacity(places.len());
        for place in places {
            let mut of_place = Vec::new();
            let Some(place) = place else {
                added.push(of_place);
                continue;
            };
            for level in smallest..=level(place) {
                let cell = (place.position / side(level)).floor().as_ivec3();
                for (axis, weight) in axes(place.normal) {
                    let next = cells.len() as u32;
                    of_place.push((*cells.entry((level, cell, axis)).or_insert(next), weight));
                }
            }
            added.push(of_place);
        }
        let read = parallel::map_collect(places.len(), |index| {
            let Some(place) = &places[index] else { return Vec::new() };
            let level = level(place);
            let at = place.position / side(level) - 0.5;
            let (first, share) = (at.floor(), at - at.floor());
            let mut of_place = Vec::new();
            for corner in 0..8 {
                let step = IVec3::new(corner & 1, corner >> 1 & 1, corner >> 2);
                let near = Vec3::select(step.cmpeq(IVec3::ONE), share, 1.0 - share);
                for (axis, weight) in axes(place.normal) {
                    if let Some(cell) = cells.get(&(level, first.as_ivec3() + step, axis)) {
                        of_place.push((*cell, weight * near.element_product()));
                    }
                }
            }
            of_place
        });
        Self { added, read, cell_count: cells.len() }
    }

    /// The sums of places with their neighbours', as far as these are near.
    pub(super) fn sums(&self, sums: &[Vec4]) -> Vec<Vec4> {
        let mut cells = vec![Vec4::ZERO; self.cell_count];
        for (cell, weight, sum) in self
            .added
            .iter()
            .zip(sums)
            .flat_map(|(cells, sum)| cells.iter().map(move |(cell, weight)| (cell, weight, sum)))
        {
            cells[*cell as usize] += *sum * *weight;
        }
        parallel::map_collect(self.read.len(), |place| {
            let near: Vec4 = self.read[place].iter().map(|(cell, weight)| cells[*cell as usize] * *weight).sum();
            if near.w > 0.0 { near } else { sums[place] }
        })
    }
}

/// The axes on whose side a unit vector is, with the squares of its cosines to them: together 1.
fn axes(normal: Vec3) -> impl Iterator<Item = (u8, f32)> {
    let axis = |(axis, part): (u8, f32)| (2 * axis + u8::from(part < 0.0), part * part);
    (0..).zip(normal.to_array()).map(axis).filter(|(_, weight)| *weight > 1e-3)
}

/// The exponent of two of a number that is not negative.
fn exponent(number: f32) -> i32 {
    (number.to_bits() >> 23) as i32 - 127
}

/// The side of a cell.
fn side(level: i32) -> f32 {
    f32::from_bits(((level + 127) as u32) << 23)
}
