//! Painted textures: patterns in which reflections can be read.
//!
//! Colours are sRGB values from 0 to 1, as one would pick them.

use catoptric_core::math::portable::PortableMath;
use catoptric_core::math::random;
use catoptric_core::parallel;
use catoptric_core::scene::{Sampler, Texture};
use glam::{IVec2, Vec2, Vec3};
use std::f32::consts::TAU;

/// A colour from the six digits of a web colour.
pub(in super::super) const fn rgb(hex: u32) -> Vec3 {
    Vec3::new((hex >> 16 & 255) as f32 / 255.0, (hex >> 8 & 255) as f32 / 255.0, (hex & 255) as f32 / 255.0)
}

/// The linear value of an sRGB colour.
pub(in super::super) fn linear(color: Vec3) -> Vec3 {
    color.to_array().map(catoptric_core::framebuffer::linear_from_srgb).into()
}

/// A square texture of `size` texels a side, painted by a function of the position (0..1, y down).
pub(in super::super) fn paint(name: &str, size: u32, color: impl Fn(Vec2) -> Vec3 + Sync + Send) -> Texture {
    let at = |x: f32, y: f32| color(Vec2::new(x, y) / size as f32);
    let columns = size as usize + 1;
    let line = |y: usize| (0..columns).map(|x| at(x as f32, y as f32)).collect::<Vec<_>>();
    let corners = parallel::map_collect(columns, line);
    let texel = |x: usize, y: usize| {
        let [a, b, c, d] = [corners[y][x], corners[y][x + 1], corners[y + 1][x], corners[y + 1][x + 1]];
        let mean = (a + b + c + d) * 0.25;
        let differ = [a, b, c, d].iter().any(|corner| (*corner - mean).abs().max_element() > 0.02);
        // Four samples inside a texel on an edge of the pattern soften the edge.
        let quarters = [(0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75)];
        let softened = || quarters.iter().map(|(dx, dy)| at(x as f32 + dx, y as f32 + dy)).sum::<Vec3>() * 0.25;
        let bytes = if differ { softened() } else { mean }.clamp(Vec3::ZERO, Vec3::ONE) * 255.0 + 0.5;
        [bytes.x as u8, bytes.y as u8, bytes.z as u8, 255]
    };
    let rows = parallel::map_collect(size as usize, |y| (0..size as usize).map(|x| texel(x, y)).collect::<Vec<_>>());
    Texture::from_srgb8(name, size, size, &rows.concat(), Sampler::default())
}

/// A wave on a texture that repeats: how many fit along its u and v, its amplitude in the texture's sides, its phase.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Wave {
    pub(in super::super) count: [i32; 2],
    pub(in super::super) amplitude: f32,
    pub(in super::super) phase: f32,
}

/// The normals of a sum of waves, of `size` texels a side.
pub(in super::super) fn ripples(name: &str, size: u32, waves: &[Wave]) -> Texture {
    let normal = |texel: u32| {
        let at = (Vec2::new((texel % size) as f32, (texel / size) as f32) + 0.5) / size as f32;
        let slope = |wave: &Wave| {
            let number = Vec2::new(wave.count[0] as f32, wave.count[1] as f32) * TAU;
            number * (wave.amplitude * (number.dot(at) + wave.phase).cosine())
        };
        let slope: Vec2 = waves.iter().map(slope).sum();
        // The texture's v runs down, a normal's y up.
        Vec3::new(-slope.x, slope.y, 1.0)
    };
    Texture::from_normals(name, size, size, (0..size * size).map(normal), Sampler::default())
}

/// The normals of a relief, of `size` texels a side: heights, in the texture's sides, by the position (0..1, y down).
pub(in super::super) fn relief(name: &str, size: u32, height: impl Fn(Vec2) -> f32) -> Texture {
    let step = 0.5 / size as f32;
    let normal = |texel: u32| {
        let at = (Vec2::new((texel % size) as f32, (texel / size) as f32) + 0.5) / size as f32;
        let slope = |along: Vec2| (height(at + along * step) - height(at - along * step)) / (2.0 * step);
        // The texture's v runs down, a normal's y up.
        Vec3::new(-slope(Vec2::X), slope(Vec2::Y), 1.0)
    };
    Texture::from_normals(name, size, size, (0..size * size).map(normal), Sampler::default())
}

