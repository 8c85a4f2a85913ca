//! Plans, work and stores for the tests.

use crate::error::BakeError;
use crate::plan::{Estimate, Identity, Plan, PlannedUnit, SCHEMA};
use crate::run::Work;
use crate::store::{Created, Entry, Store};
use serde_json::json;
use std::collections::BTreeMap;
use std::io::{Error, ErrorKind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

/// An identity with a unit of each size.
pub(crate) fn identity(sizes: &[u64]) -> Identity {
    let unit = |(row, &bytes): (usize, &u64)| PlannedUnit {
        name: format!("row {row}"),
        bytes,
        at_most: false,
        with_previous: false,
    };
    Identity {
        schema: SCHEMA,
        method: "test".into(),
        payload_version: 1,
        settings: json!({ "st": 16, "region": { "min": [0, 0, 0.1] } }),
        scene_hash: "00ff".repeat(16),
        program_version: "0.1.0".into(),
        units: sizes.iter().enumerate().map(unit).collect(),
    }
}

/// A plan with a unit of each size.
pub(crate) fn plan(sizes: &[u64]) -> Plan {
    let estimate = Estimate { core_hours: 0.25, bytes: sizes.iter().sum() };
    Plan { identity: identity(sizes), recipe: json!({ "scene": "scene.glb" }), estimate }
}

/// The payload of a unit of a plan of [`plan`].
pub(crate) fn payload(plan: &Plan, number: u64) -> Vec<u8> {
    let planned = &plan.identity.units[number as usize];
    (0..planned.bytes).map(|at| (number * 31 + at * 7 + at * at / 5) as u8).collect()
}

/// Work that makes [`payload`].
pub(crate) fn work(plan: &Plan) -> impl Work + '_ {
    |number: u64| -> Result<Vec<u8>, String> { Ok(payload(plan, number)) }
}

/// Files in memory.
#[derive(Default)]
pub(crate) struct MemoryStore {
    pub(crate) files: Mutex<BTreeMap<String, Vec<u8>>>,
}

impl Store for MemoryStore {
    fn create(&self, name: &str, bytes: &[u8]) -> Result<Created, BakeError> {
        let mut files = self.files.lock().unwrap();
        if files.contains_key(name) {
            return Ok(Created::Existed);
        }
        files.insert(name.into(), bytes.into());
        Ok(Created::New)
    }

    fn get(&self, name: &str) -> Result<Option<Vec<u8>>, BakeError> {
        Ok(self.files.lock().unwrap().get(name).cloned())
    }

    fn list(&self) -> Result<Vec<Entry>, BakeError> {
        let files = self.files.lock().unwrap();
        Ok(files.iter().map(|(name, bytes)| Entry { name: name.clone(), bytes: bytes.len() as u64 }).collect())
    }

    fn remove(&self, name: &str) -> Result<(), BakeError> {
        self.files.lock().unwrap().remove(name);
        Ok(())
    }

    fn place(&self, name: &str) -> String {
        format!("memory/{name}")
    }
}

/// A store whose disk is full after some writes.
pub(crate) struct FillingStore<'a> {
    pub(crate) store: &'a dyn Store,
    pub(crate) writes: AtomicU64,
}

impl Store for FillingStore<'_> {
    fn create(&self, name: &str, bytes: &[u8]) -> Result<Created, BakeError> {
        let left = self.writes.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |writes| writes.checked_sub(1));
        if left.is_err() {
            return Err(BakeError::write(self.place(name), Error::from(ErrorKind::StorageFull)));
        }
        self.store.create(name, bytes)
    }

    fn get(&self, name: &str) -> Result<Option<Vec<u8>>, BakeError> {
        self.store.get(name)
    }

    fn list(&self) -> Result<Vec<Entry>, BakeError> {
        self.store.list()
    }

    fn remove(&self, name: &str) -> Result<(), BakeError> {
        self.store.remove(name)
    }

    fn place(&self, name: &str) -> String {
        self.store.place(name)
    }
}
