//! A workbench with things of a dozen materials: metals, paints, wood, rubber, glass.

use super::super::info::{BuiltinInfo, TESS};
use super::super::parameters::Values;
use super::super::parts::kit::{Kit, at};
use super::super::parts::shapes::{self, prop_segments};
use super::super::parts::textures::{self, linear, rgb};
use catoptric_core::scene::model::Model;
use catoptric_core::scene::{LightKind, Material, Microfacets, Role};
use glam::{Vec2, Vec3};

pub(in super::super) const WORKSHOP: BuiltinInfo = BuiltinInfo {
    name: "workshop",
    summary: "a lit workbench with things of metal, lacquer, glaze, wood, rubber, leather, cloth and glass",
    parameters: &[TESS],
    command: "catoptric render builtin:workshop --order 3 -o workshop.png",
    build: workshop,
};

/// The height of the bench's top.
const TOP: f32 = 0.9;

fn workshop(spec: &str, values: &Values<'_>) -> Model {
    let mut kit = Kit::lit(spec);
    add_room(&mut kit, prop_segments(values.tess()));
    add_metals(&mut kit, values.tess());
    add_coats_and_glass(&mut kit, values.tess());
    add_dull_things(&mut kit, values.tess());
    let point = LightKind::Point { range: f32::INFINITY };
    kit.add_light("lamp", point, Vec3::new(9.0, 8.4, 7.2), Vec3::new(-0.9, 2.3, 0.9), Vec3::NEG_Y);
    kit.add_light("window", point, Vec3::new(10.0, 11.0, 12.5), Vec3::new(2.2, 2.4, 2.2), Vec3::NEG_Y);
    kit.add_camera("bench", Vec3::new(0.25, 1.65, 2.35), Vec3::new(0.0, 1.0, 0.0), 40.0);
    kit.add_camera("close", Vec3::new(-0.9, 1.3, 1.2), Vec3::new(-0.35, 1.0, 0.0), 42.0);
    kit.finish()
}

fn facets(roughness: f32) -> Option<Microfacets> {
    Some(Microfacets { roughness, ..Microfacets::default() })
}

/// A mirror of a metal's colour.
fn metal(name: &str, color: Vec3, mirror_roughness: f32) -> Material {
    Material { mirror_roughness, ..Material::mirror(name, linear(color)) }
}

/// Paint or glaze under a clear coat.
fn coated(name: &str, color: Vec3, mirror_roughness: f32) -> Material {
    Material { role: Role::Coated, coat: 1.0, mirror_roughness, ..Material::diffuse(name, linear(color)) }
}

fn add_room(kit: &mut Kit, segments: u32) {
    let concrete = kit.painted(textures::marble("concrete", 31, 8, rgb(0x6f7174), rgb(0x8d8f90)));
    let wall = kit.painted(textures::bricks("bricks", 12, rgb(0x8f5f4a), rgb(0xb9b0a3)));
    let board = kit.painted(textures::labels("tool_board", 8, rgb(0x23303f), rgb(0xd9cfae)));
    let ceiling = kit.plain("ceiling", rgb(0xc9c7c1));
    kit.add_room(
        [Vec3::new(-3.0, 0.0, -1.2), Vec3::new(3.0, 2.8, 3.6)],
        [(concrete, 3.0), (ceiling, 3.0)],
        ([board, wall, wall, wall], 2.8),
    );
    let oak = Material { microfacets: facets(0.45), ..Material::diffuse("oak", Vec3::ONE) };
    let oak = kit.textured(oak, textures::planks("oak_planks", 6, rgb(0xa9794b)));
    let top =
        shapes::rectangle(Vec3::new(-1.5, TOP, 0.6), Vec3::X * 3.0, Vec3::NEG_Z * 1.2, [12, 5], Vec2::new(1.5, 1.2));
    kit.add("bench_top", oak, top, at(0.0, 0.0, 0.0));
    kit.add_box("bench_front", oak, [3.0, 0.12, 0.04], at(0.0, TOP - 0.125, 0.58));
    for (index, x) in [-1.35, 1.35].into_iter().enumerate() {
        let name = ["leg_left", "leg_right"][index];
        kit.add(name, oak, shapes::cylinder(0.06, TOP - 0.13, segments), at(x, 0.0, 0.45));
    }
}

