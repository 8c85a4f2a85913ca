//! `render --watch`: a picture that follows its files.

use crate::workplace::{BALL, Workplace};
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

/// Ends the program however the test ends.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Waits until a file is there and other than it was.
fn changed(place: &Workplace, name: &str, before: &[u8]) -> Vec<u8> {
    let start = Instant::now();
    loop {
        match std::fs::read(place.path(name)) {
            Ok(bytes) if bytes != before => return bytes,
            _ => assert!(start.elapsed() < Duration::from_secs(60), "{name} is as it was"),
        }
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Replaces a file, which is never seen in part.
fn replace(place: &Workplace, name: &str, text: &str) {
    place.write("new", text);
    std::fs::rename(place.path("new"), place.path(name)).unwrap();
}

#[test]
fn pictures_follow_the_files_of_their_scene() {
    let place = Workplace::new();
    let base = |radius: &str| BALL.replace("radius = 0.8", &format!("radius = {radius}"));
    place.write("ball.toml", base("0.8"));
    place.write("scene.toml", "base = 'ball.toml'\n");
    let words = ["render", "scene.toml", "-o", "out.png", "--size", "32x24", "--samples", "1", "--watch"];
    let said = std::fs::File::create(place.path("said")).unwrap();
    let mut command = place.command(&words);
    let _running = Running(command.stdout(Stdio::null()).stderr(said).spawn().unwrap());
    let first = changed(&place, "out.png", &[]);
    // In a file that the scene names.
    replace(&place, "ball.toml", &base("0.5"));
    let second = changed(&place, "out.png", &first);
    assert!(place.text("said").contains("watching 2 files"), "{}", place.text("said"));
    // A fault ends nothing.
    replace(&place, "scene.toml", "base = 'ball.toml'\nnonsense = 1\n");
    let start = Instant::now();
    while !place.text("said").contains("error: scene.toml: line 2: nonsense") {
        assert!(start.elapsed() < Duration::from_secs(60), "{}", place.text("said"));
        std::thread::sleep(Duration::from_millis(20));
    }
    assert_eq!(place.bytes("out.png"), second);
    replace(&place, "ball.toml", &base("0.8"));
    replace(&place, "scene.toml", "base = 'ball.toml'\n\n");
    assert_eq!(changed(&place, "out.png", &second), first);
}

#[test]
fn what_cannot_change_is_not_watched() {
    let place = Workplace::new();
    place.names_faults(
        2,
        &["render", "--watch"],
        &[
            (&["builtin:vase", "-o", "out.png"], "--watch: builtin:vase is no file that could change"),
            (&["scene.toml", "-o", "-"], "--watch: -o - has room for one picture"),
        ],
    );
}
