//! Long precomputation cut into units: planned, made on one core or a cluster, resumed, merged into one mapped file.
//!
//! * A [`Plan`] names the units of a bake, and which of them are made at once, as a batch. Its hash names the bake, so
//!   results of another scene cannot mix in.
//! * [`run`] makes the units of a [`Shard`] that are missing and publishes each in a [`Store`], whole or not at all. A
//!   unit that is there with a fitting hash is done; nothing else is recorded, so a bake may be killed at any time, by
//!   anything.
//! * [`status`] counts the units of a bake that are done, from the store alone.
//! * [`merge`] makes one [`BakedFile`] of all units: the same bits, whoever made the units, in whatever order.
//!
//! The contents of units are their methods' own: all this is about bytes. A [`MethodBake`] holds what catoptric's
//! methods bake, and that a file belongs to a scene and settings; a [`Shelf`] has open files and chooses one that fits.
//!
//! ```
//! use catoptric_bake::{BakedFile, Estimate, Identity, LocalStore, Plan, PlannedUnit, RunOptions, SCHEMA, merge, run};
//!
//! let unit = |row| PlannedUnit { name: format!("row {row}"), bytes: 8, at_most: false, with_previous: false };
//! let identity = Identity {
//!     schema: SCHEMA,
//!     method: "squares".into(),
//!     payload_version: 1,
//!     settings: serde_json::json!({ "rows": 10 }),
//!     scene_hash: "0".repeat(64),
//!     program_version: "1.0.0".into(),
//!     units: (0..10).map(unit).collect(),
//! };
//! let estimate = Estimate { core_hours: 0.001, bytes: 80 };
//! let plan = Plan { identity, recipe: serde_json::json!({ "rows": 10 }), estimate };
//!
//! let folder = tempfile::tempdir().unwrap();
//! let store = LocalStore::create_folder(folder.path().join("squares")).unwrap();
//! plan.publish(&store).unwrap();
//!
//! // Work is a function of the unit's number alone. Other processes may do other shards at the same time.
//! let work = |number: u64| -> Result<Vec<u8>, String> { Ok((number * number).to_le_bytes().to_vec()) };
//! for shard in ["0/2", "1/2"] {
//!     let options = RunOptions { shard: shard.parse().unwrap(), ..RunOptions::default() };
//!     assert_eq!(run(&plan, &store, &work, &options).unwrap().made, 5);
//! }
//!
//! let output = folder.path().join("squares.bake");
//! merge(&plan, &store, &output).unwrap();
//! let baked = BakedFile::open(&output).unwrap();
//! assert_eq!(baked.identity().difference(&plan.identity), None);
//! assert_eq!(baked.unit(7), 49u64.to_le_bytes());
//! ```

mod claim;
mod container;
mod error;
mod merge;
mod methods;
mod plan;
mod plan_hash;
mod publish;
mod run;
mod shard;
mod shelf;
mod status;
mod store;
#[cfg(test)]
mod testing;
pub mod unit;

pub use claim::Claim;
pub use container::{ALIGNMENT, BakedFile, FORMAT_VERSION};
pub use error::BakeError;
pub use merge::{Merged, for_each_unit, merge, merge_through};
pub use methods::{MethodBake, MethodBakeError, MethodUnits};
pub use plan::{Difference, Estimate, Identity, MAX_IDENTITY_BYTES, PLAN_NAME, Plan, PlannedUnit, SCHEMA};
pub use plan_hash::PlanHash;
pub use run::{Outcome, Payload, Reason, RunOptions, RunReport, UnitDone, Work, run};
pub use shard::Shard;
pub use shelf::{BakeChoice, Shelf, Unfit};
pub use status::{BadUnit, Check, Status, status};
pub use store::{Created, Entry, LocalStore, Store, check_name};
pub use unit::UnitFault;
