//! `catoptric render`, `compare` and the lists: exit codes, messages, files and numbers.

use crate::workplace::{BALL, Workplace, files};
use serde_json::Value;

const RENDER: [&str; 4] = ["render", "scene.toml", "-o", "out.png"];

const SMALL: [&str; 4] = ["--size", "64x48", "--samples", "2"];

impl Workplace {
    fn render(&self, more: &[&str]) -> String {
        self.ok(&[&RENDER, &SMALL[..], more].concat())
    }
}

#[test]
fn render_writes_a_picture_its_mask_and_its_numbers() {
    let place = Workplace::new();
    let said = place.render(&["--stats", "stats.json", "--mask", "mask.png", "--frames", "3", "--motion", "eye"]);
    assert!(said.contains("out.png") && said.contains("64x48"), "{said}");
    assert_eq!(place.files(), ["mask.png", "out.png", "scene.toml", "stats.json"]);
    let picture = catoptric::picture::read(&place.path("out.png")).unwrap();
    assert_eq!((picture.width, picture.height), (64, 48));
    let mask = catoptric::picture::read(&place.path("mask.png")).unwrap();
    let white = mask.pixels.iter().filter(|pixel| pixel[0] == 1.0).count();
    let black = mask.pixels.iter().filter(|pixel| pixel[0] == 0.0).count();
    let grey = 64 * 48 - white - black;
    assert!(white > 100 && black > 100 && grey > 10 && grey < 150, "{white} white, {black} black");

    let stats = place.json("stats.json");
    for key in [
        "version",
        "scene",
        "method",
        "settings",
        "backend",
        "device",
        "threads",
        "size",
        "samples",
        "order",
        "frames",
        "motion",
        "setup_ms",
        "frame_ms",
        "stages_ms",
        "first_stages_ms",
        "counts",
        "bytes",
    ] {
        assert!(!stats[key].is_null(), "{key} is missing");
    }
    assert_eq!(stats["method"], "auto");
    assert_eq!(stats["choices"][0]["method"], "multiperspective");
    assert!(!stats["choices"][0]["reason"].as_str().unwrap().is_empty());
    assert_eq!(stats["backend"], "cpu");
    assert_eq!(stats["size"], serde_json::json!([64, 48]));
    assert_eq!((&stats["samples"], &stats["order"], &stats["frames"]), (&2.into(), &8.into(), &3.into()));
    assert!(stats["setup_ms"]["load"].as_f64().unwrap() > 0.0);
    let time = |name: &str| stats["frame_ms"][name].as_f64().unwrap();
    assert!(0.0 < time("min") && time("min") <= time("median") && time("median") <= time("max"));
    assert!(time("min") <= time("first") && time("first") <= time("max"));
    assert!(stats["counts"]["scene_triangles"].as_u64() > stats["counts"]["reflector_triangles"].as_u64());
    assert!(stats["counts"]["fallbacks"].is_object());
}

#[test]
fn frames_over_their_budget_are_drawn_by_auto_and_counted() {
    let place = Workplace::new();
    let slow = ["--method", "reference", "--size", "320x240", "--samples", "1000", "--budget-ms", "1"];
    place.ok(&[&["render", "scene.toml", "-o", "out.png", "--stats", "stats.json"], &slow[..]].concat());
    let stats = place.json("stats.json");
    assert_eq!(stats["counts"]["fallbacks"]["frames_over_budget"], 1);
    assert!(stats["warnings"].to_string().contains("within 1 ms"), "{}", stats["warnings"]);
}

#[test]
fn a_single_frame_is_the_first_one() {
    let place = Workplace::new();
    place.render(&["--stats", "stats.json"]);
    let times = place.json("stats.json")["frame_ms"].clone();
    assert!(times["first"].as_f64().unwrap() > 0.0, "{times}");
    assert!(["max", "median", "min"].iter().all(|name| times[name] == times["first"]), "{times}");
}

#[test]
fn exr_holds_linear_values() {
    let place = Workplace::new();
    place.ok(&[&["render", "scene.toml", "-o", "out.exr"], &SMALL[..]].concat());
    place.render(&[]);
    let linear = catoptric::picture::read(&place.path("out.exr")).unwrap();
    let shown = catoptric::picture::read(&place.path("out.png")).unwrap();
    assert_eq!(linear.to_srgb8(), shown.to_srgb8());
    assert!(linear.pixels.iter().flatten().all(|value| value.is_finite()));
}

