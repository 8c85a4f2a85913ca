//! Mirrors that were turned on a wheel: the vase of the papers and a teapot-like pot.

use super::info::{BuiltinInfo, TESS};
use super::parameters::{EXACT_SURFACE, Values, choice};
use super::parts::kit::{Kit, at};
use super::parts::lizard::lizard;
use super::parts::shapes::{self, ProfilePoint, Shape, TubePoint, prop_segments};
use super::parts::textures::{self, rgb};
use catoptric_core::math::portable::turn_about_f32;
use catoptric_core::scene::model::{Animation, Channel, ChannelValues, Interpolation, Model};
use catoptric_core::scene::{LightKind, Material};
use catoptric_core::surface::{AnalyticSurface, Revolution};
use glam::{Quat, Vec2, Vec3};
use std::f32::consts::TAU;

pub(super) const VASE: BuiltinInfo = BuiltinInfo {
    name: "vase",
    summary: "the mirror vase of the papers, a flat lizard of 61 vertices and an icosahedron that circles the vase",
    parameters: &[
        TESS,
        EXACT_SURFACE,
        choice("sphere", "a mirror sphere hangs beside the vase, for reflections of reflections", &["none", "mirror"]),
    ],
    command: "catoptric render builtin:vase -o vase.png",
    build: vase,
};

pub(super) const TEAPOT: BuiltinInfo = BuiltinInfo {
    name: "teapot",
    summary: "a teapot-like pot of mirror or solid glass on a checkered table, lit by lamps",
    parameters: &[
        TESS,
        choice("material", "a mirror with spout and handle, or solid glass without", &["mirror", "glass"]),
    ],
    command: "catoptric render builtin:teapot -o teapot.png",
    build: teapot,
};

/// Height of the vase.
const VASE_HEIGHT: f64 = 2.0;
/// Coefficients of the vase's radius a s^3 + b s^2 + c s + d, with s the height from 0 to 1.
pub(super) const VASE_PROFILE: [f64; 4] = [5.80, -9.78, 3.90, 0.47];

/// The vase's radius and its derivative by s, the height from 0 to 1.
fn vase_radius(s: f32) -> [f32; 2] {
    let [a, b, c, d] = VASE_PROFILE.map(|coefficient| coefficient as f32);
    [((a * s + b) * s + c) * s + d, (3.0 * a * s + 2.0 * b) * s + c]
}

/// The wall of the vase: an open surface of revolution that stands on the xz plane.
fn vase_wall(tess: u32) -> Shape {
    let curve = |s: f32| {
        let [radius, change] = vase_radius(s);
        (Vec2::new(radius, s * VASE_HEIGHT as f32), Vec2::new(change, VASE_HEIGHT as f32))
    };
    shapes::revolution(&shapes::profile(tess * 3 / 2, curve), tess * 2)
}

/// The time in which the icosahedron circles the vase, in seconds.
const ORBIT_SECONDS: f32 = 8.0;

