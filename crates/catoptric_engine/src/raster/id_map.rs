//! Small pictures of triangle numbers: look-ups of the triangles at a place.

use glam::{Vec2, Vec4};

/// For every texel the numbers of the triangles that hold its centre.
#[derive(Clone, Debug, Default)]
pub struct IdMap {
    width: u32,
    height: u32,
    /// The triangle that was drawn first at each texel.
    first: Vec<u32>,
    /// The link to another triangle at the texel.
    links: Vec<u32>,
    /// Numbers with the link to the next.
    others: Vec<[u32; 2]>,
}

/// Texels without a triangle, and the ends of chains.
const NONE: u32 = u32::MAX;

impl IdMap {
    /// An empty map.
    pub fn new(width: u32, height: u32) -> Self {
        let texels = width as usize * height as usize;
        Self { width, height, first: vec![NONE; texels], links: vec![NONE; texels], others: Vec::new() }
    }

    /// Draws a triangle, given in texels, after those that are there; triangles that are not finite or have no area are
    /// left out. Says whether it holds any texel's centre.
    #[inline(always)] // see `covered`
    pub fn draw(&mut self, id: u32, corners: [Vec2; 3]) -> bool {
        let Self { width, height, first, links, others } = self;
        let mut any = false;
        covered(corners, *width, *height, |x, y| {
            any = true;
            let texel = y as usize * *width as usize + x as usize;
            if first[texel] == NONE {
                first[texel] = id;
            } else {
                let link = others.len() as u32;
                others.push([id, std::mem::replace(&mut links[texel], link)]);
            }
        });
        any
    }

    /// The index of the texel at a place; returns `None` outside the map.
    #[inline]
    fn texel(&self, place: Vec2) -> Option<usize> {
        // Casts saturate: places left of 0 and NaN are sorted out before.
        let inside = place.x >= 0.0 && place.y >= 0.0;
        let (x, y) = (place.x as u32, place.y as u32);
        (inside && x < self.width && y < self.height).then(|| y as usize * self.width as usize + x as usize)
    }

    /// The triangle that was drawn first at a texel, counted row by row; [`u32::MAX`] where there is none.
    #[inline]
    pub fn first_in(&self, texel: usize) -> u32 {
        self.first.get(texel).copied().unwrap_or(NONE)
    }

    /// The triangles at a place, in texels, the one drawn first first; `None` outside the map.
    #[inline]
    pub fn at(&self, place: Vec2) -> impl Iterator<Item = u32> {
        let texel = self.texel(place);
        let first = texel.map_or(NONE, |texel| self.first[texel]);
        let mut link = texel.map_or(NONE, |texel| self.links[texel]);
        let others = std::iter::from_fn(move || {
            let [id, next] = *self.others.get(link as usize)?;
            link = next;
            Some(id)
        });
        (first != NONE).then_some(first).into_iter().chain(others)
    }

    /// Bytes held.
    pub fn byte_count(&self) -> u64 {
        let parts = [size_of_val(self.first.as_slice()), size_of_val(self.links.as_slice())];
        (parts.iter().sum::<usize>() + size_of_val(self.others.as_slice())) as u64
    }
}

/// Calls `emit` for every texel whose centre lies in a triangle or on its border, with the shares of the corners there.
#[inline]
pub fn covered_shares(corners: [Vec2; 3], width: u32, height: u32, mut emit: impl FnMut(u32, u32, [f32; 3])) {
    let [a, b, c] = corners;
    let area = (b - a).perp_dot(c - a);
    covered(corners, width, height, |x, y| {
        let place = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
        let (second, third) = ((place - a).perp_dot(c - a) / area, (b - a).perp_dot(place - a) / area);
        emit(x, y, [1.0 - second - third, second, third]);
    });
}

/// A centre this near to an edge, in texels, is on it: rounding must not let it fall between two triangles.
const ON_EDGE: f32 = 1e-4;

/// Calls `emit` for every texel whose centre lies in a triangle or on its border, row by row.
#[inline(always)] // into loops that are compiled for several instruction sets
pub(crate) fn covered(corners: [Vec2; 3], width: u32, height: u32, mut emit: impl FnMut(u32, u32)) {
    let [a, b, c] = corners;
    let area = (b - a).perp_dot(c - a);
    // NaN ends here too.
    if area == 0.0 || !area.is_finite() || width == 0 || height == 0 {
        return;
    }
    let [b, c] = if area > 0.0 { [b, c] } else { [c, b] };
    let (low, high) = (a.min(b).min(c) - 0.5, a.max(b).max(c) - 0.5);
    let (end_x, end_y) = (high.x + ON_EDGE, high.y + ON_EDGE);
    if end_x < 0.0 || end_y < 0.0 {
        return;
    }
    // The first centre not below, and the last not above; casts round towards 0 and saturate.
    let first = |low: f32| (low as u32).saturating_add(u32::from((low as u32 as f32) < low));
    let (left, top) = (low.x - ON_EDGE, first(low.y - ON_EDGE));
    let (right, bottom) = (end_x.min((width - 1) as f32), (end_y as u32).min(height - 1));
    // The crossings of rows with the three edges; the fourth component is unused.
    let (from_x, from_y) = (Vec4::new(a.x, b.x, c.x, 0.0) - 0.5, Vec4::new(a.y, b.y, c.y, 0.0) - 0.5);
    let (edge_x, edge_y) = (Vec4::new(b.x, c.x, a.x, 0.0) - 0.5 - from_x, Vec4::new(b.y, c.y, a.y, 0.0) - 0.5 - from_y);
    let slope = edge_x / edge_y;
    let leeway = (slope.abs() + 1.0) * ON_EDGE;
    let (enters, leaves) = (edge_y.cmplt(Vec4::ZERO), edge_y.cmpgt(Vec4::ZERO));
    let (from_enter, from_leave) = (from_x - leeway, from_x + leeway);
    for y in top..=bottom {
        let shift = slope * (y as f32 - from_y);
        let enter = Vec4::select(enters, from_enter + shift, Vec4::splat(left)).max_element().max(left);
        let leave = Vec4::select(leaves, from_leave + shift, Vec4::splat(right)).min_element().min(right);
        if leave >= 0.0 {
            for x in first(enter)..=leave as u32 {
                emit(x, y);
            }
        }
    }
}
