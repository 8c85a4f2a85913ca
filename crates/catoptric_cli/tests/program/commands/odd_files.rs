//! Files, names and outputs that no one expects: nothing hangs, nothing is lost, and terminals get plain text.

use crate::workplace::Workplace;
use std::process::Command;

const SMALL: [&str; 4] = ["--size", "32x24", "--samples", "1"];

/// A triangle whose node has this name.
fn triangle(name: &str) -> String {
    let positions = "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
    serde_json::json!({
        "asset": { "version": "2.0" },
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0, "name": name }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
        "buffers": [{ "uri": positions, "byteLength": 36 }],
        "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
        "accessors": [{
            "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]
        }],
    })
    .to_string()
}

#[test]
fn names_of_files_never_steer_a_terminal_and_never_fill_it() {
    let place = Workplace::new();
    place.write("evil.gltf", triangle("a\u{1b}]0;title\u{7}\u{9b}31m\u{202e}b"));
    let is_steering =
        |text: &str| text.contains(|letter: char| letter.is_control() && letter != '\n') || text.contains('\u{202e}');
    for words in
        [&["info", "evil.gltf"][..], &["info", "evil.gltf", "--json"], &["info", "evil.gltf", "--reflector", "x"]]
    {
        let output = place.run(words);
        let text = String::from_utf8([output.stdout, output.stderr].concat()).unwrap();
        assert!(text.contains("title") && !is_steering(&text), "{words:?}: {text}");
    }
    assert_eq!(
        place.listed(&["info", "evil.gltf", "--json"])["objects"][0]["name"],
        "a\u{1b}]0;title\u{7}\u{9b}31m\u{202e}b"
    );
    place.write("long.gltf", triangle(&"x".repeat(70_000)));
    let text = place.ok(&["info", "long.gltf"]);
    assert!(text.len() < 2000 && text.contains("69940 more characters"), "{text}");
}

#[cfg(unix)]
#[test]
fn pipes_are_refused_before_they_are_opened() {
    let place = Workplace::new();
    assert!(Command::new("mkfifo").arg(place.path("pipe.gltf")).status().unwrap().success());
    let piped = [
        &["info", "pipe.gltf"][..],
        &["info", "scene.toml", "--environment", "pipe.gltf"],
        &["diff", "pipe.gltf", "pipe.gltf"],
    ];
    for words in piped {
        let message = place.fails(1, words);
        assert!(message.contains("pipe.gltf") && message.contains("is a pipe"), "{words:?}: {message}");
    }
}

#[test]
fn no_output_replaces_what_a_picture_is_made_of() {
    let place = Workplace::new();
    let text = triangle("a");
    place.write("room.gltf", &text);
    place.write(
        "bare.gltf",
        text.replace(
            "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA",
            "corners.bin",
        ),
    );
    place.write("corners.bin", "x");
    for (scene, output) in [("room.gltf", "./room.gltf"), ("bare.gltf", "corners.bin")] {
        let message = place.fails(2, &[&["render", scene, "-o", "a.png", "--stats", output], &SMALL[..]].concat());
        assert!(message.contains(output) && message.contains("is read, too"), "{message}");
    }
    assert!(place.bytes("room.gltf") == text.as_bytes() && place.bytes("corners.bin") == b"x");
}

#[test]
fn reports_replace_reports_alone() {
    let place = Workplace::new();
    std::fs::create_dir(place.path("mine")).unwrap();
    place.write("mine/reference.png", "mine");
    let compare = ["compare", "scene.toml", "--frames", "1", "--pictures", "--report"];
    let with = |folder: &'static str, method| [&compare[..], &[folder, "--method", method], &SMALL].concat();
    let message = place.fails(2, &with("mine", "environment_map"));
    assert!(message.contains("mine") && message.contains("reference.png"), "{message}");
    assert_eq!(place.bytes("mine/reference.png"), b"mine");
    place.ok(&with("report", "environment_map"));
    place.write("report/notes.txt", "mine");
    place.ok(&with("report", "planar_mirror"));
    assert!(!place.path("report/environment_map.png").exists() && place.path("report/planar_mirror.png").exists());
    assert_eq!(place.bytes("report/notes.txt"), b"mine");
}

