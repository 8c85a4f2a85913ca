//! Highlights of a light on a ball, on the ball's reflection and on the mirror: figure 13 of Popescu, Sacks, Mei 2006.

use super::super::info::{BuiltinInfo, TESS};
use super::super::parameters::{EXACT_SURFACE, Values};
use super::super::parts::kit::{Kit, at};
use super::super::parts::shapes;
use super::super::parts::textures::{self, rgb};
use catoptric_core::scene::model::Model;
use catoptric_core::scene::{Blend, LightKind, Material, Microfacets};
use glam::Vec3;

pub(in super::super) const HIGHLIGHTS: BuiltinInfo = BuiltinInfo {
    name: "highlights",
    summary: "a lamp, a glossy ball and a mirror ball: highlights where each surface's own eye vector puts them",
    parameters: &[TESS, EXACT_SURFACE],
    command: "catoptric render builtin:highlights -o highlights.png",
    build: highlights,
};

fn highlights(spec: &str, values: &Values<'_>) -> Model {
    let mut kit = Kit::lit(spec);
    let checker = kit.painted(textures::checker("checker", 12, rgb(0x39424e), rgb(0xa9b4bf)));
    let plaster = kit.plain("plaster", rgb(0x77808c));
    let tiles = kit.painted(textures::tiles("tiles", 4, rgb(0x5a6470), rgb(0x3a424d)));
    kit.add_room(
        [Vec3::new(-5.0, 0.0, -4.0), Vec3::new(5.0, 5.0, 6.0)],
        [(checker, 5.0), (plaster, 5.0)],
        ([tiles; 4], 5.0),
    );
    let glossy = Microfacets { roughness: 0.2, ..Microfacets::default() };
    let paint = kit.material(Material {
        microfacets: Some(glossy),
        ..Material::diffuse("paint", textures::linear(rgb(0xb83226)))
    });
    let mirror = kit.material(Material {
        blend: Some(Blend { highlight_roughness: Some(0.1), ..Blend::default() }),
        ..Material::mirror("mirror", Vec3::splat(0.9))
    });
    // The ball's and the mirror's letters are those of the figure.
    kit.add_sphere("R", mirror, 1.0, at(-0.75, 1.1, -0.4), values);
    kit.add("D", paint, shapes::sphere(0.55, values.tess()), at(1.1, 0.75, 0.6));
    let lamp = Vec3::new(0.6, 4.2, 3.0);
    kit.add_light("L", LightKind::Point { range: f32::INFINITY }, Vec3::splat(28.0), lamp, Vec3::NEG_Y);
    kit.add_camera("front", Vec3::new(0.5, 1.9, 5.2), Vec3::new(0.1, 0.85, 0.0), 34.0);
    kit.finish()
}
