//! A large hall of any number of triangles, for measuring how methods scale.

use super::info::{BuiltinInfo, TESS};
use super::parameters::{SEED, SURFACE, Values, integer};
use super::parts::kit::{Kit, Place, at};
use super::parts::shapes::{self, GridVertex, Shape};
use super::parts::textures::{self, rgb};
use catoptric_core::math::portable::{PortableMath, at_angle};
use catoptric_core::math::random::Stream;
use catoptric_core::scene::LightKind;
use catoptric_core::scene::model::Model;
use glam::{Vec2, Vec3};
use std::f32::consts::TAU;

pub(super) const LARGE_ROOM: BuiltinInfo = BuiltinInfo {
    name: "large_room",
    summary: "a mirror sphere in a large lit hall of fluted columns, relief walls and blocks, of any number of \
        triangles",
    parameters: &[
        TESS,
        SURFACE,
        SEED,
        integer(
            "triangles",
            "60000",
            "triangles of the hall and all that stands in it; the mirror adds its own",
            10_000,
            10_000_000,
        ),
    ],
    command: "catoptric render \"builtin:large_room?triangles=1000000\" -o large_room.png",
    build: large_room,
};

/// Half the width and depth of the hall.
const HALF: f32 = 9.0;
/// Height of the hall.
const HEIGHT: f32 = 5.5;
/// Radius of the columns without their flutes.
const COLUMN_RADIUS: f32 = 0.42;
/// Flutes around a column.
const FLUTES: f32 = 8.0;

/// An object of the hall, at any density of triangles.
enum Part {
    /// A wall, floor or ceiling: corner, right, up, the height of its relief.
    Sheet { corner: Vec3, right: Vec3, up: Vec3, relief: f32 },
    /// A fluted column on the floor.
    Column,
    /// A block of that size.
    Block(Vec3),
    /// A ball of that radius.
    Ball(f32),
}

impl Part {
    /// Cells along two directions, for so many cells a scene unit.
    fn cells(&self, density: f32) -> [u32; 2] {
        let cells = |length: f32, least: u32| ((length * density).round() as u32).max(least);
        match self {
            Self::Sheet { right, up, .. } => [cells(right.length(), 2), cells(up.length(), 2)],
            // Round objects need more triangles for the same smoothness.
            Self::Column => [cells(HEIGHT, 2), cells(COLUMN_RADIUS * TAU * 2.0, 16)],
            Self::Block(size) => [cells(size.max_element(), 1); 2],
            Self::Ball(radius) => [cells(radius * TAU, 6); 2],
        }
    }

    fn triangle_count(&self, density: f32) -> u64 {
        let [columns, rows] = self.cells(density).map(u64::from);
        match self {
            Self::Sheet { .. } | Self::Column => 2 * columns * rows,
            Self::Block(_) => 12 * columns * rows,
            Self::Ball(_) => 4 * rows * (rows - 1),
        }
    }

    fn shape(&self, density: f32) -> Shape {
        let [columns, rows] = self.cells(density);
        match *self {
            Self::Sheet { corner, right, up, relief } => relief_sheet(corner, right, up, relief, [columns, rows]),
            Self::Column => fluted_column(columns, rows),
            Self::Block(size) => shapes::cuboid(size * 0.5, columns),
            Self::Ball(radius) => shapes::sphere(radius, rows),
        }
    }
}

/// A rectangle with waves of that height, flat along its edges; exact normals.
fn relief_sheet(corner: Vec3, right: Vec3, up: Vec3, relief: f32, cells: [u32; 2]) -> Shape {
    let (width, height) = (right.length(), up.length());
    let (x_axis, y_axis) = (right / width, up / height);
    let inwards = x_axis.cross(y_axis);
    // Whole waves, about one a unit, so that the edges stay where they are.
    let frequency = Vec2::new(width.round(), height.round()) * TAU * 0.5;
    shapes::grid(cells[0], cells[1], |i, j| {
        let (s, t) = (i as f32 / cells[0] as f32, j as f32 / cells[1] as f32);
        let (phase_x, phase_y) = (frequency.x * s, frequency.y * t);
        // sin^2 sin^2: value and slope vanish at the edges.
        let (sx, cx) = phase_x.sine_cosine();
        let (sy, cy) = phase_y.sine_cosine();
        let offset = relief * sx * sx * sy * sy;
        let slope_x = relief * 2.0 * sx * cx * sy * sy * frequency.x / width;
        let slope_y = relief * 2.0 * sx * sx * sy * cy * frequency.y / height;
        GridVertex {
            position: corner + right * s + up * t + inwards * offset,
            normal: (inwards - x_axis * slope_x - y_axis * slope_y).normalize(),
            uv: Vec2::new(s * width, (1.0 - t) * height) / 3.0,
        }
    })
}

