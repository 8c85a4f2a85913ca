//! Where outputs go: links, devices, standard output, one file by two names, and nothing that stays behind after a
//! signal.

use crate::workplace::Workplace;
use std::io::Write;
use std::process::{Output, Stdio};

const RENDER: [&str; 6] = ["render", "scene.toml", "--size", "32x24", "--samples", "1"];

impl Workplace {
    fn draw(&self, more: &[&str]) -> String {
        self.ok(&[&RENDER, more].concat())
    }

    /// Runs the program with this on its standard input.
    fn fed(&self, words: &[&str], input: &str) -> Output {
        let mut command = self.command(words);
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        child.stdin.take().unwrap().write_all(input.as_bytes()).unwrap();
        child.wait_with_output().unwrap()
    }
}

#[test]
fn two_outputs_are_never_one_file() {
    let place = Workplace::new();
    let folder = place.folder.path().file_name().unwrap().to_str().unwrap().to_owned();
    for other in ["./a.png", &format!("../{folder}/a.png"), place.path("a.png").to_str().unwrap()] {
        let message = place.fails(2, &[&RENDER, &["-o", "a.png", "--mask", other][..]].concat());
        assert!(message.contains("a.png") && message.contains("two outputs"), "{message}");
    }
    let message = place.fails(2, &[&RENDER, &["-o", "new/a.png", "--mask", "new/../new/./a.png"][..]].concat());
    assert!(message.contains("two outputs"), "{message}");
    assert_eq!(place.files(), ["scene.toml"]);
    place.write("points.csv", "x,y,z\n0,0,1\n");
    let project = ["project", "scene.toml", "--points", "points.csv", "-o", "./points.csv"];
    assert!(place.fails(2, &project).contains("both"));
}

#[cfg(unix)]
#[test]
fn links_stay_and_lead_to_the_new_file() {
    use std::os::unix::fs::symlink;
    let place = Workplace::new();
    std::fs::create_dir(place.path("deep")).unwrap();
    place.write("deep/old.png", "old");
    symlink("deep/old.png", place.path("out.png")).unwrap();
    symlink("deep/new.json", place.path("stats.json")).unwrap();
    place.draw(&["-o", "out.png", "--stats", "stats.json"]);
    assert!(place.path("out.png").is_symlink() && place.path("stats.json").is_symlink());
    assert!(catoptric::picture::read(&place.path("deep/old.png")).unwrap().width == 32);
    assert_eq!(place.json("deep/new.json")["method"], "auto");
    let message = place.fails(2, &[&RENDER, &["-o", "out.png", "--mask", "deep/old.png"][..]].concat());
    assert!(message.contains("two outputs"), "{message}");

    // A report goes through links, too.
    let small = ["--size", "32x24", "--frames", "1", "--method", "reference", "--report", "report"];
    place.ok(&[&["compare", "scene.toml"], &small[..]].concat());
    std::fs::remove_file(place.path("report/report.html")).unwrap();
    symlink("../deep/page.html", place.path("report/report.html")).unwrap();
    place.ok(&[&["compare", "scene.toml"], &small[..]].concat());
    assert!(place.path("report/report.html").is_symlink() && place.text("deep/page.html").contains("<svg"));
}

#[cfg(target_os = "linux")]
#[test]
fn devices_and_pipes_are_written_through() {
    use std::os::unix::fs::{FileTypeExt, symlink};
    use std::process::Command;
    let place = Workplace::new();
    let message = place.fails(1, &[&RENDER, &["-o", "out.png", "--stats", "/dev/full"][..]].concat());
    assert!(message.contains("/dev/full"), "{message}");
    symlink("/dev/full", place.path("full.png")).unwrap();
    place.fails(1, &[&RENDER, &["-o", "full.png"][..]].concat());
    let kind = std::fs::metadata("/dev/full").unwrap().file_type();
    assert!(kind.is_char_device() && place.path("full.png").is_symlink());
    place.draw(&["-o", "out.png", "--stats", "/dev/null"]);

    assert!(Command::new("mkfifo").arg(place.path("pipe")).status().unwrap().success());
    let pipe = place.path("pipe");
    let reader = std::thread::spawn(move || std::fs::read_to_string(pipe).unwrap());
    place.draw(&["-o", "out.png", "--stats", "pipe"]);
    assert!(reader.join().unwrap().contains("\"frame_ms\""));
    assert!(std::fs::metadata(place.path("pipe")).unwrap().file_type().is_fifo());
    assert_eq!(place.files(), ["full.png", "out.png", "pipe", "scene.toml"]);
}

#[test]
fn a_dash_is_standard_output_alone() {
    let place = Workplace::new();
    place.draw(&["-o", "out.png"]);
    let drawn = place.run(&[&RENDER[..], &["-o", "-", "--mask", "mask.png"]].concat());
    assert!(drawn.status.success() && drawn.stdout == place.bytes("out.png"));
    let said = String::from_utf8(drawn.stderr).unwrap();
    assert!(said.starts_with("standard output: auto, 32x24"), "{said}");
    let quiet = place.run(&[&RENDER[..], &["-o", "-", "--quiet"]].concat());
    assert!(quiet.stdout == drawn.stdout && quiet.stderr.is_empty());

    let stats = place.listed(&[&RENDER[..], &["-o", "out.png", "--stats", "-"]].concat());
    assert_eq!(stats["method"], "auto");
    assert_eq!(place.files(), ["mask.png", "out.png", "scene.toml"]);
    place.draw(&["-o", "out.png", "--stats", "./-"]);
    assert_eq!(place.json("-")["method"], "auto");

    // A reader that has had enough is no fault.
    let words = [&RENDER[..], &["-o", "-"]].concat();
    let mut child = place.command(&words).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
    drop(child.stdout.take());
    assert!(child.wait().unwrap().success());
}