#[test]
fn the_same_input_gives_the_same_bytes_on_any_number_of_threads() {
    let place = Workplace::new();
    let listed = place.listed(&["methods", "--json"]);
    for method in listed.as_array().unwrap() {
        let id = method["id"].as_str().unwrap();
        let [one, two] = ["1", "2"].map(|threads| {
            place.render(&["--method", id, "--threads", threads]);
            place.bytes("out.png")
        });
        assert!(one == two, "{id}");
    }
}

#[test]
fn negative_numbers_stand_with_and_without_an_equals_sign() {
    let place = Workplace::new();
    let view = ["--target", "0,0.5,-0.5", "--fov", "50"];
    place.render(&[&["--eye", "-2,1,3", "--up", "-0.1,1,0", "--time", "-1"], &view[..]].concat());
    let apart = place.bytes("out.png");
    place.render(&[&["--eye=-2,1,3", "--up=-0.1,1,0", "--time=-1"], &view[..]].concat());
    assert!(apart == place.bytes("out.png"));
    place.render(&[&["--eye", "2,1,3"], &view[..]].concat());
    assert!(apart != place.bytes("out.png"), "the eye does not matter");
}

#[test]
fn wrong_usage_ends_with_2() {
    let place = Workplace::new();
    let faults: [(&[&str], &str); 20] = [
        (&["--method", "no_such"], "no_such"),
        (&["--set", "no_such=1"], "`accuracy_px`"),
        (&["--set", "no_such=1"], "no_such"),
        (&["--method", "reference", "--set", "seed=no number"], "seed"),
        (&["--set", "seed"], "KEY=VALUE"),
        (&["--size", "0x48"], "1 to 16384"),
        (&["--size", "16384x16384"], "pixels"),
        (&["--size", "64"], "WxH"),
        (&["--samples", "0"], "1 to 4096"),
        (&["--order", "17"], "whole number from 0 to 16"),
        (&["--eye", "1,2"], "X,Y,Z"),
        (&["--eye", "1,2,nan", "--target", "0,0,0"], "nan"),
        (&["--eye", "1,2,3", "--target", "1,2,3"], "same point"),
        (&["--eye", "1,2,3", "--target", "0,0,0", "--camera", "0"], "--camera"),
        (&["--fov", "180"], "179"),
        (&["--lens", "ball:99"], "0.1 to 10"),
        (&["--threads", "0"], "1 to 1024"),
        (&["--backend", "magic"], "magic"),
        (&["--stats", "out.png"], "two outputs"),
        (&["--nonsense"], "--nonsense"),
    ];
    place.names_faults(2, &RENDER, &faults);
    let message = place.fails(2, &["render", "scene.toml", "-o", "out.bmp"]);
    assert!(message.contains(".png, .jpg, .webp or .exr"), "{message}");
    assert!(!place.run(&["render", "scene.toml"]).status.success());
    assert_eq!(place.run(&[]).status.code(), Some(2));
}

/// An environment is turned counter-clockwise seen from above, and its light multiplied.
#[test]
fn environments_are_turned_and_scaled() {
    let place = Workplace::new();
    // Rays straight through the middle of the picture, towards -z, beside the ball and the wall.
    let ahead = |more: &[&str]| {
        let view = ["--eye", "0,50,0", "--target", "0,50,-1", "--fov", "1", "--exposure", "0"];
        let size = ["render", "scene.toml", "-o", "out.exr", "--size", "3x3", "--samples", "1"];
        place.ok(&[&size, &view[..], more].concat());
        catoptric::picture::read(&place.path("out.exr")).unwrap().pixels[4][0]
    };
    let sky = catoptric_scenes::named_environment("studio").unwrap();
    let expected = |x: f32, z: f32| sky.radiance(glam::Vec3::new(x, 0.0, z).normalize()).x;
    // Turned by 90 degrees, what was at +x comes to -z.
    for (degrees, [x, z]) in [("0", [0.0, -1.0]), ("90", [1.0, 0.0]), ("-90", [-1.0, 0.0]), ("135", [1.0, 1.0])] {
        let found = ahead(&["--environment", "studio", "--environment-rotation", degrees]);
        assert!((found - expected(x, z)).abs() < 2e-3, "{degrees}: {found}, {}", expected(x, z));
    }
    let scaled = ahead(&["--environment", "studio", "--environment-strength", "0.25"]);
    assert!((scaled - 0.25 * expected(0.0, -1.0)).abs() < 1e-3, "{scaled}");
    assert!(place.fails(2, &[&RENDER[..], &["--environment-strength", "-1"]].concat()).contains("between 0 and"));
}

