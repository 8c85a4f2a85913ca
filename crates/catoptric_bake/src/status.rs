//! The progress of a bake, from the contents of its store alone.

use crate::error::BakeError;
use crate::plan::{Plan, PlannedUnit};
use crate::plan_hash::PlanHash;
use crate::store::Store;
use crate::unit::{self, UnitFault};
use rayon::prelude::*;
use serde::Serialize;
use std::collections::HashMap;

/// The check of published units.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Check {
    /// By their sizes alone, as the store lists them: fast, and finds truncated units, but those of units that may have
    /// fewer bytes than planned.
    Sizes,
    /// By reading them whole: finds every flipped bit.
    Contents,
}

/// The progress of a bake.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Status {
    /// The bake's name: its plan's hash.
    pub plan: String,
    /// True if units were read whole ([`Check::Contents`]).
    pub verified: bool,
    /// The number of units of the plan.
    pub total: u64,
    /// The number of good units, as far as they were checked.
    pub complete: u64,
    /// The number of missing units.
    pub missing: u64,
    /// The units that are there and bad.
    pub bad: Vec<BadUnit>,
    /// Names of temporary files: of writers at work or killed.
    pub left_over: Vec<String>,
    #[serde(skip)]
    missing_units: Vec<u64>,
}

/// A unit that is there and bad.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct BadUnit {
    /// The unit's number in the plan.
    pub number: u64,
    /// The name of the unit's file in the store.
    pub file: String,
    /// The reason why the file is not the planned unit.
    pub why: UnitFault,
}

impl Status {
    /// True if all units are there and good, so that they can be merged.
    pub fn is_complete(&self) -> bool {
        self.complete == self.total
    }

    /// The numbers of the units that are not there, ascending.
    pub fn missing(&self) -> &[u64] {
        &self.missing_units
    }

    /// The numbers of the units that a run would make, missing and bad, ascending.
    pub fn to_make(&self) -> Vec<u64> {
        let mut numbers = self.missing_units.clone();
        numbers.extend(self.bad.iter().map(|bad| bad.number));
        numbers.sort_unstable();
        numbers
    }

    /// The first few units that are missing or bad, in words.
    pub(crate) fn first_few(&self) -> String {
        const FEW: usize = 5;
        let to_make = self.to_make();
        let word = |&number: &u64| match self.bad.iter().find(|bad| bad.number == number) {
            Some(bad) => format!("{} {}", bad.file, bad.why),
            None => format!("{} is missing", unit::file_name(number, self.total)),
        };
        let mut words: Vec<String> = to_make.iter().take(FEW).map(word).collect();
        if to_make.len() > FEW {
            words.push(format!("and {} more", to_make.len() - FEW));
        }
        words.join(", ")
    }
}

/// Looks at all units of a plan.
///
/// # Errors
/// [`BakeError::Read`] when the store cannot be read.
pub fn status(plan: &Plan, store: &dyn Store, check: Check) -> Result<Status, BakeError> {
    let listing = Listing::read(plan, store)?;
    let look = |number: u64| Ok((number, listing.find(number, check)?));
    let total = plan.identity.unit_count();
    let found: Vec<(u64, Found)> = (0..total).into_par_iter().map(look).collect::<Result<_, BakeError>>()?;
    let left_over = store.left_over()?.into_iter().map(|entry| entry.name).collect();
    let mut status = Status {
        plan: listing.hash.to_string(),
        verified: check == Check::Contents,
        total,
        complete: 0,
        missing: 0,
        bad: Vec::new(),
        left_over,
        missing_units: Vec::new(),
    };
    status.left_over.sort_unstable();
    for (number, found) in found {
        match found {
            Found::Good => status.complete += 1,
            Found::Missing => status.missing_units.push(number),
            Found::Bad(why) => status.bad.push(BadUnit { number, file: unit::file_name(number, total), why }),
        }
    }
    status.missing = status.missing_units.len() as u64;
    Ok(status)
}

/// The state of a unit in the store.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Found {
    Good,
    Missing,
    Bad(UnitFault),
}