#[test]
fn tables_go_through_standard_streams() {
    let place = Workplace::new();
    let points = "x,y,z\n0,0.5,2\n\n1,1,1\n";
    place.write("points.csv", points);
    let project = |points: &'static str, paths| ["project", "scene.toml", "--points", points, "-o", paths];
    place.ok(&project("points.csv", "paths.csv"));
    let piped = place.fed(&project("-", "-"), points);
    assert!(piped.status.success() && piped.stdout == place.bytes("paths.csv"));
    let said = String::from_utf8(piped.stderr).unwrap();
    assert!(said.starts_with("standard output: 2 points"), "{said}");
    for (points, named) in [
        ("x,y,z\n\n1,2,3\n1,two,3\n", "standard input: line 4: y: `two` is not a number"),
        ("x,y\n1,2\n", "standard input: line 1: the header has no column `z`"),
        ("", "standard input: line 1: the header has no column `x`"),
        ("x,y,z\n1,2,1e13\n", "standard input: line 2: z: 1e13 is not between"),
    ] {
        let wrong = place.fed(&project("-", "-"), points);
        let message = String::from_utf8(wrong.stderr).unwrap();
        assert!(wrong.status.code() == Some(1) && wrong.stdout.is_empty(), "{points:?}: {message}");
        assert!(message.contains(named), "{points:?} should say {named}: {message}");
    }
}

#[test]
fn a_dash_is_refused_where_there_is_no_stream() {
    let place = Workplace::new();
    let twice = [&RENDER[..], &["-o", "-", "--stats", "-"]].concat();
    assert!(place.fails(2, &twice).contains("standard output is named for two outputs"));
    let picture = [&RENDER[..], &["-o", "out.png"]].concat();
    let bake = ["bake", "scene.toml", "--method", "light_field"];
    let plan = ["bake", "plan", "scene.toml", "--method", "light_field"];
    let remedy = "`./-` names a file called `-`";
    for (before, option) in [
        (&picture[..], "--mask"),
        (&picture, "--baked"),
        (&picture, "--environment"),
        (&["compare", "scene.toml"], "--report"),
        (&bake, "-o"),
        (&plan, "-o"),
        (&["bake", "merge", "room.parts"], "-o"),
    ] {
        place.names_faults(2, before, &[(&[option, "-"], remedy)]);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn terminals_get_no_pictures() {
    let place = Workplace::new();
    let terminal = std::fs::OpenOptions::new().read(true).write(true).open("/dev/ptmx").unwrap();
    let refused = place.command(&[&RENDER[..], &["-o", "-"]].concat()).stdout(terminal).output().unwrap();
    let message = String::from_utf8(refused.stderr).unwrap();
    assert!(refused.status.code() == Some(2) && message.contains("standard output is a terminal"), "{message}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_standard_output_is_named() {
    let place = Workplace::new();
    let picture = [&RENDER[..], &["-o", "-"]].concat();
    for words in [&["scenes"][..], &["methods", "--json"], &["completions", "bash"], &["render", "--help"], &picture] {
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let output = place.command(words).stdout(full).output().unwrap();
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{words:?}: {message}");
        assert!(message.contains("standard output") && !message.contains("panicked"), "{words:?}: {message}");
    }
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let output = place.command(&["info", "none.glb"]).stderr(full).output().unwrap();
    assert_eq!(output.status.code(), Some(1), "a message that cannot be printed is no panic");
}

#[cfg(unix)]
#[test]
fn signals_leave_nothing_behind() {
    use std::process::{Command, Stdio};
    use std::time::{Duration, Instant};
    let place = Workplace::new();
    let points: String = (0..400_000).map(|row| format!("{},0.5,1\n", f64::from(row) * 1e-6)).collect();
    place.write("points.csv", format!("x,y,z\n{points}"));
    let before = place.files();
    let long = ["--size", "1600x1200", "--samples", "256", "--method", "reference"];
    let render = [&["render", "scene.toml", "-o", "new/deep/out.png"], &long[..]].concat();
    let compare = [&["compare", "scene.toml", "--report", "new/report"], &long[..]].concat();
    let project = vec!["project", "scene.toml", "--points", "points.csv", "-o", "paths.csv"];
    for (words, made) in [(render, "new"), (compare, "new/report"), (project, ".")] {
        for signal in ["-INT", "-TERM"] {
            let mut child = place.command(&words).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
            let begun = Instant::now();
            let is_at_work = || match made {
                "new" => place.path("new/deep").exists(),
                folder => std::fs::read_dir(place.path(folder))
                    .is_ok_and(|mut entries| entries.any(|it| it.unwrap().file_name().as_encoded_bytes()[0] == b'.')),
            };
            while !is_at_work() {
                assert!(begun.elapsed() < Duration::from_secs(60) && child.try_wait().unwrap().is_none(), "{words:?}");
                std::thread::sleep(Duration::from_millis(1));
            }
            assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
            assert_eq!(child.wait().unwrap().code(), Some(130), "{words:?}");
            assert_eq!(place.files(), before, "{words:?}");
        }
    }
}
