//! Sequences of frames: which are written, where, and what moves in them.

use crate::workplace::{Workplace, files};
use catoptric::framebuffer::linear_from_srgb;
use catoptric::picture::read;
use std::process::Stdio;

const SMALL: [&str; 6] = ["render", "scene.toml", "--size", "32x24", "--samples", "1"];

/// A diffuse ball that is lit from where it is seen.
const LONE_BALL: &str = r#"
[[reflector]]
name = "ball"
surface = "sphere"
center = [5, 1, -2]
radius = 0.8
[role]
ball = "diffuse"
"#;

impl Workplace {
    fn frames(&self, more: &[&str]) -> String {
        self.ok(&[&SMALL, more].concat())
    }
}

#[test]
fn a_range_writes_its_frames_under_their_numbers() {
    let place = Workplace::new();
    let said = place.frames(&["-o", "new/f-###.png", "--frames", "3..5", "--motion", "eye", "--mask", "new/m%02d.png"]);
    assert!(said.starts_with("new/f-###.png: auto") && said.contains("frames 3 to 5, motion eye"), "{said}");
    let names = ["f-003.png", "f-004.png", "f-005.png", "m03.png", "m04.png", "m05.png"];
    assert_eq!(files(&place.path("new")), names);
    assert_eq!(place.files(), ["new", "scene.toml"]);
    // The last frame of so many, as it is without a pattern.
    for count in ["3", "5"] {
        place.frames(&["-o", "last.png", "--frames", count, "--motion", "eye", "--mask", "mask.png"]);
        assert!(place.bytes("last.png") == place.bytes(&format!("new/f-00{count}.png")), "{count}");
        assert!(place.bytes("mask.png") == place.bytes(&format!("new/m0{count}.png")), "{count}");
    }
    // A pattern writes all frames, counted from 1.
    let linear = place.frames(&["-o", "f-%03d.exr", "--frames", "2", "--motion", "eye", "--stats", "stats.json"]);
    assert!(linear.contains("frames 1 to 2"), "{linear}");
    assert!(place.path("f-001.exr").exists() && place.path("f-002.exr").exists() && !place.path("f-003.exr").exists());
    assert_eq!(place.json("stats.json")["frames"], 2);
}

#[test]
fn standard_output_takes_the_pictures_one_after_the_other() {
    let place = Workplace::new();
    let moved = ["--frames", "1..3", "--motion", "eye"];
    place.frames(&[&["-o", "f-##.png"], &moved[..]].concat());
    let piped = place.run(&[&SMALL[..], &["-o", "-"], &moved[..]].concat());
    let all = [1, 2, 3].map(|number| place.bytes(&format!("f-0{number}.png"))).concat();
    assert!(piped.status.success() && piped.stdout == all);
    // A plain number is the last frame alone, as ever.
    let last = place.run(&[&SMALL[..], &["-o", "-", "--frames", "3", "--motion", "eye"]].concat());
    assert!(last.stdout == place.bytes("f-03.png"));
    // Nothing is drawn for a reader that has gone.
    let words = [&SMALL[..], &["-o", "-", "--frames", "1..100000"]].concat();
    let mut child = place.command(&words).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
    drop(child.stdout.take());
    assert!(child.wait().unwrap().success());
}

#[test]
fn names_and_frames_must_go_together() {
    let place = Workplace::new();
    let faults: [(&[&str], &str); 10] = [
        (&["-o", "a.png", "--frames", "1..3"], "-o a-####.png"),
        (&["-o", "deep/a.b.exr", "--turntable", "3"], "-o deep/a.b-####.exr"),
        (&["-o", "a-##.png"], "--frames 1..240"),
        (&["-o", "a-##.png", "--frames", "1..3", "--mask", "m.png"], "--mask m-####.png"),
        (&["-o", "a.png", "--mask", "m-##.png"], "one picture"),
        (&["-o", "a-##-##.png", "--frames", "1..3"], "more than one pattern"),
        (&["-o", "a-##.png", "--frames", "0..3"], "numbered from 1"),
        (&["-o", "a-##.png", "--frames", "1..3", "--turntable", "3"], "--turntable"),
        (&["-o", "a-##.png", "--motion", "eye", "--turntable", "3"], "--motion"),
        (&["-o", "a-##.png", "--frames", "1..3", "--mask", "a-##.png"], "two outputs"),
    ];
    place.names_faults(2, &SMALL, &faults);
    place.frames(&["-o", "take#3.png"]);
    assert_eq!(place.files(), ["scene.toml", "take#3.png"], "one # is no pattern");
}