/// A fluted column from floor to ceiling, without lids (they would lie in the floor and the ceiling); exact normals.
fn fluted_column(rings: u32, segments: u32) -> Shape {
    shapes::grid(rings, segments, |i, j| {
        let t = i as f32 / rings as f32;
        let angle = (j % segments) as f32 / segments as f32 * TAU;
        let (sin, cos) = angle.sine_cosine();
        // Slender in the middle, and with flutes: r = R (1 - 0.12 sin(pi t)) (1 + 0.06 cos(k angle)).
        let (bulge_sin, bulge_cos) = (t * TAU * 0.5).sine_cosine();
        let bulge = 1.0 - 0.12 * bulge_sin;
        let flute = 1.0 + 0.06 * (FLUTES * angle).cosine();
        let radius = COLUMN_RADIUS * bulge * flute;
        let by_height = -COLUMN_RADIUS * 0.12 * bulge_cos * TAU * 0.5 / HEIGHT * flute;
        let by_angle = -COLUMN_RADIUS * bulge * 0.06 * FLUTES * (FLUTES * angle).sine();
        let (radial, around) = (Vec3::new(cos, 0.0, sin), Vec3::new(-sin, 0.0, cos));
        GridVertex {
            position: radial * radius + Vec3::Y * (t * HEIGHT),
            normal: (radial - around * (by_angle / radius) - Vec3::Y * by_height).normalize(),
            uv: Vec2::new(1.0 - j as f32 / segments as f32, (1.0 - t) * 2.0),
        }
    })
}

/// The density at which the parts together have about so many triangles.
fn density_for(parts: &[Part], triangles: u64) -> f32 {
    let count = |density: f32| parts.iter().map(|part| part.triangle_count(density)).sum::<u64>();
    let (mut low, mut high) = (0.0f32, 1000.0f32);
    for _ in 0..40 {
        let middle = (low + high) * 0.5;
        if count(middle) < triangles {
            low = middle;
        } else {
            high = middle;
        }
    }
    let (below, above) = (count(low), count(high));
    if triangles.abs_diff(below) < triangles.abs_diff(above) { low } else { high }
}