fn vase(spec: &str, values: &Values<'_>) -> Model {
    let mut kit = Kit::unlit(spec);
    let segments = values.tess() * 2;
    let mirror = kit.mirror();
    let floor = kit.painted(textures::checker("floor_checker", 8, rgb(0x7a5a44), rgb(0xefe2c8)));
    let plaster = kit.painted(textures::marble("plaster", 60, 3, rgb(0xb9c7cf), rgb(0xf2f4f1)));
    let labels = kit.painted(textures::labels("labels", 6, rgb(0x22343c), rgb(0xe8f0ea)));
    let stripes = kit.painted(textures::stripes("stripes", 6, rgb(0xc46f4e), rgb(0xf4e3cf)));
    let bricks = kit.painted(textures::bricks("bricks", 10, rgb(0x7f8f5a), rgb(0xe6e3cf)));
    kit.add_room(
        [Vec3::new(-3.5, 0.0, -2.8), Vec3::new(3.5, 3.6, 5.6)],
        [(floor, 3.5), (plaster, 3.6)],
        ([plaster, labels, stripes, bricks], 3.6),
    );
    let exact = Revolution::new(VASE_HEIGHT, VASE_PROFILE).map(AnalyticSurface::Revolution);
    kit.add_mirror("vase", mirror, exact, || vase_wall(values.tess()), at(0.0, 0.0, 0.0), values);
    if values.word("sphere") == "mirror" {
        // Above the way of the icosahedron, opposite the lizard.
        kit.add_sphere("sphere", mirror, 0.28, at(0.95, 1.27, 0.75), values);
    }
    // The mouth is closed a little below the rim, so that the inside needs no thought.
    let dark = kit.plain("mouth", rgb(0x1a1714));
    let depth = 0.985;
    let [mouth_radius, _] = vase_radius(depth);
    let disc = [(mouth_radius, Vec2::NEG_X), (0.0, Vec2::NEG_X)];
    let disc = disc.map(|(radius, direction)| ProfilePoint { radius, y: 0.0, direction });
    kit.add("vase_mouth", dark, shapes::revolution(&disc, segments), at(0.0, depth * VASE_HEIGHT as f32, 0.0));

    let skin = kit.painted(textures::paint("lizard_skin", 256, |p| {
        let scale = (p * 14.0).fract() - 0.5;
        let green = rgb(0x3f9b45).lerp(rgb(0xe8c437), (p.y * 1.1 - 0.05).clamp(0.0, 1.0));
        let eye = [Vec2::new(0.215, 0.055), Vec2::new(0.275, 0.065)].iter().any(|e| e.distance(p) < 0.012);
        if eye {
            rgb(0x101010)
        } else if scale.length() < 0.3 {
            green * 0.62
        } else {
            green
        }
    }));
    kit.add("lizard", skin, lizard(1.35), at(-1.05, 1.3, 0.75).turned_yxz(48.0, -10.0, 24.0));

    let pivot = kit.pivot("orbit", at(0.0, 0.62, 0.0));
    let faces = kit.painted(textures::patches("icosahedron_faces", 5));
    let icosahedron = kit.add("icosahedron", faces, shapes::icosahedron(0.3), at(1.42, 0.0, 0.0));
    kit.set_parent(icosahedron, pivot);
    let turns = |axis: Vec3, start: f32, turns: usize| -> (Vec<f32>, Vec<Quat>) {
        // Four keys a turn: a rotation between two keys takes the shorter way.
        let keys = turns * 4;
        (0..=keys)
            .map(|key| {
                let share = key as f32 / keys as f32;
                let angle = start + share * turns as f32 * TAU;
                (share * ORBIT_SECONDS, turn_about_f32(axis, angle))
            })
            .unzip()
    };
    let channels = [(pivot, Vec3::Y, -1.0, 1), (icosahedron, Vec3::new(0.36, 0.48, 0.8), 0.4, 2)];
    let channels = channels.map(|(node, axis, start, count)| {
        let (times, rotations) = turns(axis, start, count);
        Channel { node, times, interpolation: Interpolation::Linear, values: ChannelValues::Rotation(rotations) }
    });
    kit.model().animations.push(Animation { name: "orbit".into(), channels: channels.into() });

    let blue = kit.painted(textures::labels("blue_labels", 3, rgb(0xf5f9ff), rgb(0x3f6fc9)));
    let rose = kit.painted(textures::dots("rose_dots", 5, rgb(0xd65a7b), rgb(0xffe3ea)));
    kit.add_box("box_blue", blue, [0.6, 0.6, 0.6], at(-1.75, 0.0, -0.7).turned(25.0));
    kit.add_box("box_rose", rose, [0.5, 0.9, 0.5], at(1.8, 0.0, -0.9).turned(-18.0));
    kit.add_camera("front", Vec3::new(0.0, 1.45, 4.2), Vec3::new(0.0, 0.97, 0.0), 36.0);
    kit.add_camera("side", Vec3::new(2.7, 1.9, 3.0), Vec3::new(-0.15, 0.95, 0.0), 40.0);
    kit.finish()
}