/// Dents like those of a hammer: where `cells` times `cells` blows fell, each a hollow of a depth in the texture's
/// sides.
pub(in super::super) fn dents(name: &str, seed: u64, cells: u32, depth: f32) -> Texture {
    let middle = |cell: IVec2| {
        let wrapped = cell.rem_euclid(IVec2::splat(cells as i32));
        let shift = |axis: u64| 0.25 + 0.5 * random::unit(seed + axis, wrapped.x as u64, wrapped.y as u64);
        cell.as_vec2() + Vec2::new(shift(0), shift(1))
    };
    relief(name, 256, |p| {
        let q = p * cells as f32;
        let cell = q.floor().as_ivec2();
        let around = (0..9).map(|k| cell + IVec2::new(k % 3 - 1, k / 3 - 1));
        // The deepest hollow of those around: their rims meet in ridges.
        around.map(|cell| depth * (q.distance_squared(middle(cell)) - 1.0)).fold(0.0, f32::min)
    })
}

/// A grain of soft hills, `cells` a side, of a height in the texture's sides.
pub(in super::super) fn grain(name: &str, seed: u64, cells: u32, height: f32) -> Texture {
    relief(name, 256, |p| height * (noise(seed, p, cells) + 0.5 * noise(seed + 1, p, 2 * cells)))
}

/// Metal under paint that has worn off in patches, `cells` a side: roughness in green, metal in blue, as glTF has them.
pub(in super::super) fn worn(name: &str, seed: u64, cells: u32, [paint, metal]: [f32; 2]) -> Texture {
    let size = 256;
    let texel = |index: u32| {
        let at = (Vec2::new((index % size) as f32, (index / size) as f32) + 0.5) / size as f32;
        let share = wear(seed, cells, at);
        let byte = |value: f32| (value * 255.0 + 0.5) as u8;
        [255, byte(paint + (metal - paint) * share), byte(share), 255]
    };
    let texels: Vec<[u8; 4]> = (0..size * size).map(texel).collect();
    Texture::from_linear8(name, size, size, &texels, Sampler::default())
}

/// The colour of that paint and metal.
pub(in super::super) fn worn_color(name: &str, seed: u64, cells: u32, [paint, metal]: [Vec3; 2]) -> Texture {
    self::paint(name, 256, |p| paint.lerp(metal, wear(seed, cells, p)))
}

/// How much of the paint is gone, 0 to 1.
fn wear(seed: u64, cells: u32, p: Vec2) -> f32 {
    let sum = 0.6 * noise(seed, p, cells) + 0.3 * noise(seed + 1, p, 3 * cells) + 0.1 * noise(seed + 2, p, 9 * cells);
    ((sum - 0.52) * 12.0).clamp(0.0, 1.0)
}

/// A checkerboard of `cells` times `cells` squares.
pub(crate) fn checker(name: &str, cells: u32, a: Vec3, b: Vec3) -> Texture {
    paint(name, 256, |p| {
        let cell = (p * cells as f32).as_ivec2();
        if (cell.x + cell.y) & 1 == 0 { a } else { b }
    })
}

/// Vertical stripes.
pub(in super::super) fn stripes(name: &str, count: u32, a: Vec3, b: Vec3) -> Texture {
    paint(name, 256, |p| if (p.x * count as f32 * 2.0) as u32 & 1 == 0 { a } else { b })
}

/// Rows of bricks, every second one shifted, each brick of a slightly different brightness.
pub(in super::super) fn bricks(name: &str, rows: u32, brick: Vec3, mortar: Vec3) -> Texture {
    paint(name, 512, |p| {
        let row = (p.y * rows as f32) as u32;
        let columns = rows / 2;
        let x = p.x * columns as f32 + if row & 1 == 0 { 0.0 } else { 0.5 };
        let inside = (x.fract() - 0.5).abs() < 0.47 && ((p.y * rows as f32).fract() - 0.5).abs() < 0.44;
        let shade = 0.8 + 0.3 * random::unit(3, (x as u32 % columns) as u64, row as u64);
        if inside { brick * shade * (0.9 + 0.1 * noise(5, p, 64)) } else { mortar }
    })
}