fn large_room(spec: &str, values: &Values<'_>) -> Model {
    let mut kit = Kit::lit(spec);
    let mirror = kit.mirror();
    let mut random = Stream::new(values.integer("seed"));
    let floor = kit.painted(textures::checker("floor_checker", 6, rgb(0x4a4e69), rgb(0xe0d8c8)));
    let ceiling = kit.painted(textures::tiles("ceiling_tiles", 3, rgb(0xd8dee6), rgb(0x8a93a0)));
    let bricks = kit.painted(textures::bricks("bricks", 12, rgb(0xb8654a), rgb(0xd9cfc0)));
    let labels = kit.painted(textures::labels("labels", 6, rgb(0x2b2d42), rgb(0xf1e8d8)));
    let stone = kit.painted(textures::marble("marble", 12, 4, rgb(0xa98f6c), rgb(0xf0e6d2)));
    let block_materials = [
        kit.painted(textures::labels("red_labels", 3, rgb(0xfff2dc), rgb(0xd1473a))),
        kit.painted(textures::checker("blue_checker", 4, rgb(0x2f63c4), rgb(0xcfe0ff))),
        kit.painted(textures::stripes("gold_stripes", 5, rgb(0xe0a526), rgb(0x6b3d10))),
        kit.painted(textures::dots("green_dots", 5, rgb(0x3f8f54), rgb(0xe3f5d8))),
        kit.painted(textures::bricks("teal_bricks", 8, rgb(0x2d9c95), rgb(0xe7f4ee))),
    ];
    let origin = at(0.0, 0.0, 0.0);
    let (x, y, z) = (Vec3::X * HALF * 2.0, Vec3::Y * HEIGHT, Vec3::Z * HALF * 2.0);
    let sheet = |corner: [f32; 3], right: Vec3, up: Vec3, relief: f32| {
        let corner = Vec3::from(corner) * Vec3::new(HALF, HEIGHT, HALF);
        Part::Sheet { corner, right, up, relief }
    };
    let mut things: Vec<(String, usize, Part, Place)> = vec![
        ("floor".into(), floor, sheet([-1.0, 0.0, 1.0], x, -z, 0.0), origin),
        ("ceiling".into(), ceiling, sheet([-1.0, 1.0, -1.0], x, z, 0.12), origin),
        ("wall_back".into(), labels, sheet([-1.0, 0.0, -1.0], x, y, 0.15), origin),
        ("wall_front".into(), labels, sheet([1.0, 0.0, 1.0], -x, y, 0.15), origin),
        ("wall_left".into(), bricks, sheet([-1.0, 0.0, 1.0], -z, y, 0.15), origin),
        ("wall_right".into(), bricks, sheet([1.0, 0.0, -1.0], z, y, 0.15), origin),
    ];
    // Two rings of columns around the sphere.
    for (ring, count, distance) in [(1, 6, 3.4), (2, 12, 6.6)] {
        for index in 0..count {
            // The first ring leaves the way from the camera free, the second stands in the gaps of the first.
            let direction = shapes::around(count * 2, index * 2 + ring - 1) * distance;
            let name = format!("column_{ring}_{}", index + 1);
            things.push((name, stone, Part::Column, at(direction.x, 0.0, direction.y)));
        }
    }
    for index in 0..28u32 {
        // Near the sphere first, then further and further out.
        let distance = 1.7 + index as f32 * 0.2;
        // The golden angle spreads them evenly; the way to the camera stays free.
        let angle = index as f32 * 2.399_963 + random.next_between(-0.25, 0.25);
        let place = at_angle(angle) * distance;
        let size = random.next_between(0.35, 0.75);
        let tall = random.next_between(0.6, 1.8);
        let turn_deg = random.next_between(0.0, 90.0);
        let in_the_way = place.y > 0.0 && place.x.abs() < 1.1;
        let place = if in_the_way { Vec2::new(place.x + 1.6f32.copysign(place.x), place.y) } else { place };
        let material = block_materials[index as usize % block_materials.len()];
        if index % 4 == 3 {
            let radius = size * 0.6;
            things.push((format!("ball_{}", index + 1), material, Part::Ball(radius), at(place.x, radius, place.y)));
        } else {
            let size = Vec3::new(size, size * tall, size);
            let stand = at(place.x, size.y * 0.5, place.y).turned(turn_deg);
            things.push((format!("block_{}", index + 1), material, Part::Block(size), stand));
        }
    }
    let (parts, placed): (Vec<Part>, Vec<_>) =
        things.into_iter().map(|(name, material, part, place)| (part, (name, material, place))).unzip();
    let density = density_for(&parts, values.integer("triangles"));
    for (part, (name, material, place)) in parts.iter().zip(placed) {
        kit.add(&name, material, part.shape(density), place);
    }
    kit.add_sphere("sphere", mirror, 1.0, at(0.0, 1.25, 0.0), values);
    add_lamps(&mut kit);
    kit.add_camera("front", Vec3::new(0.4, 1.9, 4.2), Vec3::new(0.0, 1.25, 0.0), 42.0);
    kit.add_camera("far", Vec3::new(0.0, 2.6, 8.2), Vec3::new(0.0, 1.2, 0.0), 42.0);
    kit.finish()
}

/// Five lamps below the ceiling, cold to warm, and daylight.
fn add_lamps(kit: &mut Kit) {
    for (index, (position, warmth)) in [
        (Vec3::new(-4.5, 4.4, 4.5), 0.0),
        (Vec3::new(4.5, 4.4, 4.5), 0.6),
        (Vec3::new(-4.5, 4.4, -4.5), 0.8),
        (Vec3::new(4.5, 4.4, -4.5), 0.2),
        (Vec3::new(0.0, 4.9, 0.0), 0.5),
    ]
    .into_iter()
    .enumerate()
    {
        let color = Vec3::new(0.85, 0.92, 1.0).lerp(Vec3::new(1.0, 0.88, 0.7), warmth);
        let kind = LightKind::Point { range: f32::INFINITY };
        kit.add_light(&format!("lamp_{}", index + 1), kind, color * 34.0, position, Vec3::NEG_Y);
    }
    kit.add_light(
        "daylight",
        LightKind::Directional,
        Vec3::new(0.5, 0.55, 0.65),
        Vec3::ZERO,
        Vec3::new(0.4, -1.0, -0.6),
    );
}
