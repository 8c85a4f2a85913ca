//! Bakes in an object store: on a server of another project with the interface of S3, which refuses and cuts
//! connections.
#![cfg(feature = "object_stores")]
#![expect(clippy::unwrap_used, reason = "a test that cannot go on must fail")]
#![expect(clippy::print_stdout, reason = "what the server did is printed")]

mod server;

use catoptric_bake::{BakeError, Created, Entry, ObjectStore, Store};
use server::{BUCKET, Fate, Server};
use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};
use std::time::{Duration, Instant};

/// 36 units.
const WHAT: [&str; 9] =
    ["builtin:sphere_room", "--method", "light_field", "--set", "st=6", "--set", "uv=16", "--set", "capture_samples=1"];
const PLACE: &str = "s3://bucket/rooms/room.parts";

/// A server, and a folder for everything else.
struct Place {
    server: Server,
    folder: tempfile::TempDir,
}

impl Place {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("served")).unwrap();
        Self { server: Server::start(&folder.path().join("served")), folder }
    }

    fn store(&self, patience: Duration) -> ObjectStore {
        ObjectStore::open(PLACE, patience, self.server.variables()).unwrap()
    }

    fn command(&self, words: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_catoptric"));
        command.args(words).current_dir(self.folder.path()).envs(self.server.variables());
        command
    }

    fn run(&self, words: &[&str]) -> Output {
        self.command(words).output().unwrap()
    }

    fn ends(&self, code: i32, words: &[&str]) -> String {
        let ended = self.run(words);
        let said = String::from_utf8_lossy(&ended.stderr);
        assert_eq!(ended.status.code(), Some(code), "{words:?}: {said}");
        if code == 1 { said.into_owned() } else { String::from_utf8(ended.stdout).unwrap() }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// The file of a unit in the folder that is served.
    fn unit(&self, number: u64) -> PathBuf {
        self.path(&format!("served/{BUCKET}/rooms/room.parts/unit-{number:06}.bin"))
    }
}

#[test]
fn a_store_creates_gets_lists_and_removes() {
    let place = Place::new();
    let store = place.store(ObjectStore::PATIENCE);
    assert!(store.list().unwrap().is_empty() && store.get("x.bin").unwrap().is_none());
    assert_eq!(store.create("x.bin", b"one").unwrap(), Created::New);
    assert_eq!(store.create("x.bin", b"other").unwrap(), Created::Existed);
    assert_eq!(store.get("x.bin").unwrap().unwrap(), b"one");
    assert_eq!(store.list().unwrap(), [Entry { name: "x.bin".into(), bytes: 3 }]);
    store.remove("x.bin").unwrap();
    store.remove("x.bin").unwrap();
    assert!(store.list().unwrap().is_empty());
    // More than a listing's page.
    for number in 0..1005 {
        assert_eq!(store.create(&format!("{number}"), b"").unwrap(), Created::New);
    }
    assert_eq!(store.list().unwrap().len(), 1005);
}

#[test]
fn servers_that_stay_busy_are_given_up_after_a_while() {
    let place = Place::new();
    place.server.refuse_all();
    let (store, begun) = (place.store(Duration::from_secs(2)), Instant::now());
    let error = store.get("x.bin").unwrap_err();
    assert!(matches!(error, BakeError::Read { .. }) && error.to_string().contains("503"), "{error}");
    assert!(begun.elapsed() > Duration::from_secs(1) && begun.elapsed() < Duration::from_secs(30));
    // Nobody listens there.
    let variables =
        [("AWS_ENDPOINT_URL", "http://127.0.0.1:9"), ("AWS_ALLOW_HTTP", "true"), ("AWS_ACCESS_KEY_ID", "k")];
    let variables = variables.into_iter().chain([("AWS_SECRET_ACCESS_KEY", "s")]);
    let variables = variables.map(|(name, value)| (name.to_owned(), value.to_owned()));
    let nobody = ObjectStore::open(PLACE, Duration::from_secs(1), variables).unwrap();
    let (message, begun) = (nobody.create("x.bin", b"").unwrap_err().to_string(), Instant::now());
    assert!(message.contains("room.parts/x.bin") && message.contains("AWS_ENDPOINT_URL"), "{message}");
    assert!(begun.elapsed() < Duration::from_secs(30));
}

