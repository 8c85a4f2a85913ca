//! A glass pot and a mirror cup in a ring of columns: near, middling and far objects for layers.

use super::info::{BuiltinInfo, TESS};
use super::parameters::{Values, integer};
use super::parts::kit::{Kit, at};
use super::parts::shapes::{self, prop_segments};
use super::parts::textures::{self, rgb};
use super::pots::pot_body;
use catoptric_core::scene::Material;
use catoptric_core::scene::model::Model;
use glam::{Vec2, Vec3};

pub(super) const COLONNADE: BuiltinInfo = BuiltinInfo {
    name: "colonnade",
    summary: "a pot of solid glass and a mirror cup on a table, in a ring of columns with walls far behind",
    parameters: &[TESS, integer("columns", "10", "columns of the ring", 3, 40)],
    command: "catoptric render builtin:colonnade --order 6 -o colonnade.png",
    build: colonnade,
};

/// Half the width and depth of the hall.
const HALF: f32 = 8.0;
/// The ring of columns.
const RING: f32 = 4.6;
/// Height and radius of the table.
const TABLE: [f32; 2] = [0.9, 1.5];

fn colonnade(spec: &str, values: &Values<'_>) -> Model {
    let mut kit = Kit::unlit(spec);
    let tess = values.tess();
    let segments = prop_segments(tess);
    let floor = kit.painted(textures::checker("floor_checker", 12, rgb(0x8a8f98), rgb(0xe9e6dc)));
    let ceiling = kit.painted(textures::tiles("ceiling_tiles", 6, rgb(0xf4efe2), rgb(0xc2b391)));
    let labels = kit.painted(textures::labels("labels", 8, rgb(0x27324a), rgb(0xf1e7cf)));
    let bricks = kit.painted(textures::bricks("bricks", 14, rgb(0xb0583f), rgb(0xdcd2c4)));
    let window = kit.painted(textures::windows("windows", 5, rgb(0xd9c7a0)));
    let stripes = kit.painted(textures::stripes("stripes", 9, rgb(0x6f97b5), rgb(0xe8eef1)));
    kit.add_room(
        [Vec3::new(-HALF, 0.0, -HALF), Vec3::new(HALF, 5.0, HALF)],
        [(floor, 6.0), (ceiling, 5.0)],
        ([labels, window, bricks, stripes], 5.0),
    );
    let candy = kit.painted(textures::stripes("candy_stripes", 6, rgb(0xc8323f), rgb(0xfff4ea)));
    let teal = kit.painted(textures::bricks("teal_bricks", 10, rgb(0x2b8f88), rgb(0xe5f3ec)));
    let count = values.integer("columns") as u32;
    for index in 0..count {
        let place = shapes::around(count, index) * RING;
        let material = if index % 2 == 0 { candy } else { teal };
        let name = format!("column_{index}");
        kit.add(&name, material, shapes::cylinder(0.3, 5.0, segments), at(place.x, 0.0, place.y));
    }
    let wood = kit.painted(textures::planks("table_wood", 8, rgb(0xa06a3a)));
    let [height, radius] = TABLE;
    kit.add("table", wood, shapes::cylinder(radius, height, segments * 2), at(0.0, 0.0, 0.0));
    let tint = Vec3::new(0.22, 0.08, 0.12);
    let glass = kit.material(Material { absorption: tint, ..Material::glass("glass", 1.5) });
    // A little above the table: glass that stands in it would have no underside.
    kit.add("pot", glass, pot_body(tess), at(-0.2, height + 0.02, 0.0));
    let silver = kit.material(Material::mirror("silver", Vec3::new(0.95, 0.94, 0.9)));
    let outline = [[0.0, 0.0], [0.22, 0.0], [0.32, 0.5], [0.29, 0.5], [0.2, 0.05], [0.0, 0.05]].map(Vec2::from);
    kit.add("cup", silver, shapes::turned(&outline, segments), at(0.9, height + 0.01, 0.75));
    let apple = kit.painted(textures::marble("apple", 80, 5, rgb(0xb3212b), rgb(0xd97a35)));
    kit.add("apple", apple, shapes::sphere(0.2, segments), at(-1.1, height + 0.2, 0.7));
    let book = kit.painted(textures::labels("book_labels", 3, rgb(0x3a2440), rgb(0xd9a441)));
    kit.add_box("book", book, [0.6, 0.14, 0.45], at(-0.1, height, -1.1).turned(25.0));
    let target = Vec3::new(0.1, 1.5, 0.1);
    kit.add_camera("circle", Vec3::new(0.4, 2.5, 3.9), target, 36.0);
    kit.add_camera("above", Vec3::new(1.2, 3.8, 2.9), target, 38.0);
    kit.finish()
}
