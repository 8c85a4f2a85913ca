//! The colours of a shape's pixels: those of its corners times those of a texture, over what is beneath.

use crate::color::{OPAQUE_CHANNELS, WHITE, alpha, between, over, product};
use crate::plane::Plane;
use crate::region::Pixels;
use crate::textures::{FAR, Texture, before};
use egui::TextureFilter;
use std::ops::Range;

/// Differences of places in a texture, in texels, that do not show: a sixty-fourth is four levels of 255 at most.
const UNSEEN: f64 = 1.0 / 64.0;

/// The colours of a shape's corners.
#[derive(Debug)]
pub(crate) enum Ink {
    /// One colour.
    Even(u32),
    /// Alpha, red, green and blue, from 0 to 255.
    Blended([Plane; 4]),
}

/// How the texture lies on the pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Way {
    /// One texel for all.
    Texel(u32),
    /// A texel a pixel, row by row.
    Copied,
    /// Rows of texels on rows of pixels, nearer or farther apart.
    Stretched,
    Sampled(TextureFilter),
}

/// The filling of a shape.
#[derive(Debug)]
pub(crate) struct Fill<'a> {
    texture: &'a Texture,
    /// The place in the texture, in texels from its corner.
    place: [Plane; 2],
    ink: Ink,
    way: Way,
}

impl<'a> Fill<'a> {
    pub(crate) fn new(texture: &'a Texture, place: [Plane; 2], ink: Ink, bounds: &Pixels) -> Self {
        let way = way(texture, &place, bounds);
        Self { texture, place, ink, way }
    }

    /// Fills pixels of a row; `line` is memory for a row of texels.
    pub(crate) fn draw(&self, target: &mut [u32], row: usize, columns: Range<usize>, line: &mut Vec<u32>) {
        let (start, length) = (columns.start, columns.len());
        let Some(target) = target.get_mut(columns) else { return };
        let place = [self.place[0].at(start, row), self.place[1].at(start, row)];
        let copied = match self.way {
            Way::Texel(texel) => return self.draw_plain(target, start, row, texel),
            Way::Copied => {
                let [left, top] = place.map(|at| at.floor() as usize);
                self.texture.row(top).get(left..left + length)
            }
            Way::Stretched | Way::Sampled(_) => None,
        };
        let texels = match (copied, self.way) {
            (Some(texels), _) => texels,
            (None, Way::Stretched) => {
                self.stretch(place, length, line);
                line
            }
            (None, Way::Sampled(filter)) => {
                self.sample(place, length, filter, line);
                line
            }
            // A copy may reach beyond the texture by what does not show.
            (None, Way::Texel(_) | Way::Copied) => {
                self.sample(place, length, TextureFilter::Nearest, line);
                line
            }
        };
        match &self.ink {
            Ink::Even(WHITE) if self.texture.is_opaque => {
                for (pixel, texel) in target.iter_mut().zip(texels) {
                    *pixel = texel & OPAQUE_CHANNELS;
                }
            }
            Ink::Even(color) => lay(target, texels.iter().map(|texel| product(*texel, *color))),
            Ink::Blended(planes) => {
                lay(target, colors(planes, start, row).zip(texels).map(|(color, texel)| product(color, *texel)));
            }
        }
    }

    /// Fills pixels with one texel.
    fn draw_plain(&self, target: &mut [u32], start: usize, row: usize, texel: u32) {
        match &self.ink {
            Ink::Even(color) => {
                let color = product(*color, texel);
                match alpha(color) {
                    255 => target.fill(color & OPAQUE_CHANNELS),
                    _ if color == 0 => {}
                    _ => target.iter_mut().for_each(|pixel| *pixel = over(color, *pixel)),
                }
            }
            Ink::Blended(planes) if texel == WHITE => lay(target, colors(planes, start, row)),
            Ink::Blended(planes) => lay(target, colors(planes, start, row).map(|color| product(color, texel))),
        }
    }

