//! Cubes that are unfolded to strips and crosses.

use catoptric_core::scene::Environment;
use catoptric_scenes::import::load_environment;
use glam::Vec3;

const SIDE: usize = 8;

/// Squares of a colour, but for some pixels: a picture of so many squares, whose radiance is that of a square and a
/// place in it, from 0 to 1 to the right and downwards.
fn squares(columns: usize, rows: usize, of: impl Fn([usize; 2], [f32; 2]) -> [u8; 3]) -> Vec<u8> {
    let (width, height) = (columns * SIDE, rows * SIDE);
    let mut bytes = format!("#?RADIANCE\n\n-Y {height} +X {width}\n").into_bytes();
    for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
        let within = [x, y].map(|place| ((place % SIDE) as f32 + 0.5) / SIDE as f32);
        let [red, green, blue] = of([x / SIDE, y / SIDE], within);
        // The exponent 136 leaves mantissas as they are; 1 and 2 would begin runs.
        bytes.extend([red, green, blue, 136]);
    }
    bytes
}

fn load(bytes: &[u8], word: &str) -> Environment {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("sky.hdr");
    std::fs::write(&path, bytes).expect("a file");
    let mut warnings = Vec::new();
    let sky = load_environment(&path, &mut warnings).expect("a sound file");
    assert!(warnings.len() == 1 && warnings[0].contains(word), "{warnings:?}");
    sky
}

/// Looking towards +z with +y up, -x is to the right: there is the face +X, as a photographer would paste it.
const DIRECTIONS: [Vec3; 6] = [Vec3::NEG_X, Vec3::X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];

#[test]
fn strips_and_crosses_are_cubes() {
    let number = |face: usize| [face as u8 + 10; 3];
    let cross: [[usize; 2]; 6] = [[2, 1], [0, 1], [1, 0], [1, 2], [1, 1], [3, 1]];
    let upright: [[usize; 2]; 6] = [[2, 1], [0, 1], [1, 0], [1, 2], [1, 1], [1, 3]];
    let of_cross = |faces: [[usize; 2]; 6]| {
        move |square: [usize; 2], _: [f32; 2]| faces.iter().position(|face| *face == square).map_or([0; 3], number)
    };
    for (bytes, word) in [
        (squares(6, 1, |[column, _], _| number(column)), "strip"),
        (squares(1, 6, |[_, row], _| number(row)), "strip"),
        (squares(4, 3, of_cross(cross)), "cross"),
        (squares(3, 4, of_cross(upright)), "cross"),
    ] {
        let sky = load(&bytes, word);
        for (face, towards) in DIRECTIONS.into_iter().enumerate() {
            let radiance = sky.radiance(towards);
            assert!((radiance.x - (face as f32 + 10.0)).abs() < 1e-3, "{word}: {towards}: {radiance}");
        }
    }
}

/// Each face is right half red, and blue in its lower half: seen from the middle, upright.
#[test]
fn faces_are_seen_from_the_middle() {
    let halves = |[right, down]: [f32; 2]| [if right > 0.5 { 9 } else { 0 }, 0, if down > 0.5 { 9 } else { 0 }];
    let strip = load(&squares(6, 1, |_, within| halves(within)), "strip");
    let turned = |square: [usize; 2], [right, down]: [f32; 2]| match square {
        [0, 0] | [2, 0] | [0, 2] | [2, 2] | [0, 3] | [2, 3] => [0; 3],
        [1, 3] => halves([1.0 - right, 1.0 - down]),
        _ => halves([right, down]),
    };
    let cross = load(&squares(3, 4, turned), "cross");
    // For each face the direction of its middle, to the right and downwards; the upper and lower faces join +Z.
    let faces = [
        (Vec3::NEG_X, Vec3::NEG_Z, Vec3::NEG_Y),
        (Vec3::X, Vec3::Z, Vec3::NEG_Y),
        (Vec3::Y, Vec3::NEG_X, Vec3::Z),
        (Vec3::NEG_Y, Vec3::NEG_X, Vec3::NEG_Z),
        (Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y),
        (Vec3::NEG_Z, Vec3::X, Vec3::NEG_Y),
    ];
    for (sky, name) in [(strip, "strip"), (cross, "cross")] {
        for (middle, right, down) in faces {
            let found = sky.radiance((middle + right * 0.5 - down * 0.5).normalize());
            assert!((found - Vec3::new(9.0, 0.0, 0.0)).length() < 0.05, "{name}: right of {middle}: {found}");
            let found = sky.radiance((middle - right * 0.5 + down * 0.5).normalize());
            assert!((found - Vec3::new(0.0, 0.0, 9.0)).length() < 0.05, "{name}: below {middle}: {found}");
        }
    }
}

#[test]
fn other_proportions_are_told() {
    let photograph = squares(4, 3, |[column, row], _| [(column + 4 * row) as u8 + 10; 3]);
    load(&photograph, "stretched");
    load(&squares(1, 1, |_, _| [10; 3]), "stretched");
}
