//! A plan: which units a bake consists of. It is made once, published first and never changed.

mod identity;

pub(crate) use identity::AnyIdentity;
pub use identity::{Difference, Identity, MAX_IDENTITY_BYTES, PlannedUnit, SCHEMA};

use crate::error::BakeError;
use crate::plan_hash::PlanHash;
use crate::store::{Created, Store};
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// The plan's name in its store.
pub const PLAN_NAME: &str = "plan.json";

/// The parts of a bake.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Everything that the bits of the bake depend on.
    pub identity: Identity,
    /// The recipe by which a program makes the work again: the scene's argument, options. Equal plans may differ in it.
    pub recipe: Value,
    /// The estimated costs. Equal plans may differ in them.
    pub estimate: Estimate,
}

/// The estimated costs of a bake.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Estimate {
    /// Hours of one core.
    pub core_hours: f64,
    /// Bytes of all units.
    pub bytes: u64,
}

/// A plan as it is written: with the hash of its identity, so that a plan that was damaged or edited is noticed before
/// its units seem to be another bake's.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PlanFile<I> {
    hash: String,
    identity: I,
    recipe: Value,
    estimate: Estimate,
}

/// The part of any version's plan that holds the version.
#[derive(Deserialize)]
struct AnyPlan {
    identity: AnyIdentity,
}

impl Plan {
    /// The name of the bake: the hash of the identity alone, so planning again with another estimate, or another path
    /// of the same scene, gives the same.
    pub fn hash(&self) -> PlanHash {
        self.identity.hash()
    }

    /// Reads a plan; `file` names it in messages.
    ///
    /// # Errors
    /// [`BakeError::Version`] for a plan of another schema, [`BakeError::Invalid`] for what is no plan.
    pub fn from_json(file: &str, bytes: &[u8]) -> Result<Self, BakeError> {
        let invalid =
            |field, problem: &str| BakeError::invalid(file, field, format!("{problem}; remove it and plan again"));
        let unreadable = |error: serde_json::Error| invalid("plan", &error.to_string());
        // Other schemas have other fields, so the schema is read before these.
        let schema = serde_json::from_slice::<AnyPlan>(bytes).map_err(unreadable)?.identity.schema;
        if schema != SCHEMA {
            return Err(BakeError::Version { file: file.into(), field: "schema", found: schema, known: SCHEMA });
        }
        let PlanFile { hash, identity, recipe, estimate } = serde_json::from_slice(bytes).map_err(unreadable)?;
        let plan = Self { identity, recipe, estimate };
        plan.validate(file)?;
        if plan.hash().to_string() != hash {
            return Err(invalid("hash", "the identity does not fit it: the file is damaged, or was edited"));
        }
        Ok(plan)
    }

    /// The plan as JSON for people, one field a line.
    ///
    /// # Errors
    /// [`BakeError::Invalid`] for plans that could not be read again: see [`Identity::validate`]; estimates must be
    /// finite.
    pub fn to_json(&self) -> Result<Vec<u8>, BakeError> {
        self.validate(PLAN_NAME)?;
        let (hash, identity) = (self.hash().to_string(), &self.identity);
        let file = PlanFile { hash, identity, recipe: self.recipe.clone(), estimate: self.estimate };
        let written = serde_json::to_vec_pretty(&file);
        let mut text = written.map_err(|error| BakeError::invalid(PLAN_NAME, "plan", error.to_string()))?;
        text.push(b'\n');
        // Faults such as settings nested too deeply are found now and not by every machine that is to run the plan.
        Self::from_json(PLAN_NAME, &text)?;
        Ok(text)
    }

    /// Publishes the plan. Where the store has one already, it must be of the same identity, and is kept.
    ///
    /// # Errors
    /// [`BakeError::OtherPlan`] where the store has another bake's plan; as for [`Self::to_json`] and
    /// [`Store::create`].
    pub fn publish(&self, store: &dyn Store) -> Result<Created, BakeError> {
        let created = store.create(PLAN_NAME, &self.to_json()?)?;
        if created == Created::Existed {
            let found = Self::load(store)?;
            if let Some(difference) = found.identity.difference(&self.identity) {
                let file = store.place(PLAN_NAME);
                return Err(BakeError::OtherPlan { file, difference: difference.to_string() });
            }
        }
        Ok(created)
    }

