//! Help and completions.

use crate::workplace::Workplace;
use std::process::Command;

const COMMANDS: [&[&str]; 20] = [
    &[],
    &["render"],
    &["compare"],
    &["project"],
    &["bake"],
    &["bake", "plan"],
    &["bake", "frames"],
    &["bake", "run"],
    &["bake", "status"],
    &["bake", "views"],
    &["bake", "merge"],
    &["bake", "submit"],
    &["diff"],
    &["methods"],
    &["explain"],
    &["view"],
    &["info"],
    &["scenes"],
    &["doctor"],
    &["completions"],
];

#[test]
fn options_stand_under_headings() {
    let place = Workplace::new();
    for command in COMMANDS {
        for help in ["--help", "-h"] {
            let text = place.ok(&[command, &[help]].concat());
            assert!(text.contains("\nGeneral:\n") && !text.contains("\nOptions:\n"), "{command:?}: {text}");
        }
    }
    for command in ["render", "compare", "project", "bake"] {
        let text = place.ok(&[command, "--help"]);
        let at =
            |heading: &str| text.find(&format!("\n{heading}:\n")).unwrap_or_else(|| panic!("{command}: {heading}"));
        assert!(text.contains("\nScene:\n  <SCENE>"), "{command}: {text}");
        assert!(at("Scene") < at("Method") && at("Output") < at("General"), "{command}");
        assert!(command == "bake" || text.contains("\nView:\n"), "{command}");
    }
    let version = place.ok(&["--version"]);
    assert!(version.starts_with("catoptric "), "{version}");
}

#[test]
fn examples_fit_into_80_columns() {
    let place = Workplace::new();
    for command in COMMANDS {
        let output = place.command(&[command, &["--help"]].concat()).env("COLUMNS", "80").output().unwrap();
        let text = String::from_utf8(output.stdout).unwrap();
        let mut lines = text.lines().skip_while(|line| !line.starts_with("Example")).peekable();
        assert!(lines.peek().is_some(), "{command:?} has no example");
        let mut is_example = false;
        let mut goes_on = false;
        for line in lines {
            assert!(line.chars().count() <= 80, "{line}");
            is_example = line.starts_with("Example") || (is_example && !line.is_empty());
            if !is_example || line.starts_with("Example") {
                continue;
            }
            let is_begin = line.starts_with("  catoptric ") || line.starts_with("  (");
            assert!(if goes_on { line.starts_with("      ") } else { is_begin }, "wrapped: {line}");
            goes_on = line.ends_with('\\');
        }
        assert!(!goes_on, "{command:?}");
    }
}

#[test]
fn completions_know_methods_settings_and_scenes() {
    let place = Workplace::new();
    for (shell, scene) in
        [("bash", "builtin:sphere_room"), ("zsh", "builtin\\:sphere_room"), ("fish", "builtin:sphere_room")]
    {
        let script = place.ok(&["completions", shell]);
        for name in ["sample_based_camera", "accuracy_px=", "reference.seed=", "exact", scene] {
            assert!(script.contains(name), "{shell}: {name}");
        }
    }
    if Command::new("bash").arg("--version").output().is_err() {
        return;
    }
    let script = place.ok(&["completions", "bash"]);
    let completed = |words: &[&str]| -> Vec<String> {
        let (last, before) = (words[words.len() - 1], words[words.len() - 2]);
        let (line, count) = (words.join(" "), words.len() - 1);
        let call = format!(
            "{script}\nCOMP_WORDS=({line})\n[ -z '{last}' ] && COMP_WORDS+=('')\nCOMP_CWORD={count}\n\
            _catoptric catoptric '{last}' '{before}'\nprintf '%s\\n' \"${{COMPREPLY[@]}}\"\n"
        );
        place.write("call.bash", call);
        let output = Command::new("bash").arg("--norc").arg(place.path("call.bash")).output().unwrap();
        String::from_utf8(output.stdout).unwrap().lines().map(String::from).collect()
    };
    assert_eq!(completed(&["catoptric", "render", "builtin:sphere_r"]), ["builtin:sphere_room"]);
    assert_eq!(completed(&["catoptric", "render", "a.glb", "--method", "path_p"]), ["path_perturbation"]);
    assert_eq!(completed(&["catoptric", "render", "a.glb", "--set", "accuracy_p"]), ["accuracy_px="]);
    assert!(completed(&["catoptric", "bake", "a.glb", "--method", ""]).contains(&"light_field".to_owned()));
}