    /// Writes texels that lie between those of two rows, for pixels that go along these.
    fn stretch(&self, [x, y]: [f64; 2], length: usize, line: &mut Vec<u32>) {
        let (top, share) = before(y);
        let last_row = self.texture.size[1].saturating_sub(1) as i64;
        let [upper, lower] = [top, top + 1].map(|row| self.texture.row(row.clamp(0, last_row) as usize));
        let right = self.place[0].right;
        let last = x + right * length.saturating_sub(1) as f64;
        let (first, end) = (before(x.min(last)).0, before(x.max(last)).0 + 1);
        // The texels of the two rows, mixed, and behind them the pixels.
        line.clear();
        let last_column = self.texture.size[0].saturating_sub(1) as i64;
        line.extend((first..=end).map(|column| {
            let column = column.clamp(0, last_column) as usize;
            match (upper.get(column), lower.get(column)) {
                (Some(upper), Some(lower)) => between(*upper, *lower, share),
                _ => 0,
            }
        }));
        let count = line.len();
        let unit = f64::from(1_u32 << 16);
        let mut at = ((x - 0.5 - first as f64) * unit).round() as i64;
        let step = (right * unit).round() as i64;
        for _ in 0..length {
            let column = ((at >> 16).max(0) as usize).min(count - 1);
            let next = (column + 1).min(count - 1);
            line.push(between(line[column], line[next], ((at >> 8) & 255) as u32));
            at += step;
        }
        line.drain(..count);
    }

    /// Writes texels for pixels, one by one.
    fn sample(&self, [x, y]: [f64; 2], length: usize, filter: TextureFilter, line: &mut Vec<u32>) {
        line.clear();
        let [right, down] = self.place.map(|plane| plane.right);
        let texel = |index: usize| {
            let steps = index as f64;
            self.texture.sample([x + right * steps, y + down * steps], filter)
        };
        line.extend((0..length).map(texel));
    }
}

/// How a texture lies on the pixels of a shape.
fn way(texture: &Texture, [x, y]: &[Plane; 2], bounds: &Pixels) -> Way {
    let [wide, high] = [bounds.columns.len() as f64, bounds.rows.len() as f64];
    let (start, row) = (bounds.columns.start, bounds.rows.start);
    let place = [x.at(start, row), y.at(start, row)];
    let options = texture.options;
    let is_large = [x, y].iter().all(|plane| plane.right.hypot(plane.down) <= 1.0);
    let filter = if is_large { options.magnification } else { options.minification };
    if [x, y].iter().all(|plane| plane.right.abs() * wide + plane.down.abs() * high < UNSEEN) {
        return Way::Texel(texture.sample(place, filter));
    }
    let is_upright = x.down.abs() * high < UNSEEN && y.right.abs() * wide < UNSEEN;
    let is_inside = |at: f64, length: usize| at >= 0.0 && at < length as f64;
    let is_unscaled = (x.right - 1.0).abs() * wide < UNSEEN && (y.down - 1.0).abs() * high < UNSEEN;
    let is_on_texels = place.iter().all(|at| (at - at.floor() - 0.5).abs() < UNSEEN);
    let is_inside = is_inside(place[0], texture.size[0]) && is_inside(place[1], texture.size[1]);
    if is_upright && is_unscaled && is_inside && (is_on_texels || filter == TextureFilter::Nearest) {
        return Way::Copied;
    }
    let ends = [place[0] + x.right * wide, place[1] + y.down * high];
    let is_clamped = options.wrap_mode == egui::TextureWrapMode::ClampToEdge
        || (0..2).all(|axis| {
            place[axis].min(ends[axis]) >= 1.0 && place[axis].max(ends[axis]) <= texture.size[axis] as f64 - 1.0
        });
    // Few texels a pixel, so that no row is longer than it is worth, and places that can be counted.
    let is_near = place.iter().chain(&ends).all(|at| at.abs() < FAR);
    if is_near && is_upright && is_clamped && filter == TextureFilter::Linear && x.right.abs() < 4.0 {
        return Way::Stretched;
    }
    Way::Sampled(filter)
}

/// The colours of a row's pixels from one on.
fn colors(planes: &[Plane; 4], start: usize, row: usize) -> impl Iterator<Item = u32> {
    let mut values = planes.map(|plane| plane.at(start, row) as f32 + 0.5);
    let steps = planes.map(|plane| plane.right as f32);
    std::iter::repeat_with(move || {
        let color = values.iter().fold(0, |color, value| (color << 8) | value.clamp(0.0, 255.0) as u32);
        values.iter_mut().zip(steps).for_each(|(value, step)| *value += step);
        color
    })
}

/// Lays colours over pixels.
fn lay(target: &mut [u32], colors: impl Iterator<Item = u32>) {
    for (pixel, color) in target.iter_mut().zip(colors) {
        if alpha(color) == 255 {
            *pixel = color & OPAQUE_CHANNELS;
        } else if color != 0 {
            *pixel = over(color, *pixel);
        }
    }
}
