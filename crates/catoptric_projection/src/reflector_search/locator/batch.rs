//! Many points on a reflector that shows no point twice: eight of them side by side.

use super::cell::{Ends, FAR, STEPS};
use super::starts::Starts;
use super::{BEHIND, OUTSIDE, ReflectorSearch, TILT};
use crate::find::virtual_objects::{ReflectionPoint, Reflector};
use crate::reflector_search::image::ImagePlace;
use catoptric_core::math::lanes::{LANES, Lanes, Vec3Lanes};
use glam::{Vec2, Vec3};

/// Points that are not in their cell after this many are searched one by one. A bound on time; chosen, not measured.
const MAX_CELLS: u32 = 3;

impl ReflectorSearch {
    /// The mirror images of `points` in the tangent planes where they appear; not finite where they do not.
    ///
    /// Every image depends on its own point alone, not on the number or order of points.
    pub fn mirror_images(&self, reflector: &Reflector<'_>, points: &[Vec3], images: &mut [Vec3]) {
        let mut one = Vec::new();
        for (points, images) in points.chunks(LANES).zip(images.chunks_mut(LANES)) {
            let mut eight = [points[0]; LANES];
            eight[..points.len()].copy_from_slice(points);
            let found = match (&self.starts, self.source.eye) {
                (Some(starts), Some(eye)) => in_whole_cells(self, starts, eye, eight),
                _ => [None; LANES],
            };
            for (image, (point, found)) in images.iter_mut().zip(points.iter().zip(found)) {
                *image = found.unwrap_or_else(|| self.mirror_image(reflector, *point, &mut one));
            }
        }
    }

    /// The mirror image of a point where it appears first, not finite if it does not; `found` is scratch space.
    #[cold]
    fn mirror_image(&self, reflector: &Reflector<'_>, point: Vec3, found: &mut Vec<ReflectionPoint>) -> Vec3 {
        found.clear();
        self.locate_point(reflector, point, found);
        let mirrored =
            |first: &ReflectionPoint| point - first.normal * (2.0 * first.normal.dot(point - first.position));
        found.first().map_or(Vec3::NAN, mirrored)
    }
}

/// The four corners of a cell for each point.
struct CellCorners {
    ends: [Ends<LANES>; 4],
    misses: [Vec3Lanes; 4],
}

