//! Many points on a reflector that shows no point twice: eight of them side by side.

use super::cell::{Ends, FAR, STEPS};
use super::image::Place;
use super::search::{BEHIND, OUTSIDE, ReflectorSearch, TILT};
use super::starts::Starts;
use crate::methods::projection::virtual_objects::Reflector;
use glam::{Vec2, Vec3};

/// Points side by side: the compiler makes vector instructions of loops of this length.
const LANES: usize = 8;

/// Points that are not in their cell after so many are searched one by one.
const MOST_CELLS: u32 = 3;

/// A number of each point.
type Lane = [f32; LANES];
/// A vector of each point.
type Lane3 = [Lane; 3];

impl ReflectorSearch {
    /// The mirror images of `points` in the tangent planes where they appear; not finite where they do not.
    ///
    /// Every image depends on its own point alone: how many there are and who is beside whom changes nothing.
    pub(super) fn mirror_images(&self, reflector: &Reflector<'_>, points: &[Vec3], images: &mut [Vec3]) {
        for (points, images) in points.chunks(LANES).zip(images.chunks_mut(LANES)) {
            let mut eight = [points[0]; LANES];
            eight[..points.len()].copy_from_slice(points);
            let found = match (&self.starts, self.source.eye) {
                (Some(starts), Some(eye)) => in_whole_cells(self, starts, eye, eight),
                _ => [None; LANES],
            };
            for (image, (point, found)) in images.iter_mut().zip(points.iter().zip(found)) {
                *image = found.unwrap_or_else(|| self.mirror_image(reflector, *point));
            }
        }
    }

    /// The mirror image of a point where it appears first; not finite where it does not.
    #[cold]
    fn mirror_image(&self, reflector: &Reflector<'_>, point: Vec3) -> Vec3 {
        let foot = self.first_foot(reflector, point);
        foot.map_or(Vec3::NAN, |foot| point - foot.normal * (2.0 * foot.normal.dot(point - foot.position)))
    }
}

/// The four corners of a cell for each point.
struct Corners {
    ends: [Ends<LANES>; 4],
    misses: [Lane3; 4],
}

/// What is bilinear between the corners, and its changes to the right and down.
#[inline(always)] // for the instructions of its caller
fn between<const COUNT: usize>(values: [&[Lane; COUNT]; 4], at: &[Lane; 2]) -> [[Lane; COUNT]; 3] {
    let mut all = [[[0.0; LANES]; COUNT]; 3];
    for component in 0..COUNT {
        let [a, b, c, d] = values.map(|of| of[component]);
        for lane in 0..LANES {
            let (right, down) = (b[lane] - a[lane], c[lane] - a[lane]);
            let twist = d[lane] - c[lane] - right;
            let (x, y) = (at[0][lane], at[1][lane]);
            all[0][component][lane] = a[lane] + right * x + down * y + twist * (x * y);
            all[1][component][lane] = right + twist * y;
            all[2][component][lane] = down + twist * x;
        }
    }
    all
}

#[inline(always)] // for the instructions of its caller
fn dot(a: &Lane3, b: &Lane3) -> Lane {
    let mut product = [0.0; LANES];
    for lane in 0..LANES {
        product[lane] = a[0][lane] * b[0][lane] + a[1][lane] * b[1][lane] + a[2][lane] * b[2][lane];
    }
    product
}

/// The images of those points whose search ends within a whole cell after few steps, on the side of it that is seen; not finite
/// for those that lie far behind the reflector.
#[multiversion::multiversion(targets("x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"))]
fn in_whole_cells(search: &ReflectorSearch, starts: &Starts, eye: Vec3, eight: [Vec3; LANES]) -> [Option<Vec3>; LANES] {
    let mut points: Lane3 = [[0.0; LANES]; 3];
    for (lane, point) in eight.iter().enumerate() {
        for axis in 0..3 {
            points[axis][lane] = point[axis];
        }
    }
    let mut places = eight.map(|point| search.begun(&starts.start(eye, point)));
    let mut corners = search.cells_at(&places, eye, &points);
    let mut zero = corners.zero();
    for _ in 1..MOST_CELLS {
        let mut moved = false;
        for lane in 0..LANES {
            let (x, y) = (zero[0][lane] - 0.5, zero[1][lane] - 0.5);
            if x.abs().max(y.abs()) <= 0.5 + OUTSIDE {
                continue;
            }
            let place = &mut places[lane];
            let next = search.image.settled(Place { face: place.face, at: place.at.floor() + 0.5 + Vec2::new(x, y) });
            if search.whole_at(&next).is_some() {
                *place = next;
                moved = true;
            }
        }
        if !moved {
            break;
        }
        corners = search.cells_at(&places, eye, &points);
        zero = corners.zero();
    }
    corners.images(search, eye, &zero, &points)
}

impl ReflectorSearch {
    /// The cells that hold places; these must be whole.
    #[inline(always)] // for the instructions of its caller
    fn cells_at(&self, places: &[Place; LANES], eye: Vec3, points: &Lane3) -> Corners {
        let mut ends: [Ends<LANES>; 4] = Default::default();
        let side = self.law.side;
        for (lane, place) in places.iter().enumerate() {
            let (x, y) = self.image.cell_at(place);
            let texels = self.image.corners(self.image.index(place.face, x, y));
            for (end, texel) in ends.iter_mut().zip(texels) {
                end.set(lane, &self.image.texels[texel], side, eye);
            }
        }
        let mut misses = [[[0.0; LANES]; 3]; 4];
        for (miss, end) in misses.iter_mut().zip(&ends) {
            *miss = end.misses(&self.law, points);
        }
        Corners { ends, misses }
    }
}

