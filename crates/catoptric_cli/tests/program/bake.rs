//! `catoptric bake` as its users meet it: interrupted, killed, on several machines, with wrong files.

use crate::workplace::{BALL, Workplace, files};
use serde_json::Value;
use std::fs;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// 36 units.
const WHAT: [&str; 9] =
    ["scene.toml", "--method", "light_field", "--set", "st=6", "--set", "uv=16", "--set", "capture_samples=4"];

impl Workplace {
    fn start(&self, words: &[&str]) -> Child {
        self.command(words).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
    }

    fn all(&self, output: &str) -> Vec<u8> {
        self.ok(&bake(&["-o", output]));
        self.bytes(output)
    }

    fn plan(&self, folder: &str) {
        self.ok(&[&["bake", "plan"], &WHAT[..], &["-o", folder]].concat());
    }
}

/// The command line of a bake of [`WHAT`].
fn bake<'a>(more: &[&'a str]) -> Vec<&'a str> {
    [&["bake"], &WHAT[..], more].concat()
}

/// Multiplies by 6364136223846793005 and takes the upper bits (Knuth): the same delays in every run.
struct Delays(u64);

impl Delays {
    fn next(&mut self, longest: Duration) -> Duration {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        longest.mul_f64((self.0 >> 40) as f64 / f64::from(1u32 << 24))
    }
}

/// Killed at 50 moments, resumed each time; the file is that of an undisturbed bake, bit for bit.
#[test]
fn a_bake_that_is_killed_again_and_again_is_the_same() {
    let place = Workplace::new();
    let start = Instant::now();
    let expected = place.all("undisturbed.bake");
    let longest = start.elapsed();
    let words = bake(&["-o", "room.bake"]);
    let (mut delays, mut kills, mut within, mut finished) = (Delays(7), 0, 0, 0);
    while kills < 50 {
        let mut child = place.start(&words);
        sleep(delays.next(longest));
        if child.try_wait().unwrap().is_none() {
            child.kill().unwrap();
            kills += 1;
        }
        child.wait().unwrap();
        let units = fs::read_dir(place.path("room.bake.parts")).map_or(0, Iterator::count);
        within += u32::from((2..37).contains(&units));
        // The baked file appears whole or not at all.
        if let Ok(found) = fs::read(place.path("room.bake")) {
            assert!(found == expected, "after {kills} kills");
            fs::remove_file(place.path("room.bake")).unwrap();
            finished += 1;
        }
    }
    assert!(within >= 10, "{within} of {kills} kills left some units made and some not");
    assert!(finished >= 1, "it gets to its end although it is killed");
    assert!(place.all("room.bake") == expected);
    assert_eq!(place.files(), ["room.bake", "scene.toml", "undisturbed.bake"]);
}

#[cfg(unix)]
#[test]
fn a_signal_stops_it_with_75_and_it_goes_on_later() {
    let place = Workplace::new();
    // Long enough to be met at work.
    let words = |output: &'static str| bake(&["--set", "uv=48", "--set", "capture_samples=16", "-o", output]);
    let mut child = place.start(&words("room.bake"));
    let begun = Instant::now();
    // Some unit is there.
    while fs::read_dir(place.path("room.bake.parts")).map_or(0, Iterator::count) < 3 {
        assert!(begun.elapsed() < Duration::from_secs(60), "it does not begin");
        sleep(Duration::from_millis(2));
    }
    assert!(Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(75));
    assert!(!place.path("room.bake").exists());
    let plan = place.json("room.bake.parts/plan.json");
    assert_eq!(plan["identity"]["units"].as_array().unwrap().len(), 36);
    place.ok(&words("room.bake"));
    place.ok(&words("other.bake"));
    assert!(place.bytes("room.bake") == place.bytes("other.bake"));
}

