//! Starts of the search on a reflector that shows no point twice: its places by their normals, so that a half vector
//! leads to one at once.

use crate::reflector_search::image::{ImagePlace, ReflectorImage};
use glam::{Vec2, Vec3};
use std::collections::VecDeque;

/// Cells along a side of the square that an octahedron of directions is unfolded to. Chosen, not measured.
pub const SIDE: usize = 64;

/// The maximum number of texels along a picture's longer side that are read to fill the square. A bound on time;
/// chosen, not measured.
const LOOKED_AT: u32 = 128;

/// Half vectors are looked up so often, each at the place that the one before led to: near points change them along the
/// reflector. Chosen, not measured.
const LOOK_UPS: u32 = 2;

/// The longest step of Newton's method from a start, as a share of the picture. Chosen, not measured.
const MAX_LED: f32 = 0.1;

/// A place of the reflector.
#[derive(Clone, Copy, Debug)]
struct StartEntry {
    position: Vec3,
    /// The unit normal on the side that is met.
    normal: Vec3,
    /// Steps on the surface of one texel to the right and down.
    right: Vec3,
    down: Vec3,
    /// The turn of normals along those: the part along `right` of a step to the right, the mixed part, and the part
    /// along `down` of a step down.
    bend: Vec3,
    /// The low corner of a whole cell.
    x: u16,
    y: u16,
    face: u16,
}

/// Places of a reflector by their normals.
#[derive(Clone, Debug)]
pub(in super::super) struct Starts {
    entries: Vec<StartEntry>,
    center: Vec3,
    /// The longest step from a start, in texels.
    most_led: f32,
}

/// A start of a search: a place that need not lie in the picture, and one that lies in a whole cell.
#[derive(Clone, Copy, Debug, Default)]
pub(in super::super) struct Start {
    pub(in super::super) near: ImagePlace,
    pub(in super::super) sure: ImagePlace,
}

impl Starts {
    /// Builds the starts of the cells that are `whole`; returns `None` if there is no such cell. `side` turns normals
    /// to the side that is met, and `center` lies about in the reflector's middle.
    pub(in super::super) fn new(image: &ReflectorImage, whole: &[bool], side: f32, center: Vec3) -> Option<Self> {
        let mut found: Vec<Option<(f32, StartEntry)>> = vec![None; SIDE * SIDE];
        let stride = image.width.max(image.height).div_ceil(LOOKED_AT) as usize;
        for face in 0..image.face_count {
            for y in (0..image.height).step_by(stride) {
                for x in (0..image.width).step_by(stride) {
                    let index = image.index(face, x, y);
                    if !whole[index] {
                        continue;
                    }
                    let normal = image.texels[index].normal * side;
                    let cell = cell_of(normal);
                    let nearness = normal.dot(middle_of(cell));
                    if found[cell].is_none_or(|(nearest, _)| nearness > nearest) {
                        found[cell] = Some((nearness, StartEntry::new(image, side, face, x, y)));
                    }
                }
            }
        }
        let mut entries: Vec<Option<StartEntry>> = found.into_iter().map(|one| one.map(|(_, entry)| entry)).collect();
        // Normals that are not visible lead to places at the border of the visible part.
        let mut waiting: VecDeque<usize> = (0..entries.len()).filter(|cell| entries[*cell].is_some()).collect();
        while let Some(cell) = waiting.pop_front() {
            for beside in around(cell) {
                if entries[beside].is_none() {
                    entries[beside] = entries[cell];
                    waiting.push_back(beside);
                }
            }
        }
        let most_led = MAX_LED * image.width.max(image.height) as f32;
        Some(Self { entries: entries.into_iter().collect::<Option<_>>()?, center, most_led })
    }

    /// The approximate place where a point appears, seen from `eye`.
    #[inline]
    pub(in super::super) fn start(&self, eye: Vec3, point: Vec3) -> Start {
        let mut found = (self.center, None);
        for _ in 0..LOOK_UPS {
            let entry = &self.entries[cell_of(half_at(found.0, eye, point))];
            found = (entry.position, Some(entry));
        }
        match found.1 {
            Some(entry) => entry.start(eye, point, self.most_led),
            None => Start::default(),
        }
    }

    /// Bytes held.
    pub(in super::super) fn byte_count(&self) -> u64 {
        size_of_val(self.entries.as_slice()) as u64
    }
}

