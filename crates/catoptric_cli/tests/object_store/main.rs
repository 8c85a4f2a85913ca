//! Bakes in object stores, on servers that refuse and cut connections: one of another project with the interface of S3,
//! the same behind what is different at Google's, and one that follows Azure's documentation.
#![cfg(feature = "object_stores")]
#![expect(clippy::unwrap_used, reason = "a test that cannot go on must fail")]
#![expect(clippy::print_stdout, reason = "what the server did is printed")]

mod azure;
mod server;

use catoptric_bake::{BakeError, Created, Entry, ObjectStore, Store};
use server::{BUCKET, Fate, Provider, Server};
use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};
use std::time::{Duration, Instant};

/// 36 units.
const WHAT: [&str; 9] =
    ["builtin:sphere_room", "--method", "light_field", "--set", "st=6", "--set", "uv=16", "--set", "capture_samples=1"];
const PREFIX: &str = "rooms/room.parts";

/// A server, and a folder for everything else.
struct Place {
    server: Server,
    /// The address of the prefix.
    address: String,
    folder: tempfile::TempDir,
}

impl Place {
    fn new(provider: Provider) -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("served")).unwrap();
        let server = Server::start(provider, &folder.path().join("served"));
        Self { server, address: provider.address(PREFIX), folder }
    }

    fn store(&self, patience: Duration) -> ObjectStore {
        ObjectStore::open(&self.address, patience, self.server.variables()).unwrap()
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
        self.path(&format!("served/{BUCKET}/{PREFIX}/unit-{number:06}.bin"))
    }
}

#[test]
fn a_store_creates_gets_lists_and_removes() {
    Provider::ALL.into_iter().for_each(creates_gets_lists_and_removes);
}

fn creates_gets_lists_and_removes(provider: Provider) {
    let place = Place::new(provider);
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
    Provider::ALL.into_iter().for_each(is_given_up_after_a_while);
}

fn is_given_up_after_a_while(provider: Provider) {
    let place = Place::new(provider);
    place.server.refuse_all();
    let (store, begun) = (place.store(Duration::from_secs(2)), Instant::now());
    let error = store.get("x.bin").unwrap_err();
    assert!(matches!(error, BakeError::Read { .. }) && error.to_string().contains("503"), "{error}");
    assert!(begun.elapsed() > Duration::from_secs(1) && begun.elapsed() < Duration::from_secs(30));
    // Nobody listens there.
    let variables = server::variables(provider, "http://127.0.0.1:9");
    let nobody = ObjectStore::open(&place.address, Duration::from_secs(1), variables).unwrap();
    let (message, begun) = (nobody.create("x.bin", b"").unwrap_err().to_string(), Instant::now());
    let named = ["AWS_ENDPOINT_URL", "GOOGLE_BASE_URL", "AZURE_STORAGE_ENDPOINT"][provider as usize];
    assert!(message.contains("room.parts/x.bin") && message.contains(named), "{message}");
    assert!(begun.elapsed() < Duration::from_secs(30));
}

#[test]
fn bakes_in_s3_are_those_in_a_folder() {
    bakes_are_those_in_a_folder(Provider::Amazon);
}

#[test]
fn bakes_at_googles_are_those_in_a_folder() {
    bakes_are_those_in_a_folder(Provider::Google);
}

#[test]
fn bakes_at_azure_are_those_in_a_folder() {
    bakes_are_those_in_a_folder(Provider::Azure);
}

fn bakes_are_those_in_a_folder(provider: Provider) {
    let place = Place::new(provider);
    let address = place.address.as_str();
    place.ends(0, &[&["bake"], &WHAT[..], &["-o", "here.bake"]].concat());
    place.server.fail_often();
    place.ends(0, &[&["bake", "plan"], &WHAT[..], &["-o", address]].concat());
    assert_eq!(place.ends(3, &["bake", "status", address, "--missing"]).lines().count(), 36);
    // One stops with its shard, two do all at the same time.
    place.ends(0, &["bake", "run", address, "--shard", "1/3", "--quiet"]);
    let both = [(); 2].map(|()| place.command(&["bake", "run", address, "--quiet"]).spawn().unwrap());
    for mut one in both {
        assert!(one.wait().unwrap().success());
    }
    place.ends(0, &["bake", "status", address]);
    place.ends(0, &["bake", "merge", address, "-o", "there.bake"]);
    let expected = fs::read(place.path("here.bake")).unwrap();
    assert!(fs::read(place.path("there.bake")).unwrap() == expected);

    // Damage that no server makes by itself: a unit is cut off, one has another bit.
    let (cut, flipped) = (place.unit(7), place.unit(20));
    let bytes = fs::read(&cut).unwrap();
    fs::write(&cut, &bytes[..bytes.len() / 2]).unwrap();
    let mut bytes = fs::read(&flipped).unwrap();
    bytes[100] ^= 8;
    fs::write(&flipped, bytes).unwrap();
    let refused = place.ends(1, &["bake", "merge", address, "-o", "no.bake"]);
    assert!(refused.contains("unit-000007.bin is truncated") && !place.path("no.bake").exists(), "{refused}");
    assert_eq!(place.ends(3, &["bake", "status", address, "--missing", "--verify"]), "7\n20\n");
    assert!(place.ends(0, &["bake", "run", address]).contains("2 replaced"));
    place.ends(0, &["bake", "merge", address, "-o", "again.bake"]);
    assert!(fs::read(place.path("again.bake")).unwrap() == expected);

    let fates = place.server.fates();
    println!("{fates:?}");
    for fate in [Fate::Refused, Fate::CutBefore, Fate::CutAfter, Fate::CutWithin] {
        assert!(fates[&fate] > 4, "{fate:?}");
    }
}

#[test]
fn what_keeps_a_store_from_being_used_is_named() {
    let place = Place::new(Provider::Amazon);
    let message = place.ends(1, &["bake", "status", &place.address]);
    assert!(message.contains("s3://bucket/rooms/room.parts/plan.json") && message.contains("plan"), "{message}");
    for (place_named, named) in [("s3://bucket", "s3://bucket/prefix"), ("ftp://bucket/x", "gs://bucket/prefix")] {
        let message = place.ends(1, &["bake", "run", place_named]);
        assert!(message.contains(place_named) && message.contains(named), "{message}");
    }
    let wrong = ["AWS_SECRET_ACCESS_KEY", "GOOGLE_BEARER_TOKEN", "AZURE_STORAGE_ACCOUNT"];
    let status = ["403", "401", "403"];
    for (provider, (variable, status)) in Provider::ALL.into_iter().zip(wrong.into_iter().zip(status)) {
        let place = Place::new(provider);
        let nowhere = place.address.replace(BUCKET, "nowhere");
        let message = place.ends(1, &["bake", "merge", &nowhere, "-o", "no.bake"]);
        assert!(message.contains(&format!("{nowhere}/plan.json: there is no such file")), "{message}");
        let mut command = place.command(&["bake", "status", &place.address]);
        let ended = command.env(variable, "another").output().unwrap();
        let message = String::from_utf8(ended.stderr).unwrap();
        let named = variable.replace("BEARER_TOKEN", "APPLICATION_CREDENTIALS");
        assert!(message.contains(status) && message.contains(&named), "{message}");
    }
}