/// The profile of the pot's closed body (radius, height), as cubic Bezier curves from the axis below to the axis
/// above: foot, belly, shoulder, lid and knob. Neighbouring curves share tangents but at the foot and under the lid.
const POT: [[[f32; 2]; 4]; 7] = [
    [[0.0, 0.0], [0.15, 0.0], [0.35, 0.0], [0.5, 0.0]],
    [[0.5, 0.0], [0.53, 0.0], [0.53, 0.06], [0.56, 0.09]],
    [[0.56, 0.09], [0.74, 0.27], [0.86, 0.38], [0.86, 0.62]],
    [[0.86, 0.62], [0.86, 0.88], [0.72, 1.02], [0.52, 1.09]],
    [[0.52, 1.09], [0.52, 1.14], [0.46, 1.155], [0.4, 1.17]],
    [[0.4, 1.17], [0.2, 1.22], [0.07, 1.2], [0.07, 1.26]],
    [[0.07, 1.26], [0.07, 1.29], [0.14, 1.29], [0.14, 1.35]],
];
/// The knob's top: the curve that ends on the axis.
const POT_KNOB: [[f32; 2]; 4] = [[0.14, 1.35], [0.14, 1.41], [0.08, 1.44], [0.0, 1.44]];

/// Point, first and second derivative of a cubic Bezier curve.
fn bezier(control: &[[f32; 2]; 4], t: f32) -> [Vec2; 3] {
    let [a, b, c, d] = control.map(Vec2::from);
    let (ab, bc, cd) = (b - a, c - b, d - c);
    let s = 1.0 - t;
    // The end itself is taken exactly, so that neighbouring curves meet.
    let point = if t == 1.0 {
        d
    } else {
        a + (ab * (3.0 * s * s + 3.0 * s * t + t * t) + bc * (t * (3.0 - 2.0 * t)) + cd * (t * t)) * t
    };
    let first = (ab * (s * s) + bc * (2.0 * s * t) + cd * (t * t)) * 3.0;
    let second = ((bc - ab) * s + (cd - bc) * t) * 6.0;
    [point, first, second]
}

/// The pot's body without spout and handle; closed.
pub(super) fn pot_body(tess: u32) -> Shape {
    let mut shape = Shape::default();
    for control in POT.iter().chain([&POT_KNOB]) {
        let curve = |t: f32| {
            let [point, direction, _] = bezier(control, t);
            (point, direction)
        };
        let chord = Vec2::from(control[0]).distance(Vec2::from(control[3]));
        let steps = ((tess as f32 * chord * 0.6).ceil() as u32).max(tess / 6).max(2);
        shapes::append(&mut shape, &shapes::revolution(&shapes::profile(steps, curve), tess * 2));
    }
    shape
}

fn bent_tube(tess: u32, control: &[[f32; 2]; 4], radii: [f32; 2]) -> Shape {
    shapes::tube(tess, tess.div_ceil(2).max(3), |t| TubePoint {
        curve: bezier(control, t),
        radius: [radii[0] + (radii[1] - radii[0]) * t, radii[1] - radii[0]],
    })
}

