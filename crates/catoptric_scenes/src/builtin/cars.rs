//! A car-like body of many smooth curved panels between buildings.

use super::info::{BuiltinInfo, TESS};
use super::parameters::{SEED, Values};
use super::parts::kit::{Kit, at};
use super::parts::shapes::{self, GridVertex, Shape, prop_segments};
use super::parts::textures::{self, rgb};
use catoptric_core::math::portable::PortableMath;
use catoptric_core::math::random::Stream;
use catoptric_core::scene::Material;
use catoptric_core::scene::model::Model;
use glam::{Vec2, Vec3};

pub(super) const CAR: BuiltinInfo = BuiltinInfo {
    name: "car",
    summary: "a car-like body of smooth mirror panels (hood, roof, doors, fenders...) in a street of near buildings",
    parameters: &[TESS, SEED],
    command: "catoptric render builtin:car -o car.png",
    build: car,
};

/// A part of the body: a hull along x whose cross-sections are superellipses |z/w|^n + |(y - base)/h|^n = 1.
struct Hull {
    base: f32,
    exponent: f32,
    /// Half the width at x, and its derivative.
    half_width: fn(f32) -> [f32; 2],
    /// Height above the base at x, and its derivative.
    height: fn(f32) -> [f32; 2],
}

/// `high - drop u^2 - end u^4` with u the position from the middle, in half-lengths; and the derivative by x.
fn arch(x: f32, middle: f32, half_length: f32, [high, drop, end]: [f32; 3]) -> [f32; 2] {
    let u = (x - middle) / half_length;
    [high - drop * u * u - end * u.powi(4), (-2.0 * drop * u - 4.0 * end * u.powi(3)) / half_length]
}

/// The lower body, from x = -2.1 (tail) to 2.1 (nose).
const BODY: Hull = Hull {
    base: 0.55,
    exponent: 3.0,
    half_width: |x| arch(x, -0.1, 2.2, [0.9, 0.06, 0.22]),
    height: |x| arch(x, -0.4, 2.5, [0.5, 0.12, 0.12]),
};

/// The cabin on top of it.
const CABIN: Hull = Hull {
    base: 0.8,
    exponent: 2.6,
    half_width: |x| arch(x, -0.4, 1.5, [0.76, 0.08, 0.3]),
    height: |x| arch(x, -0.4, 1.5, [0.68, 0.3, 0.34]),
};

impl Hull {
    /// The point at x in the direction of an angle of the cross-section (0: to +z, a quarter turn: up), and the outer
    /// normal: the gradient of the superellipse's implicit function.
    fn point(&self, x: f32, angle: f32) -> (Vec3, Vec3) {
        let n = self.exponent;
        let ([w, dw], [h, dh]) = ((self.half_width)(x), (self.height)(x));
        let (sin, cos) = angle.sine_cosine();
        let reach = ((cos.abs() / w).power(n) + (sin.abs() / h).power(n)).power(-1.0 / n);
        let (z, y) = (cos * reach, sin * reach);
        // F = |z/w|^n + |y/h|^n - 1; w and h depend on x.
        let power = |value: f32| value.abs().power(n - 1.0) * value.signum();
        let (fz, fy) = (power(z / w), power(y / h));
        let gradient = Vec3::new(-fz * z * dw / (w * w) - fy * y * dh / (h * h), fy / h, fz / w);
        (Vec3::new(x, self.base + y, z), gradient.normalize_or(Vec3::Y))
    }

    /// The bulging end of the hull at x: as far as `bulge` beyond it (negative: at the rear end).
    ///
    /// With r the superellipse's own radius (|z/w|^n + |y/h|^n)^(1/n), it is x + bulge (1 - r^2); the normal is the
    /// gradient.
    fn end(&self, x: f32, bulge: f32, cells: u32) -> Shape {
        let n = self.exponent;
        let ([w, _], [h, _]) = ((self.half_width)(x), (self.height)(x));
        let facing = bulge.signum();
        shapes::grid(cells, cells * 2, |i, j| {
            // From the rim inwards in front, outwards behind, so that the outer side is outside.
            let share = i as f32 / cells as f32;
            let r = if bulge > 0.0 { 1.0 - share } else { share };
            let angle = (-18.0 + 216.0 * j as f32 / (cells * 2) as f32).to_radians();
            let (rim, _) = self.point(x, angle);
            let (z, y) = (rim.z * r, (rim.y - self.base) * r);
            let slope = |value: f32, scale: f32| {
                let ratio = value / scale;
                2.0 * bulge * r.max(1e-6).power(2.0 - n) * ratio.abs().power(n - 1.0) * ratio.signum() / scale
            };
            let normal = Vec3::new(1.0, slope(y, h), slope(z, w)) * facing;
            GridVertex {
                position: Vec3::new(x + bulge * (1.0 - r * r), self.base + y, z),
                normal: normal.normalize_or(Vec3::X * facing),
                uv: Vec2::new(j as f32 / (cells * 2) as f32, r),
            }
        })
    }

