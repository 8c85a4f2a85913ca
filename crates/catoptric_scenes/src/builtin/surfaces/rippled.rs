//! Mirrors and glass with bumps: a pool of rippled water, a wavy mirror and a pane of ornamental glass.

use super::super::info::{BuiltinInfo, TESS};
use super::super::parameters::{ParameterInfo, Values, number};
use super::super::parts::kit::{Kit, at};
use super::super::parts::shapes::{self, prop_segments};
use super::super::parts::textures::{self, Wave, rgb};
use catoptric_core::scene::model::Model;
use catoptric_core::scene::{Material, Role};
use glam::{Vec2, Vec3};

const BUMPS: ParameterInfo = number("bumps", "1", "the scale of all normal maps; 0: smooth", 0.0, 4.0);

const COPIES: ParameterInfo =
    number("copies", "1", "how many times smaller the water's ripples are; 40: smaller than pixels", 1.0, 100.0);

pub(in super::super) const RIPPLED: BuiltinInfo = BuiltinInfo {
    name: "rippled",
    summary: "rippled water, a wavy mirror and a pane of bumpy glass: their normal maps turn rays",
    parameters: &[TESS, BUMPS, COPIES],
    command: "catoptric render builtin:rippled -o rippled.png",
    build: rippled,
};

fn wave(u: i32, v: i32, amplitude: f32, phase: f32) -> Wave {
    Wave { count: [u, v], amplitude, phase }
}

fn rippled(spec: &str, values: &Values<'_>) -> Model {
    let mut kit = Kit::unlit(spec);
    let segments = prop_segments(values.tess());
    let bumps = values.number(BUMPS.name);
    let checker = kit.painted(textures::checker("checker", 12, rgb(0x5b3f2e), rgb(0xcdb79e)));
    let wall = kit.painted(textures::bricks("bricks", 10, rgb(0x8a6d52), rgb(0xd9cfc0)));
    let labels = kit.painted(textures::labels("labels", 8, rgb(0x1d2b44), rgb(0xf6efe0)));
    let ceiling = kit.painted(textures::tiles("ceiling", 4, rgb(0xdfe8ef), rgb(0x9fb0bd)));
    kit.add_room(
        [Vec3::new(-4.0, 0.0, -4.0), Vec3::new(4.0, 4.0, 5.0)],
        [(checker, 4.0), (ceiling, 3.0)],
        ([labels, wall, wall, wall], 3.4),
    );
    let mut bumpy = |material: Material, name: &str, waves: &[Wave]| {
        let material = kit.material(material);
        if bumps > 0.0 {
            kit.set_normal_map(material, textures::ripples(name, 256, waves), bumps);
        }
        material
    };
    let ripples =
        [wave(2, 1, 1.8e-3, 0.3), wave(-1, 3, 1.4e-3, 1.7), wave(3, 4, 0.7e-3, 4.1), wave(5, -2, 0.6e-3, 2.6)];
    let water = bumpy(Material::mirror("water", Vec3::new(0.80, 0.88, 0.92)), "ripples", &ripples);
    let waves = [wave(3, 0, 1.6e-3, 0.0), wave(1, 2, 1.2e-3, 2.0)];
    let wavy = bumpy(Material::mirror("wavy_mirror", Vec3::splat(0.93)), "waves", &waves);
    let dimples = [wave(7, 0, 1.5e-3, 0.0), wave(0, 7, 1.5e-3, 1.0)];
    let glass = Material { role: Role::Lens, ior: 1.5, ..Material::diffuse("glass", Vec3::new(0.95, 0.99, 0.97)) };
    let glass = bumpy(glass, "dimples", &dimples);
    let tile = 2.2 / values.number(COPIES.name);
    let pool =
        shapes::rectangle(Vec3::new(-2.6, 0.06, 3.2), Vec3::X * 5.2, Vec3::NEG_Z * 4.4, [8, 8], Vec2::splat(tile));
    kit.add("water", water, pool, at(0.0, 0.0, 0.0));
    let mirror = shapes::rectangle(Vec3::ZERO, Vec3::X * 2.2, Vec3::Y * 1.9, [4, 4], Vec2::splat(1.6));
    kit.add("wavy_mirror", wavy, mirror, at(-3.2, 0.9, -2.6).turned(18.0));
    kit.add_box("pane", glass, [1.1, 1.2, 0.1], at(1.75, 0.95, 1.5).turned(-20.0));
    let red = kit.plain("red", rgb(0xd03a2b));
    let blue = kit.plain("blue", rgb(0x2c63c8));
    let stripes = kit.painted(textures::stripes("yellow_stripes", 6, rgb(0xf0c230), rgb(0x33302a)));
    for (index, x) in [-1.9, -0.5, 0.7, 2.2].into_iter().enumerate() {
        let material = [red, stripes, blue, red][index];
        kit.add(
            ["post_1", "post_2", "post_3", "post_4"][index],
            material,
            shapes::cylinder(0.12, 1.7, segments),
            at(x, 0.0, -1.6),
        );
    }
    kit.add_box("block", blue, [0.5, 0.5, 0.5], at(-1.2, 0.06, 0.6).turned(25.0));
    kit.add("ball", stripes, shapes::sphere(0.35, segments), at(0.4, 0.42, 0.9));
    kit.add_camera("front", Vec3::new(0.1, 1.5, 4.6), Vec3::new(0.0, 0.75, 0.0), 45.0);
    kit.add_camera("low", Vec3::new(-1.5, 0.7, 4.0), Vec3::new(0.4, 0.4, 0.0), 40.0);
    kit.finish()
}
