//! Triangle set-up from picture points to fixed point: near plane, guard band, snapping, depth plane.

use super::samples::Pattern;
use catoptric_core::scene::{PicturePoint, Projection, View};

/// Fixed point: parts of a pixel.
pub(super) const SUBPIXELS: i32 = 256;

/// Half the width of the square around the picture's centre to which triangles are clipped, in pixels.
///
/// Edge functions of triangles within it fit into 32 bits over a block of 8 x 8 pixels (see `kernel`).
const GUARD_BAND_PX: f64 = 16_383.0;

/// The largest width and height of a picture; it must lie well within the guard band.
pub(super) const MAX_PICTURE_PX: u32 = 16_384;

/// Constants of a picture, the same for all its triangles.
#[derive(Clone, Debug)]
pub struct PictureSetup {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) pattern: Pattern,
    perspective: bool,
    near: f64,
}

impl PictureSetup {
    /// The constants of the pictures of a view.
    pub fn new(view: &View, pattern: Pattern) -> Self {
        let near = if view.near.is_finite() { view.near.max(f32::MIN_POSITIVE) } else { f32::MIN_POSITIVE };
        Self {
            width: view.width,
            height: view.height,
            pattern,
            perspective: matches!(view.projection, Projection::Perspective { .. }),
            near: near as f64,
        }
    }

    /// The pixel at whose corner fixed-point coordinates are 0.
    #[inline]
    pub(super) fn center(&self) -> [i32; 2] {
        [(self.width / 2) as i32, (self.height / 2) as i32]
    }
}

/// A triangle (or a piece of a clipped one), ready to be drawn.
#[derive(Clone, Copy, Debug)]
pub struct SetupTriangle {
    /// Corners in fixed point from the centre of the picture; the inside is on the positive side of every edge.
    pub(super) corners: [[i32; 2]; 3],
    /// The number of the triangle in the picture, over all lists.
    pub(super) id: u32,
    /// True if the shader tests its presence at every sample.
    pub(super) alpha_tested: bool,
    /// The key's plane: its change a pixel along x and y, and its value at the centre of the picture.
    pub(super) key_plane: [f64; 3],
    /// The key's range over the triangle.
    pub(super) key_range: [f32; 2],
    /// First and last pixel column and row that may have a covered sample, within the picture.
    pub(super) columns: [u16; 2],
    /// The same for rows.
    pub(super) rows: [u16; 2],
}

/// A homogeneous point from the picture's centre, in double precision.
#[derive(Clone, Copy, Debug)]
struct SetupPoint {
    x: f64,
    y: f64,
    w: f64,
    /// The key times w, which is linear in space.
    key_w: f64,
    /// Distance behind the near plane.
    beyond_near: f64,
    /// The list's own clip distance.
    clip_distance: f64,
}

impl SetupPoint {
    #[inline]
    fn new(frame: &PictureSetup, point: &PicturePoint, clip_distance: f32) -> Self {
        let [cx, cy] = frame.center();
        let w = point.w as f64;
        let (key_w, depth) = if frame.perspective { (1.0, w) } else { (-(point.depth as f64) * w, point.depth as f64) };
        Self {
            x: point.xy.x as f64 - cx as f64 * w,
            y: point.xy.y as f64 - cy as f64 * w,
            w,
            key_w,
            beyond_near: depth - frame.near,
            clip_distance: clip_distance as f64,
        }
    }

    /// The point of the segment from `inside` to `outside` where the distances (of opposite sign) vanish.
    ///
    /// Always called from the inner end, so that two triangles with a common edge get the same point.
    fn between(inside: &Self, outside: &Self, inner_distance: f64, outer_distance: f64) -> Self {
        let t = inner_distance / (inner_distance - outer_distance);
        let mix = |a: f64, b: f64| a + (b - a) * t;
        Self {
            x: mix(inside.x, outside.x),
            y: mix(inside.y, outside.y),
            w: mix(inside.w, outside.w),
            key_w: mix(inside.key_w, outside.key_w),
            beyond_near: mix(inside.beyond_near, outside.beyond_near),
            clip_distance: mix(inside.clip_distance, outside.clip_distance),
        }
    }

