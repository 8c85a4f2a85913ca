//! Mirror spheres among near objects.

use super::info::{BuiltinInfo, TESS};
use super::parameters::{BLEND, SEED, SURFACE, Values};
use super::parts::kit::{Kit, Place, at};
use super::parts::shapes::{self, prop_segments};
use super::parts::textures::{self, rgb};
use catoptric_core::math::random::Stream;
use catoptric_core::scene::model::Model;
use glam::{Vec2, Vec3};

pub(super) const SPHERE_ROOM: BuiltinInfo = BuiltinInfo {
    name: "sphere_room",
    summary: "a mirror sphere in a room, with boxes and columns so near that an environment map fails",
    parameters: &[TESS, SURFACE, BLEND],
    command: "catoptric render builtin:sphere_room -o sphere_room.png",
    build: sphere_room,
};

pub(super) const TWO_SPHERES: BuiltinInfo = BuiltinInfo {
    name: "two_spheres",
    summary: "two mirror spheres that face each other, with small coloured things around them",
    parameters: &[TESS, SURFACE, SEED],
    command: "catoptric render builtin:two_spheres --order 4 -o two_spheres.png",
    build: two_spheres,
};

fn sphere_room(spec: &str, values: &Values<'_>) -> Model {
    let mut kit = Kit::unlit(spec);
    let segments = prop_segments(values.tess());
    let mirror = kit.blended_mirror(1.5, rgb(0x9db4c0), values);
    let planks = kit.painted(textures::planks("planks", 10, rgb(0xc99a63)));
    let plaster = kit.painted(textures::tiles("ceiling_tiles", 4, rgb(0xf1ead8), rgb(0xc9bfa5)));
    let labels = kit.painted(textures::labels("labels", 8, rgb(0x1d2b44), rgb(0xf6efe0)));
    let bricks = kit.painted(textures::bricks("bricks", 12, rgb(0xb4553c), rgb(0xd9cfc0)));
    let stripes = kit.painted(textures::stripes("stripes", 8, rgb(0x5d8fb3), rgb(0xe9eef0)));
    let checker = kit.painted(textures::checker("green_checker", 8, rgb(0x4c8c5e), rgb(0xdde6c7)));
    kit.add_room(
        [Vec3::new(-3.0, 0.0, -2.6), Vec3::new(3.0, 3.2, 4.2)],
        [(planks, 2.0), (plaster, 3.0)],
        ([labels, checker, bricks, stripes], 3.2),
    );
    let stone = kit.painted(textures::marble("marble", 21, 4, rgb(0x8f8a99), rgb(0xe8e4e6)));
    kit.add("pedestal", stone, shapes::cylinder(0.42, 0.5, segments), at(0.0, 0.0, 0.0));
    kit.add_sphere("sphere", mirror, 0.8, at(0.0, 1.3, 0.0), values);

    let red = kit.painted(textures::labels("red_labels", 4, rgb(0xfff2dc), rgb(0xd9483b)));
    let blue = kit.painted(textures::checker("blue_checker", 4, rgb(0x2f63c4), rgb(0xcfe0ff)));
    let yellow = kit.painted(textures::dots("yellow_dots", 4, rgb(0xf2c230), rgb(0x7c4a12)));
    let violet = kit.painted(textures::checker("violet_checker", 4, rgb(0x7a3fa0), rgb(0xe6ccf2)));
    kit.add_box("box_red", red, [0.62, 0.62, 0.62], at(-1.2, 0.0, 0.5).turned(28.0));
    kit.add_box("box_yellow", yellow, [0.4, 0.4, 0.4], at(-1.16, 0.62, 0.48).turned(-12.0));
    kit.add_box("box_blue", blue, [0.7, 1.15, 0.7], at(1.35, 0.0, -0.75).turned(20.0));
    kit.add_box("box_violet", violet, [0.5, 0.5, 0.5], at(0.95, 0.0, 0.85).turned(-30.0));
    kit.add_box("box_low", red, [0.9, 0.3, 0.5], at(0.1, 0.0, -1.5).turned(8.0));

    let candy = kit.painted(textures::stripes("candy_stripes", 6, rgb(0xd8324a), rgb(0xfff6ee)));
    let teal = kit.painted(textures::bricks("teal_bricks", 8, rgb(0x2d9c95), rgb(0xe7f4ee)));
    for (name, material, x, z) in [
        ("column_left", candy, -1.6, -0.75),
        ("column_right", teal, 1.3, 0.45),
        ("column_back", teal, -0.55, -1.75),
        ("column_front", candy, 0.9, 3.3),
    ] {
        kit.add(name, material, shapes::cylinder(0.16, 3.2, segments), at(x, 0.0, z));
    }
    kit.add_camera("front", Vec3::new(-0.35, 1.8, 3.4), Vec3::new(0.0, 1.13, 0.0), 42.0);
    kit.add_camera("close", Vec3::new(0.6, 1.6, 2.0), Vec3::new(0.0, 1.3, 0.0), 50.0);
    kit.add_camera("high", Vec3::new(-1.9, 2.9, 2.6), Vec3::new(0.1, 1.0, 0.0), 50.0);
    kit.finish()
}