fn teapot(spec: &str, values: &Values<'_>) -> Model {
    let mut kit = Kit::lit(spec);
    let tess = values.tess();
    let segments = prop_segments(tess);
    let glass = values.word("material") == "glass";
    let table = kit.painted(textures::checker("table_checker", 12, rgb(0x8f2f2b), rgb(0xf3e8d3)));
    let wall = kit.painted(textures::tiles("wall_tiles", 8, rgb(0x9fc3c9), rgb(0xe9f1ef)));
    let window = kit.painted(textures::windows("windows", 5, rgb(0xe8d9bf)));
    let shelf = kit.painted(textures::planks("planks", 8, rgb(0xb98a58)));
    let plaster = kit.plain("plaster", rgb(0xf2eee4));
    kit.add_room(
        [Vec3::new(-3.0, 0.0, -2.2), Vec3::new(3.0, 3.2, 4.4)],
        [(table, 3.0), (plaster, 1.0)],
        ([wall, window, shelf, window], 3.2),
    );
    let glaze = if glass {
        let tint = Vec3::new(0.25, 0.1, 0.14);
        kit.material(Material { absorption: tint, ..Material::glass("glass", 1.5) })
    } else {
        kit.material(Material::mirror("glaze", Vec3::new(0.95, 0.93, 0.88)))
    };
    let stand = at(0.0, 0.0, 0.0).turned(-24.0);
    kit.add("pot_body", glaze, pot_body(tess), stand);
    if !glass {
        // They end inside the body; solid glass would show that.
        let spout = bent_tube(tess, &[[0.7, 0.42], [1.25, 0.42], [0.98, 0.95], [1.38, 1.14]], [0.2, 0.085]);
        kit.add("pot_spout", glaze, spout, stand);
        let handle = bent_tube(tess, &[[-0.68, 0.96], [-1.42, 1.12], [-1.42, 0.3], [-0.78, 0.34]], [0.075, 0.075]);
        kit.add("pot_handle", glaze, handle, stand);
    }
    let cup = kit.painted(textures::stripes("cup_stripes", 10, rgb(0x2f6fb0), rgb(0xf6f3ea)));
    let lemon = kit.painted(textures::marble("lemon", 70, 12, rgb(0xe9b91c), rgb(0xf7dc55)));
    let apple = kit.painted(textures::marble("apple", 80, 5, rgb(0xb3212b), rgb(0xd97a35)));
    let tin = kit.painted(textures::labels("tin_labels", 4, rgb(0xfaf3e3), rgb(0x2f7d57)));
    let book = kit.painted(textures::labels("book_labels", 3, rgb(0x3a2440), rgb(0xd9a441)));
    let cup_outline = [[0.0, 0.0], [0.2, 0.0], [0.3, 0.44], [0.27, 0.44], [0.18, 0.05], [0.0, 0.05]].map(Vec2::from);
    kit.add("cup", cup, shapes::turned(&cup_outline, segments), at(1.15, 0.0, 1.05));
    kit.add(
        "lemon",
        lemon,
        shapes::ellipsoid(Vec3::new(0.24, 0.17, 0.17), segments),
        at(-0.75, 0.17, 1.2).turned(35.0),
    );
    kit.add("apple", apple, shapes::sphere(0.22, segments), at(-1.28, 0.22, 0.72));
    kit.add("tin", tin, shapes::cylinder(0.34, 0.85, segments), at(-1.55, 0.0, -0.45));
    kit.add_box("book_lower", book, [0.95, 0.16, 0.7], at(1.55, 0.0, -0.6).turned(20.0));
    kit.add_box("book_upper", tin, [0.8, 0.13, 0.6], at(1.5, 0.16, -0.62).turned(38.0));

    let lamp = |strength: f32| (LightKind::Point { range: f32::INFINITY }, Vec3::new(1.0, 0.93, 0.82) * strength);
    for (name, strength, position) in [
        ("lamp_left", 12.0, Vec3::new(-1.6, 2.7, 1.8)),
        ("lamp_right", 10.0, Vec3::new(2.0, 2.6, 0.4)),
        ("lamp_behind", 8.0, Vec3::new(0.4, 2.2, 3.6)),
    ] {
        let (kind, intensity) = lamp(strength);
        kit.add_light(name, kind, intensity, position, Vec3::NEG_Y);
    }
    kit.add_light(
        "daylight",
        LightKind::Directional,
        Vec3::new(0.5, 0.6, 0.75),
        Vec3::ZERO,
        Vec3::new(0.3, -1.0, -0.5),
    );
    kit.add_camera("front", Vec3::new(0.0, 1.75, 3.7), Vec3::new(0.05, 0.62, 0.0), 36.0);
    kit.add_camera("low", Vec3::new(1.5, 0.7, 2.9), Vec3::new(0.0, 0.6, 0.0), 38.0);
    kit.finish()
}
