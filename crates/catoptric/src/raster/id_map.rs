//! Small pictures of triangle numbers, for look-ups rather than for eyes: which triangles lie at a place?

use glam::Vec2;

/// For every texel the numbers of the triangles that hold its centre, in increasing order.
#[derive(Clone, Debug, Default)]
pub(crate) struct IdMap {
    width: u32,
    height: u32,
    /// Where each texel's numbers start; one more than there are texels.
    starts: Vec<u32>,
    ids: Vec<u32>,
}

impl IdMap {
    /// Draws triangles, given in texels; what is not finite or has no area is left out.
    pub(crate) fn draw(width: u32, height: u32, triangles: impl ExactSizeIterator<Item = [Vec2; 3]>) -> Self {
        let texels = width as usize * height as usize;
        let mut pairs: Vec<(u32, u32)> = Vec::with_capacity(texels + 2 * triangles.len());
        let mut starts = vec![0; texels + 1];
        for (id, corners) in triangles.enumerate() {
            covered(corners, width, height, |x, y| {
                let texel = y * width + x;
                starts[texel as usize + 1] += 1;
                pairs.push((texel, id as u32));
            });
        }
        for texel in 0..texels {
            starts[texel + 1] += starts[texel];
        }
        // Pairs come in the order of their numbers; `ends` counts up to where the next texel starts.
        let mut ends = starts.clone();
        let mut ids = vec![0; pairs.len()];
        for (texel, id) in pairs {
            let end = &mut ends[texel as usize];
            ids[*end as usize] = id;
            *end += 1;
        }
        Self { width, height, starts, ids }
    }

    /// The triangles at a place, in texels; none outside the map.
    #[inline]
    pub(crate) fn at(&self, place: Vec2) -> &[u32] {
        // Casts saturate: what is left of 0 or not a number must be told before.
        let inside = place.x >= 0.0 && place.y >= 0.0;
        let (x, y) = (place.x as u32, place.y as u32);
        if !inside || x >= self.width || y >= self.height {
            return &[];
        }
        let texel = y as usize * self.width as usize + x as usize;
        &self.ids[self.starts[texel] as usize..self.starts[texel + 1] as usize]
    }

    /// Bytes held.
    pub(crate) fn byte_count(&self) -> u64 {
        (size_of_val(self.starts.as_slice()) + size_of_val(self.ids.as_slice())) as u64
    }
}

/// Calls `emit` for every texel whose centre lies in a triangle or on its border, with the shares of the corners there.
#[inline]
pub(crate) fn covered_shares(corners: [Vec2; 3], width: u32, height: u32, mut emit: impl FnMut(u32, u32, [f32; 3])) {
    let [a, b, c] = corners;
    let area = (b - a).perp_dot(c - a);
    covered(corners, width, height, |x, y| {
        let place = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
        let (second, third) = ((place - a).perp_dot(c - a) / area, (b - a).perp_dot(place - a) / area);
        emit(x, y, [1.0 - second - third, second, third]);
    });
}

/// Calls `emit` for every texel whose centre lies in a triangle or on its border.
#[inline]
pub(crate) fn covered(corners: [Vec2; 3], width: u32, height: u32, mut emit: impl FnMut(u32, u32)) {
    let [a, b, c] = corners;
    let area = (b - a).perp_dot(c - a);
    // Also what is not a number.
    if area == 0.0 || !area.is_finite() {
        return;
    }
    let [b, c] = if area > 0.0 { [b, c] } else { [c, b] };
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    // The first centre not below, and the last not above.
    let first = |low: f32| (low - 0.5).ceil().max(0.0) as u32;
    let last = |high: f32, size: u32| (high - 0.5).floor().min(size as f32 - 1.0);
    let (right, bottom) = (last(high.x, width), last(high.y, height));
    if right < 0.0 || bottom < 0.0 {
        return;
    }
    let edges = [(a, b - a), (b, c - b), (c, a - c)];
    let holds = |x: u32, y: u32| {
        let centre = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
        edges.iter().all(|(from, edge)| edge.perp_dot(centre - *from) >= 0.0)
    };
    let left = first(low.x);
    for y in first(low.y)..=bottom as u32 {
        // About where the row enters and leaves; the test itself says exactly.
        let (mut enter, mut leave) = (left as f32, right);
        let row = y as f32 + 0.5;
        for (from, edge) in edges {
            let crossing = from.x + edge.x * (row - from.y) / edge.y - 0.5;
            if edge.y < 0.0 {
                enter = enter.max(crossing - 1.0);
            } else if edge.y > 0.0 {
                leave = leave.min(crossing + 1.0);
            }
        }
        let (mut enter, leave) = (enter.ceil() as u32, leave.floor());
        if leave < enter as f32 {
            continue;
        }
        let mut leave = leave as u32;
        while enter <= leave && !holds(enter, y) {
            enter += 1;
        }
        while leave > enter && !holds(leave, y) {
            leave -= 1;
        }
        for x in enter..=leave {
            emit(x, y);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Stream;

    #[test]
    fn every_centre_of_a_triangulated_square_has_a_triangle_that_holds_it() {
        let mut random = Stream::new(5);
        let (width, height) = (37, 23);
        // A fan about a point within: its triangles cover the map, inner edges twice.
        let centre = Vec2::new(13.3, 9.1);
        let size = Vec2::new(width as f32, height as f32);
        let rim: Vec<Vec2> = (0..40)
            .map(|k| {
                Vec2::from_angle(std::f32::consts::TAU * (k as f32 + random.next_unit() * 0.5) / 40.0) * 60.0 + centre
            })
            .collect();
        let triangles: Vec<[Vec2; 3]> = (0..rim.len()).map(|k| [centre, rim[k], rim[(k + 1) % rim.len()]]).collect();
        let map = IdMap::draw(width, height, triangles.iter().copied());
        for y in 0..height {
            for x in 0..width {
                let place = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
                let holds = |[a, b, c]: [Vec2; 3]| {
                    let sides = [(b - a).perp_dot(place - a), (c - b).perp_dot(place - b), (a - c).perp_dot(place - c)];
                    sides.iter().all(|side| *side >= 0.0)
                };
                let wanted: Vec<u32> = (0..triangles.len() as u32).filter(|k| holds(triangles[*k as usize])).collect();
                assert!(!wanted.is_empty() && map.at(place) == wanted, "{place}: {:?}, not {wanted:?}", map.at(place));
            }
        }
        for outside in [-Vec2::X, -Vec2::Y, Vec2::X * 1e9, size, Vec2::NAN, Vec2::splat(f32::NEG_INFINITY)] {
            assert!(map.at(outside).is_empty());
        }
    }

    #[test]
    fn triangles_without_area_and_broken_ones_cover_nothing() {
        let broken = [
            [Vec2::ONE; 3],
            [Vec2::ZERO, Vec2::X * 4.0, Vec2::X * 8.0],
            [Vec2::NAN, Vec2::X, Vec2::Y],
            [Vec2::splat(f32::INFINITY), Vec2::X, Vec2::Y],
            [Vec2::splat(-9.0), Vec2::splat(-3.0), Vec2::new(-9.0, -3.0)],
        ];
        let map = IdMap::draw(8, 8, broken.into_iter());
        assert!(map.ids.is_empty());
    }
}
