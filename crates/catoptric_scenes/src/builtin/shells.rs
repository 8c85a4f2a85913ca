//! One curved mirror in a gallery: a hollow dish, an ellipsoid, a torus.

use super::info::{BuiltinInfo, TESS};
use super::parameters::{EXACT_SURFACE, Values, choice};
use super::parts::kit::{Kit, at};
use super::parts::shapes::{self, prop_segments};
use super::parts::textures::{self, rgb};
use catoptric_core::scene::model::Model;
use catoptric_core::surface::{AnalyticSurface, Ellipsoid, Quadric, SurfaceError, Torus};
use glam::Vec3;

pub(super) const DISH: BuiltinInfo = BuiltinInfo {
    name: "dish",
    summary: "a hollow mirror with things inside its focus (upright, enlarged) and beyond it (upside down)",
    parameters: &[
        TESS,
        EXACT_SURFACE,
        choice("shape", "the form of the mirror; both have their focus 1 before it", &["sphere", "parabola"]),
    ],
    command: "catoptric render builtin:dish -o dish.png",
    build: dish,
};

pub(super) const ELLIPSOID: BuiltinInfo = BuiltinInfo {
    name: "ellipsoid",
    summary: "a mirror ellipsoid with three different axes, among near boxes and columns",
    parameters: &[TESS, EXACT_SURFACE],
    command: "catoptric render builtin:ellipsoid -o ellipsoid.png",
    build: ellipsoid,
};

pub(super) const TORUS: BuiltinInfo = BuiltinInfo {
    name: "torus",
    summary: "a mirror torus: convex outside, a saddle inside, and seen in itself",
    parameters: &[TESS, EXACT_SURFACE],
    command: "catoptric render builtin:torus --order 3 -o torus.png",
    build: torus,
};

/// Distance of the dish's focus from its deepest point.
const FOCAL_LENGTH: f32 = 1.0;
/// Radius of the dish's rim.
const DISH_RADIUS: f32 = 1.25;

/// The dish that opens towards +y, its deepest point at the origin; the outer side is the hollow one.
fn exact_dish(is_parabola: bool) -> Result<AnalyticSurface, SurfaceError> {
    let (focus, radius) = (FOCAL_LENGTH as f64, DISH_RADIUS as f64);
    // The sphere is |p|^2 = 4 f y, the paraboloid the same without y^2; the upper bound cuts them at the rim.
    let (yy, depth) = match is_parabola {
        true => (0.0, radius * radius / (4.0 * focus)),
        false => (-1.0, 2.0 * focus - (4.0 * focus * focus - radius * radius).sqrt()),
    };
    let coefficients = [-1.0, yy, -1.0, 0.0, 0.0, 0.0, 0.0, 4.0 * focus, 0.0, 0.0];
    // A little room beside the rim, which lies on the upper bound alone.
    let wide = 1.01 * radius;
    Quadric::new(coefficients, [-wide, 0.0, -wide], [wide, depth, wide]).map(AnalyticSurface::Quadric)
}

fn dish(spec: &str, values: &Values<'_>) -> Model {
    let mut kit = Kit::unlit(spec);
    let tess = values.tess();
    let segments = prop_segments(tess);
    let mirror = kit.mirror();
    let floor = kit.painted(textures::tiles("floor_tiles", 6, rgb(0x7fa08c), rgb(0x40554a)));
    let back = kit.painted(textures::marble("plaster", 90, 3, rgb(0x39424e), rgb(0x5b6876)));
    let labels = kit.painted(textures::labels("labels", 8, rgb(0x3b1f2b), rgb(0xfbf0dd)));
    let bricks = kit.painted(textures::bricks("bricks", 12, rgb(0xb8794a), rgb(0xe6dac6)));
    let stripes = kit.painted(textures::stripes("stripes", 8, rgb(0x46658f), rgb(0xe4e9f0)));
    let ceiling = kit.painted(textures::tiles("ceiling_tiles", 4, rgb(0xf1ead8), rgb(0xc9bfa5)));
    kit.add_room(
        [Vec3::new(-3.2, 0.0, -1.9), Vec3::new(3.2, 3.2, 5.6)],
        [(floor, 3.2), (ceiling, 3.2)],
        ([back, labels, bricks, stripes], 3.2),
    );
    let is_parabola = values.word("shape") == "parabola";
    let mesh = || match is_parabola {
        true => shapes::parabolic_dish(FOCAL_LENGTH, DISH_RADIUS, tess),
        false => shapes::spherical_dish(2.0 * FOCAL_LENGTH, DISH_RADIUS, tess),
    };
    // The dish opens towards the viewer; its deepest point is 1 behind the origin, so its focus is near the origin.
    let place = at(0.0, 1.5, -FOCAL_LENGTH).turned_yxz(0.0, 90.0, 0.0);
    kit.add_mirror("dish", mirror, exact_dish(is_parabola), mesh, place, values);
    let red = kit.painted(textures::labels("red_labels", 2, rgb(0xfff2dc), rgb(0xd9483b)));
    let yellow = kit.painted(textures::stripes("yellow_stripes", 6, rgb(0xf0bd2d), rgb(0x7c4a12)));
    let blue = kit.painted(textures::checker("blue_checker", 4, rgb(0x2f63c4), rgb(0xcfe0ff)));
    let faces = kit.painted(textures::patches("icosahedron_faces", 5));
    kit.add("column_inside", yellow, shapes::cylinder(0.07, 1.35, segments), at(-0.5, 0.0, -0.45));
    kit.add_box("box_inside", red, [0.24, 0.24, 0.24], at(-0.5, 1.35, -0.45).turned(25.0));
    kit.add("icosahedron_beyond", faces, shapes::icosahedron(0.24), at(0.72, 0.95, 1.0).turned(10.0));
    kit.add("column_beyond", blue, shapes::cylinder(0.08, 0.76, segments), at(0.72, 0.0, 1.0));
    kit.add_box("box_beyond", blue, [0.5, 0.5, 0.5], at(-1.15, 0.0, 1.3).turned(-20.0));
    kit.add_camera("front", Vec3::new(0.25, 1.75, 4.4), Vec3::new(0.0, 1.4, -0.5), 36.0);
    kit.finish()
}

