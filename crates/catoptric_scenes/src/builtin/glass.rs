//! Glass bodies before patterns.

use super::info::{BuiltinInfo, TESS};
use super::parameters::{ParameterInfo, SURFACE, Values, number};
use super::parts::kit::{Kit, at};
use super::parts::shapes::{self, prop_segments};
use super::parts::textures::{self, rgb};
use catoptric_core::math::portable::PortableMath;
use catoptric_core::scene::Material;
use catoptric_core::scene::model::Model;
use glam::{Vec2, Vec3};

const IOR: ParameterInfo = number("ior", "1.5", "index of refraction of the glass", 1.0, 3.0);

pub(super) const GLASS_SPHERE: BuiltinInfo = BuiltinInfo {
    name: "glass_sphere",
    summary: "a glass sphere before a checkerboard, which it shows upside down",
    parameters: &[TESS, SURFACE, IOR],
    command: "catoptric render builtin:glass_sphere --order 4 -o glass_sphere.png",
    build: glass_sphere,
};

pub(super) const GLASS_SLAB: BuiltinInfo = BuiltinInfo {
    name: "glass_slab",
    summary: "a thick slanted glass plate before a checkerboard, which it shifts sideways",
    parameters: &[TESS, IOR],
    command: "catoptric render builtin:glass_slab --order 4 -o glass_slab.png",
    build: glass_slab,
};

pub(super) const LENS: BuiltinInfo = BuiltinInfo {
    name: "lens",
    summary: "a biconvex lens before a target, as a magnifying glass or (far from it) turning it upside down",
    parameters: &[
        TESS,
        IOR,
        number("curvature", "2", "radius of the lens's two faces; its own radius is 0.9", 1.0, 100.0),
        number("distance", "1", "from the lens to the target", 0.7, 6.0),
    ],
    command: "catoptric render builtin:lens --order 4 -o lens.png",
    build: lens,
};

/// A room with its back wall, of the material `back`, at `z = -depth`.
fn studio(kit: &mut Kit, depth: f32, back: usize) {
    let floor = kit.painted(textures::planks("planks", 10, rgb(0xa87c52)));
    let wall = kit.painted(textures::bricks("bricks", 12, rgb(0x8a6f8f), rgb(0xded5dd)));
    let front = kit.painted(textures::windows("windows", 9, rgb(0xcfc4ae)));
    let ceiling = kit.painted(textures::tiles("ceiling_tiles", 4, rgb(0xf0ece2), rgb(0xc4bdaa)));
    kit.add_room(
        [Vec3::new(-3.2, 0.0, -depth), Vec3::new(3.2, 3.2, 5.0)],
        [(floor, 2.0), (ceiling, 3.2)],
        ([back, front, wall, wall], 3.2),
    );
}

fn glass(kit: &mut Kit, values: &Values<'_>) -> usize {
    kit.material(Material::glass("glass", values.number("ior")))
}

fn glass_sphere(spec: &str, values: &Values<'_>) -> Model {
    let mut kit = Kit::unlit(spec);
    let segments = prop_segments(values.tess());
    let glass = glass(&mut kit, values);
    let checker = kit.painted(textures::checker("checker", 12, rgb(0x24466b), rgb(0xf3ead2)));
    studio(&mut kit, 2.2, checker);
    let stone = kit.painted(textures::marble("marble", 22, 4, rgb(0x6f7d78), rgb(0xdde6df)));
    kit.add("pedestal", stone, shapes::cylinder(0.4, 0.55, segments), at(0.0, 0.0, 0.0));
    kit.add_sphere("sphere", glass, 0.8, at(0.0, 1.36, 0.0), values);
    let red = kit.painted(textures::labels("red_labels", 3, rgb(0xfff2dc), rgb(0xd1473a)));
    let gold = kit.painted(textures::stripes("gold_stripes", 6, rgb(0xe0a526), rgb(0xfff1c9)));
    kit.add_box("box_red", red, [0.6, 0.9, 0.6], at(-0.95, 0.0, -1.3).turned(22.0));
    kit.add("column_gold", gold, shapes::cylinder(0.15, 3.2, segments), at(0.75, 0.0, -1.45));
    kit.add_box("box_near", gold, [0.4, 0.4, 0.4], at(1.15, 0.0, 0.75).turned(-25.0));
    kit.add_camera("front", Vec3::new(0.25, 1.7, 3.5), Vec3::new(0.0, 1.25, 0.0), 40.0);
    kit.finish()
}