#[test]
fn faults_of_the_input_and_the_machine_end_with_1() {
    let place = Workplace::new();
    let faults: [(&[&str], &str); 9] = [
        (&["--adapter", "no such"], "--adapter: "),
        (&["--baked", "a.bake"], "a.bake"),
        (&["--camera", "no_such"], "scene.toml"),
        (&["--reflector", "no_such*"], "no_such*"),
        (&["--environment", "none.hdr"], "none.hdr"),
        (&["--environment", "moon"], "studio, sky"),
        (&["--environment-rotation", "20"], "--environment-rotation: the scene has no environment"),
        (&["--stats", "scene.toml/where.json"], "where.json"),
        (&["--mask", "scene.toml/where.png"], "where.png"),
    ];
    place.names_faults(1, &RENDER, &faults);
    assert!(place.fails(1, &["render", "none.glb", "-o", "out.png"]).contains("none.glb"));
    assert!(place.fails(1, &["render", "scene.toml", "-o", "scene.toml/out.png"]).contains("scene.toml/out.png"));
    assert!(place.fails(1, &["info", "builtin:no_such"]).contains("no_such"));
    std::fs::create_dir(place.path("folder.png")).unwrap();
    assert!(place.fails(1, &["render", "scene.toml", "-o", "folder.png"]).contains("folder"));
    place.write("broken.toml", BALL.replace("radius = 0.8", "radius = -1"));
    assert!(place.fails(1, &["render", "broken.toml", "-o", "out.png"]).contains("broken.toml"));
    place.write("setting.toml", format!("{BALL}[method.reference]\nseeed = 1\n"));
    assert!(place.fails(1, &["render", "setting.toml", "-o", "out.png"]).contains("seeed"));
    assert_eq!(place.files(), ["broken.toml", "folder.png", "scene.toml", "setting.toml"]);
}

#[test]
fn render_makes_missing_folders_when_it_draws() {
    let place = Workplace::new();
    place.fails(1, &["render", "scene.toml", "-o", "new/deep/out.png", "--camera", "7"]);
    assert_eq!(place.files(), ["scene.toml"]);
    let outputs = ["-o", "new/deep/out.png", "--stats", "new/stats.json", "--mask", "masks/mask.png"];
    place.ends(0, &[&["render", "scene.toml", "--size", "16x12"], &outputs[..]].concat());
    assert!(["new/deep/out.png", "new/stats.json", "masks/mask.png"].iter().all(|name| place.path(name).is_file()));
}

#[test]
fn a_failed_run_leaves_the_old_picture() {
    let place = Workplace::new();
    place.render(&[]);
    let before = place.bytes("out.png");
    place.fails(1, &["render", "scene.toml", "-o", "out.png", "--camera", "7"]);
    assert!(before == place.bytes("out.png"));
}

#[test]
fn settings_and_roles_take_effect() {
    let place = Workplace::new();
    let set = ["--method", "reference", "--set", "seed=5", "--set", "samples=random"];
    place.render(&[&["--stats", "stats.json"], &set[..]].concat());
    let stats = place.json("stats.json");
    assert_eq!((&stats["settings"]["seed"], &stats["settings"]["samples"]), (&5.into(), &"random".into()));
    let info = |words: &[&str]| -> Value { place.listed(&[&["info", "scene.toml", "--json"], words].concat()) };
    let role = |info: &Value, name: &str| {
        let objects = info["objects"].as_array().unwrap();
        objects.iter().find(|object| object["name"] == name).unwrap()["role"].clone()
    };
    let plain = info(&[]);
    assert_eq!((role(&plain, "ball"), role(&plain, "wall")), ("reflector".into(), "diffuse".into()));
    let changed = info(&["--diffuse", "*", "--lens", "ba*:1.3"]);
    assert_eq!((role(&changed, "ball"), role(&changed, "wall")), ("lens".into(), "diffuse".into()));
    let overruled = info(&["--lens", "ba*:1.3", "--diffuse", "*"]);
    assert_eq!(role(&overruled, "ball"), "diffuse");
    assert_eq!(plain["cameras"].as_array().unwrap().len(), 1);
    assert!(place.ok(&["info", "scene.toml"]).contains("sphere"));
}

