//! Metal balls of growing roughness among near things: reflections that blur with distance.

use super::super::info::{BuiltinInfo, TESS};
use super::super::parameters::{ParameterInfo, Values, number};
use super::super::parts::kit::{Kit, at};
use super::super::parts::shapes::{self, prop_segments};
use super::super::parts::textures::{self, rgb};
use catoptric_core::scene::Material;
use catoptric_core::scene::model::Model;
use glam::Vec3;

/// The scale of all three balls' roughness.
const ROUGHNESS: ParameterInfo =
    number("roughness", "0", "the perceptual roughness of all balls; 0: 0.1, 0.2 and 0.4", 0.0, 0.5);

pub(in super::super) const BRUSHED: BuiltinInfo = BuiltinInfo {
    name: "brushed",
    summary: "three metal balls of growing roughness on a checker, with things near and far from them",
    parameters: &[TESS, ROUGHNESS],
    command: "catoptric render builtin:brushed -o brushed.png",
    build: brushed,
};

fn brushed(spec: &str, values: &Values<'_>) -> Model {
    let mut kit = Kit::unlit(spec);
    let segments = prop_segments(values.tess());
    let checker = kit.painted(textures::checker("checker", 16, rgb(0x28303a), rgb(0xd8dcd2)));
    let wall = kit.painted(textures::bricks("bricks", 10, rgb(0x9c5a45), rgb(0xd9cfc0)));
    let labels = kit.painted(textures::labels("labels", 8, rgb(0x1d2b44), rgb(0xf6efe0)));
    let ceiling = kit.painted(textures::tiles("ceiling", 4, rgb(0xe8e6df), rgb(0xbdb8ad)));
    kit.add_room(
        [Vec3::new(-4.0, 0.0, -3.0), Vec3::new(4.0, 3.4, 5.0)],
        [(checker, 4.0), (ceiling, 3.0)],
        ([wall, labels, wall, labels], 3.4),
    );
    for (index, roughness) in [0.1, 0.2, 0.4].into_iter().enumerate() {
        let given = values.number(ROUGHNESS.name);
        let mirror_roughness = if given > 0.0 { given } else { roughness };
        let metal = kit.material(Material {
            mirror_roughness,
            ..Material::mirror(["metal_1", "metal_2", "metal_3"][index], Vec3::new(0.95, 0.93, 0.88))
        });
        let place = at(-1.7 + 1.7 * index as f32, 0.7, 0.0);
        kit.add(["ball_1", "ball_2", "ball_3"][index], metal, shapes::sphere(0.7, values.tess()), place);
    }
    // Things that touch the balls nearly, and others some way off.
    let red = kit.plain("red", rgb(0xd03a2b));
    let blue = kit.plain("blue", rgb(0x2c63c8));
    let yellow = kit.painted(textures::stripes("yellow_stripes", 6, rgb(0xf0c230), rgb(0x33302a)));
    for (post, rod, x) in [("post_left", "rod_left", -0.85), ("post_right", "rod_right", 0.85)] {
        kit.add(post, red, shapes::cylinder(0.08, 1.5, segments), at(x, 0.0, 0.62));
        kit.add(rod, yellow, shapes::cylinder(0.05, 2.6, segments), at(x, 0.0, 1.9));
    }
    kit.add_box("block", blue, [0.3, 0.3, 0.3], at(0.0, 0.0, 0.95).turned(25.0));
    kit.add_box("slab", yellow, [0.9, 0.35, 0.3], at(-2.1, 0.0, 1.1).turned(-15.0));
    kit.add_box("tower", blue, [0.4, 1.8, 0.4], at(2.7, 0.0, 1.3).turned(30.0));
    kit.add_camera("front", Vec3::new(0.2, 1.7, 4.4), Vec3::new(0.0, 0.75, 0.0), 40.0);
    kit.add_camera("close", Vec3::new(1.2, 1.0, 2.4), Vec3::new(1.3, 0.7, 0.0), 45.0);
    kit.finish()
}