/// The units of a plan that a store lists.
pub(crate) struct Listing<'a> {
    plan: &'a Plan,
    store: &'a dyn Store,
    pub(crate) hash: PlanHash,
    /// By name, since a store's order is its own.
    bytes: HashMap<String, u64>,
}

impl<'a> Listing<'a> {
    pub(crate) fn read(plan: &'a Plan, store: &'a dyn Store) -> Result<Self, BakeError> {
        let bytes = store.list()?.into_iter().map(|entry| (entry.name, entry.bytes)).collect();
        Ok(Self { plan, store, hash: plan.hash(), bytes })
    }

    /// Looks at one unit.
    pub(crate) fn find(&self, number: u64, check: Check) -> Result<Found, BakeError> {
        let identity = &self.plan.identity;
        let name = unit::file_name(number, identity.unit_count());
        let Some(&found) = self.bytes.get(&name) else { return Ok(Found::Missing) };
        // Files of a wrong size are not read: they may be of any size.
        if let Err(fault) = identity.units[number as usize].payload_bytes(found) {
            return Ok(Found::Bad(fault));
        }
        if check == Check::Sizes {
            return Ok(Found::Good);
        }
        // Otherwise removed since, by a writer that replaces it.
        let Some(bytes) = self.store.get(&name)? else { return Ok(Found::Missing) };
        Ok(match identity.units[number as usize].decode(&bytes, self.hash, number) {
            Ok(_) => Found::Good,
            Err(fault) => Found::Bad(fault),
        })
    }

    /// The bytes of every unit's payload, if all are there with a size that is allowed.
    pub(crate) fn payload_bytes(&self) -> Option<Vec<u64>> {
        let units = &self.plan.identity.units;
        let of_unit = |(number, planned): (usize, &PlannedUnit)| {
            let found = self.bytes.get(&unit::file_name(number as u64, units.len() as u64))?;
            planned.payload_bytes(*found).ok()
        };
        units.iter().enumerate().map(of_unit).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{MemoryStore, payload, plan};

    #[test]
    fn counts_what_is_there() {
        let (plan, store) = (plan(&[3, 4, 5, 6]), MemoryStore::default());
        let name = |number| unit::file_name(number, 4);
        for number in [0, 2, 3] {
            store.create(&name(number), &unit::encode(plan.hash(), number, &payload(&plan, number))).unwrap();
        }
        store.create("bake.sbatch", b"a script beside the units").unwrap();
        store.files.lock().unwrap().get_mut(&name(0)).unwrap().pop();
        store.files.lock().unwrap().get_mut(&name(3)).unwrap()[70] ^= 1;

        let fast = status(&plan, &store, Check::Sizes).unwrap();
        assert_eq!((fast.total, fast.complete, fast.missing, fast.bad.len()), (4, 2, 1, 1));
        let full = status(&plan, &store, Check::Contents).unwrap();
        assert_eq!((full.total, full.complete, full.missing, full.bad.len()), (4, 1, 1, 2));
        assert_eq!((full.missing(), full.to_make()), (&[1][..], vec![0, 1, 3]));
        assert!(!full.is_complete());
        let few = full.first_few();
        let expected =
            "unit-000000.bin is truncated: 98 of 99 bytes, unit-000001.bin is missing, unit-000003.bin is damaged";
        assert!(few.starts_with(expected), "{few}");

        let json = serde_json::to_value(&full).unwrap();
        assert_eq!((json["complete"].as_u64(), json["missing"].as_u64()), (Some(1), Some(1)));
        assert_eq!(json["bad"][1]["why"], "is damaged: its hash does not fit");
        assert_eq!(json["plan"], plan.hash().to_string());
    }

    #[test]
    fn units_of_another_plan_do_not_count() {
        let (planned, store) = (plan(&[3]), MemoryStore::default());
        let other = plan(&[3, 3]);
        store.create("unit-000000.bin", &unit::encode(other.hash(), 0, &payload(&planned, 0))).unwrap();
        let status = status(&planned, &store, Check::Contents).unwrap();
        assert_eq!(status.bad[0].why, UnitFault::OtherPlan { found: other.hash() });
    }
}