#[test]
fn quiet_says_nothing_and_verbose_more() {
    let place = Workplace::new();
    assert_eq!(place.render(&["--quiet"]), "");
    assert!(place.render(&["-v"]).lines().count() > place.render(&[]).lines().count());
    assert!(place.run(&["render", "scene.toml", "-o", "out.png", "--size", "8x8"]).stderr.is_empty());
}

/// Draws on a GPU where there is a real one, and without a word on the processor where there is none.
#[test]
fn the_processor_that_draws_is_chosen() {
    let place = Workplace::new();
    let mut command = place.command(&[&RENDER, &SMALL[..], &["--backend", "auto"]].concat());
    // Drivers of Mesa look for a desktop, and complain themselves where this names no folder.
    let output = command.env("XDG_RUNTIME_DIR", std::env::temp_dir()).output().unwrap();
    assert!(output.status.success() && output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
    if cfg!(not(feature = "gpu")) {
        let message = place.fails(1, &[&RENDER[..], &["--backend", "gpu"]].concat());
        assert!(message.contains("without the GPU backend"), "{message}");
    }
}

#[test]
fn methods_are_listed() {
    let place = Workplace::new();
    let listed = place.listed(&["methods", "--json"]);
    let listed = listed.as_array().unwrap();
    assert_eq!(listed[0]["id"], "reference");
    for method in listed {
        for key in ["id", "family", "paper", "cpu", "gpu", "bake", "settings"] {
            assert!(!method[key].is_null(), "{method}: {key}");
        }
        for setting in method["settings"].as_array().unwrap() {
            assert!(setting["name"].is_string() && setting["default"].is_string() && setting["help"].is_string());
        }
        assert!(place.ok(&["methods"]).contains(method["id"].as_str().unwrap()));
    }
}

#[test]
fn the_other_lists_can_be_read() {
    let place = Workplace::new();
    let scenes = place.listed(&["scenes", "--json"]);
    let name = scenes[0]["name"].as_str().unwrap();
    assert!(place.ok(&["scenes"]).contains(name));
    place.ok(&[&["render", &format!("builtin:{name}"), "-o", "out.png"], &SMALL[..]].concat());
    let doctor = place.listed(&["doctor", "--json"]);
    assert!(doctor["cores"].as_u64().unwrap() > 0 && doctor["threads"].as_u64().unwrap() > 0);
    assert!(place.ok(&["doctor"]).contains("processor"));
    for shell in ["bash", "zsh", "fish", "powershell"] {
        assert!(place.ok(&["completions", shell]).contains("compare"), "{shell}");
    }
    for command in ["render", "compare", "project", "methods", "info", "scenes", "doctor", "completions"] {
        assert!(place.ok(&[command, "--help"]).contains("Example"), "{command} --help has no example");
    }
}

#[test]
fn compare_writes_a_report() {
    let place = Workplace::new();
    let methods =
        ["--method", "reference", "--method", "reference:samples=random,seed=4", "--set", "reference.paths=tree"];
    let report = ["--report", "new/report", "--frames", "2", "--motion", "eye"];
    let said = place.ok(&[&["compare", "scene.toml"], &SMALL[..], &methods, &report].concat());
    assert!(said.contains("report.html"), "{said}");
    assert_eq!(files(&place.path("new/report")), ["report.html", "report.json"]);
    let report = place.json("new/report/report.json");
    let entries = report.as_array().unwrap();
    assert_eq!(entries.len(), 2);
    for entry in entries {
        for part in ["image", "reflector"] {
            for key in ["flip_mean", "flip_p99", "rmse", "over_0_1"] {
                assert!(entry["error"][part][key].is_f64(), "{part}.{key} in {entry}");
            }
        }
        assert!(entry["error"].as_object().unwrap().contains_key("projection_px"));
        assert!(entry["reference_ms"].as_f64().unwrap() > 0.0 && entry["frames"] == 2);
    }
    assert_eq!(entries[0]["error"]["image"]["flip_mean"], 0.0);
    assert!(entries[1]["error"]["image"]["rmse"].as_f64().unwrap() > 0.0, "other samples, the same picture?");
    assert_eq!(entries[1]["variant"], "samples=random,seed=4");
    let page = place.text("new/report/report.html");
    assert_eq!(page.matches("src=\"data:image/png;base64,").count(), 3);
    assert!(page.contains("<svg") && page.contains("catoptric compare scene.toml"));
    for fetched in ["<link", "src=\"http", "href=\"http", "url(", "@import"] {
        assert!(!page.contains(fetched), "the page fetches something: {fetched}");
    }
    assert!(!page.contains(place.folder.path().to_str().unwrap()), "the page names a folder of this machine");
}

#[test]
fn compare_takes_all_methods_and_lists_those_that_fail() {
    let place = Workplace::new();
    place.ok(&[&["compare", "scene.toml", "--report", "report", "--frames", "1"], &SMALL[..]].concat());
    let listed = place.listed(&["methods", "--json"]);
    let report = place.json("report/report.json");
    let ids = |list: &Value, key: &str| -> Vec<Value> {
        list.as_array().unwrap().iter().map(|entry| entry[key].clone()).collect()
    };
    assert_eq!(ids(&report, "method"), ids(&listed, "id"));
    for entry in report.as_array().unwrap() {
        assert!(entry["error"].is_object() != entry["failed"].is_string(), "{entry}");
    }
}

#[test]
fn a_comparison_in_which_a_method_fails_ends_with_1_and_its_report() {
    let place = Workplace::new();
    let methods = ["--method", "environment_map", "--method", "light_field:views=none.toml"];
    let words = [&["compare", "scene.toml", "--report", "report", "--frames", "1"], &SMALL[..], &methods].concat();
    let said = place.ends(1, &words);
    assert!(said.contains("report.html"), "{said}");
    let report = place.json("report/report.json");
    assert!(report[0]["error"].is_object(), "{report}");
    assert!(report[1]["failed"].as_str().unwrap().contains("none.toml"), "{report}");
}

#[test]
fn compare_measures_where_methods_project_points() {
    let place = Workplace::new();
    let words = ["compare", "builtin:planar_mirror", "--report", "report", "--frames", "1", "--projection-every", "2"];
    let methods = ["--method", "planar_mirror", "--method", "environment_map"];
    let said = place.ok(&[&words[..], &SMALL, &methods].concat());
    assert!(said.contains("px p99"), "{said}");
    let report = place.json("report/report.json");
    let error = &report[0]["error"]["projection_px"];
    assert!(error["p99"].as_f64().unwrap() < 0.01 && error["count"].as_u64().unwrap() > 100, "{error}");
    assert!(error["missing"].as_f64().unwrap() < 0.01 && error["max"].is_f64() && error["p50"].is_f64(), "{error}");
    assert!(report[1]["error"]["projection_px"].is_null());
    assert!(place.text("report/report.html").contains("Projection, pixels"));
}

/// Tiles have drawn the first one's picture: nothing is said of points that it would have projected.
#[test]
fn compare_says_who_has_drawn_and_measures_no_projection_of_others() {
    let place = Workplace::new();
    let words = ["compare", "builtin:sphere_room", "--report", "report", "--order", "1", "--samples", "1"];
    let methods = ["--size", "240x180", "--method", "path_perturbation:work=0", "--method", "path_perturbation"];
    let said = place.ok(&[&words[..], &methods].concat());
    let rows: Vec<&str> = said.lines().filter(|line| line.starts_with("path_perturbation")).collect();
    assert!(said.contains("drawn by") && rows[0].contains("tiles ") && !rows[0].contains("own "), "{said}");
    assert!(rows[1].contains("own 100 %") && rows[0].matches('–').count() == 4, "{said}");
    assert!(said.contains("of the paths that the method's own geometry has drawn"), "{said}");
    let report = place.json("report/report.json");
    assert!(report[0]["error"]["projection_px"].is_null(), "{report}");
    assert!(report[1]["error"]["projection_px"]["count"].as_u64().unwrap() > 100, "{report}");
    let share = |by: &str| report[0]["drawn_by"][by].as_f64().unwrap();
    assert!(share("tiles") > 0.5 && share("method") == 0.0 && share("tiles") + share("rays") == 1.0, "{report}");
    let page = place.text("report/report.html");
    assert!(page.contains("Over half of the reflectors is drawn by tiles and rays") && page.contains("own 100 %"));
    assert!(page.contains(", mostly by tiles"));
}

#[test]
fn a_picture_without_reflectors_has_no_reflector_error() {
    let place = Workplace::new();
    let words =
        ["compare", "scene.toml", "--report", "report", "--frames", "1", "--diffuse", "*", "--method", "reference"];
    place.ok(&[&words, &SMALL[..]].concat());
    let report = place.json("report/report.json");
    assert!(report[0]["error"]["reflector"].is_null() && report[0]["error"]["image"].is_object());
}

#[test]
fn compare_refuses_before_it_writes() {
    let place = Workplace::new();
    let usage: [(&[&str], &str); 5] = [
        (&["--method", "no_such"], "no_such"),
        (&["--method", "reference:no_such=1"], "no_such"),
        (&["--method", "reference:seed"], "KEY=VALUE"),
        (&["--set", "no_such=1"], "no_such"),
        (&["--set", "no_such.seed=1"], "no_such"),
    ];
    let compare = ["compare", "scene.toml", "--report", "report"];
    place.names_faults(2, &compare, &usage);
    place.names_faults(
        1,
        &compare,
        &[(&["--adapter", "no such"], "--adapter: "), (&["--camera", "no_such"], "no_such")],
    );
    assert_eq!(place.files(), ["scene.toml"]);
    let message = place.fails(1, &["compare", "scene.toml", "--report", "scene.toml"]);
    assert!(message.contains("--report scene.toml"), "{message}");
}

/// A file as other programs write them, without light and camera: a triangle of one material.
fn triangle(material: &str) -> String {
    let positions = "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"material":0}}]}}],"materials":[{material}],
        "buffers":[{{"byteLength":36,"uri":"{positions}"}}],"bufferViews":[{{"buffer":0,"byteLength":36}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}}]}}"#
    )
}

