//! Messages about scene files and settings: they name the file, the line and the remedy in plain words.

use crate::workplace::{BALL, Workplace};

/// Words of the libraries that read files, which help no user.
const JARGON: [&str; 11] = [
    "digit found",
    "target type",
    "..=",
    "expected u",
    "expected f",
    "unknown variant",
    "unknown field",
    "expected ident",
    "invalid type",
    "serde",
    "TomlError",
];

#[test]
fn faults_of_scene_files_name_the_line() {
    let place = Workplace::new();
    place.write("broken.gltf", "nonsense");
    place.write("typed.gltf", r#"{"asset":{"version":"2.0"},"nodes":[{"mesh":"one"}]}"#);
    let line = BALL.lines().count();
    for (more, offset, named) in [
        ("[method.environment_map]\nsizze = 3\n", 2, "`size`"),
        ("[method.environment_map]\nsize = 64\nparallax = 'cube'\n", 3, "`box`"),
        ("[method.environment_map]\nsize = 'large'\n", 2, "whole number"),
        ("[method.environment_map]\nsize = -1\n", 2, "whole number"),
        ("[method.reference]\nseed = 1\n[method.nonsense]\n", 3, "there is no method `nonsense`"),
        ("'no such*' = 'diffuse'\n", 1, "there is no node or material `no such*`"),
    ] {
        place.write("scene.toml", format!("{BALL}{more}"));
        for command in [&["info", "scene.toml"][..], &["render", "scene.toml", "-o", "out.png"]] {
            let message = place.fails(1, command);
            assert!(message.contains(&format!("scene.toml: line {}: ", line + offset)), "{more}: {message}");
            assert!(message.contains(named), "{more}: {message}");
            assert!(!JARGON.iter().any(|word| message.contains(word)), "{more}: {message}");
        }
    }
    for (first, named) in [
        ("gltf = ['none.glb']", "none.glb"),
        ("gltf = ['broken.gltf']", "is no JSON"),
        ("gltf = ['typed.gltf']", "whole number"),
        ("environment = 'none.hdr'", "none.hdr"),
    ] {
        place.write("scene.toml", format!("{first}\n{BALL}"));
        let message = place.fails(1, &["info", "scene.toml"]);
        assert!(message.contains("scene.toml: line 1: ") && message.contains(named), "{message}");
        assert!(!JARGON.iter().any(|word| message.contains(word)), "{message}");
    }
}

#[test]
fn faults_of_settings_are_in_plain_words() {
    let place = Workplace::new();
    for (method, set, named) in [
        ("reference", "seed=no number", "whole number"),
        ("reference", "seed=-1", "whole number"),
        ("reference", "paths=forest", "`tree`"),
        ("reference", "no_such=1", "there is no setting `no_such`"),
        ("environment_map", "size=1.5", "whole number"),
        ("environment_map", "size=99999999999", "99999999999"),
        ("sample_based_camera", "accuracy_px=small", "must be a number"),
        ("reference", "count_tests=yes", "true or false"),
    ] {
        let message = place.fails(2, &["render", "scene.toml", "-o", "out.png", "--method", method, "--set", set]);
        assert!(message.contains(named), "{set}: {message}");
        assert!(!JARGON.iter().any(|word| message.contains(word)), "{set}: {message}");
    }
}

#[test]
fn faults_of_options_are_in_plain_words() {
    let place = Workplace::new();
    let render = ["render", "scene.toml", "-o", "out.png"];
    let report = ["compare", "scene.toml", "--report", "report"];
    for (command, option, value, named) in [
        (&render[..], "--samples", "many", "it must be a whole number"),
        (&render, "--samples", "", "it must be a whole number"),
        (&render, "--samples", "5000", "1 to 4096"),
        (&render, "--samples", "-1", "1 to 4096"),
        (&render, "--samples", "99999999999999999999", "the number is too large"),
        (&render, "--order", "17", "whole number from 0 to 16"),
        (&render, "--threads", "0", "1 to 1024"),
        (&render, "--frames", "x", "`x` is not a whole number"),
        (&report, "--projection-every", "0", "1 to 1024"),
        (&report, "--set", "referense.seed=1", "there is no method `referense` (did you mean `reference`?)"),
        (&report, "--set", "sed=1", "none of the methods compared has this setting (did you mean `seed`?)"),
        (&render, "--set", "acuracy_px=1", "there is no setting `acuracy_px` (did you mean `accuracy_px`?)"),
    ] {
        let assigned = format!("{option}={value}");
        let message = place.fails(2, &[command, &[&assigned]].concat());
        assert!(message.contains(option) || message.contains("auto"), "{value}: {message}");
        assert!(message.contains(named), "{value}: {message}");
        assert!(!JARGON.iter().any(|word| message.contains(word)), "{value}: {message}");
    }
    let project = ["project", "scene.toml", "--points", "scene.csv", "-o", "out.csv"];
    place.write("scene.csv", "x,y,z\n0,0,0\n");
    for (words, named) in [
        (&[&project[..], &["--reflector", "bal"]].concat(), "(did you mean `ball`?)"),
        (&[&render[..], &["--lens", "bal"]].concat(), "`bal` (did you mean `ball`?)"),
        (&[&render[..], &["--camera", "camra"]].concat(), "`camra` (did you mean `camera`?)"),
        (&vec!["info", "builtin:vas"], "`vas` (did you mean `vase`?)"),
        (&vec!["info", "builtin:vase?tes=4"], "(did you mean `tess`?)"),
    ] {
        let message = place.fails(1, words);
        assert!(message.contains(named), "{words:?}: {message}");
    }
    place.write("settings.toml", [0xff, 0xfe]);
    let bake = ["bake", "scene.toml", "--method", "light_field", "-c", "settings.toml", "-o", "out.bake"];
    let message = place.fails(1, &bake);
    assert!(message.contains("settings.toml: is no text; save it as UTF-8"), "{message}");
}

#[test]
fn samples_that_a_method_cannot_take_are_wrong_usage() {
    let place = Workplace::new();
    let render = ["render", "scene.toml", "-o", "out.png", "--samples", "3", "--size", "8x8"];
    let message = place.fails(2, &[&render[..], &["--method", "environment_map"]].concat());
    assert!(message.contains("--samples 3") && message.contains("1, 2, 4, 8, 16"), "{message}");
    let message = place.fails(2, &["compare", "scene.toml", "--report", "report", "--samples", "3"]);
    assert!(message.contains("--samples 3"), "{message}");
    let message = place.fails(2, &render);
    assert!(message.contains("method `auto` takes 1, 2, 4, 8, 16"), "{message}");
    assert_eq!(place.files(), ["scene.toml"]);
    place.ok(&[&render[..], &["--method", "reference"]].concat());
}

#[test]
fn numbers_print_as_they_are_written() {
    let place = Workplace::with_scene(&BALL.replace("radius = 0.8", "radius = 0.8\ntint = [0.1, 0.2, 0.7]"));
    let info = place.ok(&["info", "scene.toml", "--json"]);
    let set = ["--method", "sample_based_camera", "--set", "accuracy_px=0.1", "--stats", "stats.json"];
    place.ok(&[&["render", "scene.toml", "-o", "out.png", "--size", "16x12"], &set[..]].concat());
    let lists = [info, place.ok(&["methods", "--json"]), place.text("stats.json")];
    for text in &lists {
        let numbers = text.split(|c: char| !(c.is_ascii_digit() || "+-.e".contains(c)));
        let long: Vec<&str> = numbers.filter(|number| number.contains('.') && number.len() > 12).collect();
        assert!(long.is_empty(), "{long:?}");
    }
    assert!(lists[0].contains("0.1,") && lists[0].contains("\"fov_deg\": 45.0"), "{}", lists[0]);
    assert!(lists[2].contains("\"accuracy_px\": 0.1,"), "{}", lists[2]);
}

#[test]
fn methods_that_do_not_know_two_media_say_so() {
    let place = Workplace::new();
    let bubble = "[[reflector]]\nname = 'bubble'\nsurface = 'sphere'\ncenter = [0, 0.5, 0]\nradius = 0.3\n";
    let glass = "[role]\nwall = 'diffuse'\nball = 'lens'\nbubble = 'lens'\n";
    place.write("nested.toml", BALL.replace("[role]\nwall = \"diffuse\"\n", &format!("{bubble}{glass}")));
    place.write("points.csv", "x,y,z\n0,0.5,-2\n");
    let render = ["render", "nested.toml", "--size", "32x24", "-o", "out.png"];
    let project = ["project", "nested.toml", "--points", "points.csv", "-o", "out.csv"];
    for (words, is_said) in [
        (render.to_vec(), false),
        ([&render[..], &["--method", "multiperspective"]].concat(), true),
        (project.to_vec(), true),
    ] {
        let said = place.run(&words);
        let message = String::from_utf8(said.stderr).unwrap();
        assert!(said.status.success(), "{words:?}: {message}");
        assert_eq!(message.contains("as if air were on the other side"), is_said, "{words:?}: {message}");
    }
}
