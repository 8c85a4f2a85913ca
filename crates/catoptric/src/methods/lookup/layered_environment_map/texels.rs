//! Textures of layers: the faces of a cube or a single square with transparency, and which texels a look-up reads.
//!
//! [`Layout::taps`] is the only place that says which texels count how much: look-ups sum over it, and inference has its
//! matrix from it.

use super::least_squares::Equations;
use crate::methods::lookup::cube::{Probes, direction_of, locate};
use glam::{Vec2, Vec3, Vec4};

/// The largest ratio of a footprint's axes that is resolved by several look-ups: there are many layers to look up.
const MAX_ANISOTROPY: f32 = 4.0;

/// The order of a texture's texels: level after level from the finest, face after face, row after row from the top.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Layout {
    /// Texels a side of the finest level, a power of two.
    size: u32,
    /// Six: those of a cube, looked up by directions. One: a square, looked up by places from -1 to 1.
    faces: u32,
    /// The first texel of every level.
    levels: Vec<u32>,
    count: u32,
}

impl Layout {
    /// The faces of a cube.
    pub(super) fn cube(size: u32) -> Self {
        Self::new(size, 6)
    }

    /// A square.
    pub(super) fn square(size: u32) -> Self {
        Self::new(size, 1)
    }

    fn new(size: u32, faces: u32) -> Self {
        let (mut levels, mut count) = (Vec::new(), 0);
        let mut side = size;
        while side > 0 {
            levels.push(count);
            count += faces * side * side;
            side /= 2;
        }
        Self { size, faces, levels, count }
    }

    /// Texels of all levels.
    pub(super) fn texel_count(&self) -> usize {
        self.count as usize
    }

    /// Faces of a level.
    pub(super) fn faces(&self) -> u32 {
        self.faces
    }

    /// Where a place of a face (from -1 to 1) is looked up.
    pub(super) fn place_of(&self, face: u32, at: Vec2) -> Vec3 {
        if self.faces == 6 { direction_of(face as usize, at) } else { at.extend(0.0) }
    }

    /// The texels that a look-up reads, with their weights, which sum to `weight` (less beyond a square's edges): trilinear
    /// within a footprint of this width. A place is a unit direction or a place of the square.
    #[inline(always)]
    fn taps_of_probe(&self, place: Vec3, spread: f32, weight: f32, tap: &mut impl FnMut(u32, f32)) {
        let (face, at, secant2) = if self.faces == 6 { locate(place) } else { (0, place.truncate(), 1.0) };
        // A texel in the middle of a face spans 2 / size; its solid angle falls with the cube of the cosine.
        let texels = spread * self.size as f32 * 0.5 * (secant2 * secant2.sqrt()).sqrt();
        let last = self.levels.len() - 1;
        let level = if texels > 1.0 { texels.log2().min(last as f32) } else { 0.0 };
        let index = level as usize;
        let blend = level - index as f32;
        self.bilinear(index, face as u32, at, weight * (1.0 - blend), tap);
        if blend > 0.0 {
            self.bilinear((index + 1).min(last), face as u32, at, weight * blend, tap);
        }
    }

    #[inline(always)]
    fn bilinear(&self, level: usize, face: u32, at: Vec2, weight: f32, tap: &mut impl FnMut(u32, f32)) {
        let side = self.size >> level;
        let place = (at + 1.0) * (0.5 * side as f32) - 0.5;
        // What is far beyond a square reads nothing; casts saturate.
        let place = place.clamp(Vec2::splat(-2.0), Vec2::splat(side as f32 + 1.0));
        let low = place.floor();
        let part = place - low;
        let (x, y) = (low.x as i32, low.y as i32);
        let first = self.levels[level] + face * side * side;
        let inner = 0..side as i32 - 1;
        if inner.contains(&x) && inner.contains(&y) {
            let texel = first + y as u32 * side + x as u32;
            tap(texel, weight * (1.0 - part.x) * (1.0 - part.y));
            tap(texel + 1, weight * part.x * (1.0 - part.y));
            tap(texel + side, weight * (1.0 - part.x) * part.y);
            tap(texel + side + 1, weight * part.x * part.y);
            return;
        }
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let share_x = if dx == 0 { 1.0 - part.x } else { part.x };
            let share_y = if dy == 0 { 1.0 - part.y } else { part.y };
            if let Some(texel) = self.texel(level, face, x + dx, y + dy) {
                tap(texel, weight * share_x * share_y);
            }
        }
    }

    /// A texel of a face, or that of the next face where it lies beyond an edge; none beyond the edge of a square.
    fn texel(&self, level: usize, face: u32, x: i32, y: i32) -> Option<u32> {
        let side = self.size >> level;
        let within = 0..side as i32;
        if within.contains(&x) && within.contains(&y) {
            return Some(self.levels[level] + (face * side + y as u32) * side + x as u32);
        }
        if self.faces != 6 {
            return None;
        }
        let at = (Vec2::new(x as f32, y as f32) + 0.5) * (2.0 / side as f32) - 1.0;
        let (face, at, _) = locate(direction_of(face as usize, at));
        let place = ((at + 1.0) * (0.5 * side as f32)).clamp(Vec2::ZERO, Vec2::splat(side as f32 - 1.0));
        Some(self.levels[level] + (face as u32 * side + place.y as u32) * side + place.x as u32)
    }

    /// The texels that a look-up over a footprint reads, with their weights. Changes are those of the place from pixel to pixel.
    #[inline(always)]
    pub(super) fn taps(&self, place: Vec3, changes: [Vec3; 2], tap: &mut impl FnMut(u32, f32)) {
        let probes = Probes::of(changes, MAX_ANISOTROPY);
        let weight = 1.0 / probes.count as f32;
        for offset in probes.offsets() {
            self.taps_of_probe(place + offset, probes.spread, weight, tap);
        }
    }

    /// Appends equations that say that the texels of coarser levels are the means of those that they cover.
    pub(super) fn couple(&self, confidence: f32, equations: &mut Equations) {
        for level in 1..self.levels.len() {
            let side = self.size >> level;
            for index in 0..self.faces * side * side {
                let (row, x) = (index / side, index % side);
                let corner = self.levels[level - 1] + 4 * row * side + 2 * x;
                equations.push(confidence, Vec4::ZERO, |tap| {
                    tap(self.levels[level] + index, 1.0);
                    for finer in [corner, corner + 1, corner + 2 * side, corner + 2 * side + 1] {
                        tap(finer, -0.25);
                    }
                });
            }
        }
    }

    /// Fills all levels but the finest: each texel has the mean of the four that it covers.
    pub(super) fn fill_coarser(&self, texels: &mut [Vec4]) {
        for level in 1..self.levels.len() {
            let side = self.size >> level;
            let (finer, rest) = texels.split_at_mut(self.levels[level] as usize);
            let finer = &finer[self.levels[level - 1] as usize..];
            for (index, texel) in rest[..(self.faces * side * side) as usize].iter_mut().enumerate() {
                let (row, x) = (index / side as usize, index % side as usize);
                let corner = 4 * row * side as usize + 2 * x;
                let below = corner + 2 * side as usize;
                *texel = (finer[corner] + finer[corner + 1] + finer[below] + finer[below + 1]) * 0.25;
            }
        }
    }
}