#[test]
fn a_bare_file_is_framed_and_lit_and_what_it_leaves_open_is_said() {
    let place = Workplace::new();
    let render = |material: &str, more: &[&str]| {
        place.write("bare.gltf", triangle(material));
        place.run(&[&["render", "bare.gltf", "-o", "out.png"], &SMALL[..], more].concat())
    };
    let metal = r#"{"pbrMetallicRoughness":{"roughnessFactor":0.5},"doubleSided":true}"#;
    let drawn = render(metal, &["--mask", "mask.png"]);
    assert!(drawn.status.success() && drawn.stderr.is_empty(), "{drawn:?}");
    let picture = catoptric::picture::read(&place.path("out.png")).unwrap();
    // The studio is behind the metal and in it.
    assert!(picture.pixels.iter().all(|pixel| pixel[0] > 0.02));

    let pane = r#"{"extensions":{"KHR_materials_transmission":{"transmissionFactor":1}}}"#;
    let said = |output: std::process::Output| String::from_utf8(output.stderr).unwrap();
    assert!(said(render(pane, &[])).contains("1 transmitting material has no volume and is drawn as thin walls"));
    let solid = said(render(pane, &["--thin-glass", "solid"]));
    assert!(solid.contains("of object 0 has no closed surface") && solid.lines().count() == 1, "{solid}");

    let glitter = r#"{"name":"tinsel","extensions":{"VENDOR_materials_glitter":{}}}"#;
    let without = "materials[0] `tinsel` is drawn without VENDOR_materials_glitter";
    let output = render(glitter, &[]);
    assert!(output.status.success() && said(output).contains(without));
    let output = render(glitter, &["--strict"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(said(output).contains(without));
}
