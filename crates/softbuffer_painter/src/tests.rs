use crate::Painter;
use crate::color::{WHITE, between, over, packed, product};
use egui::epaint::{ClippedPrimitive, ImageDelta, Mesh, Primitive, Vertex};
use egui::{Color32, ColorImage, Pos2, Rect, TextureId, TextureOptions, TexturesDelta, pos2};
use proptest::prelude::*;

const SIZE: [usize; 2] = [40, 30];

/// A painter with a white texture of one texel, and other pictures.
fn painter(pictures: &[(u64, ColorImage, TextureOptions)]) -> Painter {
    let mut painter = Painter::default();
    let mut delta = TexturesDelta::default();
    let white = ColorImage::filled([1, 1], Color32::WHITE);
    delta.push(TextureId::Managed(0), ImageDelta::full(white, TextureOptions::LINEAR));
    for (id, picture, options) in pictures {
        delta.push(TextureId::Managed(*id), ImageDelta::full(picture.clone(), *options));
    }
    painter.update(&delta);
    delta.clear();
    painter
}

fn shown(painter: &mut Painter, clip: Rect, mesh: Mesh) -> Vec<u32> {
    let mut pixels = vec![0x0012_3456; SIZE[0] * SIZE[1]];
    let primitive = ClippedPrimitive { clip_rect: clip, primitive: Primitive::Mesh(mesh) };
    painter.paint(&mut pixels, SIZE, 1.0, &[primitive]);
    pixels
}

fn corner(x: f32, y: f32, color: Color32) -> Vertex {
    Vertex { pos: pos2(x, y), uv: Pos2::ZERO, color }
}

/// Triangles of plain corners.
fn plain(corners: &[Vertex]) -> Mesh {
    Mesh { indices: (0..corners.len() as u32).collect(), vertices: corners.to_vec(), texture_id: TextureId::default() }
}

/// A picture on a rectangle.
fn pictured(id: u64, rect: Rect, part: Rect) -> Mesh {
    let mut mesh = Mesh::with_texture(TextureId::Managed(id));
    mesh.add_rect_with_uv(rect, part, Color32::WHITE);
    mesh
}

const EVERYTHING: Rect = Rect { min: Pos2::ZERO, max: pos2(40.0, 30.0) };
const WHOLE: Rect = Rect { min: Pos2::ZERO, max: pos2(1.0, 1.0) };

/// A half of white: covered once it shows 128, covered twice more.
const VEIL: Color32 = Color32::from_rgba_premultiplied(128, 128, 128, 128);
const ONCE: u32 = 0x0080_8080;

/// A picture of which no two texels are alike.
fn motley(size: [usize; 2]) -> ColorImage {
    let texel = |index: usize| {
        let [x, y] = [index % size[0], index / size[0]];
        Color32::from_rgb((7 * x + 11) as u8, (9 * y + 5) as u8, (x * y + 40) as u8)
    };
    ColorImage::new(size, (0..size[0] * size[1]).map(texel).collect())
}

#[test]
fn two_triangles_of_a_square_cover_each_pixel_once() {
    // An upright square, and the same with another color at a corner, which is drawn as two triangles.
    for last in [VEIL, Color32::from_rgba_premultiplied(128, 128, 127, 128)] {
        let [a, b, c] = [corner(3.0, 4.0, VEIL), corner(23.0, 4.0, VEIL), corner(3.0, 17.5, VEIL)];
        let d = corner(23.0, 17.5, last);
        let pixels = shown(&mut painter(&[]), EVERYTHING, plain(&[a, b, c, c, b, d]));
        for (index, pixel) in pixels.iter().enumerate() {
            let (x, y) = (index % SIZE[0], index / SIZE[0]);
            // The lower edge goes through the middles of row 17: these lie beyond.
            let is_inside = (3..23).contains(&x) && (4..17).contains(&y);
            let blue = if is_inside { 0x7f..=0x80 } else { 0..=0 };
            assert!(blue.contains(&(pixel & 255)), "{x} {y}: {pixel:x}");
            assert_eq!(pixel >> 8, if is_inside { ONCE >> 8 } else { 0 }, "{x} {y}");
        }
    }
}