    /// Distances inside the four sides of the guard band; positive inside.
    fn guard_distances(&self) -> [f64; 4] {
        let limit = GUARD_BAND_PX * self.w;
        [limit - self.x, limit + self.x, limit - self.y, limit + self.y]
    }

    /// Moves the point onto a side of the guard band; the sides are in the order of the distances.
    fn set_on_guard(&mut self, side: usize) {
        let limit = GUARD_BAND_PX * self.w;
        let limit = if side & 1 == 0 { limit } else { -limit };
        if side < 2 { self.x = limit } else { self.y = limit }
    }
}

/// The result of setting up a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SetupOutcome {
    /// Nothing of it is in the picture, or it is degenerate or not finite.
    Culled,
    /// The triangle was drawn whole.
    Whole,
    /// The triangle crosses the near plane or the guard band.
    Clipped,
}

/// Makes the triangles to be drawn for one triangle and hands them to `emit`.
#[inline]
pub fn set_up(
    frame: &PictureSetup,
    points: [&PicturePoint; 3],
    clip_distances: [f32; 3],
    id: u32,
    alpha_tested: bool,
    mut emit: impl FnMut(SetupTriangle),
) -> SetupOutcome {
    let finite = |p: &PicturePoint| p.xy.is_finite() && p.w.is_finite() && p.depth.is_finite();
    if !points.iter().all(|p| finite(p)) || !clip_distances.iter().all(|d| d.is_finite()) {
        return SetupOutcome::Culled;
    }
    let points: [SetupPoint; 3] = std::array::from_fn(|i| SetupPoint::new(frame, points[i], clip_distances[i]));
    let piece = |corners: [&SetupPoint; 3]| finish(frame, corners, &points, id, alpha_tested);
    let whole = |p: &SetupPoint| {
        p.beyond_near >= 0.0 && p.clip_distance >= 0.0 && p.w > 0.0 && p.guard_distances().iter().all(|d| *d >= 0.0)
    };
    if points.iter().all(whole) {
        return match piece([&points[0], &points[1], &points[2]]) {
            Some(triangle) => {
                emit(triangle);
                SetupOutcome::Whole
            }
            None => SetupOutcome::Culled,
        };
    }
    let mut polygon = Polygon::new(&points);
    polygon.clip(|p| p.beyond_near, |_| {});
    polygon.clip(|p| p.clip_distance, |_| {});
    // Orthographic points have w = 1; other points behind the eye are cut off before the division.
    if polygon.points().iter().any(|p| p.w <= 0.0) {
        return SetupOutcome::Culled;
    }
    for side in 0..4 {
        polygon.clip(|p| p.guard_distances()[side], |p| p.set_on_guard(side));
    }
    let corners = polygon.points();
    let mut outcome = SetupOutcome::Culled;
    for index in 2..corners.len() {
        if let Some(triangle) = piece([&corners[0], &corners[index - 1], &corners[index]]) {
            emit(triangle);
            outcome = SetupOutcome::Clipped;
        }
    }
    outcome
}

/// A convex polygon; clipping a triangle by six planes gives at most nine corners.
struct Polygon {
    points: [SetupPoint; 9],
    len: usize,
}

impl Polygon {
    fn new(corners: &[SetupPoint; 3]) -> Self {
        let mut points = [corners[0]; 9];
        points[..3].copy_from_slice(corners);
        Self { points, len: 3 }
    }

    fn points(&self) -> &[SetupPoint] {
        &self.points[..self.len]
    }

    /// Keeps the part where `distance` is not negative (Sutherland and Hodgman 1974). `settle` moves new points onto
    /// the border, from where rounding has left them.
    fn clip(&mut self, distance: impl Fn(&SetupPoint) -> f64, settle: impl Fn(&mut SetupPoint)) {
        let old = self.points;
        let old = &old[..self.len];
        self.len = 0;
        for (index, current) in old.iter().enumerate() {
            let next = &old[(index + 1) % old.len()];
            let (here, there) = (distance(current), distance(next));
            if here >= 0.0 {
                self.push(*current);
            }
            if (here >= 0.0) != (there >= 0.0) {
                let mut point = match here >= 0.0 {
                    true => SetupPoint::between(current, next, here, there),
                    false => SetupPoint::between(next, current, there, here),
                };
                settle(&mut point);
                self.push(point);
            }
        }
    }

