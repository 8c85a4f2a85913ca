//! Nodes of baked files draw the same pictures as nodes that are built.

use catoptric::methods::Quality;
use catoptric::scene::{Scene, View};
use catoptric_testkit::baking::{Units, baked};
use catoptric_testkit::drawing::{draw, scene};
use catoptric_testkit::{Drawn, Session};

const ID: &str = "sample_based_camera";
const QUALITY: Quality = Quality { samples: 1, order: 2 };

/// Few nodes, about the eye too.
const MORPH: &str = "mode = 'morph'\nnode_size = 64\ngrid = '4x4x3'\nwork = 1000";

fn with_bake(settings: &str, scene: &Scene, units: &[Vec<u8>]) -> Session {
    Session::with_bake(ID, settings, scene, QUALITY, Units(units.to_vec())).expect("the units fit")
}

fn view(scene: &Scene) -> View {
    scene.default_view(96, 72)
}

fn nodes(drawn: &Drawn) -> [u64; 2] {
    ["nodes_read", "nodes_built"].map(|count| drawn.report.counts[count])
}

#[test]
fn baked_nodes_draw_what_built_ones_do() {
    for (name, more) in [
        ("two_spheres?tess=12", ""),
        ("two_spheres?tess=12", "camera = 'pinhole'\naccuracy_px = 0.5"),
        ("glass_sphere?tess=12", "polish = 2"),
    ] {
        let (scene, settings) = (scene(name), format!("{MORPH}\n{more}"));
        let view = view(&scene);
        let built = draw(ID, &settings, &scene, &view, QUALITY);
        let Units(units) = baked(ID, &settings, &scene, QUALITY);
        let drawn = with_bake(&settings, &scene, &units).draw(&view).unwrap();
        assert!(built.picture.pixels == drawn.picture.pixels, "{name} {more}");
        let [read, made] = [nodes(&drawn), nodes(&built)];
        assert!(read == [made[1], 0] && made[0] == 0 && made[1] >= 4, "{name} {more}: {read:?}, {made:?}");
        // Nodes of rays and leaves alone.
        assert_eq!(drawn.report.bytes["nodes"], built.report.bytes["nodes"]);
    }
}

#[test]
fn nodes_stay_while_other_things_move_and_are_built_where_the_bake_is_of_something_else() {
    let still = scene("two_spheres?tess=12");
    let Units(units) = baked(ID, MORPH, &still, QUALITY);
    let view = view(&still);
    let mut session = with_bake(MORPH, &still, &units);
    let read = nodes(&session.draw(&view).unwrap())[0];
    // A wall is somewhat nearer.
    let mut moved = still.clone();
    let wall = (0..).find(|&object| !moved.role_of(object).is_specular()).expect("there is a room");
    let vertices = moved.objects[wall as usize].vertices.clone();
    let center = moved.bounds.center();
    for position in &mut moved.positions[vertices.start as usize..vertices.end as usize] {
        *position = center + (*position - center) * 0.99;
    }
    session.update(&moved).unwrap();
    let beside = still.default_view(90, 72);
    assert_eq!(nodes(&session.draw(&beside).unwrap()), [0, 0], "known nodes are used again");

    // Maps in place of the smaller reflector: paths end there.
    let mut session = with_bake(&format!("{MORPH}\nenvironment_below_px = 1000"), &still, &units);
    assert_eq!(nodes(&session.draw(&view).unwrap())[0], 0);
    // Another order is another bake, which callers check.
    let fewer = Session::with_bake(ID, MORPH, &still, Quality { order: 0, ..QUALITY }, Units(units.clone()));
    assert!(fewer.is_ok());
    let error = Session::with_bake(ID, MORPH, &still, QUALITY, Units(units[1..].to_vec())).err().unwrap().to_string();
    assert!(error.contains("95 units where the scene needs 96 nodes"), "{error}");
    let error = Session::with_bake(ID, "", &still, QUALITY, Units(units)).err().unwrap().to_string();
    assert!(error.contains("runtime") && error.contains("mode=morph"), "{error}");
    assert!(read >= 4);
}

#[test]
fn nodes_of_any_bytes_are_read_or_built() {
    let scene = scene("sphere_room?tess=8");
    let small = scene.default_view(32, 24);
    for camera in ["ray_bundle", "pinhole"] {
        let settings = format!("{MORPH}\ncamera = '{camera}'\naccuracy_px = 1.0\nnode_size = 32").replacen(
            "node_size = 64\n",
            "",
            1,
        );
        let Units(good) = baked(ID, &settings, &scene, QUALITY);
        let used = nodes(&with_bake(&settings, &scene, &good).draw(&small).unwrap());
        assert!(used[0] == 4 && used[1] == 0, "{used:?}");
        // Cut off: built.
        let cut: Vec<Vec<u8>> = good.iter().map(|unit| unit[..unit.len() / 2 / 4 * 4].to_vec()).collect();
        let drawn = with_bake(&settings, &scene, &cut).draw(&small).unwrap();
        assert_eq!((nodes(&drawn), drawn.report.fallbacks["unreadable_nodes"]), ([0, 4], 4));
        // Words that lie, everywhere: whatever is read, pictures are of numbers (drawing checks that).
        for start in 0..60 {
            let lying = good.iter().map(|unit| {
                let mut unit = unit.clone();
                let words = unit.len() / 4;
                let wrong: u32 = [u32::MAX, 0, 7, f32::NAN.to_bits(), 1 << 20][start % 5];
                for word in (start..words).step_by(61 * (1 + start)) {
                    unit[word * 4..][..4].copy_from_slice(&wrong.to_le_bytes());
                }
                unit
            });
            let lying: Vec<Vec<u8>> = lying.collect();
            let [read, built] = nodes(&with_bake(&settings, &scene, &lying).draw(&small).unwrap());
            assert_eq!(read + built, 4);
        }
    }
}