#[test]
fn animations_play_in_sequences() {
    let place = Workplace::new();
    let vase = ["render", "builtin:vase?tess=8", "--size", "48x36", "--samples", "1", "--order", "1"];
    let said = place.ok(&[&vase[..], &["-o", "f-#####.png", "--frames", "4..5", "--fps", "10"]].concat());
    assert!(said.contains("frames 4 to 5, motion animation, as the scene has one"), "{said}");
    // Frame n shows the time (n - 1) / fps.
    place.ok(&[&vase[..], &["-o", "still.png", "--time", "0.4"]].concat());
    assert!(place.bytes("still.png") == place.bytes("f-00005.png"));
    assert!(place.bytes("still.png") != place.bytes("f-00004.png"));
    let said = place.ok(&[&vase[..], &["-o", "s-#####.png", "--frames", "4..5", "--motion", "none"]].concat());
    assert!(said.contains("motion none") && place.bytes("s-00004.png") == place.bytes("s-00005.png"), "{said}");
    let still = place.run(&[&SMALL[..], &["-o", "b-##.png", "--frames", "1..2"]].concat());
    assert!(String::from_utf8_lossy(&still.stderr).contains("--turntable N moves the eye"));
}

#[test]
fn all_frames_have_one_exposure() {
    let place = Workplace::new();
    let turn = ["--turntable", "2", "--exposure", "auto", "--tone", "none"];
    place.frames(&[&["-o", "f-##.png"], &turn[..]].concat());
    place.frames(&[&["-o", "f-##.exr"], &turn[..2]].concat());
    let scale = |number: u32| {
        let [shown, linear] = ["png", "exr"].map(|kind| read(&place.path(&format!("f-0{number}.{kind}"))).unwrap());
        let of_pixels = shown.pixels.iter().zip(&linear.pixels);
        let mut scales: Vec<f32> =
            of_pixels.filter(|(_, linear)| linear[0] > 0.01).map(|(shown, linear)| shown[0] / linear[0]).collect();
        scales.sort_by(f32::total_cmp);
        scales[scales.len() / 2]
    };
    let (first, second) = (scale(1), scale(2));
    let step = linear_from_srgb(128.5 / 255.0) / linear_from_srgb(127.5 / 255.0);
    assert!((first / second).max(second / first) < step, "{first} {second}");
    assert!((first - 1.0).abs() > 0.05, "the exposure does something: {first}");
}

#[test]
fn a_turntable_shows_a_ball_alike_from_everywhere() {
    let place = Workplace::with_scene(LONE_BALL);
    let fine = ["render", "scene.toml", "--size", "32x24", "--samples", "4", "--transparent"];
    place.ok(&[&fine[..], &["-o", "f-##.exr", "--turntable", "5"]].concat());
    let pictures = [1, 2, 3, 4, 5].map(|number| read(&place.path(&format!("f-0{number}.exr"))).unwrap());
    let covered = |picture: &catoptric::framebuffer::Framebuffer| {
        picture.pixels.iter().map(|pixel| f64::from(pixel[3])).sum::<f64>()
    };
    // The ball in its box, whose silhouette fills four fifths of the height.
    let area = covered(&pictures[0]);
    assert!(area > 0.25 * 0.25 * 24.0 * 24.0 && area < 0.64 * 24.0 * 24.0, "{area} pixels");
    for picture in &pictures {
        assert!((covered(picture) / area - 1.0).abs() < 0.02, "{} of {area} pixels", covered(picture));
        let border = (0..32).flat_map(|x| [(x, 0), (x, 23)]).chain((0..24).flat_map(|y| [(0, y), (31, y)]));
        assert!(border.into_iter().all(|(x, y)| picture.pixel(x, y)[3] == 0.0));
    }
    // An eye of one's own goes around the middle of what is there, too: half way it looks the other way.
    let placed = [&fine[..], &["--eye", "5,1,2", "--target", "5,1,-2"]].concat();
    place.ok(&[&placed[..], &["-o", "e-##.exr", "--turntable", "2"]].concat());
    place.ok(&[&placed[..], &["-o", "front.exr"]].concat());
    assert!(place.bytes("e-01.exr") == place.bytes("front.exr"));
    let [front, back] = ["e-01.exr", "e-02.exr"].map(|name| covered(&read(&place.path(name)).unwrap()));
    assert!((front / back - 1.0).abs() < 0.02 && front > 20.0, "{front} {back}");
}

#[test]
fn progress_is_that_of_all_frames() {
    let place = Workplace::new();
    let drawn = place.run(&[&SMALL[..], &["-o", "f-##.png", "--frames", "1..3", "--progress", "lines"]].concat());
    let said = String::from_utf8(drawn.stderr).unwrap();
    assert!(said.contains(r#""done":0,"of":3,"stage":"frames""#), "{said}");
}

#[cfg(unix)]
#[test]
fn whole_frames_alone_are_left_by_a_signal() {
    use std::process::Command;
    use std::time::{Duration, Instant};
    let place = Workplace::new();
    let long = ["-o", "new/f-####.png", "--frames", "1..10000", "--motion", "eye", "--size", "160x120"];
    let words = [&SMALL[..2], &long].concat();
    let mut child = place.command(&words).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let begun = Instant::now();
    while !place.path("new/f-0003.png").exists() {
        assert!(begun.elapsed() < Duration::from_secs(60) && child.try_wait().unwrap().is_none());
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let names = files(&place.path("new"));
    assert!(names.len() >= 3 && names.len() < 10000);
    for (index, name) in names.iter().enumerate() {
        assert_eq!(*name, format!("f-{:04}.png", index + 1));
        assert_eq!(read(&place.path("new").join(name)).unwrap().width, 160);
    }
}