/// Radius of the two spheres.
const PAIR_RADIUS: f32 = 0.9;
/// Half the distance of their centres.
const PAIR_OFFSET: f32 = 1.3;

fn two_spheres(spec: &str, values: &Values<'_>) -> Model {
    let mut kit = Kit::unlit(spec);
    let segments = prop_segments(values.tess());
    let mirror = kit.mirror();
    let floor = kit.painted(textures::checker("floor_checker", 8, rgb(0x3b4252), rgb(0xe5e9f0)));
    let wall = kit.painted(textures::tiles("wall_tiles", 6, rgb(0xe2c391), rgb(0x8d6b3f)));
    let far = kit.painted(textures::labels("wall_labels", 6, rgb(0x5b2333), rgb(0xf7efe1)));
    let sky = kit.painted(textures::marble("sky", 40, 3, rgb(0x6fa8dc), rgb(0xeaf3fb)));
    kit.add_room(
        [Vec3::new(-4.0, 0.0, -3.0), Vec3::new(4.0, 4.0, 6.0)],
        [(floor, 4.0), (sky, 4.0)],
        ([far, wall, wall, wall], 4.0),
    );
    for (name, sign) in [("sphere_left", -1.0), ("sphere_right", 1.0)] {
        kit.add_sphere(name, mirror, PAIR_RADIUS, at(sign * PAIR_OFFSET, PAIR_RADIUS, 0.0), values);
    }
    let colors = [
        ("coral", rgb(0xe4572e)),
        ("amber", rgb(0xf3a712)),
        ("leaf", rgb(0x669b3c)),
        ("sea", rgb(0x2a9d8f)),
        ("sky_blue", rgb(0x3d7bd9)),
        ("plum", rgb(0x8d4fa8)),
    ];
    let materials: Vec<usize> = colors
        .iter()
        .map(|(name, color)| kit.painted(textures::checker(name, 4, *color, *color * 0.45 + 0.55)))
        .collect();
    // Between the spheres, where both reflect it again and again.
    kit.add("post", materials[1], shapes::cylinder(0.11, 0.75, segments), at(0.0, 0.0, 0.05));
    kit.add("post_ball", materials[0], shapes::sphere(0.2, segments), at(0.0, 0.95, 0.05));

    let mut random = Stream::new(values.integer("seed"));
    let mut placed: Vec<(Vec2, f32)> = vec![
        (Vec2::new(-PAIR_OFFSET, 0.0), PAIR_RADIUS * 0.9),
        (Vec2::new(PAIR_OFFSET, 0.0), PAIR_RADIUS * 0.9),
        (Vec2::new(0.0, 0.05), 0.25),
    ];
    let mut count = 0;
    // Places that are taken are left out; the number of trials is bounded, whatever the seed.
    for _ in 0..2000 {
        if count == 26 {
            break;
        }
        let place = Vec2::new(random.next_between(-3.0, 3.0), random.next_between(-2.2, 2.1));
        let radius = random.next_between(0.11, 0.22);
        if placed.iter().any(|(other, other_radius)| place.distance(*other) < radius + other_radius + 0.12) {
            continue;
        }
        placed.push((place, radius));
        let material = materials[count % materials.len()];
        let name = format!("thing_{}", count + 1);
        let stand = at(place.x, 0.0, place.y).turned(random.next_between(0.0, 90.0));
        let side = radius * 1.4;
        match count % 4 {
            0 => kit.add_box(&name, material, [side; 3], stand),
            1 => kit.add(&name, material, shapes::cone(radius, radius * 2.6, segments), stand),
            2 => {
                let lifted = Place { translation: stand.translation + Vec3::Y * radius, ..stand };
                kit.add(&name, material, shapes::sphere(radius, segments), lifted)
            }
            _ => kit.add(&name, material, shapes::cylinder(radius * 0.8, radius * 2.0, segments), stand),
        };
        count += 1;
    }
    kit.add_camera("front", Vec3::new(0.0, 1.75, 4.6), Vec3::new(0.0, 0.78, 0.0), 36.0);
    kit.add_camera("between", Vec3::new(-0.2, 1.0, 1.5), Vec3::new(0.5, 0.8, 0.0), 60.0);
    kit.finish()
}