#[test]
fn shards_on_several_machines_make_the_same_file() {
    let place = Workplace::new();
    let expected = place.all("room.bake");
    place.plan("parts");
    // Planned again, it is the same plan.
    place.plan("parts");
    let status: Value = serde_json::from_str(&place.ends(3, &["bake", "status", "parts", "--json"])).unwrap();
    assert_eq!((status["total"].as_u64(), status["missing"].as_u64()), (Some(36), Some(36)));
    place.ok(&["bake", "run", "parts", "--shard", "1/3", "--quiet"]);
    assert_eq!(place.ends(3, &["bake", "status", "parts", "--missing"]).lines().count(), 24);
    let message = place.fails(1, &["bake", "merge", "parts", "-o", "merged.bake"]);
    assert!(message.contains("24") && message.contains("missing"), "{message}");
    assert!(!place.path("merged.bake").exists());
    assert_eq!(place.run(&["bake", "run", "parts", "--max-time", "0s"]).status.code(), Some(75));
    let scheduled = |index: &str| {
        let mut command = place.command(&["bake", "run", "parts", "--shard", "auto", "--progress", "lines"]);
        command.env("AWS_BATCH_JOB_ARRAY_INDEX", index).env("AWS_BATCH_JOB_ARRAY_SIZE", "2");
        command.output().unwrap()
    };
    for index in ["0", "1"] {
        let output = scheduled(index);
        assert!(output.status.success());
        // A line a unit, beside those of stages.
        let lines = String::from_utf8(output.stderr).unwrap();
        let lines: Vec<Value> = lines.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        assert_eq!(lines.iter().filter(|line| line["number"].is_u64() && line["total"] == 18).count(), 18);
    }
    place.ok(&["bake", "status", "parts", "--verify"]);
    // A unit that is damaged is found, and made again.
    let unit = place.path("parts/unit-000007.bin");
    let mut bytes = fs::read(&unit).unwrap();
    bytes[200] ^= 1;
    fs::write(&unit, bytes).unwrap();
    place.ok(&["bake", "status", "parts"]);
    let found = place.ends(3, &["bake", "status", "parts", "--verify"]);
    assert!(found.contains("unit-000007.bin"), "{found}");
    assert!(place.fails(1, &["bake", "merge", "parts", "-o", "merged.bake"]).contains("unit-000007.bin"));
    assert!(place.ok(&["bake", "run", "parts"]).contains("1 replaced"));
    place.ok(&["bake", "merge", "parts", "-o", "merged.bake"]);
    assert!(place.bytes("merged.bake") == expected);

    // Another scene or other settings are not mixed in.
    let other = [&["bake", "plan"], &WHAT[..], &["--set", "uv=17", "-o", "parts"]].concat();
    assert!(place.fails(1, &other).contains("uv is 16 in the bake, 17 asked for"));
    place.write("scene.toml", BALL.replace("0.8", "0.7"));
    assert!(place.fails(1, &["bake", "run", "parts"]).contains("has changed since"));
}

#[test]
fn pictures_from_a_bake_are_those_without_and_wrong_files_are_refused() {
    let place = Workplace::new();
    let baked = place.all("room.bake");
    const SMALL: [&str; 8] = ["render", "scene.toml", "--method", "light_field", "--size", "64x48", "--samples", "1"];
    let set = &WHAT[3..];
    place.ok(&[&SMALL[..], set, &["-o", "captured.png"]].concat());
    // Settings that are not given are those of the bake.
    place.ok(&[&SMALL[..], &["--baked", "room.bake", "-o", "baked.png"]].concat());
    assert!(place.bytes("captured.png") == place.bytes("baked.png"));
    let refused = |file: &str, more: &[&str]| {
        let message = place.fails(1, &[&SMALL[..], &["--baked", file, "-o", "no.png"], more].concat());
        assert!(message.contains(file) && !place.path("no.png").exists(), "{message}");
        message
    };
    assert!(refused("room.bake", &["--set", "st=7"]).contains("st is 6 in the bake, 7 asked for"));
    assert!(refused("room.bake", &["--order", "1"]).contains("order is 2 in the bake, 1 asked for"));
    refused("absent.bake", &[]);
    refused("captured.png", &[]);
    refused("scene.toml", &[]);
    for (name, change) in [("cut.bake", 0), ("flipped.bake", 1), ("longer.bake", 2)] {
        let mut bytes = baked.clone();
        let middle = bytes.len() / 2;
        match change {
            0 => bytes.truncate(middle),
            1 => bytes[middle] ^= 0x10,
            _ => bytes.push(0),
        }
        place.write(name, bytes);
        refused(name, &[]);
    }
    let message = place.fails(1, &["render", "scene.toml", "-o", "no.png", "--baked", "room.bake"]);
    assert!(message.contains("bake of light_field, not of auto"), "{message}");
    place.write("scene.toml", BALL.replace("0.8", "0.7"));
    assert!(refused("room.bake", &[]).contains("scene"));

    // A comparison takes bakes, too.
    place.write("scene.toml", BALL);
    let compare = ["compare", "scene.toml", "--size", "64x48", "--samples", "1", "--report", "report", "--quiet"];
    let methods = ["--method", "light_field", "--method", "environment_map", "--baked", "room.bake"];
    place.ok(&[&compare[..], &methods].concat());
    let report = place.json("report/report.json");
    let slabs = report.as_array().unwrap().iter().find(|entry| entry["method"] == "light_field").unwrap();
    assert_eq!(slabs["settings"]["st"], 6);
    assert!(slabs["setup_ms"]["bake_load"].is_number() && slabs["setup_ms"]["bake_open"].is_number());
}