fn glass_slab(spec: &str, values: &Values<'_>) -> Model {
    let mut kit = Kit::unlit(spec);
    let segments = prop_segments(values.tess());
    let glass = glass(&mut kit, values);
    let checker = kit.painted(textures::checker("checker", 8, rgb(0x5b2a4e), rgb(0xf6ecd9)));
    studio(&mut kit, 1.9, checker);
    kit.add_box("slab", glass, [2.1, 1.7, 0.55], at(0.0, 0.35, 0.0).turned(34.0));
    let steel = kit.painted(textures::marble("steel", 33, 6, rgb(0x59636e), rgb(0x9aa7b3)));
    for (name, side) in [("foot_left", -0.75), ("foot_right", 0.75)] {
        let (sin, cos) = 34f32.to_radians().sine_cosine();
        kit.add_box(name, steel, [0.2, 0.35, 0.5], at(side * cos, 0.0, -side * sin).turned(34.0));
    }
    let green = kit.painted(textures::labels("green_labels", 3, rgb(0xf3fff0), rgb(0x2f8a4c)));
    let orange = kit.painted(textures::stripes("orange_stripes", 6, rgb(0xe5752c), rgb(0xfff0df)));
    kit.add("column", orange, shapes::cylinder(0.14, 3.2, segments), at(0.35, 0.0, -1.2));
    kit.add_box("box_behind", green, [0.6, 0.95, 0.4], at(-0.65, 0.0, -1.1).turned(-10.0));
    kit.add_box("box_near", orange, [0.4, 0.4, 0.4], at(-1.3, 0.0, 0.9).turned(30.0));
    kit.add_camera("front", Vec3::new(0.1, 1.6, 3.9), Vec3::new(0.0, 1.15, 0.0), 38.0);
    kit.finish()
}

/// Radius of the lens's rim.
const LENS_RADIUS: f32 = 0.9;

fn lens(spec: &str, values: &Values<'_>) -> Model {
    let mut kit = Kit::unlit(spec);
    let tess = values.tess();
    let glass = glass(&mut kit, values);
    let distance = values.number("distance");
    let target = kit.painted(textures::target("target", 12, rgb(0xfdf6e3), rgb(0x2f5d7c), rgb(0xc8321f)));
    let plaster = kit.painted(textures::marble("plaster", 44, 3, rgb(0x6d7f86), rgb(0xaebbbd)));
    studio(&mut kit, distance + 0.04, plaster);
    let panel = shapes::rectangle(Vec3::new(-1.6, -1.4, 0.0), Vec3::X * 3.2, Vec3::Y * 2.8, [16, 14], Vec2::splat(3.2));
    kit.add("target", target, panel, at(0.0, 1.5, -distance));
    let body = shapes::biconvex_lens(values.number("curvature"), LENS_RADIUS, tess);
    kit.add("lens", glass, body, at(0.0, 1.5, 0.0).turned_yxz(0.0, 90.0, 0.0));
    let wood = kit.painted(textures::planks("stand_wood", 4, rgb(0x8b5a33)));
    kit.add("stand_post", wood, shapes::cylinder(0.06, 0.56, prop_segments(tess)), at(0.0, 0.0, 0.0));
    kit.add("stand_foot", wood, shapes::cylinder(0.4, 0.06, prop_segments(tess)), at(0.0, 0.0, 0.0));
    let red = kit.painted(textures::labels("red_labels", 3, rgb(0xfff2dc), rgb(0xc9433a)));
    let teal = kit.painted(textures::stripes("teal_stripes", 6, rgb(0x2d9c95), rgb(0xe7f4ee)));
    kit.add_box("box_red", red, [0.55, 0.55, 0.35], at(-1.4, 0.0, -0.25).turned(20.0));
    kit.add("cone_teal", teal, shapes::cone(0.28, 0.8, prop_segments(tess)), at(1.45, 0.0, -0.1));
    kit.add_camera("front", Vec3::new(0.3, 1.65, 4.2), Vec3::new(0.0, 1.42, 0.0), 36.0);
    kit.finish()
}
