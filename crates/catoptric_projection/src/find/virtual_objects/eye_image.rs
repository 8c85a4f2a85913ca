//! A small picture of a reflector from the eye, to find the nearest of its surfaces.

use super::mesh::ReflectorMesh;
use super::piece::{CORNERS, in_front, interpolated};
use catoptric_core::scene::{PicturePoint, View};
use catoptric_engine::raster::id_map::covered_shares;
use glam::{Vec2, Vec3};

/// The margin around the view's picture, as a share of its size, up to which the reflector is drawn: places beyond are
/// not looked up. Chosen, not measured.
const MARGIN_SHARE: f32 = 0.02;

/// A picture of the parts of a reflector that are seen first, larger than it appears by a margin.
#[derive(Clone, Debug)]
pub(crate) struct EyeImage {
    /// The picture's place of the first texel's corner, and texels a pixel.
    low_px: Vec2,
    texels_a_px: Vec2,
    pub(crate) width: u32,
    pub(crate) height: u32,
    /// Texels, row by row: the reciprocal depth (one less the depth where rays are parallel), and the surface seen.
    pub(crate) texels: Vec<EyeTexel>,
}

/// Surface point of a texel; `triangle` is [`NOTHING`] outside the reflector.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EyeTexel {
    nearness: f32,
    pub(crate) triangle: u32,
    /// The weights of its second and third corner.
    pub(crate) weights: Vec2,
}

/// Texels without a triangle.
pub(crate) const NOTHING: u32 = u32::MAX;

impl EyeImage {
    /// Draws a reflector with about `size` texels along its longer side in the picture; returns `None` if it is not
    /// seen.
    pub(crate) fn draw(mesh: &ReflectorMesh, view: &View, size: u32) -> Option<Self> {
        let transform = view.picture_from_world();
        let points: Vec<PicturePoint> = mesh.positions.iter().map(|position| transform.apply(*position)).collect();
        let near = view.near.max(f32::MIN_POSITIVE);
        let perspective = matches!(view.projection, catoptric_core::scene::Projection::Perspective { .. });
        let mut pieces: Vec<(u32, [ImageCorner; 3])> = Vec::with_capacity(mesh.triangles.len());
        for (index, triangle) in mesh.triangles.iter().enumerate() {
            let corners = [0, 1, 2].map(|k| (points[triangle[k] as usize], CORNERS[k]));
            let height = |(point, _): &(PicturePoint, Vec2)| point.depth - near;
            in_front(corners, height, mixed, |corners| {
                pieces.push((index as u32, corners.map(|corner| ImageCorner::new(corner, perspective))));
            });
        }
        // The part of the picture that it covers.
        let size_px = Vec2::new(view.width as f32, view.height as f32);
        let margin = size_px * MARGIN_SHARE;
        let (mut low, mut high) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
        for corner in pieces.iter().flat_map(|(_, corners)| corners) {
            (low, high) = (low.min(corner.place), high.max(corner.place));
        }
        (low, high) = (low.max(-margin), high.min(size_px + margin));
        let extent = high - low;
        // Extents that are not numbers are rejected, too.
        if !(extent.x > 0.0 && extent.y > 0.0) {
            return None;
        }
        // Two texels of nothing around.
        let texels_a_px = (size as f32 - 4.0).max(1.0) / extent.max_element();
        let [width, height] = extent.to_array().map(|extent| ((extent * texels_a_px).ceil() as u32 + 4).clamp(5, size));
        let low_px = low - Vec2::splat(2.0) / texels_a_px;
        let nothing = EyeTexel { nearness: f32::NEG_INFINITY, triangle: NOTHING, weights: Vec2::ZERO };
        let mut texels = vec![nothing; width as usize * height as usize];
        for (triangle, corners) in pieces {
            let places = corners.map(|corner| (corner.place - low_px) * texels_a_px);
            covered_shares(places, width, height, |x, y, shares| {
                // Linear in the picture: the nearness, and weights times it.
                let nearness: f32 = (0..3).map(|k| corners[k].nearness * shares[k]).sum();
                let texel = &mut texels[(y * width + x) as usize];
                if nearness > texel.nearness {
                    let scale: f32 = (0..3).map(|k| corners[k].scale * shares[k]).sum();
                    let weights: Vec2 = (0..3).map(|k| corners[k].weights * (corners[k].scale * shares[k])).sum();
                    *texel = EyeTexel { nearness, triangle, weights: weights / scale };
                }
            });
        }
        Some(Self { low_px, texels_a_px: Vec2::splat(texels_a_px), width, height, texels })
    }

    /// A place of the picture in texels.
    pub(crate) fn texel_of(&self, place_px: Vec2) -> Vec2 {
        (place_px - self.low_px) * self.texels_a_px
    }

    /// True if another part of the reflector hides a point of it; `place_px` is where it is in the picture.
    ///
    /// Within a share of the reflector's size parts are not told from each other.
    pub(crate) fn hides(&self, mesh: &ReflectorMesh, place_px: Vec2, point: Vec3, leeway: f32) -> bool {
        let texel = self.texel_of(place_px);
        let (x, y) = (texel.x.floor() as i64, texel.y.floor() as i64);
        let mut shown = false;
        for (x, y) in [(0, 0), (1, 0), (-1, 0), (0, 1), (0, -1)].map(|(dx, dy)| (x + dx, y + dy)) {
            if x < 0 || y < 0 || x >= i64::from(self.width) || y >= i64::from(self.height) {
                return false;
            }
            let texel = &self.texels[y as usize * self.width as usize + x as usize];
            if texel.triangle == NOTHING {
                return false;
            }
            shown |= texel.position(mesh).distance(point) <= leeway;
        }
        !shown
    }
}

impl EyeTexel {
    /// The position of the surface; not finite without one.
    pub(crate) fn position(&self, mesh: &ReflectorMesh) -> Vec3 {
        let Some(corners) = mesh.triangles.get(self.triangle as usize) else { return Vec3::NAN };
        interpolated(&mesh.positions, *corners, self.weights)
    }
}

/// A corner of a piece in the picture.
#[derive(Clone, Copy, Debug)]
struct ImageCorner {
    place: Vec2,
    nearness: f32,
    /// Factor of weights that makes them linear in the picture.
    scale: f32,
    weights: Vec2,
}

impl ImageCorner {
    fn new((point, weights): (PicturePoint, Vec2), perspective: bool) -> Self {
        let scale = 1.0 / point.w;
        let nearness = if perspective { scale } else { -point.depth };
        Self { place: point.xy * scale, nearness, scale, weights }
    }
}

/// The corner at a share of the way between two.
fn mixed(here: &(PicturePoint, Vec2), next: &(PicturePoint, Vec2), share: f32) -> (PicturePoint, Vec2) {
    let mix = |a: f32, b: f32| a + (b - a) * share;
    let point = PicturePoint {
        xy: here.0.xy.lerp(next.0.xy, share),
        w: mix(here.0.w, next.0.w),
        depth: mix(here.0.depth, next.0.depth),
    };
    (point, here.1.lerp(next.1, share))
}