/// Bilinear values between the corners, and their changes to the right and down.
#[inline(always)] // for the instructions of its caller
fn between<const COUNT: usize>(values: [&[Lanes; COUNT]; 4], at: &[Lanes; 2]) -> [[Lanes; COUNT]; 3] {
    let mut all = [[Lanes::ZERO; COUNT]; 3];
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

/// The images of those points whose search ends within a whole cell after few steps, on the side of it that is seen;
/// not finite for those that lie far behind the reflector.
#[multiversion::multiversion(targets("x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"))]
fn in_whole_cells(search: &ReflectorSearch, starts: &Starts, eye: Vec3, eight: [Vec3; LANES]) -> [Option<Vec3>; LANES] {
    let points = Vec3Lanes::new(&eight);
    let mut places = eight.map(|point| search.begun(&starts.start(eye, point)));
    let mut corners = search.cells_at(&places, eye, &points);
    let mut zero = corners.zero();
    for _ in 1..MAX_CELLS {
        let mut moved = false;
        for lane in 0..LANES {
            let (x, y) = (zero[0][lane] - 0.5, zero[1][lane] - 0.5);
            if x.abs().max(y.abs()) <= 0.5 + OUTSIDE {
                continue;
            }
            let place = &mut places[lane];
            let next =
                search.image.settled(ImagePlace { face: place.face, at: place.at.floor() + 0.5 + Vec2::new(x, y) });
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
    fn cells_at(&self, places: &[ImagePlace; LANES], eye: Vec3, points: &Vec3Lanes) -> CellCorners {
        let mut ends: [Ends<LANES>; 4] = Default::default();
        let side = self.law.side;
        for (lane, place) in places.iter().enumerate() {
            let (x, y) = self.image.cell_at(place);
            let texels = self.image.corners(self.image.index(place.face, x, y));
            for (end, texel) in ends.iter_mut().zip(texels) {
                end.set(lane, &self.image.texels[texel], side, eye);
            }
        }
        let mut misses = [Vec3Lanes::ZERO; 4];
        for (miss, end) in misses.iter_mut().zip(&ends) {
            *miss = end.misses(&self.law, points);
        }
        CellCorners { ends, misses }
    }
}

impl CellCorners {
    /// The point where the misses are zero along the surface, from the low corners; it may lie outside, or not be a
    /// number.
    #[inline(always)] // for the instructions of its caller
    fn zero(&self) -> [Lanes; 2] {
        let [a, b, c, d] = [0, 1, 2, 3].map(|corner: usize| &self.ends[corner].position);
        let (mut right, mut down) = (Vec3Lanes::ZERO, Vec3Lanes::ZERO);
        for axis in 0..3 {
            for lane in 0..LANES {
                right[axis][lane] = b[axis][lane] - a[axis][lane] + d[axis][lane] - c[axis][lane];
                down[axis][lane] = c[axis][lane] - a[axis][lane] + d[axis][lane] - b[axis][lane];
            }
        }
        let forms = [0, 1, 2, 3].map(|corner: usize| [self.misses[corner].dot(&right), self.misses[corner].dot(&down)]);
        let mut zero = [Lanes::splat(0.5); 2];
        for _ in 0..STEPS {
            let [value, to_right, to_down] = between([&forms[0], &forms[1], &forms[2], &forms[3]], &zero);
            for lane in 0..LANES {
                let scale = 1.0 / (to_right[0][lane] * to_down[1][lane] - to_right[1][lane] * to_down[0][lane]);
                let x = (to_down[1][lane] * value[0][lane] - to_down[0][lane] * value[1][lane]) * scale;
                let y = (to_right[0][lane] * value[1][lane] - to_right[1][lane] * value[0][lane]) * scale;
                // Further out the bilinear form bends to nonsense: the first step has the direction.
                let near = (zero[0][lane] - 0.5).abs().max((zero[1][lane] - 0.5).abs()) <= FAR;
                zero[0][lane] -= if near { x } else { 0.0 };
                zero[1][lane] -= if near { y } else { 0.0 };
            }
        }
        zero
    }

    /// The mirror images at the zeros that lie within their cells and obey the law.
    #[inline(always)] // for the instructions of its caller
    fn images(
        &self,
        search: &ReflectorSearch,
        eye: Vec3,
        zero: &[Lanes; 2],
        points: &Vec3Lanes,
    ) -> [Option<Vec3>; LANES] {
        let [position, ..] = between([0, 1, 2, 3].map(|corner: usize| &*self.ends[corner].position), zero);
        let [normal, ..] = between([0, 1, 2, 3].map(|corner: usize| &*self.ends[corner].normal), zero);
        let (position, mut normal) = (Vec3Lanes(position), Vec3Lanes(normal));
        let squared = normal.dot(&normal);
        for along in normal.iter_mut() {
            for lane in 0..LANES {
                along[lane] /= squared[lane].sqrt();
            }
        }
        let spot = Ends { position, normal, origin: Vec3Lanes::splat(eye) };
        let miss = spot.misses(&search.law, points);
        let tilt = miss.dot(&miss);
        let mut bend = [0.0_f32; LANES];
        for corner in 1..4 {
            let turn = self.ends[corner].normal - self.ends[0].normal;
            let squared = turn.dot(&turn);
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

    /// Marks points far below the tangent planes at the low corners: the same test as at the start of the search of one
    /// point.
    #[inline(always)] // for the instructions of its caller
    fn behind(&self, points: &Vec3Lanes) -> [bool; LANES] {
        let from = *points - self.ends[0].position;
        let (height, squared) = (self.ends[0].normal.dot(&from), from.dot(&from));
        let mut behind = [false; LANES];
        for lane in 0..LANES {
            behind[lane] = height[lane] < BEHIND * squared[lane].sqrt();
        }
        behind
    }
}