    fn push(&mut self, point: SetupPoint) {
        // Rounding can make a polygon not quite convex; corners beyond the possible nine are then of no size.
        if self.len < self.points.len() {
            self.points[self.len] = point;
            self.len += 1;
        }
    }
}

#[inline]
fn finish(
    frame: &PictureSetup,
    corners: [&SetupPoint; 3],
    original: &[SetupPoint; 3],
    id: u32,
    alpha_tested: bool,
) -> Option<SetupTriangle> {
    let inverse = corners.map(|p| 1.0 / p.w);
    let snap = |value: f64| {
        // Corners of triangles of astronomical size may miss the guard band by rounding.
        let scaled = value.clamp(-GUARD_BAND_PX, GUARD_BAND_PX) * SUBPIXELS as f64;
        (scaled + 0.5f64.copysign(scaled)) as i32
    };
    let mut snapped: [[i32; 2]; 3] =
        std::array::from_fn(|i| [snap(corners[i].x * inverse[i]), snap(corners[i].y * inverse[i])]);
    let [a, b, c] = snapped.map(|p| p.map(i64::from));
    let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    if area == 0 {
        return None;
    }
    if area < 0 {
        snapped.swap(1, 2);
    }
    let center = frame.center();
    let range = |axis: usize, extent: [i32; 2], size: u32| -> Option<[u16; 2]> {
        let values = snapped.map(|p| p[axis]);
        let low = values[0].min(values[1]).min(values[2]);
        let high = values[0].max(values[1]).max(values[2]);
        let unit = SUBPIXELS / 16;
        // The first pixel whose last sample, and the last pixel whose first sample, lies within the triangle's extent.
        let first = (low - extent[1] * unit + SUBPIXELS - 1).div_euclid(SUBPIXELS) + center[axis];
        let last = (high - extent[0] * unit).div_euclid(SUBPIXELS) + center[axis];
        let (first, last) = (first.max(0), last.min(size as i32 - 1));
        (first <= last).then_some([first as u16, last as u16])
    };
    let columns = range(0, frame.pattern.extent_x, frame.width)?;
    let rows = range(1, frame.pattern.extent_y, frame.height)?;
    let keys: [f32; 3] = std::array::from_fn(|i| (corners[i].key_w * inverse[i]) as f32);
    let key_range = [keys[0].min(keys[1]).min(keys[2]), keys[0].max(keys[1]).max(keys[2])];
    // A triangle seen exactly edge-on has no plane; the key is then that of its nearest corner.
    let key_plane = key_plane(original).unwrap_or([0.0, 0.0, key_range[1] as f64]);
    Some(SetupTriangle { corners: snapped, id, alpha_tested, key_plane, key_range, columns, rows })
}

/// The coefficients of the key as a linear function of the picture position (Olano and Greer 1997).
fn key_plane(points: &[SetupPoint; 3]) -> Option<[f64; 3]> {
    let cross = |p: &SetupPoint, q: &SetupPoint| [p.y * q.w - p.w * q.y, p.w * q.x - p.x * q.w, p.x * q.y - p.y * q.x];
    let [a, b, c] = points;
    let rows = [cross(b, c), cross(c, a), cross(a, b)];
    let determinant = a.x * rows[0][0] + a.y * rows[0][1] + a.w * rows[0][2];
    let inverse = 1.0 / determinant;
    let plane: [f64; 3] =
        std::array::from_fn(|i| (a.key_w * rows[0][i] + b.key_w * rows[1][i] + c.key_w * rows[2][i]) * inverse);
    // Steeper planes cannot be stepped in single precision, and no triangle of any width has one.
    plane.iter().all(|value| value.abs() < 1e30).then_some(plane)
}