/// Boards that run from left to right, each of its own tone and grain.
pub(in super::super) fn planks(name: &str, rows: u32, wood: Vec3) -> Texture {
    paint(name, 512, |p| {
        let row = (p.y * rows as f32) as u32;
        let joint = random::unit(7, row as u64, 0);
        let along = (p.x + joint).fract();
        let board = (along * 2.0) as u64;
        let tone = 0.72 + 0.36 * random::unit(8, row as u64, board);
        let grain = 0.86 + 0.2 * noise(9 + row as u64, Vec2::new(p.x * 0.125, p.y), 64);
        let gap = (p.y * rows as f32).fract() < 0.05 || (along * 2.0).fract() < 0.008;
        if gap { wood * 0.35 } else { wood * tone * grain }
    })
}

/// Square tiles with dark joints and small differences of tone.
pub(in super::super) fn tiles(name: &str, count: u32, tile: Vec3, joint: Vec3) -> Texture {
    paint(name, 512, |p| {
        let q = p * count as f32;
        let cell = q.as_ivec2();
        let tone = 0.88 + 0.16 * random::unit(11, cell.x as u64, cell.y as u64);
        let edge = (q.fract() - 0.5).abs().max_element() > 0.47;
        if edge { joint } else { tile * tone }
    })
}

/// Cells of changing hue with their letter (the row) and number (the column): reflections show what they reverse.
pub(in super::super) fn labels(name: &str, cells: u32, dark: Vec3, light: Vec3) -> Texture {
    let cells = cells.clamp(1, 8);
    paint(name, 512, |p| {
        let q = p * cells as f32;
        let cell = q.as_ivec2();
        let inside = q.fract();
        let hue = (cell.x * 3 + cell.y * 5) as f32 / (cells * 3) as f32;
        let ground = if (cell.x + cell.y) & 1 == 0 { light } else { light * 0.84 };
        let ground = ground * (0.8 + 0.2 * spectrum(hue));
        let edge = (inside - 0.5).abs().max_element() > 0.475;
        // Two glyphs of 3 by 5 dots, with a column between: 7 by 5 dots in the middle of the cell.
        let dot = ((inside - Vec2::new(0.15, 0.2)) / Vec2::new(0.1, 0.12)).floor().as_ivec2();
        let inked = glyph_dot(10 + cell.y as usize, dot.x, dot.y) || glyph_dot(1 + cell.x as usize, dot.x - 4, dot.y);
        if edge || inked { dark } else { ground }
    })
}

/// Rings about the middle, with a cross: shows how lenses and dishes distort.
pub(in super::super) fn target(name: &str, rings: u32, a: Vec3, b: Vec3, cross: Vec3) -> Texture {
    paint(name, 512, |p| {
        let q = p - 0.5;
        let ring = (q.length() * 2.0 * rings as f32) as u32;
        let on_cross = q.abs().min_element() < 0.008 && q.abs().max_element() < 0.45;
        let color = if ring & 1 == 0 { a } else { b };
        if on_cross { cross } else { color * (0.75 + 0.25 * spectrum(q.y.arc_tangent2(q.x) / std::f32::consts::TAU)) }
    })
}

/// The front of a building: rows of windows, some of them lit.
pub(in super::super) fn windows(name: &str, seed: u64, wall: Vec3) -> Texture {
    paint(name, 256, |p| {
        let q = p * 8.0;
        let cell = q.as_ivec2();
        let inside = q.fract();
        let pane = (inside.x - 0.5).abs() < 0.28 && (inside.y - 0.48).abs() < 0.32;
        let bar = (inside.x - 0.5).abs() < 0.03;
        let lit = random::unit(seed, cell.x as u64, cell.y as u64);
        if !pane || bar {
            wall * (0.92 + 0.08 * noise(seed, p, 32))
        } else if lit > 0.7 {
            rgb(0xffe2a0)
        } else {
            rgb(0x2c3e55) * (0.7 + 0.8 * lit)
        }
    })
}

