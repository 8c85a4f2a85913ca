//! `explain`, `view`, and environment variables in place of options.

use crate::workplace::Workplace;
use catoptric::methods;

#[test]
fn every_method_is_explained() {
    let place = Workplace::new();
    for info in methods::all() {
        let settings = (info.settings)();
        for name in info.about.useful {
            assert!(settings.iter().any(|setting| setting.name == *name), "{}: {name}", info.id);
        }
        let text = place.ok(&["explain", info.id]);
        let has = |part: &str| text.contains(&format!("\n  {part}: "));
        assert!(["paper", "idea", "draws", "costs", "assumes", "faults"].into_iter().all(has), "{text}");
        assert!(info.about.idea().len() > 40 && !text.contains("](") && !text.contains("**"), "{text}");
        assert_eq!(text.matches("\n  --set ").count(), info.about.useful.len(), "{text}");
        assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
        let json = place.listed(&["explain", info.id, "--json"]);
        assert_eq!(json["idea"].as_str(), Some(info.about.idea().as_str()));
    }
    let message = place.fails(2, &["explain", "lightfield"]);
    assert!(message.contains("there is no method `lightfield` (did you mean `light_field`?)"), "{message}");
}

#[cfg(unix)]
#[test]
fn the_viewer_gets_what_stands_behind_view() {
    use std::os::unix::fs::PermissionsExt;
    let place = Workplace::new();
    place.write("viewer", "#!/bin/sh\necho \"$@\"\nexit 7\n");
    let viewer = place.path("viewer");
    std::fs::set_permissions(&viewer, std::fs::Permissions::from_mode(0o755)).unwrap();
    let view = |words: &[&str]| {
        let output = place.command(&[&["view"], words].concat()).env("CATOPTRIC_VIEWER", &viewer).output().unwrap();
        assert_eq!(output.status.code(), Some(7), "{words:?}");
        String::from_utf8(output.stdout).unwrap()
    };
    assert_eq!(
        view(&["room.glb", "--against", "reference", "--order", "3"]),
        "room.glb --against reference --order 3\n"
    );
    assert_eq!(view(&["--", "--help"]), "--help\n");
    assert_eq!(view(&[]), "\n");
    let output = place.command(&["view"]).env("CATOPTRIC_VIEWER", "nowhere").output().unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(message.contains("CATOPTRIC_VIEWER=nowhere: there is no such file; build it with `cargo"), "{message}");
}

#[test]
fn variables_stand_for_options_that_are_not_given() {
    let place = Workplace::new();
    let variables = [
        ("CATOPTRIC_SIZE", "24x16"),
        ("CATOPTRIC_SAMPLES", "1"),
        ("CATOPTRIC_ORDER", "1"),
        ("CATOPTRIC_METHOD", "reference"),
        ("CATOPTRIC_BACKEND", "cpu"),
        ("CATOPTRIC_THREADS", "1"),
        ("CATOPTRIC_ENVIRONMENT", "studio"),
        ("CATOPTRIC_EXPOSURE", "0"),
        ("CATOPTRIC_TONE", "none"),
    ];
    let render = ["render", "scene.toml", "-o", "out.png", "--stats", "stats.json"];
    let draw = |words: &[&str]| {
        let output = place.command(&[&render, words].concat()).envs(variables).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        place.json("stats.json")
    };
    let stats = draw(&[]);
    assert_eq!((&stats["size"][0], &stats["size"][1], &stats["samples"]), (&24.into(), &16.into(), &1.into()));
    assert_eq!((&stats["order"], &stats["method"], &stats["threads"]), (&1.into(), &"reference".into(), &1.into()));
    let stats = draw(&["--size", "8x8", "--method=environment_map", "--threads", "2"]);
    assert_eq!(
        (&stats["size"][0], &stats["method"], &stats["threads"]),
        (&8.into(), &"environment_map".into(), &2.into())
    );
    // Other commands have options of the same names that mean something else.
    let plan =
        ["bake", "plan", "scene.toml", "--method", "light_field", "--set", "st=2", "--set", "uv=4", "-o", "parts"];
    let output = place.command(&plan).envs(variables).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn faults_of_variables_name_the_variable() {
    let place = Workplace::new();
    let fault = |code: i32, variable: &str, value: &str, words: &[&str]| {
        let render = ["render", "scene.toml", "-o", "out.png", "--size", "8x8"];
        let output = place.command(&[&render, words].concat()).env(variable, value).output().unwrap();
        assert_eq!(output.status.code(), Some(code), "{variable}={value}");
        String::from_utf8(output.stderr).unwrap()
    };
    let message = fault(2, "CATOPTRIC_SAMPLES", "many", &[]);
    assert!(message.contains("'--samples <N>' (from the environment variable CATOPTRIC_SAMPLES)"), "{message}");
    let message = fault(2, "CATOPTRIC_TONE", "loud", &[]);
    assert!(message.contains("CATOPTRIC_TONE") && message.contains("neutral"), "{message}");
    let message = fault(2, "CATOPTRIC_METHOD", "refrence", &[]);
    assert!(message.contains("environment variables: CATOPTRIC_METHOD=refrence"), "{message}");
    let message = fault(1, "CATOPTRIC_ENVIRONMENT", "none.hdr", &[]);
    assert!(message.contains("CATOPTRIC_ENVIRONMENT=none.hdr"), "{message}");
    let message = fault(2, "CATOPTRIC_SAMPLES", "many", &["--samples", "many"]);
    assert!(message.contains("--samples") && !message.contains("CATOPTRIC"), "{message}");
    assert_eq!(fault(0, "CATOPTRIC_SAMPLES", "many", &["--samples", "1"]), "");
}
