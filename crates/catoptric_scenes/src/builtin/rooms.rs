//! Flat mirrors on the walls of a room.

use super::info::{BuiltinInfo, TESS};
use super::parameters::{BLEND, SURFACE, Values, integer};
use super::parts::kit::{Kit, at};
use super::parts::shapes::{self, prop_segments};
use super::parts::textures::{self, rgb};
use catoptric_core::math::portable::PortableMath;
use catoptric_core::scene::model::Model;
use catoptric_core::surface::AnalyticSurface;
use glam::{Vec2, Vec3};

pub(super) const PLANAR_MIRROR: BuiltinInfo = BuiltinInfo {
    name: "planar_mirror",
    summary: "a room with one to four flat mirrors: behind, to the right, before and to the left of the things",
    parameters: &[
        TESS,
        SURFACE,
        integer("mirrors", "2", "1: back wall; 2: and right wall; 3: and front wall; 4: and left wall", 1, 4),
        BLEND,
    ],
    command: "catoptric render \"builtin:planar_mirror?mirrors=2\" --order 4 -o planar_mirror.png",
    build: planar_mirror,
};

/// Half the side of the room.
const HALF: f32 = 2.6;
/// Width and height of the mirrors.
const MIRROR_SIZE: [f32; 2] = [3.6, 1.9];
/// Width of their frames.
const FRAME: f32 = 0.1;

fn planar_mirror(spec: &str, values: &Values<'_>) -> Model {
    let mut kit = Kit::unlit(spec);
    let segments = prop_segments(values.tess());
    let mirror = kit.blended_mirror(3.0, rgb(0x9db4c0), values);
    let floor = kit.painted(textures::planks("planks", 10, rgb(0xb98754)));
    let ceiling = kit.painted(textures::tiles("ceiling_tiles", 4, rgb(0xf1ead8), rgb(0xc9bfa5)));
    let back = kit.painted(textures::marble("plaster", 50, 3, rgb(0xa9b8a2), rgb(0xe2e8da)));
    let front = kit.painted(textures::labels("labels", 8, rgb(0x2d2433), rgb(0xf2e9da)));
    let left = kit.painted(textures::bricks("bricks", 12, rgb(0xb4553c), rgb(0xd9cfc0)));
    let right = kit.painted(textures::stripes("stripes", 8, rgb(0x7a9cc0), rgb(0xe9eef0)));
    kit.add_room(
        [Vec3::new(-HALF, 0.0, -HALF), Vec3::new(HALF, 2.8, HALF)],
        [(floor, 2.0), (ceiling, 2.6)],
        ([back, front, left, right], 2.8),
    );
    let wood = kit.painted(textures::planks("frame_wood", 4, rgb(0x7b4a26)));
    let [width, height] = MIRROR_SIZE;
    let middle_height = 1.4;
    let walls = [("back", 0.0), ("right", -90.0), ("front", 180.0), ("left", 90.0)];
    for (wall, turn_deg) in walls.into_iter().take(values.integer("mirrors") as usize) {
        let name = format!("mirror_{wall}");
        let inwards = Vec3::new(f32::to_radians(turn_deg).sine(), 0.0, f32::to_radians(turn_deg).cosine());
        let across = Vec3::Y.cross(inwards);
        let center = -inwards * (HALF - 0.04) + Vec3::Y * middle_height;
        let place = at(center.x, center.y, center.z).turned(turn_deg);
        if values.analytic() {
            let surface = AnalyticSurface::Plane { half_width: width as f64 * 0.5, half_height: height as f64 * 0.5 };
            kit.add_analytic(&name, mirror, surface, place.turned_yxz(0.0, 90.0, 0.0));
        } else {
            let corner = Vec3::new(-width * 0.5, -height * 0.5, 0.0);
            let sheet = shapes::rectangle(corner, Vec3::X * width, Vec3::Y * height, [1, 1], Vec2::ONE);
            kit.add(&name, mirror, sheet, place);
        }
        for (part, offset, size) in [
            ("top", Vec3::Y * (height * 0.5), [width + 2.0 * FRAME, FRAME, 0.08]),
            ("bottom", Vec3::Y * (-height * 0.5 - FRAME), [width + 2.0 * FRAME, FRAME, 0.08]),
            ("one_side", across * (width + FRAME) * 0.5 - Vec3::Y * height * 0.5, [FRAME, height, 0.08]),
            ("other_side", across * -(width + FRAME) * 0.5 - Vec3::Y * height * 0.5, [FRAME, height, 0.08]),
        ] {
            let foot = center + offset - inwards * 0.001;
            let name = format!("frame_{wall}_{part}");
            kit.add_box(&name, wood, size, at(foot.x, foot.y, foot.z).turned(turn_deg));
        }
    }
    let red = kit.painted(textures::labels("red_labels", 3, rgb(0xfff2dc), rgb(0xd1473a)));
    let blue = kit.painted(textures::checker("blue_checker", 4, rgb(0x2f63c4), rgb(0xcfe0ff)));
    let gold = kit.painted(textures::dots("gold_dots", 4, rgb(0xf0bd2d), rgb(0x7c4a12)));
    let faces = kit.painted(textures::patches("icosahedron_faces", 5));
    let ball = kit.painted(textures::checker("ball_checker", 8, rgb(0xc2336f), rgb(0xffe6ef)));
    kit.add_box("box_red", red, [0.6, 0.6, 0.6], at(-0.9, 0.0, -0.9).turned(25.0));
    kit.add_box("box_blue", blue, [0.5, 1.2, 0.5], at(0.2, 0.0, -1.6).turned(-15.0));
    kit.add_box("box_gold", gold, [0.45, 0.45, 0.45], at(1.5, 0.0, -0.55).turned(40.0));
    kit.add("icosahedron", faces, shapes::icosahedron(0.3), at(1.5, 0.72, -0.55).turned(15.0));
    kit.add("ball", ball, shapes::sphere(0.3, segments), at(0.55, 0.3, -0.4));
    kit.add("cone", gold, shapes::cone(0.26, 0.8, segments), at(-1.7, 0.0, -1.5));
    kit.add_camera("corner", Vec3::new(-1.75, 1.75, 2.1), Vec3::new(0.75, 0.95, -1.6), 52.0);
    kit.add_camera("back_wall", Vec3::new(-0.3, 1.5, 2.3), Vec3::new(0.0, 1.2, -2.6), 50.0);
    kit.finish()
}