fn add_metals(kit: &mut Kit, tess: u32) {
    let chrome = kit.material(metal("chrome", rgb(0xdfe1e2), 0.0));
    kit.add("bearing_ball", chrome, shapes::sphere(0.16, tess), at(-0.62, TOP + 0.16, 0.12));
    let steel = kit.material(metal("brushed_steel", rgb(0xc6c4bf), 0.3));
    kit.add("canister", steel, shapes::cylinder(0.15, 0.4, 2 * tess), at(-1.05, TOP, -0.2));
    let copper = kit.material(metal("copper", rgb(0xf0a98c), 0.2));
    kit.add("copper_pipe", copper, shapes::torus(0.2, 0.05, (tess / 2).max(3)), at(0.2, TOP + 0.05, 0.3));
    let brass = kit.material(metal("hammered_brass", rgb(0xe8c977), 0.1));
    kit.set_normal_map(brass, textures::dents("dents", 41, 7, 6e-3), 1.0);
    let plate = shapes::rectangle(Vec3::ZERO, Vec3::X * 0.7, Vec3::Y * 0.55, [4, 4], Vec2::splat(0.7));
    kit.add("brass_plate", brass, plate, at(-0.25, TOP, -0.5).turned_yxz(8.0, -14.0, 0.0));
}

fn add_coats_and_glass(kit: &mut Kit, tess: u32) {
    let lacquer = kit.material(coated("red_lacquer", rgb(0xa3161b), 0.0));
    kit.add("lacquered_ball", lacquer, shapes::sphere(0.17, tess), at(0.62, TOP + 0.17, -0.1));
    let glaze = kit.material(coated("glazed_clay", rgb(0x2f6f78), 0.15));
    kit.add("bowl", glaze, shapes::ellipsoid(Vec3::new(0.2, 0.12, 0.2), tess), at(1.05, TOP + 0.12, 0.2));
    let glass = Material { role: Role::Lens, ior: 1.5, ..Material::diffuse("glass", Vec3::new(0.95, 0.98, 0.97)) };
    let glass = kit.material(glass);
    kit.add("magnifier", glass, shapes::ellipsoid(Vec3::new(0.15, 0.15, 0.06), tess), at(-0.3, TOP + 0.16, 0.4));
}

fn add_dull_things(kit: &mut Kit, tess: u32) {
    let segments = prop_segments(tess);
    let worn = textures::worn_color("worn_paint_color", 51, 5, [rgb(0x2b5d8f), rgb(0xa8a7a3)]);
    let toolbox = Material { microfacets: facets(1.0), ..Material::diffuse("worn_paint", Vec3::ONE) };
    let toolbox = kit.textured(toolbox, worn);
    kit.set_facet_map(toolbox, textures::worn("worn_paint_facets", 51, 5, [0.5, 0.35]));
    kit.add_box("toolbox", toolbox, [0.5, 0.26, 0.26], at(0.95, TOP, -0.38).turned(-12.0));
    let rubber = Material { microfacets: facets(0.9), ..Material::diffuse("rubber", linear(rgb(0x2a2a2b))) };
    let rubber = kit.material(rubber);
    kit.add("tyre", rubber, shapes::torus(0.13, 0.045, (segments / 2).max(3)), at(0.62, TOP + 0.045, 0.38));
    let plastic = Material { microfacets: facets(0.25), ..Material::diffuse("plastic", linear(rgb(0xe0a020))) };
    let plastic = kit.material(plastic);
    kit.add("handle", plastic, shapes::cylinder(0.05, 0.32, segments), at(0.3, TOP, -0.32));
    let leather = Material { microfacets: facets(0.6), ..Material::diffuse("leather", linear(rgb(0x6b4226))) };
    let leather = kit.material(leather);
    kit.set_normal_map(leather, textures::grain("leather_grain", 61, 24, 8e-3), 1.0);
    kit.add_box("pouch", leather, [0.3, 0.2, 0.14], at(-0.8, TOP, 0.42).turned(24.0));
    let cloth = Material { microfacets: facets(1.0), ..Material::diffuse("cloth", Vec3::ONE) };
    let cloth = kit.textured(cloth, textures::stripes("cloth_stripes", 8, rgb(0x8c2f39), rgb(0xd8cdb6)));
    kit.add_box("rag", cloth, [0.42, 0.03, 0.3], at(-0.05, TOP, 0.1).turned(35.0));
}