proptest! {
    /// Triangles about a point share all their edges but the outer ones: within, each pixel is covered once.
    #[test]
    fn fans_cover_each_pixel_once(
        middle in (10.0_f32..30.0, 8.0_f32..22.0),
        radii in prop::collection::vec(1.0_f32..60.0, 5..12),
        on_grid in any::<bool>(),
    ) {
        let snap = |at: f32| if on_grid { at.round() + 0.5 } else { at };
        let count = radii.len();
        let outer: Vec<Vertex> = radii.iter().enumerate().map(|(index, radius)| {
            let (sine, cosine) = (index as f32 / count as f32 * std::f32::consts::TAU).sin_cos();
            corner(snap(middle.0 + radius * cosine), snap(middle.1 + radius * sine), VEIL)
        }).collect();
        let centre = corner(snap(middle.0), snap(middle.1), VEIL);
        // On the grid short radii may turn back, so that triangles do lie on each other.
        let turn = |index: usize| {
            let [one, next] = [outer[index].pos - centre.pos, outer[(index + 1) % count].pos - centre.pos];
            one.x * next.y - one.y * next.x
        };
        prop_assume!((0..count).all(|index| turn(index) >= 0.0));
        let corners: Vec<Vertex> =
            (0..count).flat_map(|index| [centre, outer[index], outer[(index + 1) % count]]).collect();
        let mut painter = painter(&[]);
        let pixels = shown(&mut painter, EVERYTHING, plain(&corners));
        prop_assert!(pixels.iter().all(|pixel| [0, ONCE].contains(pixel)), "a pixel is covered twice");
        // A pixel that the triangles cover without a doubt is covered.
        let inside = |x: f32, y: f32| (0..count).any(|index| {
            let ends = [centre, outer[index], outer[(index + 1) % count]].map(|corner| corner.pos);
            let side = |a: Pos2, b: Pos2| (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
            let sides = [side(ends[0], ends[1]), side(ends[1], ends[2]), side(ends[2], ends[0])];
            sides.iter().all(|side| *side > -0.01)
        });
        let far = |x: f32, y: f32| (0..count).all(|index| {
            let [a, b] = [outer[index].pos, outer[(index + 1) % count].pos];
            ((b - a).normalized().rot90().dot(pos2(x, y) - a)).abs() > 0.02
        });
        for (index, pixel) in pixels.iter().enumerate() {
            let (x, y) = ((index % SIZE[0]) as f32 + 0.5, (index / SIZE[0]) as f32 + 0.5);
            if far(x, y) {
                prop_assert_eq!(*pixel == ONCE, inside(x, y), "{} {}", x, y);
            }
        }
    }

    /// Colours against their formulas in real numbers.
    #[test]
    fn colors_are_rounded(one in any::<[u8; 4]>(), other in any::<[u8; 4]>(), share in 0_u32..=256) {
        let [one, other] = [one, other].map(|[r, g, b, a]| Color32::from_rgba_premultiplied(r, g, b, a));
        let channels = |color: u32| color.to_be_bytes().map(f64::from);
        let [from, to] = [channels(packed(one)), channels(packed(other))];
        let mixed = channels(between(packed(one), packed(other), share));
        let multiplied = channels(product(packed(one), packed(other)));
        let laid = channels(over(packed(one), packed(other)));
        for channel in 0..4 {
            let middle = from[channel] + (to[channel] - from[channel]) * f64::from(share) / 256.0;
            prop_assert!((mixed[channel] - middle).abs() <= 0.51);
            prop_assert!((multiplied[channel] - from[channel] * to[channel] / 255.0).abs() <= 0.51);
            let expected = (from[channel] + to[channel] * (255.0 - from[0]) / 255.0).min(255.0);
            let difference = if channel == 0 { laid[0] } else { laid[channel] - expected };
            prop_assert!(difference.abs() <= 0.51);
        }
        prop_assert_eq!(product(WHITE, packed(other)), packed(other));
    }

    /// Nothing that egui may send makes the painter stop.
    #[test]
    fn any_mesh_is_drawn(
        corners in prop::collection::vec((any::<[f32; 2]>(), any::<[f32; 2]>(), any::<[u8; 4]>()), 0..9),
        indices in prop::collection::vec(0_u32..10, 0..20),
        id in 0_u64..3,
        clip in any::<[f32; 4]>(),
        scale in any::<f32>(),
    ) {
        let vertex = |&([x, y], [u, v], [r, g, b, a]): &([f32; 2], [f32; 2], [u8; 4])| Vertex {
            pos: pos2(x, y),
            uv: pos2(u, v),
            color: Color32::from_rgba_premultiplied(r, g, b, a),
        };
        let mesh =
            Mesh { indices, vertices: corners.iter().map(vertex).collect(), texture_id: TextureId::Managed(id) };
        let mut painter = painter(&[(1, motley([5, 4]), TextureOptions::LINEAR_REPEAT)]);
        let mut pixels = vec![0; SIZE[0] * SIZE[1]];
        let clip_rect = Rect::from_min_max(pos2(clip[0], clip[1]), pos2(clip[2], clip[3]));
        let primitive = [ClippedPrimitive { clip_rect, primitive: Primitive::Mesh(mesh.clone()) }];
        painter.paint(&mut pixels, SIZE, scale, &primitive);
        let everywhere = [ClippedPrimitive { clip_rect: Rect::EVERYTHING, primitive: Primitive::Mesh(mesh) }];
        painter.paint(&mut pixels, SIZE, 1.0, &everywhere);
    }
}

#[test]
fn colors_change_evenly_between_the_middles_of_pixels() {
    let color = |level: u8| Color32::from_rgb(level, 255 - level, 7);
    let [a, b, c] = [corner(0.0, 0.0, color(0)), corner(40.0, 0.0, color(240)), corner(0.0, 30.0, color(0))];
    let d = corner(40.0, 30.0, color(240));
    let pixels = shown(&mut painter(&[]), EVERYTHING, plain(&[a, b, c, c, b, d]));
    for (index, pixel) in pixels.iter().enumerate() {
        let level = 6.0 * ((index % SIZE[0]) as f64 + 0.5);
        let [_, red, green, blue] = pixel.to_be_bytes().map(f64::from);
        assert!((red - level).abs() <= 0.51 && (green - (255.0 - level)).abs() <= 0.51, "{index}: {red} {green}");
        assert_eq!(blue, 7.0);
    }
}

#[test]
fn nothing_is_drawn_beyond_the_clip_rectangle() {
    let [a, b, c] = [corner(-50.0, -50.0, VEIL), corner(500.0, -50.0, VEIL), corner(-50.0, 500.0, VEIL)];
    let clip = Rect::from_min_max(pos2(5.4, 6.6), pos2(20.5, 29.0));
    let pixels = shown(&mut painter(&[]), clip, plain(&[a, b, c]));
    for (index, pixel) in pixels.iter().enumerate() {
        // Rounded to whole pixels, as egui's renderer does.
        let is_inside = (5..21).contains(&(index % SIZE[0])) && (7..29).contains(&(index / SIZE[0]));
        assert_eq!(*pixel, if is_inside { ONCE } else { 0 }, "{index}");
    }
}

#[test]
fn pictures_of_the_same_size_are_copied() {
    let picture = motley([12, 9]);
    let rect = Rect::from_min_max(pos2(4.0, 5.0), pos2(16.0, 14.0));
    let mut painter = painter(&[(1, picture.clone(), TextureOptions::LINEAR)]);
    let pixels = shown(&mut painter, EVERYTHING, pictured(1, rect, WHOLE));
    for y in 0..9 {
        for x in 0..12 {
            let expected = packed(picture.pixels[y * 12 + x]) & 0x00ff_ffff;
            assert_eq!(pixels[(y + 5) * SIZE[0] + x + 4], expected, "{x} {y}");
        }
    }
    assert_eq!(pixels[5 * SIZE[0] + 3], 0);
    assert_eq!(pixels[5 * SIZE[0] + 16], 0);
}

/// The mean of the four texels about a place, by the formula.
fn interpolated(picture: &ColorImage, x: f64, y: f64) -> [f64; 3] {
    let [width, height] = picture.size;
    let at = |x: f64, y: f64| {
        let [x, y] = [x.clamp(0.0, width as f64 - 1.0), y.clamp(0.0, height as f64 - 1.0)];
        picture.pixels[y as usize * width + x as usize].to_array().map(f64::from)
    };
    let [x, y] = [x - 0.5, y - 0.5];
    let ([left, top], [right, down]) = ([x.floor(), y.floor()], [x - x.floor(), y - y.floor()]);
    [0, 1, 2].map(|channel| {
        let line = |y: f64| at(left, y)[channel] * (1.0 - right) + at(left + 1.0, y)[channel] * right;
        line(top) * (1.0 - down) + line(top + 1.0) * down
    })
}

fn differs(pixel: u32, expected: [f64; 3]) -> f64 {
    let [_, red, green, blue] = pixel.to_be_bytes().map(f64::from);
    [red, green, blue].iter().zip(expected).map(|(one, other)| (one - other).abs()).fold(0.0, f64::max)
}

#[test]
fn pictures_are_stretched_bilinearly_upright_and_turned() {
    let picture = motley([9, 7]);
    let mut painter =
        painter(&[(1, picture.clone(), TextureOptions::LINEAR), (2, picture.clone(), TextureOptions::NEAREST)]);
    // Upright: 36 pixels of 9 texels, mirrored in height, and beginning between pixels.
    let rect = Rect::from_min_max(pos2(2.25, 1.5), pos2(38.25, 29.5));
    let part = Rect::from_min_max(pos2(0.0, 1.0), pos2(1.0, 0.0));
    let linear = shown(&mut painter, EVERYTHING, pictured(1, rect, part));
    let nearest = shown(&mut painter, EVERYTHING, pictured(2, rect, part));
    // By the same numbers, as triangles of two colours.
    let mut triangles = pictured(1, rect, part);
    triangles.vertices[3].color = Color32::from_rgb(255, 255, 254);
    let sampled = shown(&mut painter, EVERYTHING, triangles);
    for y in 2..29 {
        for x in 3..38 {
            let place = [(x as f64 + 0.5 - 2.25) / 4.0, 7.0 - (y as f64 + 0.5 - 1.5) / 4.0];
            let expected = interpolated(&picture, place[0], place[1]);
            let index = y * SIZE[0] + x;
            assert!(differs(linear[index], expected) <= 1.6, "{x} {y}: {:x} {expected:?}", linear[index]);
            assert!(differs(sampled[index], expected) <= 2.6, "{x} {y}: {:x} {expected:?}", sampled[index]);
            if place.iter().all(|at| (at - at.round()).abs() > 0.01) {
                let texel = picture.pixels[place[1] as usize * 9 + place[0] as usize];
                assert_eq!(nearest[index], packed(texel) & 0x00ff_ffff, "{x} {y}");
            }
        }
    }
    // Turned by a quarter: rows of texels are columns of pixels.
    let mut turned = pictured(1, Rect::from_min_max(pos2(0.0, 0.0), pos2(28.0, 27.0)), WHOLE);
    for (vertex, uv) in turned.vertices.iter_mut().zip([[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]]) {
        vertex.uv = uv.into();
    }
    let pixels = shown(&mut painter, EVERYTHING, turned);
    for y in 0..27 {
        for x in 0..28 {
            let expected = interpolated(&picture, (y as f64 + 0.5) / 3.0, (x as f64 + 0.5) / 4.0);
            assert!(differs(pixels[y * SIZE[0] + x], expected) <= 1.6, "{x} {y}");
        }
    }
}

#[test]
fn wrapped_pictures_repeat() {
    let picture = motley([4, 3]);
    let options = [TextureOptions::NEAREST_REPEAT, TextureOptions::NEAREST_MIRRORED_REPEAT, TextureOptions::NEAREST];
    let wrap: [fn(i64, i64) -> i64; 3] = [
        |at, length| at.rem_euclid(length),
        |at, length| {
            if at.div_euclid(length) % 2 == 0 { at.rem_euclid(length) } else { length - 1 - at.rem_euclid(length) }
        },
        |at, length| at.clamp(0, length - 1),
    ];
    for (options, wrap) in options.into_iter().zip(wrap) {
        let mut painter = painter(&[(1, picture.clone(), options)]);
        let rect = Rect::from_min_max(pos2(0.0, 0.0), pos2(20.0, 15.0));
        let pixels =
            shown(&mut painter, EVERYTHING, pictured(1, rect, Rect::from_min_max(pos2(-2.0, -2.0), pos2(3.0, 3.0))));
        for (x, y) in (0..20).flat_map(|x| (0..15).map(move |y| (x, y))) {
            let [column, row] = [wrap(x - 8, 4), wrap(y - 6, 3)];
            let expected = packed(picture.pixels[(row * 4 + column) as usize]) & 0x00ff_ffff;
            assert_eq!(pixels[y as usize * SIZE[0] + x as usize], expected, "{options:?} {x} {y}");
        }
    }
}

#[test]
fn parts_of_textures_are_replaced_and_textures_freed() {
    let mut picture = motley([12, 9]);
    let mut painter = painter(&[(1, picture.clone(), TextureOptions::NEAREST)]);
    // Opaque before, and then with a hole; the last part lies half beyond the picture.
    let hole = ColorImage::filled([3, 2], Color32::TRANSPARENT);
    let mut delta = TexturesDelta::default();
    delta.push(TextureId::Managed(1), ImageDelta::partial([5, 4], hole, TextureOptions::NEAREST));
    let border = ColorImage::filled([4, 4], Color32::RED);
    delta.push(TextureId::Managed(1), ImageDelta::partial([10, 7], border, TextureOptions::NEAREST));
    painter.update(&delta);
    delta.clear();
    for (y, x) in (0..9).flat_map(|y| (0..12).map(move |x| (y, x))) {
        if (5..8).contains(&x) && (4..6).contains(&y) {
            picture.pixels[y * 12 + x] = Color32::TRANSPARENT;
        } else if x >= 10 && y >= 7 {
            picture.pixels[y * 12 + x] = Color32::RED;
        }
    }
    let rect = Rect::from_min_max(pos2(0.0, 0.0), pos2(12.0, 9.0));
    let pixels = shown(&mut painter, EVERYTHING, pictured(1, rect, WHOLE));
    for (index, color) in picture.pixels.iter().enumerate() {
        assert_eq!(pixels[index / 12 * SIZE[0] + index % 12], packed(*color) & 0x00ff_ffff, "{index}");
    }
    delta.free(TextureId::Managed(1));
    painter.free(&delta);
    delta.clear();
    assert!(shown(&mut painter, EVERYTHING, pictured(1, rect, WHOLE)).iter().all(|pixel| *pixel == 0));
}

#[test]
fn places_of_any_size_have_texels_nearby() {
    for at in [1e30, -1e30, f64::MAX, f64::INFINITY, f64::NAN] {
        let (first, share) = crate::textures::before(at);
        assert!(first.abs() < i64::MAX / 4 && share <= 256, "{at}: {first}, {share}");
    }
}