#[cfg(target_os = "linux")]
#[test]
fn limits_and_signals_of_the_system_are_respected() {
    let place = Workplace::new();
    let program = place.command(&[]).get_program().to_owned();
    let shell = |script: &str| {
        let script = script.replace("PROGRAM", &format!("'{}'", program.to_str().unwrap()));
        let output = Command::new("bash").arg("-c").arg(script).current_dir(place.folder.path()).output().unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    // A limit of 8 kB on files, and a picture of more.
    let (code, message) = shell("ulimit -f 8; exec PROGRAM render scene.toml -o a.exr --size 64x64 --samples 1");
    assert!(code == Some(1) && message.contains("a.exr"), "{code:?} {message}");
    // A picture for which there is no memory is refused before it is drawn.
    let (code, message) = shell("ulimit -v 3000000; exec PROGRAM render scene.toml -o b.png --size 16384x8192");
    assert!(code == Some(1) && message.contains("needs 4.5 GiB of memory"), "{code:?} {message}");
    // Signals that are ignored at the start stay ignored.
    let (code, message) = shell(
        "trap '' HUP; PROGRAM render scene.toml -o a.png --method reference --samples 256 --size 96x64 & \
         kill -HUP $!; sleep 0.1; kill -HUP $!; wait $!",
    );
    assert!(code == Some(0) && place.path("a.png").exists(), "{code:?} {message}");
}

#[cfg(target_os = "linux")]
#[test]
fn names_of_files_are_any_bytes() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let place = Workplace::new();
    let scene = OsStr::from_bytes(b"\xff\xfe.toml");
    std::fs::copy(place.path("scene.toml"), place.folder.path().join(scene)).unwrap();
    let mut command = place.command(&["render"]);
    let output = command.arg(scene).args(SMALL).arg("-o").arg(OsStr::from_bytes(b"\xff.png")).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    assert!(place.folder.path().join(OsStr::from_bytes(b"\xff.png")).exists());
}

#[test]
fn numbers_below_zero_are_told_as_such() {
    let place = Workplace::new();
    let message = place.fails(2, &["render", "scene.toml", "-o", "a.png", "--samples", "-1"]);
    assert!(message.contains("--samples") && message.contains("-1 is not in 1 to 4096"), "{message}");
}

#[test]
fn habits_of_other_programs_are_understood_or_answered() {
    let place = Workplace::new();
    let draw = ["render", "scene.toml", "-o", "a.png", "--size", "32x24"];
    for options in [
        &["--hdri", "studio", "--spp", "1"][..],
        &["--env", "sky", "--mirror", "wall"],
        &["--glass", "ball:1.5"],
        &["--eye", "0,2,5"],
        &["--method", "multiperspective:accuracy_px=0.3"],
    ] {
        place.ok(&[&draw, options].concat());
    }
    place.write("bare.gltf", triangle("vase"));
    for (words, tip) in [
        (&["sphere_room"][..], "did you mean builtin:sphere_room?"),
        (&["https://example.org/a.glb"], "download the file first"),
        (&["bare.gltf", "--camera", "0"], "give --eye"),
        (&["bare.gltf", "--lens", "vase:water"], "a number, such as 1.5"),
        (&["bare.gltf", "--reflector", "vase,b"], "several times"),
    ] {
        let message = place.fails(1, &[&["render", "-o", "a.png"], words].concat());
        assert!(message.contains(tip), "{words:?}: {message}");
    }
    for (words, tip) in [
        (&["render", "scene.toml", "a.png"][..], "-o a.png"),
        (&["render", "scene.toml", "-o", "a.png", "--width", "32"], "--size 1280x720"),
        (&["render", "scene.toml", "-o", "a.png", "--ior=1.4"], "--lens 'Vase:1.5'"),
        (&["scene.toml"], "catoptric render scene.toml -o picture.png"),
        (&["render", "scene.toml", "-o", "a.png", "--method", "auto:x"], "--method auto:x"),
        (&["render", "scene.toml", "-o", "a.png", "--budget-ms", "5"], "name another --method"),
    ] {
        let message = place.fails(2, words);
        assert!(message.contains(tip), "{words:?}: {message}");
    }
}