/// The same command twice at once: both share the work and end well, and only the file is left.
#[test]
fn two_that_bake_the_same_file_both_end_well() {
    let place = Workplace::new();
    let expected = place.all("alone.bake");
    for round in 0..6 {
        let words = bake(&["-o", "room.bake"]);
        let mut first = place.start(&words);
        // From at once to about the time when the first one ends.
        sleep(Duration::from_millis(60 * round));
        let mut second = place.start(&words);
        assert!(first.wait().unwrap().success() && second.wait().unwrap().success(), "round {round}");
        assert!(place.bytes("room.bake") == expected, "round {round}");
        assert_eq!(place.files(), ["alone.bake", "room.bake", "scene.toml"], "round {round}");
        fs::remove_file(place.path("room.bake")).unwrap();
    }
}

/// Textures seen from the centre, the default: in a moment, and drawn as without a bake.
#[test]
fn projected_layers_are_baked() {
    let place = Workplace::new();
    const LAYERS: [&str; 8] =
        ["--method", "layered_environment_map", "--set", "size=32", "--set", "layers=6", "--set", "capture_samples=1"];
    place.ok(&[&["bake", "scene.toml"], &LAYERS[..], &["-o", "layers.bake"]].concat());
    let render = ["render", "scene.toml", "--size", "80x60", "--samples", "1", "--quiet"];
    let render = |more: &[&'static str]| place.ok(&[&render[..], more].concat());
    render(&[&LAYERS[..], &["-o", "captured.png"]].concat());
    render(&[&LAYERS[..2], &["--baked", "layers.bake", "-o", "baked.png"]].concat());
    assert!(place.bytes("captured.png") == place.bytes("baked.png"));
    let message = place.fails(
        1,
        &[
            &["render", "scene.toml", "--baked", "layers.bake", "-o", "no.png"],
            &LAYERS[..2],
            &["--set", "textures=inferred"],
        ]
        .concat(),
    );
    assert!(message.contains("textures") && message.contains("inferred"), "{message}");
}

/// Layers are inferred for viewpoints, each with a note of its remaining residuals; killed and resumed it is the
/// same file, and pictures from it are those without.
#[test]
fn layers_of_viewpoints_are_baked_and_resumed() {
    const LAYERS: [&str; 16] = [
        "--method",
        "layered_environment_map",
        "--set",
        "size=16",
        "--set",
        "picture_size=64",
        "--set",
        "capture_samples=1",
        "--set",
        "viewpoint_count=24",
        "--set",
        "viewpoints=line",
        "--set",
        "direct=both",
        "--set",
        "textures=inferred",
    ];
    let place = Workplace::new();
    let layers =
        |output: &'static str| [&["bake", "scene.toml"], &LAYERS[..], &["--progress", "lines", "-o", output]].concat();
    let done = place.run(&layers("whole.bake"));
    let messages = String::from_utf8(done.stderr).unwrap();
    assert_eq!(done.status.code(), Some(0), "{messages}");
    let lines = messages.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
    let notes: Vec<String> = lines.filter_map(|line| line["note"].as_str().map(String::from)).collect();
    assert!(notes.len() == 24 && notes.iter().all(|note| note.starts_with("residuals ")), "{notes:?}");
    let started = Instant::now();
    let mut child = place.start(&layers("killed.bake"));
    let units = || fs::read_dir(place.path("killed.bake.parts")).map_or(0, Iterator::count);
    while units() < 6 && child.try_wait().unwrap().is_none() && started.elapsed() < Duration::from_secs(60) {
        sleep(Duration::from_millis(2));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(units() > 3, "it was killed after some units");
    place.ok(&layers("killed.bake"));
    let whole = place.bytes("whole.bake");
    assert!(whole == place.bytes("killed.bake"));

    let render = ["render", "scene.toml", "--size", "80x60", "--samples", "1", "--quiet"];
    let render = |more: &[&'static str]| [&render[..], &LAYERS[..], more].concat();
    place.ok(&render(&["-o", "inferred.png"]));
    place.ok(&render(&["--baked", "whole.bake", "-o", "baked.png"]));
    assert!(place.bytes("inferred.png") == place.bytes("baked.png"));
    let refused = place.fails(1, &render(&["--baked", "whole.bake", "-o", "no.png", "--set", "layers=2"]));
    assert!(refused.contains("layers is 3 in the bake, 2 asked for"), "{refused}");
}

#[test]
fn a_manifest_lists_views_to_be_made_elsewhere() {
    let place = Workplace::new();
    place.ok(&[&["bake", "views"], &WHAT[..], &["-o", "views.toml"]].concat());
    let text = place.text("views.toml");
    assert_eq!(text.matches("[[view]]").count(), 6 * 36);
    let bake = [&["bake"], &WHAT[..], &["--set", "views=views.toml", "-o", "room.bake"]].concat();
    assert!(place.fails(1, &bake).contains("radiance-px-0-0.exr"));
    let of_another = ["bake", "views", "scene.toml", "--method", "reference", "-o", "no.toml"];
    place.ends(2, &of_another);
    assert_eq!(place.files(), ["scene.toml", "views.toml"]);
}

#[test]
fn runs_of_listed_units_make_these_alone() {
    let place = Workplace::new();
    place.plan("room.parts");
    place.write("list", "3\n\n 17\n35\n");
    place.ok(&["bake", "run", "room.parts", "--units", "list", "--shard", "1/2", "--quiet"]);
    assert_eq!(files(&place.path("room.parts")), ["plan.json", "unit-000017.bin"]);
    place.ok(&["bake", "run", "room.parts", "--units", "list", "--quiet"]);
    assert_eq!(place.ends(3, &["bake", "status", "room.parts", "--missing"]).lines().count(), 33);
    for (list, named) in [("3\nx\n", "list: line 2: `x` is no unit's number"), ("36\n", "there is no unit 36")] {
        place.write("list", list);
        let message = place.fails(1, &["bake", "run", "room.parts", "--units", "list"]);
        assert!(message.contains(named), "{message}");
    }
}

/// Programs without the feature `cloud` have the same command line, and name the remedy.
#[test]
fn object_stores_and_clusters_are_in_programs_with_the_feature_cloud() {
    let place = Workplace::new();
    let remedy = "cargo install catoptric_cli --features cloud";
    let help = place.ok(&["bake", "--help"]).split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(help.contains(remedy), "{help}");
    if cfg!(feature = "cloud") {
        return;
    }
    let address = "s3://bucket/room.parts";
    let plan = [&["bake", "plan"], &WHAT[..], &["-o", address]].concat();
    let steps: [(&[&str], &str); 6] = [
        (&plan, address),
        (&["bake", "run", address], address),
        (&["bake", "status", address], address),
        (&["bake", "merge", address, "-o", "room.bake"], address),
        (&["bake", "submit", address, "--engine", "slurm"], "bake submit"),
        (&["bake", "submit", "room.parts", "--engine", "slurm", "--dry-run"], "bake submit"),
    ];
    for (words, named) in steps {
        let message = place.fails(1, words);
        assert!(message.contains(named) && message.contains(remedy), "{message}");
        assert!(message.contains("--features cloud`)") && message.lines().count() == 1, "{message}");
    }
    place.ends(2, &["bake", "submit", "room.parts", "--engine", "cron"]);
    assert_eq!(place.files(), ["scene.toml"]);
}

#[test]
fn what_cannot_be_baked_is_refused() {
    let place = Workplace::new();
    assert!(place.fails(1, &["bake", "scene.toml", "--method", "reference", "-o", "x"]).contains("bakes nothing"));
    let method = ["--method", "light_field"];
    let nothing = [&["bake", "scene.toml"], &method[..], &["--order", "0", "-o", "x"]].concat();
    assert!(place.fails(1, &nothing).contains("nothing to bake"));
    let elsewhere = [&["bake", "scene.toml"], &method[..], &["-o", "no/where.bake"]].concat();
    assert!(place.fails(1, &elsewhere).contains("does not exist"));
    assert!(place.fails(1, &["bake", "run", "nowhere"]).contains("nowhere"));
    assert!(place.fails(1, &["bake", "status", "ftp://bucket/bake"]).contains("folder"));
    // Units too large for stores: before any work.
    let large = [&["bake", "scene.toml"], &method[..], &["--set", "st=64", "--set", "uv=1024", "-o", "x"]].concat();
    let message = place.fails(1, &large);
    assert!(message.contains("units[0].bytes") && message.contains("are allowed"), "{message}");
    place.write("bake.toml", "st = 3\nuv =");
    let broken = [&["bake", "scene.toml"], &method[..], &["-c", "bake.toml", "-o", "x"]].concat();
    assert!(place.fails(1, &broken).contains("bake.toml: line 2: "));
    for (text, named) in [("st = 3\nuw = 2\n", "`uv`"), ("st = 3\nuv = 'many'\n", "whole number")] {
        place.write("bake.toml", text);
        let message = place.fails(1, &broken);
        assert!(message.contains("bake.toml: line 2: ") && message.contains(named), "{message}");
    }
    assert_eq!(place.files(), ["bake.toml", "scene.toml"]);
    place.ends(2, &["bake"]);
    place.ends(2, &["bake", "run", ".", "--shard", "4/4"]);
    place.ends(2, &["bake", "run", ".", "--max-time", "soon"]);
}