    /// The part of the hull between two positions and two angles (in degrees), without a gap's width at its edges.
    fn panel(&self, [x0, x1]: [f32; 2], [from_deg, to_deg]: [f32; 2], cells: u32) -> Shape {
        let (x0, x1) = (x0 + GAP, x1 - GAP);
        let (from, to) = (from_deg.to_radians() + GAP, to_deg.to_radians() - GAP);
        // Counter-clockwise seen from outside: along x, then up on the left and over to the right.
        shapes::grid(cells, cells, |i, j| {
            let (s, t) = (i as f32 / cells as f32, j as f32 / cells as f32);
            let (position, normal) = self.point(x0 + (x1 - x0) * s, from + (to - from) * t);
            GridVertex { position, normal, uv: Vec2::new(s, t) }
        })
    }
}

/// The front end of the body, before its nose.
const NOSE: f32 = 2.05;
/// The rear end of the body.
const TAIL: f32 = -2.1;
/// Half the width of the joints between panels.
const GAP: f32 = 0.012;

fn car(spec: &str, values: &Values<'_>) -> Model {
    let mut kit = Kit::unlit(spec);
    let tess = values.tess();
    let paint = kit.material(Material::mirror("paint", Vec3::new(0.9, 0.86, 0.82)));
    let panes = kit.material(Material::mirror("panes", Vec3::new(0.38, 0.45, 0.5)));
    let cells = (tess / 2).max(2);
    for (name, material, hull, x, angles) in [
        ("hood", paint, &BODY, [0.75, NOSE], [38.0, 142.0]),
        ("fender_front_left", paint, &BODY, [0.75, NOSE], [-18.0, 38.0]),
        ("fender_front_right", paint, &BODY, [0.75, NOSE], [142.0, 198.0]),
        ("door_front_left", paint, &BODY, [-0.3, 0.75], [-24.0, 66.0]),
        ("door_front_right", paint, &BODY, [-0.3, 0.75], [114.0, 204.0]),
        ("door_rear_left", paint, &BODY, [-1.2, -0.3], [-24.0, 66.0]),
        ("door_rear_right", paint, &BODY, [-1.2, -0.3], [114.0, 204.0]),
        ("fender_rear_left", paint, &BODY, [TAIL, -1.2], [-18.0, 44.0]),
        ("fender_rear_right", paint, &BODY, [TAIL, -1.2], [136.0, 198.0]),
        ("trunk", paint, &BODY, [TAIL, -1.2], [44.0, 136.0]),
        ("roof", paint, &CABIN, [-1.15, 0.3], [48.0, 132.0]),
        ("windshield", panes, &CABIN, [0.3, 1.02], [18.0, 162.0]),
        ("rear_window", panes, &CABIN, [-1.82, -1.15], [18.0, 162.0]),
        ("window_front_left", panes, &CABIN, [-0.35, 0.3], [14.0, 48.0]),
        ("window_front_right", panes, &CABIN, [-0.35, 0.3], [132.0, 166.0]),
        ("window_rear_left", panes, &CABIN, [-1.15, -0.35], [14.0, 48.0]),
        ("window_rear_right", panes, &CABIN, [-1.15, -0.35], [132.0, 166.0]),
    ] {
        kit.add(name, material, hull.panel(x, angles, cells), at(0.0, 0.0, 0.0));
    }
    kit.add("nose", paint, BODY.end(NOSE, 0.2, cells), at(0.0, 0.0, 0.0));
    kit.add("tail", paint, BODY.end(TAIL, -0.12, cells), at(0.0, 0.0, 0.0));
    let dark = kit.plain("underbody", rgb(0x1d1f22));
    kit.add_box("underbody", dark, [3.2, 0.4, 1.1], at(-0.1, 0.2, 0.0));
    kit.add_box("interior", dark, [2.0, 0.45, 1.1], at(-0.4, 0.5, 0.0));
    add_wheels(&mut kit, prop_segments(tess));
    add_street(&mut kit, values.integer("seed"), prop_segments(tess));
    kit.add_camera("front", Vec3::new(4.0, 1.8, 3.5), Vec3::new(0.1, 0.62, 0.0), 34.0);
    kit.add_camera("side", Vec3::new(0.0, 1.5, 5.2), Vec3::new(0.0, 0.7, 0.0), 38.0);
    kit.finish()
}

fn add_wheels(kit: &mut Kit, segments: u32) {
    let rubber = kit.plain("rubber", rgb(0x26282b));
    let hub = kit.painted(textures::target("hubs", 5, rgb(0xd8dde2), rgb(0x7b848d), rgb(0x3a3f45)));
    for (name, x, z, side) in [
        ("front_left", 1.35, 0.78, 1.0),
        ("front_right", 1.35, -0.78, -1.0),
        ("rear_left", -1.4, 0.78, 1.0),
        ("rear_right", -1.4, -0.78, -1.0),
    ] {
        let place = at(x, 0.34, z).turned_yxz(0.0, 90.0 * side, 0.0);
        kit.add(&format!("wheel_{name}"), rubber, shapes::cylinder(0.34, 0.16, segments), place);
        let place = at(x, 0.34, z + side * 0.16).turned_yxz(0.0, 90.0 * side, 0.0);
        kit.add(&format!("hub_{name}"), hub, shapes::cylinder(0.21, 0.02, segments), place);
    }
}

