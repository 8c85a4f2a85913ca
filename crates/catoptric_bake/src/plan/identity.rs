//! The identity of a bake: everything that its bits depend on, and nothing else.

use crate::error::BakeError;
use crate::plan_hash::PlanHash;
use crate::unit::{self, UnitFault};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeSet;
use std::fmt;
use std::ops::Range;

/// The version of the identity's fields.
pub const SCHEMA: u32 = 1;
/// Longer identities, of about 300,000 units, are refused: memory is taken by their length.
pub const MAX_IDENTITY_BYTES: u64 = 16 << 20;
/// Values in messages are cut to about this many characters.
const SHOWN: usize = 60;

/// Everything that the bits of a bake depend on. Its hash names the bake.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Identity {
    /// The version of these fields: [`SCHEMA`].
    pub schema: u32,
    /// The id of the method that looks the result up.
    pub method: String,
    /// The version of the layout of that method's units.
    pub payload_version: u32,
    /// The method's settings. Numbers that JSON cannot hold (no number, infinity) become `null`: keep them out.
    pub settings: Value,
    /// BLAKE3 of everything in the scene that the units depend on, in 64 lower-case hexadecimal digits.
    pub scene_hash: String,
    /// The version of the program that makes the units: other versions may make other bits.
    pub program_version: String,
    /// The units, in the order of their numbers.
    pub units: Vec<PlannedUnit>,
}

/// The part of any version's identity that holds the version.
#[derive(Deserialize)]
pub(crate) struct AnyIdentity {
    pub(crate) schema: u32,
}

/// One unit as it was planned.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlannedUnit {
    /// The unit's name, for people.
    pub name: String,
    /// The bytes of its payload, or the most that it may have.
    pub bytes: u64,
    /// The payload may have fewer bytes: how many is known only once it is made.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub at_most: bool,
    /// The unit is made at once with the unit before it: both are in one batch, and so in one shard.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub with_previous: bool,
}

impl PlannedUnit {
    /// True if its payload may have so many bytes.
    pub fn admits(&self, bytes: u64) -> bool {
        if self.at_most { bytes <= self.bytes } else { bytes == self.bytes }
    }

    /// The bytes of its payload, if its file has so many.
    ///
    /// # Errors
    /// A [`UnitFault`] where a file of that size cannot be the planned unit.
    pub(crate) fn payload_bytes(&self, found: u64) -> Result<u64, UnitFault> {
        let most = unit::file_bytes(self.bytes);
        let least = if self.at_most { unit::FRAME_BYTES } else { most };
        match found {
            _ if found < least => Err(UnitFault::Truncated { expected: least, found }),
            _ if found > most => Err(UnitFault::Longer { expected: most, found }),
            _ => Ok(found - unit::FRAME_BYTES),
        }
    }

    /// The payload of its file in the bake of a plan, as [`unit::decode`], of a size that the plan allows.
    pub(crate) fn decode<'a>(&self, bytes: &'a [u8], plan: PlanHash, number: u64) -> Result<&'a [u8], UnitFault> {
        let payload = unit::decode(bytes, plan, number)?;
        let found = payload.len() as u64;
        if self.admits(found) { Ok(payload) } else { Err(UnitFault::OtherSize { planned: self.bytes, found }) }
    }
}

/// The first difference of two identities; its text is such as `settings: st is 16 in the bake, 32 asked for`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// The field, such as `settings: st`.
    pub field: String,
    /// The field's value in the bake.
    pub baked: String,
    /// The field's value in the requested identity.
    pub asked: String,
}

impl fmt::Display for Difference {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{} is {} in the bake, {} asked for", self.field, self.baked, self.asked)
    }
}