/// Radiance times opacity, and opacity.
#[derive(Clone, Debug)]
pub(super) struct Texture {
    pub(super) layout: Layout,
    pub(super) texels: Vec<Vec4>,
}

impl Texture {
    /// The mean over a footprint.
    #[inline(always)] // for the instructions of its caller
    pub(super) fn fetch(&self, place: Vec3, changes: [Vec3; 2]) -> Vec4 {
        let mut sum = Vec4::ZERO;
        self.layout.taps(place, changes, &mut |texel, weight| sum += self.texels[texel as usize] * weight);
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Stream;

    fn texture(layout: Layout, value: impl Fn(Vec3) -> Vec4) -> Texture {
        let side = layout.size;
        let mut texels = vec![Vec4::ZERO; layout.texel_count()];
        for face in 0..layout.faces {
            for (y, x) in (0..side).flat_map(|y| (0..side).map(move |x| (y, x))) {
                let at = (Vec2::new(x as f32, y as f32) + 0.5) * (2.0 / side as f32) - 1.0;
                texels[((face * side + y) * side + x) as usize] = value(layout.place_of(face, at));
            }
        }
        layout.fill_coarser(&mut texels);
        Texture { layout, texels }
    }

    #[test]
    fn a_look_up_gives_what_is_there_also_across_edges() {
        let cube = texture(Layout::cube(64), |direction| (direction.normalize() + 1.0).extend(0.5));
        let mut random = Stream::new(5);
        let mut number = || random.next_between(-1.0, 1.0);
        let mut directions: Vec<Vec3> =
            (0..2000).map(|_| Vec3::new(number(), number(), number()).normalize()).collect();
        directions.extend([Vec3::ONE.normalize(), Vec3::new(1.0, 1.0, 0.0).normalize()]);
        for direction in directions {
            let found = cube.fetch(direction, [Vec3::ZERO; 2]);
            // Beyond an edge the next texel of the other face stands in: off by less than a texel.
            assert!((found.truncate() - 1.0 - direction).length() < 0.02, "{direction}: {found}");
            assert!((found.w - 0.5).abs() < 1e-6);
        }
        let square = texture(Layout::square(32), |place| Vec4::new(place.x, place.y, 1.0, 1.0));
        let found = square.fetch(Vec3::new(0.3, -0.2, 0.0), [Vec3::ZERO; 2]);
        assert!((found - Vec4::new(0.3, -0.2, 1.0, 1.0)).length() < 1e-5, "{found}");
        assert_eq!(square.fetch(Vec3::new(1.2, 0.0, 0.0), [Vec3::ZERO; 2]), Vec4::ZERO, "nothing is beyond a square");
        assert!(square.fetch(Vec3::new(f32::INFINITY, f32::NAN, 0.0), [Vec3::ZERO; 2]).is_finite());
    }

    #[test]
    fn weights_sum_to_one_and_wide_footprints_average() {
        let layout = Layout::cube(16);
        for spread in [0.0, 0.1, 0.5, 3.0] {
            let mut sum = 0.0;
            let changes = [Vec3::Y * spread, Vec3::Z * (0.3 * spread)];
            layout.taps(Vec3::new(0.8, 0.6, 0.0), changes, &mut |_, weight| sum += weight);
            assert!((sum - 1.0).abs() < 1e-5, "{spread}: {sum}");
        }
        let cube = texture(Layout::cube(64), |direction| direction.normalize().extend(1.0));
        let blurred = cube.fetch(Vec3::X, [Vec3::Y * 3.0, Vec3::Z * 3.0]);
        assert!(blurred.x > 0.5 && blurred.y.abs() < 0.05 && blurred.z.abs() < 0.05, "{blurred}");
    }
}