/// Half the size of the block of streets.
const STREET: f32 = 12.0;

fn add_street(kit: &mut Kit, seed: u64, segments: u32) {
    let mut random = Stream::new(seed);
    let paving = kit.painted(textures::paint("paving", 512, |p| {
        let q = p * 32.0;
        let cell = q.as_ivec2();
        // Bands of light and dark slabs, and a white line on either side of the car.
        let line = ((p.y - 0.62).abs() < 0.006 || (p.y - 0.38).abs() < 0.006) && (p.x * 12.0).fract() < 0.6;
        let joint = (q.fract() - 0.5).abs().max_element() > 0.47;
        let slab = if (cell.x + cell.y) & 1 == 0 { rgb(0x8d8578) } else { rgb(0x666a73) };
        if line {
            rgb(0xf4f1e4)
        } else if joint {
            slab * 0.7
        } else {
            slab
        }
    }));
    let sky = kit.painted(textures::paint("sky", 256, |p| {
        // Round the horizon it is brightest; the texture's upper edge is the zenith.
        rgb(0x3f78c2).lerp(rgb(0xdcebf7), (p.y * 1.9).min(1.0))
    }));
    let ground = shapes::rectangle(
        Vec3::new(-STREET, 0.0, STREET),
        Vec3::X * STREET * 2.0,
        Vec3::NEG_Z * STREET * 2.0,
        [48, 48],
        Vec2::splat(STREET * 2.0),
    );
    kit.add("street", paving, ground, at(0.0, 0.0, 0.0));
    // A dome that is seen from within: a ball with its inside out.
    let mut dome = shapes::sphere(STREET * 2.5, 24);
    dome.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    dome.normals.iter_mut().for_each(|normal| *normal = -*normal);
    kit.add("sky", sky, dome, at(0.0, 0.0, 0.0));

    let fronts = [
        kit.painted(textures::windows("front_sand", 1, rgb(0xd9bb8c))),
        kit.painted(textures::windows("front_brick", 2, rgb(0xb5644a))),
        kit.painted(textures::windows("front_mint", 3, rgb(0x86b8a1))),
        kit.painted(textures::windows("front_cream", 4, rgb(0xefe3c8))),
        kit.painted(textures::windows("front_blue", 5, rgb(0x7d97bd))),
    ];
    let mut count = 0;
    let mut building = |kit: &mut Kit, random: &mut Stream, x: f32, z: f32| {
        let size = [random.next_between(2.4, 3.2), random.next_between(3.0, 7.5), random.next_between(2.4, 3.0)];
        let material = fronts[count % fronts.len()];
        count += 1;
        kit.add_box(&format!("building_{count}"), material, size, at(x, 0.0, z));
    };
    for step in 0..7 {
        let along = (step as f32 - 3.0) * 3.4;
        building(kit, &mut random, along, -5.6);
        building(kit, &mut random, along + 1.0, 8.2);
    }
    for step in 0..2 {
        let across = -2.2 + step as f32 * 4.2;
        building(kit, &mut random, -9.5, across);
        building(kit, &mut random, 10.2, across + 0.8);
    }
    let pole = kit.painted(textures::stripes("pole_stripes", 4, rgb(0xd8324a), rgb(0xfff6ee)));
    let crate_labels = kit.painted(textures::labels("crate_labels", 3, rgb(0x3a2a12), rgb(0xe3a93b)));
    let leaves = kit.painted(textures::marble("leaves", 77, 6, rgb(0x2f6b35), rgb(0x86b84f)));
    for (index, (x, z)) in [(2.6, -2.1), (-2.4, -2.1), (3.1, -0.3), (-3.0, 4.2)].into_iter().enumerate() {
        let name = format!("pole_{}", index + 1);
        kit.add(&name, pole, shapes::cylinder(0.09, 1.3, segments), at(x, 0.0, z));
    }
    for (index, (x, z)) in [(0.4, -2.3), (-3.2, 0.4)].into_iter().enumerate() {
        kit.add(&format!("tree_{}", index + 1), leaves, shapes::cone(0.55, 2.4, segments), at(x, 0.0, z));
    }
    kit.add_box("crate_near", crate_labels, [0.6, 0.6, 0.6], at(-0.9, 0.0, 2.1).turned(25.0));
    kit.add_box("crate_far", crate_labels, [0.8, 0.8, 0.8], at(3.3, 0.0, -1.2).turned(-15.0));
}