impl Corners {
    /// Where the misses are zero along the surface, from the low corners; may lie outside, and need not be a number.
    #[inline(always)] // for the instructions of its caller
    fn zero(&self) -> [Lane; 2] {
        let [a, b, c, d] = [0, 1, 2, 3].map(|corner: usize| &self.ends[corner].position);
        let (mut right, mut down): (Lane3, Lane3) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
        for axis in 0..3 {
            for lane in 0..LANES {
                right[axis][lane] = b[axis][lane] - a[axis][lane] + d[axis][lane] - c[axis][lane];
                down[axis][lane] = c[axis][lane] - a[axis][lane] + d[axis][lane] - b[axis][lane];
            }
        }
        let forms =
            [0, 1, 2, 3].map(|corner: usize| [dot(&self.misses[corner], &right), dot(&self.misses[corner], &down)]);
        let mut zero = [[0.5; LANES]; 2];
        for _ in 0..STEPS {
            let [value, to_right, to_down] = between([&forms[0], &forms[1], &forms[2], &forms[3]], &zero);
            for lane in 0..LANES {
                let scale = 1.0 / (to_right[0][lane] * to_down[1][lane] - to_right[1][lane] * to_down[0][lane]);
                let x = (to_down[1][lane] * value[0][lane] - to_down[0][lane] * value[1][lane]) * scale;
                let y = (to_right[0][lane] * value[1][lane] - to_right[1][lane] * value[0][lane]) * scale;
                // Further out the bilinear form bends to nonsense: the first step says the direction.
                let near = (zero[0][lane] - 0.5).abs().max((zero[1][lane] - 0.5).abs()) <= FAR;
                zero[0][lane] -= if near { x } else { 0.0 };
                zero[1][lane] -= if near { y } else { 0.0 };
            }
        }
        zero
    }

    /// The mirror images at the zeros that lie within their cells and obey the law.
    #[inline(always)] // for the instructions of its caller
    fn images(&self, search: &ReflectorSearch, eye: Vec3, zero: &[Lane; 2], points: &Lane3) -> [Option<Vec3>; LANES] {
        let [position, ..] = between([0, 1, 2, 3].map(|corner: usize| &self.ends[corner].position), zero);
        let [mut normal, ..] = between([0, 1, 2, 3].map(|corner: usize| &self.ends[corner].normal), zero);
        let squared = dot(&normal, &normal);
        for along in &mut normal {
            for (along, squared) in along.iter_mut().zip(squared) {
                *along /= squared.sqrt();
            }
        }
        let mut spot = Ends::<LANES>::default();
        (spot.position, spot.normal, spot.origin) = (position, normal, eye.to_array().map(|along| [along; LANES]));
        let miss = spot.misses(&search.law, points);
        let tilt = dot(&miss, &miss);
        let mut bend = [0.0_f32; LANES];
        for corner in 1..4 {
            let mut turn = self.ends[corner].normal;
            for (turn, first) in turn.iter_mut().zip(&self.ends[0].normal) {
                for (turn, first) in turn.iter_mut().zip(first) {
                    *turn -= first;
                }
            }
            let squared = dot(&turn, &turn);
            for lane in 0..LANES {
                bend[lane] = bend[lane].max(squared[lane]);
            }
        }
        let (mut height, mut front) = ([0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            for axis in 0..3 {
                height[lane] += normal[axis][lane] * (points[axis][lane] - position[axis][lane]);
                front[lane] += normal[axis][lane] * (eye[axis] - position[axis][lane]);
            }
        }
        let behind = self.behind(points);
        let mut images = [None; LANES];
        for (lane, image) in images.iter_mut().enumerate() {
            let inside = (zero[0][lane] - 0.5).abs().max((zero[1][lane] - 0.5).abs()) <= 0.5 + OUTSIDE;
            let allowed = TILT + bend[lane];
            if behind[lane] {
                *image = Some(Vec3::NAN);
            } else if inside && tilt[lane] <= allowed * allowed && front[lane] >= 0.0 {
                let along = |axis: usize| points[axis][lane] - normal[axis][lane] * (2.0 * height[lane]);
                *image = Some(Vec3::new(along(0), along(1), along(2)));
            }
        }
        images
    }

    /// Which points lie far below the tangent planes at the low corners, as the search of one point asks at its start.
    #[inline(always)] // for the instructions of its caller
    fn behind(&self, points: &Lane3) -> [bool; LANES] {
        let mut from = *points;
        for (from, position) in from.iter_mut().zip(&self.ends[0].position) {
            for (from, position) in from.iter_mut().zip(position) {
                *from -= position;
            }
        }
        let (height, squared) = (dot(&self.ends[0].normal, &from), dot(&from, &from));
        let mut behind = [false; LANES];
        for lane in 0..LANES {
            behind[lane] = height[lane] < BEHIND * squared[lane].sqrt();
        }
        behind
    }
}