/// A room with columns and boxes around a pedestal that ends at `pedestal_height`.
fn gallery(kit: &mut Kit, values: &Values<'_>, accent: u32, ground: u32, pedestal_height: f32) {
    let segments = prop_segments(values.tess());
    let (accent, ground) = (rgb(accent), rgb(ground));
    let floor = kit.painted(textures::checker("floor_checker", 8, accent * 0.55, ground));
    let back = kit.painted(textures::tiles("wall_tiles", 6, ground * 0.95, accent));
    let front = kit.painted(textures::labels("labels", 8, accent * 0.3, ground));
    let left = kit.painted(textures::bricks("bricks", 12, accent, ground));
    let right = kit.painted(textures::windows("windows", 17, ground * 0.9));
    let ceiling = kit.painted(textures::dots("ceiling_dots", 6, ground, accent.lerp(ground, 0.25)));
    kit.add_room(
        [Vec3::new(-3.0, 0.0, -2.6), Vec3::new(3.0, 3.2, 4.8)],
        [(floor, 3.0), (ceiling, 3.2)],
        ([back, front, left, right], 3.2),
    );
    let stone = kit.painted(textures::marble("marble", 31, 4, accent * 0.5, ground));
    kit.add("pedestal", stone, shapes::cylinder(0.45, pedestal_height, segments), at(0.0, 0.0, 0.0));
    let red = kit.painted(textures::labels("red_labels", 3, rgb(0xfff2dc), rgb(0xd1473a)));
    let blue = kit.painted(textures::checker("blue_checker", 4, rgb(0x2f63c4), rgb(0xcfe0ff)));
    let gold = kit.painted(textures::stripes("gold_stripes", 6, rgb(0xe0a526), rgb(0x6b3d10)));
    let green = kit.painted(textures::dots("green_dots", 5, rgb(0x3f8f54), rgb(0xe3f5d8)));
    kit.add_box("box_red", red, [0.55, 0.55, 0.55], at(-1.35, 0.0, 0.6).turned(28.0));
    kit.add_box("box_blue", blue, [0.6, 1.3, 0.6], at(1.55, 0.0, -0.7).turned(15.0));
    kit.add_box("box_green", green, [0.45, 0.45, 0.45], at(1.1, 0.0, 0.85).turned(-35.0));
    kit.add_box("box_low", blue, [0.4, 0.3, 0.4], at(-0.55, 0.0, 1.35).turned(12.0));
    kit.add("column_left", gold, shapes::cylinder(0.15, 3.2, segments), at(-1.75, 0.0, -0.35));
    kit.add("column_right", red, shapes::cylinder(0.15, 3.2, segments), at(1.8, 0.0, 0.5));
    kit.add("column_back", green, shapes::cylinder(0.15, 3.2, segments), at(-0.6, 0.0, -1.7));
}

fn ellipsoid(spec: &str, values: &Values<'_>) -> Model {
    let mut kit = Kit::unlit(spec);
    let mirror = kit.mirror();
    gallery(&mut kit, values, 0x3f7f8c, 0xf2ead9, 0.6);
    let radii = [1.15, 0.68, 0.5];
    let exact = Ellipsoid::new(radii).map(AnalyticSurface::Ellipsoid);
    let mesh = || shapes::ellipsoid(Vec3::from(radii.map(|radius| radius as f32)), values.tess());
    kit.add_mirror("ellipsoid", mirror, exact, mesh, at(0.0, 1.34, 0.0).turned_yxz(24.0, 0.0, 14.0), values);
    kit.add_camera("front", Vec3::new(0.2, 1.75, 3.5), Vec3::new(0.0, 1.25, 0.0), 40.0);
    kit.finish()
}

fn torus(spec: &str, values: &Values<'_>) -> Model {
    let mut kit = Kit::unlit(spec);
    let mirror = kit.mirror();
    gallery(&mut kit, values, 0x8a5a9e, 0xf3eee2, 0.34);
    let exact = Torus::new(0.8, 0.32).map(AnalyticSurface::Torus);
    let mesh = || shapes::torus(0.8, 0.32, values.tess());
    kit.add_mirror("torus", mirror, exact, mesh, at(0.0, 1.4, 0.0).turned_yxz(18.0, 62.0, 0.0), values);
    kit.add_camera("front", Vec3::new(0.1, 1.9, 3.4), Vec3::new(0.0, 1.33, 0.0), 42.0);
    kit.finish()
}
