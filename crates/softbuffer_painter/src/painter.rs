//! egui's meshes on a buffer of pixels, as its own renderer draws them on a device.

use crate::color::packed;
use crate::fill::{Fill, Ink};
use crate::plane::Plane;
use crate::region::{Pixels, Region, rectangle, snapped};
use crate::textures::{Texture, Textures};
use egui::epaint::{ClippedPrimitive, Mesh, Primitive, Vertex};
use egui::{Rect, TexturesDelta};

/// Draws what egui shows.
///
/// Pixels are words with red, green and blue from the third byte down, as windows without a driver take them. Colours
/// are blended in gamma space, as egui's renderer does on a target that is not sRGB.
#[derive(Debug, Default)]
pub struct Painter {
    textures: Textures,
    /// Memory for a row of texels.
    line: Vec<u32>,
}

impl Painter {
    /// Takes new and changed textures: before [`Self::paint`].
    pub fn update(&mut self, delta: &TexturesDelta) {
        self.textures.update(delta);
    }

    /// Forgets textures: after [`Self::paint`].
    pub fn free(&mut self, delta: &TexturesDelta) {
        self.textures.free(delta);
    }

    /// Draws meshes over black on all pixels, row by row; `scale` is in pixels a point. Callbacks are for devices alone
    /// and draw nothing, as do meshes without their texture.
    pub fn paint(&mut self, pixels: &mut [u32], size: [usize; 2], scale: f32, primitives: &[ClippedPrimitive]) {
        pixels.fill(0);
        for ClippedPrimitive { clip_rect, primitive } in primitives {
            let Primitive::Mesh(mesh) = primitive else { continue };
            let Some(texture) = self.textures.get(mesh.texture_id) else { continue };
            let clip = clipped(*clip_rect, scale, size);
            if clip.is_empty() || texture.size.contains(&0) {
                continue;
            }
            let mut canvas = Canvas { pixels: &mut *pixels, width: size[0], clip, line: &mut self.line };
            draw_mesh(&mut canvas, texture, mesh, scale);
        }
    }
}

/// The pixels of a clip rectangle.
fn clipped(rect: Rect, scale: f32, size: [usize; 2]) -> Pixels {
    let cut = |low: f32, high: f32, length: usize| {
        let [start, end] = [low, high].map(|at| ((at * scale).round().max(0.0) as usize).min(length));
        start..end.max(start)
    };
    Pixels { columns: cut(rect.min.x, rect.max.x, size[0]), rows: cut(rect.min.y, rect.max.y, size[1]) }
}

/// Where shapes are drawn.
struct Canvas<'a> {
    pixels: &'a mut [u32],
    width: usize,
    clip: Pixels,
    line: &'a mut Vec<u32>,
}

/// A corner of a triangle.
#[derive(Clone, Copy)]
struct Corner<'a> {
    place: [f64; 2],
    vertex: &'a Vertex,
}

fn draw_mesh(canvas: &mut Canvas<'_>, texture: &Texture, mesh: &Mesh, scale: f32) {
    let corner = |index: &u32| {
        let vertex = mesh.vertices.get(*index as usize)?;
        Some(Corner { place: snapped([vertex.pos.x * scale, vertex.pos.y * scale])?, vertex })
    };
    let corners = |indices: &[u32]| match indices {
        [a, b, c, ..] => Some([corner(a)?, corner(b)?, corner(c)?]),
        _ => None,
    };
    let mut rest = mesh.indices.as_slice();
    while let Some((first, after)) = rest.split_at_checked(3) {
        rest = after;
        let Some(triangle) = corners(first) else { continue };
        if let Some(other) = corners(after)
            && let Some(ends) = upright(&triangle, &other)
        {
            rest = &after[3..];
            draw_shape(canvas, texture, &Region::Rectangle, ends, &triangle);
            continue;
        }
        let places = triangle.map(|corner| corner.place);
        let ends = [f64::min as fn(f64, f64) -> f64, f64::max]
            .map(|of| [0, 1].map(|axis| of(of(places[0][axis], places[1][axis]), places[2][axis])));
        draw_shape(canvas, texture, &Region::triangle(places), ends, &triangle);
    }
}

/// The ends of the upright rectangle that two triangles make, if texture and colour go on from one to the other.
fn upright(one: &[Corner<'_>; 3], other: &[Corner<'_>; 3]) -> Option<[[f64; 2]; 2]> {
    let color = one[0].vertex.color;
    if one.iter().chain(other).any(|corner| corner.vertex.color != color) {
        return None;
    }
    let [a, b, c] = one.map(|corner| corner.place);
    let [d, e, f] = other.map(|corner| corner.place);
    let ends = rectangle(&[a, b, c, d, e, f])?;
    // On the same side all corners have the same place in the texture.
    let agrees = |one: &Corner<'_>, other: &Corner<'_>| {
        (one.place[0] != other.place[0] || one.vertex.uv.x == other.vertex.uv.x)
            && (one.place[1] != other.place[1] || one.vertex.uv.y == other.vertex.uv.y)
    };
    let is_even = one.iter().all(|corner| other.iter().chain(one).all(|next| agrees(corner, next)));
    is_even.then_some(ends)
}

/// Draws a shape of even colours; `corners` are three of its own.
fn draw_shape(
    canvas: &mut Canvas<'_>,
    texture: &Texture,
    region: &Region,
    ends: [[f64; 2]; 2],
    corners: &[Corner<'_>; 3],
) {
    let bounds = canvas.clip.within(ends);
    if bounds.is_empty() {
        return;
    }
    let places = corners.map(|corner| corner.place);
    let plane = |of: &dyn Fn(&Vertex) -> f64| Plane::through(places, corners.map(|corner| of(corner.vertex)));
    let [width, height] = texture.size.map(|length| length as f64);
    let place = [plane(&|vertex| f64::from(vertex.uv.x) * width), plane(&|vertex| f64::from(vertex.uv.y) * height)];
    let [Some(x), Some(y)] = place else { return };
    let [first, second, third] = corners.map(|corner| packed(corner.vertex.color));
    let ink = if first == second && first == third {
        Ink::Even(first)
    } else {
        let channel = |shift: u32| plane(&|vertex| f64::from((packed(vertex.color) >> shift) & 255));
        match [channel(24), channel(16), channel(8), channel(0)] {
            [Some(alpha), Some(red), Some(green), Some(blue)] => Ink::Blended([alpha, red, green, blue]),
            _ => return,
        }
    };
    let fill = Fill::new(texture, [x, y], ink, &bounds);
    for row in bounds.rows.clone() {
        let columns = region.columns(row, &bounds);
        let line = canvas.pixels.get_mut(row * canvas.width..(row + 1) * canvas.width);
        if let (Some(pixels), false) = (line, columns.is_empty()) {
            fill.draw(pixels, row, columns, canvas.line);
        }
    }
}