/// Soft patches between two colours, like marble or clouds.
pub(in super::super) fn marble(name: &str, seed: u64, cells: u32, a: Vec3, b: Vec3) -> Texture {
    paint(name, 256, |p| {
        let sum: f32 =
            (0..4).map(|octave| noise(seed + octave, p, cells << octave) * 0.5f32.powi(octave as i32 + 1)).sum();
        a.lerp(b, ((sum - 0.47) * 2.2 + 0.5).clamp(0.0, 1.0))
    })
}

/// Coloured dots on a ground.
pub(in super::super) fn dots(name: &str, count: u32, ground: Vec3, dot: Vec3) -> Texture {
    paint(name, 256, |p| {
        let q = p * count as f32;
        if (q.fract() - 0.5).length() < 0.32 { dot } else { ground }
    })
}

/// Cells of all hues, each with a light dot in its middle.
pub(in super::super) fn patches(name: &str, cells: u32) -> Texture {
    paint(name, 256, |p| {
        let q = p * cells as f32;
        let cell = q.as_ivec2();
        let index = (cell.x + cell.y * cells as i32) as u64;
        // The golden section keeps neighbours apart.
        let color = spectrum((index as f32 * 0.618_034).fract()) * 0.8 + 0.1;
        if (q.fract() - Vec2::new(0.5, 0.64)).length() < 0.13 { color * 0.3 + 0.7 } else { color }
    })
}

/// A saturated colour for every hue from 0 to 1, around the circle.
pub(in super::super) fn spectrum(hue: f32) -> Vec3 {
    let channel = |shift: f32| 0.5 + 0.5 * ((hue + shift) * std::f32::consts::TAU).cosine();
    Vec3::new(channel(0.0), channel(-1.0 / 3.0), channel(-2.0 / 3.0))
}

/// Smooth noise in 0..1 that repeats after 1 in both directions and has `cells` hills a side.
fn noise(seed: u64, p: Vec2, cells: u32) -> f32 {
    let q = p.rem_euclid(Vec2::ONE) * cells as f32;
    let cell = q.floor().as_ivec2();
    let f = q - q.floor();
    let f = f * f * (3.0 - 2.0 * f);
    let at = |dx: i32, dy: i32| {
        let wrap = |value: i32| value.rem_euclid(cells as i32) as u64;
        random::unit(seed, wrap(cell.x + dx), wrap(cell.y + dy))
    };
    let top = at(0, 0) + (at(1, 0) - at(0, 0)) * f.x;
    let bottom = at(0, 1) + (at(1, 1) - at(0, 1)) * f.x;
    top + (bottom - top) * f.y
}

/// Digits 0 to 9 and letters A to H as rows of three dots.
const GLYPHS: [[u8; 5]; 18] = [
    [0b111, 0b101, 0b101, 0b101, 0b111],
    [0b010, 0b110, 0b010, 0b010, 0b111],
    [0b111, 0b001, 0b111, 0b100, 0b111],
    [0b111, 0b001, 0b111, 0b001, 0b111],
    [0b101, 0b101, 0b111, 0b001, 0b001],
    [0b111, 0b100, 0b111, 0b001, 0b111],
    [0b111, 0b100, 0b111, 0b101, 0b111],
    [0b111, 0b001, 0b010, 0b010, 0b010],
    [0b111, 0b101, 0b111, 0b101, 0b111],
    [0b111, 0b101, 0b111, 0b001, 0b111],
    [0b010, 0b101, 0b111, 0b101, 0b101],
    [0b110, 0b101, 0b110, 0b101, 0b110],
    [0b011, 0b100, 0b100, 0b100, 0b011],
    [0b110, 0b101, 0b101, 0b101, 0b110],
    [0b111, 0b100, 0b110, 0b100, 0b111],
    [0b111, 0b100, 0b110, 0b100, 0b100],
    [0b011, 0b100, 0b101, 0b101, 0b011],
    [0b101, 0b101, 0b111, 0b101, 0b101],
];

fn glyph_dot(glyph: usize, x: i32, y: i32) -> bool {
    let inside = (0..3).contains(&x) && (0..5).contains(&y);
    inside && GLYPHS.get(glyph).is_some_and(|rows| rows[y as usize] >> (2 - x) & 1 == 1)
}
