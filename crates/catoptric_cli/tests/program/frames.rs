//! `catoptric bake frames`: the frames of a sequence are those that `render` draws, whoever draws which.

use crate::workplace::Workplace;
use std::fs;

/// Five frames of a ball that the eye goes around.
const WHAT: [&str; 14] = [
    "scene.toml",
    "--method",
    "sample_based_camera",
    "--set",
    "polish=2",
    "--motion",
    "eye",
    "--size",
    "64x48",
    "--samples",
    "1",
    "--order",
    "1",
    "--frames",
];

impl Workplace {
    fn plan_frames(&self, count: &str, more: &[&str]) {
        self.ok(&[&["bake", "frames"], &WHAT[..], &[count], more].concat());
    }

    /// The picture of the last of so many frames, drawn by `render` alone.
    fn last_of(&self, count: &str, output: &str) -> Vec<u8> {
        self.ok(&[&["render"], &WHAT[..], &[count, "--backend", "cpu", "-o", output]].concat());
        self.bytes(output)
    }
}

#[test]
fn frames_are_those_of_render_whoever_draws_them() {
    let place = Workplace::new();
    place.plan_frames("5", &["-o", "parts"]);
    assert_eq!(place.ends(3, &["bake", "status", "parts", "--missing"]), "0\n1\n2\n3\n4\n");
    // Nothing is written before all are there.
    let message = place.fails(1, &["bake", "merge", "parts", "-o", "pictures"]);
    assert!(message.contains("5 of 5 units are missing") && !place.path("pictures").exists(), "{message}");
    place.ok(&["bake", "run", "parts", "--shard", "1/2", "--threads", "1"]);
    place.ok(&["bake", "run", "parts"]);
    place.ok(&["bake", "status", "parts", "--verify"]);
    let said = place.ok(&["bake", "merge", "parts", "-o", "some/pictures"]);
    assert!(said.contains("5 frames"), "{said}");
    let names = fs::read_dir(place.path("some/pictures")).unwrap().map(|entry| entry.unwrap().file_name());
    let mut names: Vec<String> = names.map(|name| name.into_string().unwrap()).collect();
    names.sort();
    assert_eq!(names, [0, 1, 2, 3, 4].map(|frame| format!("frame-{frame:06}.png")));
    let first = place.bytes("some/pictures/frame-000000.png");
    assert!(first == place.last_of("1", "first.png"));
    let last = place.bytes("some/pictures/frame-000004.png");
    assert!(last != first && last == place.last_of("5", "last.png"));

    // A damaged frame is noticed, and drawn again.
    let unit = place.path("parts/unit-000002.bin");
    let mut bytes = fs::read(&unit).unwrap();
    bytes.truncate(bytes.len() - 10);
    fs::write(&unit, bytes).unwrap();
    let message = place.fails(1, &["bake", "merge", "parts", "-o", "again"]);
    assert!(message.contains("unit-000002.bin is truncated") && !place.path("again").exists(), "{message}");
    assert!(place.ok(&["bake", "run", "parts"]).contains("1 replaced"));
    place.ok(&["bake", "merge", "parts", "-o", "again"]);
    let frame = "frame-000002.png";
    assert!(place.bytes(&format!("again/{frame}")) == place.bytes(&format!("some/pictures/{frame}")));
}

#[test]
fn linear_pictures_and_bakes_go_with_frames() {
    let place = Workplace::new();
    let light_field = ["--method", "light_field", "--set", "st=3", "--set", "uv=16", "--order", "1"];
    place.ok(&[&["bake", "scene.toml"], &light_field[..], &["-o", "field.bake"]].concat());
    let what = [&["scene.toml"], &light_field[..], &["--motion", "eye", "--size", "32x24", "--baked", "field.bake"]];
    let what = what.concat();
    place.ok(&[&["bake", "frames"], &what[..], &["--frames", "2", "--format", "exr", "-o", "parts"]].concat());
    place.ok(&["bake", "run", "parts"]);
    place.ok(&["bake", "merge", "parts", "-o", "pictures"]);
    let alone = [&["render"], &what[..], &["--frames", "2", "--backend", "cpu", "-o", "last.exr"]].concat();
    place.ok(&alone);
    assert!(place.bytes("pictures/frame-000001.exr") == place.bytes("last.exr"));
    // Another bake is another plan.
    let other = ["--method", "light_field", "--set", "st=2", "--set", "uv=16", "--order", "1"];
    fs::remove_file(place.path("field.bake")).unwrap();
    place.ok(&[&["bake", "scene.toml"], &other[..], &["-o", "field.bake"]].concat());
    let message = place.fails(1, &["bake", "run", "parts"]);
    assert!(message.contains("field.bake") || message.contains("has changed since"), "{message}");
}

#[test]
fn sequences_that_cannot_be_drawn_are_refused_before_any_work() {
    let place = Workplace::new();
    let plan = ["bake", "frames", "scene.toml", "-o", "parts", "--frames", "3", "--method"];
    place.names_faults(
        2,
        &plan,
        &[
            (&["no_such"], "no_such"),
            (&["auto", "--samples", "3"], "--samples 3"),
            (&["auto", "--size", "4096x2160", "--format", "exr"], "--format png"),
            (&["auto", "--frames", "0"], "--frames"),
        ],
    );
    place.names_faults(
        1,
        &plan,
        &[(&["auto", "--baked", "no.bake"], "no.bake"), (&["auto", "--camera", "9"], "camera")],
    );
    // The scene has changed since.
    place.plan_frames("2", &["-o", "parts"]);
    place.write("scene.toml", place.text("scene.toml").replace("radius = 0.8", "radius = 0.7"));
    let message = place.fails(1, &["bake", "run", "parts"]);
    assert!(message.contains("the scene's hash") && message.contains("plan again elsewhere"), "{message}");
}