impl StartEntry {
    fn new(image: &ReflectorImage, side: f32, face: u32, x: u32, y: u32) -> Self {
        let [low, to_right, to_down, _] = image.corners(image.index(face, x, y)).map(|texel| &image.texels[texel]);
        let (right, down) = (to_right.position - low.position, to_down.position - low.position);
        let turns = [to_right, to_down].map(|texel| (texel.normal - low.normal) * side);
        let across = 0.5 * (turns[0].dot(down) + turns[1].dot(right));
        let bend = Vec3::new(turns[0].dot(right), across, turns[1].dot(down));
        let (x, y, face) = (x as u16, y as u16, face as u16);
        Self { position: low.position, normal: low.normal * side, right, down, bend, x, y, face }
    }

    /// Takes one step of Newton's method on the law of the half vector from here, at most `most_led` texels long.
    #[inline]
    fn start(&self, eye: Vec3, point: Vec3, most_led: f32) -> Start {
        let (back, on) = (eye - self.position, point - self.position);
        let (back_nearness, on_nearness) = (1.0 / back.length(), 1.0 / on.length());
        let (toward, to_point) = (back * back_nearness, on * on_nearness);
        let sum = toward + to_point;
        let shortness = 1.0 / sum.length();
        let miss = sum * shortness - self.normal;
        let value = Vec2::new(miss.dot(self.right), miss.dot(self.down));
        let metric = Vec3::new(self.right.length_squared(), self.right.dot(self.down), self.down.length_squared());
        // Directions turn by the part of a step that is across them.
        let across = |direction: Vec3| {
            let (x, y) = (direction.dot(self.right), direction.dot(self.down));
            metric - Vec3::new(x * x, x * y, y * y)
        };
        let turns = across(toward) * back_nearness + across(to_point) * on_nearness;
        let slope = self.bend + turns * shortness;
        let scale = 1.0 / (slope.x * slope.z - slope.y * slope.y);
        let step = Vec2::new(slope.z * value.x - slope.y * value.y, slope.x * value.y - slope.y * value.x) * scale;
        let sure = ImagePlace { face: u32::from(self.face), at: Vec2::new(f32::from(self.x), f32::from(self.y)) };
        let near = ImagePlace { at: sure.at + step.clamp(Vec2::splat(-most_led), Vec2::splat(most_led)), ..sure };
        Start { near, sure }
    }
}

/// Along the half vector at a position.
#[inline]
fn half_at(position: Vec3, eye: Vec3, point: Vec3) -> Vec3 {
    let (toward, on) = (eye - position, point - position);
    toward * (1.0 / toward.length()) + on * (1.0 / on.length())
}

/// The cells beside one, over the square's sides too.
pub fn around(cell: usize) -> [usize; 4] {
    let (x, y) = (cell % SIDE, cell / SIDE);
    let (mirrored_x, mirrored_y) = (SIDE - 1 - x, SIDE - 1 - y);
    let at = |x: usize, y: usize| y * SIDE + x;
    [
        if x > 0 { at(x - 1, y) } else { at(x, mirrored_y) },
        if x + 1 < SIDE { at(x + 1, y) } else { at(x, mirrored_y) },
        if y > 0 { at(x, y - 1) } else { at(mirrored_x, y) },
        if y + 1 < SIDE { at(x, y + 1) } else { at(mirrored_x, y) },
    ]
}

/// The cell of a direction, of any length, in the unfolded octahedron.
#[inline]
pub fn cell_of(direction: Vec3) -> usize {
    let size = direction.abs();
    let scale = 1.0 / (size.x + size.y + size.z);
    let flat = direction.truncate() * scale;
    // The far side's triangles are folded out over the square's corners.
    let folded = (1.0 - Vec2::new(size.y, size.x) * scale).copysign(flat);
    let at = if direction.z < 0.0 { folded } else { flat };
    // Casts saturate; values that are not numbers become 0.
    let cell = |along: f32| ((along + 1.0) * (0.5 * SIDE as f32)) as usize;
    cell(at.y).min(SIDE - 1) * SIDE + cell(at.x).min(SIDE - 1)
}

/// The unit direction of a cell's middle.
pub fn middle_of(cell: usize) -> Vec3 {
    let middle = |number: usize| (number as f32 + 0.5) * (2.0 / SIDE as f32) - 1.0;
    let flat = Vec2::new(middle(cell % SIDE), middle(cell / SIDE));
    let up = 1.0 - flat.x.abs() - flat.y.abs();
    let at = if up < 0.0 { (1.0 - Vec2::new(flat.y, flat.x).abs()).copysign(flat) } else { flat };
    at.extend(up).normalize()
}