#[test]
fn bakes_in_an_object_store_are_those_in_a_folder() {
    let place = Place::new();
    place.ends(0, &[&["bake"], &WHAT[..], &["-o", "here.bake"]].concat());
    place.server.fail_often();
    place.ends(0, &[&["bake", "plan"], &WHAT[..], &["-o", PLACE]].concat());
    assert_eq!(place.ends(3, &["bake", "status", PLACE, "--missing"]).lines().count(), 36);
    // One stops with its shard, two do all at the same time.
    place.ends(0, &["bake", "run", PLACE, "--shard", "1/3", "--quiet"]);
    let both = [(); 2].map(|()| place.command(&["bake", "run", PLACE, "--quiet"]).spawn().unwrap());
    for mut one in both {
        assert!(one.wait().unwrap().success());
    }
    place.ends(0, &["bake", "status", PLACE]);
    place.ends(0, &["bake", "merge", PLACE, "-o", "there.bake"]);
    let expected = fs::read(place.path("here.bake")).unwrap();
    assert!(fs::read(place.path("there.bake")).unwrap() == expected);

    // Damage that no server makes by itself: a unit is cut off, one has another bit.
    let (cut, flipped) = (place.unit(7), place.unit(20));
    let bytes = fs::read(&cut).unwrap();
    fs::write(&cut, &bytes[..bytes.len() / 2]).unwrap();
    let mut bytes = fs::read(&flipped).unwrap();
    bytes[100] ^= 8;
    fs::write(&flipped, bytes).unwrap();
    let refused = place.ends(1, &["bake", "merge", PLACE, "-o", "no.bake"]);
    assert!(refused.contains("unit-000007.bin is truncated") && !place.path("no.bake").exists(), "{refused}");
    assert_eq!(place.ends(3, &["bake", "status", PLACE, "--missing", "--verify"]), "7\n20\n");
    assert!(place.ends(0, &["bake", "run", PLACE]).contains("2 replaced"));
    place.ends(0, &["bake", "merge", PLACE, "-o", "again.bake"]);
    assert!(fs::read(place.path("again.bake")).unwrap() == expected);

    let fates = place.server.fates();
    println!("{fates:?}");
    for fate in [Fate::Refused, Fate::CutBefore, Fate::CutAfter, Fate::CutWithin] {
        assert!(fates[&fate] > 4, "{fate:?}");
    }
}

#[test]
fn what_keeps_a_store_from_being_used_is_named() {
    let place = Place::new();
    let message = place.ends(1, &["bake", "status", PLACE]);
    assert!(message.contains("s3://bucket/rooms/room.parts/plan.json") && message.contains("plan"), "{message}");
    for (place_named, named) in [("s3://bucket", "s3://bucket/prefix"), ("ftp://bucket/x", "s3://bucket/prefix")] {
        let message = place.ends(1, &["bake", "run", place_named]);
        assert!(message.contains(place_named) && message.contains(named), "{message}");
    }
    let message = place.ends(1, &["bake", "merge", "s3://nowhere/room", "-o", "no.bake"]);
    assert!(message.contains("s3://nowhere/room/plan.json: there is no such file"), "{message}");
    let mut command = place.command(&["bake", "status", PLACE]);
    let ended = command.env("AWS_SECRET_ACCESS_KEY", "another").output().unwrap();
    let message = String::from_utf8(ended.stderr).unwrap();
    assert!(message.contains("403") && message.contains("AWS_SECRET_ACCESS_KEY"), "{message}");
}