    /// Reads the plan of a store.
    ///
    /// # Errors
    /// [`BakeError::Absent`] where there is none; as for [`Self::from_json`] and [`Store::get`].
    pub fn load(store: &dyn Store) -> Result<Self, BakeError> {
        let file = store.place(PLAN_NAME);
        let Some(bytes) = store.get(PLAN_NAME)? else {
            return Err(BakeError::Absent { file, remedy: "a bake begins with a plan: make one there first" });
        };
        Self::from_json(&file, &bytes)
    }

    fn validate(&self, file: &str) -> Result<(), BakeError> {
        self.identity.validate(file)?;
        let length = self.identity.canonical_bytes().len() as u64;
        if length > MAX_IDENTITY_BYTES {
            let problem = format!("takes {length} bytes, {MAX_IDENTITY_BYTES} are allowed; make fewer, larger units");
            return Err(BakeError::invalid(file, "identity", problem));
        }
        if !(self.estimate.core_hours >= 0.0 && self.estimate.core_hours.is_finite()) {
            return Err(BakeError::invalid(file, "estimate.core_hours", "must be a finite number, 0 or more"));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{MemoryStore, plan};
    use serde_json::json;

    #[test]
    fn comes_back_as_it_was_published() {
        let store = MemoryStore::default();
        let plan = plan(&[3, 4]);
        assert_eq!(plan.publish(&store).unwrap(), Created::New);
        assert_eq!(Plan::load(&store).unwrap(), plan);
        assert_eq!(Plan::load(&store).unwrap().hash(), plan.hash());
    }

    #[test]
    fn planning_again_changes_nothing() {
        let store = MemoryStore::default();
        let first = plan(&[3, 4]);
        first.publish(&store).unwrap();
        let mut again = first.clone();
        again.recipe = json!({ "scene": "elsewhere/scene.glb" });
        again.estimate = Estimate { core_hours: 9.0, bytes: 7 };
        assert_eq!(again.hash(), first.hash());
        assert_eq!(again.publish(&store).unwrap(), Created::Existed);
        assert_eq!(Plan::load(&store).unwrap(), first);
        again.identity.settings["st"] = 32.into();
        let message = again.publish(&store).unwrap_err().to_string();
        assert!(message.contains("settings: st is 16 in the bake, 32 asked for"), "{message}");
        assert!(message.contains("memory/plan.json"), "{message}");
    }

    #[test]
    fn what_is_no_plan_is_an_error() {
        let store = MemoryStore::default();
        assert!(matches!(Plan::load(&store), Err(BakeError::Absent { .. })));
        let good = plan(&[3]).to_json().unwrap();
        for length in 0..good.len() - 2 {
            assert!(Plan::from_json("plan.json", &good[..length]).is_err());
        }
        let text = String::from_utf8(good).unwrap();
        let message = |from: &str, to: &str| {
            assert!(text.contains(from), "{from}");
            Plan::from_json("a/plan.json", text.replace(from, to).as_bytes()).unwrap_err().to_string()
        };
        let other = message(r#""schema": 1"#, r#""schema": 2, "more": []"#);
        assert!(other.contains("a/plan.json: schema is 2, this program reads 1"), "{other}");
        assert!(message(r#""recipe""#, r#""recipes""#).contains("recipes"));
        assert!(message(r#""st": 16"#, r#""st": 1e999"#).contains("plan"));
        assert!(message(r#""name": "row 0""#, r#""name": 0"#).contains("line"));
    }

    #[test]
    fn edited_plans_are_noticed() {
        let text = String::from_utf8(plan(&[3]).to_json().unwrap()).unwrap();
        let edited = Plan::from_json("plan.json", text.replace(r#""st": 16"#, r#""st": 17"#).as_bytes());
        let message = edited.unwrap_err().to_string();
        assert!(message.contains("hash: the identity does not fit it") && message.contains("plan again"), "{message}");
    }

    #[test]
    fn plans_that_could_not_be_read_again_are_not_written() {
        let mut plan = plan(&[3]);
        plan.identity.settings = (0..200).fold(json!(1), |inner, _| json!([inner]));
        assert!(plan.to_json().unwrap_err().to_string().contains("recursion"));
    }

    #[test]
    fn estimates_must_be_numbers() {
        let mut plan = plan(&[3]);
        plan.estimate.core_hours = f64::NAN;
        assert!(plan.to_json().unwrap_err().to_string().contains("estimate.core_hours"));
    }
}