impl Identity {
    /// The one way to write it: JSON without spaces, keys sorted.
    pub fn canonical_bytes(&self) -> Vec<u8> {
        // Written piece by piece: as JSON values, millions of units would take many times the memory of the text.
        let text = |text: &str| Value::from(text).to_string();
        let mut whole = format!(
            concat!(
                r#"{{"method":{},"payload_version":{},"program_version":{},"scene_hash":{},"#,
                r#""schema":{},"settings":{},"units":["#
            ),
            text(&self.method),
            self.payload_version,
            text(&self.program_version),
            text(&self.scene_hash),
            self.schema,
            canonical(self.settings.clone()),
        );
        for (number, unit) in self.units.iter().enumerate() {
            let comma = if number == 0 { "" } else { "," };
            // Identities without these are as they were before there were any.
            let at_most = if unit.at_most { r#""at_most":true,"# } else { "" };
            let joined = if unit.with_previous { r#","with_previous":true"# } else { "" };
            whole += &format!(r#"{comma}{{{at_most}"bytes":{},"name":{}{joined}}}"#, unit.bytes, text(&unit.name));
        }
        whole += "]}";
        whole.into_bytes()
    }

    /// BLAKE3 of [`Self::canonical_bytes`].
    pub fn hash(&self) -> PlanHash {
        PlanHash(blake3::hash(&self.canonical_bytes()).into())
    }

    /// The number of units.
    pub fn unit_count(&self) -> u64 {
        self.units.len() as u64
    }

    /// The batches: ranges of numbers of units that are made at once.
    pub fn batches(&self) -> Vec<Range<u64>> {
        let batches = catoptric::methods::bake::batches(self.units.iter().map(|unit| unit.with_previous));
        batches.into_iter().map(|batch| batch.start as u64..batch.end as u64).collect()
    }

    /// Checks its fields; `file` names it in messages.
    ///
    /// # Errors
    /// [`BakeError::Version`] for another schema, [`BakeError::Invalid`] for a scene hash that is none, for no units,
    /// and for units larger than [`unit::MAX_PAYLOAD_BYTES`].
    pub fn validate(&self, file: &str) -> Result<(), BakeError> {
        if self.schema != SCHEMA {
            return Err(BakeError::Version { file: file.into(), field: "schema", found: self.schema, known: SCHEMA });
        }
        let invalid =
            |field: &str, problem: String| Err(BakeError::invalid(file, format!("identity.{field}"), problem));
        let is_digit = |byte: u8| byte.is_ascii_digit() || (b'a'..=b'f').contains(&byte);
        if self.scene_hash.len() != 64 || !self.scene_hash.bytes().all(is_digit) {
            return invalid("scene_hash", "must be 64 lower-case hexadecimal digits".into());
        }
        if self.units.is_empty() {
            return invalid("units", "there are none; a bake has at least one".into());
        }
        if self.units[0].with_previous {
            return invalid("units[0].with_previous", "there is none before it".into());
        }
        for (number, planned) in self.units.iter().enumerate() {
            if planned.bytes > unit::MAX_PAYLOAD_BYTES {
                let most = unit::MAX_PAYLOAD_BYTES;
                let problem = format!("{} bytes are too many, {most} are allowed; cut the work finer", planned.bytes);
                return invalid(&format!("units[{number}].bytes"), problem);
            }
        }
        Ok(())
    }

    /// The first difference between this identity, of a bake, and a requested one.
    ///
    /// Look-ups do not depend on the version of the program that made the bake: callers set `program_version` of
    /// the requested identity to the bake's.
    pub fn difference(&self, asked: &Self) -> Option<Difference> {
        let of = |field: &str, baked: Value, asked: Value| differing(field, &baked, &asked);
        let hash = |hash: &str| Value::from(hash.get(..12).unwrap_or(hash));
        of("schema", self.schema.into(), asked.schema.into())
            .or_else(|| of("method", self.method.as_str().into(), asked.method.as_str().into()))
            .or_else(|| of("payload_version", self.payload_version.into(), asked.payload_version.into()))
            .or_else(|| differing("settings", &self.settings, &asked.settings))
            // The beginning is enough to distinguish hashes; otherwise the whole is shown.
            .or_else(|| of("the scene's hash", hash(&self.scene_hash), hash(&asked.scene_hash)))
            .or_else(|| of("the scene's hash", self.scene_hash.as_str().into(), asked.scene_hash.as_str().into()))
            .or_else(|| {
                of("program_version", self.program_version.as_str().into(), asked.program_version.as_str().into())
            })
            .or_else(|| of("units: their number", self.unit_count().into(), asked.unit_count().into()))
            .or_else(|| {
                self.units.iter().zip(&asked.units).enumerate().find_map(|(number, (baked, asked))| {
                    let field = format!("units: the name of unit {number}");
                    of(&field, baked.name.as_str().into(), asked.name.as_str().into())
                        .or_else(|| {
                            of(&format!("units: the bytes of unit {number}"), baked.bytes.into(), asked.bytes.into())
                        })
                        .or_else(|| {
                            let field = format!("units: at_most of unit {number}");
                            of(&field, baked.at_most.into(), asked.at_most.into())
                        })
                        .or_else(|| {
                            let field = format!("units: with_previous of unit {number}");
                            of(&field, baked.with_previous.into(), asked.with_previous.into())
                        })
                })
            })
    }
}

/// The value with the keys of all objects sorted, whatever order the JSON library keeps them in.
fn canonical(value: Value) -> Value {
    match value {
        Value::Object(map) => {
            let mut entries: Vec<(String, Value)> = map.into_iter().collect();
            entries.sort_by(|a, b| a.0.cmp(&b.0));
            Value::Object(entries.into_iter().map(|(key, value)| (key, canonical(value))).collect())
        }
        Value::Array(values) => Value::Array(values.into_iter().map(canonical).collect()),
        other => other,
    }
}

/// The first place where two values differ. `path` leads to them; the name of the field at its front is set off by a
/// colon.
fn differing(path: &str, baked: &Value, asked: &Value) -> Option<Difference> {
    match (baked, asked) {
        (Value::Object(baked), Value::Object(asked)) => {
            let keys: BTreeSet<&String> = baked.keys().chain(asked.keys()).collect();
            // Fields that only one of them has follow from fields that both have, such as settings of a choice.
            let (common, others): (Vec<&String>, Vec<&String>) =
                keys.into_iter().partition(|key| baked.contains_key(*key) && asked.contains_key(*key));
            common.into_iter().chain(others).find_map(|key| {
                let path = if path.contains(": ") { format!("{path}.{key}") } else { format!("{path}: {key}") };
                match (baked.get(key), asked.get(key)) {
                    (Some(baked), Some(asked)) => differing(&path, baked, asked),
                    (baked, asked) => Some(Difference { field: path, baked: shown(baked), asked: shown(asked) }),
                }
            })
        }
        (Value::Array(baked), Value::Array(asked)) if baked.len() == asked.len() => {
            let mut pairs = baked.iter().zip(asked).enumerate();
            pairs.find_map(|(index, (baked, asked))| differing(&format!("{path}[{index}]"), baked, asked))
        }
        _ => {
            // As they are written, since that is hashed: 0 and -0 are equal.
            let written = [baked, asked].map(|value| canonical(value.clone()).to_string());
            let differ = || Difference { field: path.into(), baked: shown(Some(baked)), asked: shown(Some(asked)) };
            (written[0] != written[1]).then(differ)
        }
    }
}

fn shown(value: Option<&Value>) -> String {
    let text = match value {
        None => return "not given".into(),
        Some(Value::String(text)) => format!("`{text}`"),
        Some(value @ Value::Array(values)) if value.to_string().len() > SHOWN => {
            return format!("a list of {}", values.len());
        }
        Some(value) => canonical(value.clone()).to_string(),
    };
    if text.chars().count() <= SHOWN { text } else { text.chars().take(SHOWN).chain(['…']).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::identity;
    use serde_json::json;

    fn with(change: impl FnOnce(&mut Identity)) -> Identity {
        let mut changed = identity(&[3, 4]);
        change(&mut changed);
        changed
    }

    #[test]
    fn the_hash_does_not_depend_on_the_order_of_keys() {
        let one = with(|identity| identity.settings = serde_json::from_str(r#"{"a":{"x":1,"b":2},"c":0.1}"#).unwrap());
        let other =
            with(|identity| identity.settings = serde_json::from_str(r#"{"c":0.1,"a":{"b":2,"x":1}}"#).unwrap());
        assert_eq!(one.hash(), other.hash());
        assert_eq!(one.canonical_bytes(), other.canonical_bytes());
        assert_eq!(one.difference(&other), None);
        assert_ne!(one.hash(), identity(&[3, 4]).hash());
        assert_eq!(one.hash().to_string().len(), 64);
        // The canonical form is JSON, whatever characters names have.
        let odd = with(|identity| identity.units[0].name = "a \"row\"\n\u{1}\u{10ffff}".into());
        assert_eq!(serde_json::from_slice::<Identity>(&odd.canonical_bytes()).unwrap(), odd);
    }

    /// Written as it was by the first version: plans and units of old bakes must stay readable.
    #[test]
    fn the_canonical_form_is_fixed() {
        let text = String::from_utf8(identity(&[3]).canonical_bytes()).unwrap();
        let expected = concat!(
            r#"{"method":"test","payload_version":1,"program_version":"0.1.0","scene_hash":""#,
            "00ff00ff00ff00ff00ff00ff00ff00ff00ff00ff00ff00ff00ff00ff00ff00ff",
            r#"","schema":1,"settings":{"region":{"min":[0,0,0.1]},"st":16},"units":[{"bytes":3,"name":"row 0"}]}"#
        );
        assert_eq!(text, expected);
    }

    #[test]
    fn numbers_come_back_as_they_were() {
        // Parsed without care, such numbers come back as their neighbours.
        for bits in (0..2000u64).map(|k| 0x3fb0_0000_0000_0000 + k * 0x1_2345_6789_abcd % (1 << 60)) {
            let value = f64::from_bits(bits);
            let before = with(|identity| identity.settings = json!({ "value": value }));
            let after: Identity = serde_json::from_slice(&before.canonical_bytes()).unwrap();
            assert_eq!(after.hash(), before.hash(), "{value:e}");
        }
    }

    #[test]
    fn differences_have_a_text() {
        let baked = identity(&[3, 4]);
        let text = |change: &dyn Fn(&mut Identity)| baked.difference(&with(change)).unwrap().to_string();
        assert_eq!(text(&|i| i.settings["st"] = 32.into()), "settings: st is 16 in the bake, 32 asked for");
        assert_eq!(
            text(&|i| i.settings["region"]["min"][2] = 0.25.into()),
            "settings: region.min[2] is 0.1 in the bake, 0.25 asked for"
        );
        assert_eq!(text(&|i| i.settings["uv"] = 8.into()), "settings: uv is not given in the bake, 8 asked for");
        assert_eq!(
            text(&|i| i.settings["region"]["min"] = (0..90).collect()),
            "settings: region.min is [0,0,0.1] in the bake, a list of 90 asked for"
        );
        assert_eq!(text(&|i| i.method = "other".into()), "method is `test` in the bake, `other` asked for");
        assert_eq!(
            text(&|i| i.scene_hash = "a".repeat(64)),
            "the scene's hash is `00ff00ff00ff` in the bake, `aaaaaaaaaaaa` asked for"
        );
        assert!(text(&|i| i.scene_hash = i.scene_hash.replacen("ff00ff", "ff00fe", 1)).starts_with("the scene's hash"));
        assert_eq!(text(&|i| i.payload_version = 2), "payload_version is 1 in the bake, 2 asked for");
        assert_eq!(
            text(&|i| i.program_version = "0.2".into()),
            "program_version is `0.1.0` in the bake, `0.2` asked for"
        );
        assert_eq!(text(&|i| i.units.truncate(1)), "units: their number is 2 in the bake, 1 asked for");
        assert_eq!(text(&|i| i.units[1].bytes = 5), "units: the bytes of unit 1 is 4 in the bake, 5 asked for");
        assert!(text(&|i| i.method = "x".repeat(500)).len() < 150);
        assert_eq!(text(&|i| i.settings["st"] = json!(16.0)), "settings: st is 16 in the bake, 16.0 asked for");
        let zero = [0.0, -0.0].map(|zero| with(|identity| identity.settings = json!({ "zero": zero })));
        assert_eq!(zero[0].difference(&zero[1]).is_some(), zero[0].hash() != zero[1].hash());
        assert_eq!(baked.difference(&baked), None);
    }

    #[test]
    fn what_means_nothing_is_refused() {
        let message = |change: &dyn Fn(&mut Identity)| with(change).validate("plan.json").unwrap_err().to_string();
        assert!(identity(&[0]).validate("plan.json").is_ok());
        assert!(message(&|i| i.schema = 2).contains("schema is 2, this program reads 1"));
        assert!(message(&|i| i.scene_hash = "A".repeat(64)).contains("identity.scene_hash"));
        assert!(message(&|i| i.units.clear()).contains("identity.units"));
        assert!(message(&|i| i.units[1].bytes = 1 << 40).contains("identity.units[1].bytes"));
    }
}
