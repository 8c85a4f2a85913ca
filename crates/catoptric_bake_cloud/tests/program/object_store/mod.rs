//! Bakes in object stores, on servers that refuse and cut connections: one of another project with the interface of S3,
//! the same behind what is different at Google's, and one that follows Azure's documentation.

mod azure;
mod server;

use crate::trial;
use crate::workplace::{WHAT, Workplace};
use catoptric_bake::{BakeError, Created, Entry, Store};
use catoptric_bake_cloud::ObjectStore;
use libtest_mimic::Trial;
use server::{BUCKET, Fate, Provider, Server};
use std::fs;
use std::path::PathBuf;
use std::time::{Duration, Instant};
use tempfile::TempDir;

const PREFIX: &str = "rooms/room.parts";

/// A server, and a folder for everything else.
struct Place {
    server: Server,
    /// The address of the prefix.
    address: String,
    served: TempDir,
    workplace: Workplace,
}

impl Place {
    fn new(provider: Provider) -> Self {
        let served = tempfile::tempdir().unwrap();
        let server = Server::start(provider, served.path());
        let workplace = Workplace::new(server.variables());
        Self { server, address: provider.address(PREFIX), served, workplace }
    }

    fn store(&self, patience: Duration) -> ObjectStore {
        ObjectStore::open(&self.address, patience, self.server.variables()).unwrap()
    }

    /// The file of a unit in the folder that is served.
    fn unit(&self, number: u64) -> PathBuf {
        self.served.path().join(format!("{BUCKET}/{PREFIX}/unit-{number:06}.bin"))
    }
}

pub(crate) fn trials() -> Vec<Trial> {
    let of_all = |test: fn(Provider)| move || Provider::ALL.into_iter().for_each(test);
    let of_one = |provider: Provider| move || bakes_are_those_in_a_folder(provider);
    vec![
        trial("a store creates, gets, lists and removes", of_all(creates_gets_lists_and_removes)),
        trial("servers that stay busy are given up after a while", of_all(is_given_up_after_a_while)),
        trial("bakes in S3 are those in a folder", of_one(Provider::Amazon)),
        trial("bakes at Google's are those in a folder", of_one(Provider::Google)),
        trial("bakes at Azure are those in a folder", of_one(Provider::Azure)),
        trial("what keeps a store from being used is named", what_keeps_it_from_being_used_is_named),
    ]
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

fn bakes_are_those_in_a_folder(provider: Provider) {
    let place = Place::new(provider);
    let address = place.address.as_str();
    place.workplace.ends(0, &[&["bake"], &WHAT[..], &["-o", "here.bake"]].concat());
    place.server.fail_often();
    place.workplace.ends(0, &[&["bake", "plan"], &WHAT[..], &["-o", address]].concat());
    assert_eq!(place.workplace.ends(3, &["bake", "status", address, "--missing"]).lines().count(), 36);
    // One stops with its shard, two do all at the same time.
    place.workplace.ends(0, &["bake", "run", address, "--shard", "1/3", "--quiet"]);
    let both = [(); 2].map(|()| place.workplace.command(&["bake", "run", address, "--quiet"]).spawn().unwrap());
    for mut one in both {
        assert!(one.wait().unwrap().success());
    }
    place.workplace.ends(0, &["bake", "status", address]);
    place.workplace.ends(0, &["bake", "merge", address, "-o", "there.bake"]);
    let expected = place.workplace.bytes("here.bake");
    assert!(place.workplace.bytes("there.bake") == expected);

    // Damage that no server makes by itself: a unit is cut off, one has another bit.
    let (cut, flipped) = (place.unit(7), place.unit(20));
    let bytes = fs::read(&cut).unwrap();
    fs::write(&cut, &bytes[..bytes.len() / 2]).unwrap();
    let mut bytes = fs::read(&flipped).unwrap();
    bytes[100] ^= 8;
    fs::write(&flipped, bytes).unwrap();
    let refused = place.workplace.ends(1, &["bake", "merge", address, "-o", "no.bake"]);
    assert!(refused.contains("unit-000007.bin is truncated") && !place.workplace.path("no.bake").exists(), "{refused}");
    assert_eq!(place.workplace.ends(3, &["bake", "status", address, "--missing", "--verify"]), "7\n20\n");
    assert!(place.workplace.ends(0, &["bake", "run", address]).contains("2 replaced"));
    place.workplace.ends(0, &["bake", "merge", address, "-o", "again.bake"]);
    assert!(place.workplace.bytes("again.bake") == expected);

    let fates = place.server.fates();
    println!("{fates:?}");
    for fate in [Fate::Refused, Fate::CutBefore, Fate::CutAfter, Fate::CutWithin] {
        assert!(fates[&fate] > 4, "{fate:?}");
    }
}

fn what_keeps_it_from_being_used_is_named() {
    let place = Place::new(Provider::Amazon);
    let message = place.workplace.ends(1, &["bake", "status", &place.address]);
    assert!(message.contains("s3://bucket/rooms/room.parts/plan.json") && message.contains("plan"), "{message}");
    for (place_named, named) in [("s3://bucket", "s3://bucket/prefix"), ("ftp://bucket/x", "gs://bucket/prefix")] {
        let message = place.workplace.ends(1, &["bake", "run", place_named]);
        assert!(message.contains(place_named) && message.contains(named), "{message}");
    }
    let wrong = ["AWS_SECRET_ACCESS_KEY", "GOOGLE_BEARER_TOKEN", "AZURE_STORAGE_ACCOUNT"];
    let status = ["403", "401", "403"];
    for (provider, (variable, status)) in Provider::ALL.into_iter().zip(wrong.into_iter().zip(status)) {
        let place = Place::new(provider);
        let nowhere = place.address.replace(BUCKET, "nowhere");
        let message = place.workplace.ends(1, &["bake", "merge", &nowhere, "-o", "no.bake"]);
        assert!(message.contains(&format!("{nowhere}/plan.json: there is no such file")), "{message}");
        let mut command = place.workplace.command(&["bake", "status", &place.address]);
        let ended = command.env(variable, "another").output().unwrap();
        let message = String::from_utf8(ended.stderr).unwrap();
        let named = variable.replace("BEARER_TOKEN", "APPLICATION_CREDENTIALS");
        assert!(message.contains(status) && message.contains(&named), "{message}");
    }
}
