//! Settings of methods, each declared once: `declare_settings!` makes of the declaration the struct, its defaults,
//! the reading from `key = value` tables with errors that list the allowed values, the texts for users, and the part of
//! a bake's identity.

use crate::error::{RenderError, did_you_mean};
use serde::{Serialize, de::DeserializeOwned};
use toml::{Table, Value};

/// The declaration of one setting.
#[derive(Clone, Copy, Debug)]
pub struct SettingSpec {
    /// The setting's name, as in scene files.
    pub name: &'static str,
    /// The kind of its values.
    pub kind: SettingKind,
    /// The values that are allowed of that kind.
    pub limits: Limits,
    /// The unit of a number; empty for pure numbers, counts included.
    pub unit: &'static str,
    /// The setting's effect, in sentences.
    pub help: &'static str,
    /// The results of a bake depend on it.
    pub is_baked: bool,
}

/// The kind of a setting's values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SettingKind {
    /// True or false.
    Bool,
    /// A whole number of 0 or more.
    Whole,
    /// A number in single precision.
    Number,
    /// One of these texts.
    Choice(&'static [ChoiceSpec]),
    /// Any text.
    Text,
    /// Three finite numbers.
    Vector,
}

/// One of the values of a setting of the kind [`SettingKind::Choice`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct ChoiceSpec {
    /// The value's name, as in scene files.
    pub name: &'static str,
    /// The value's effect, in a sentence.
    pub help: &'static str,
}

/// The numbers that a setting allows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Limits {
    /// All of its kind.
    Any,
    /// Numbers from the first to the second.
    Range(f64, f64),
    /// Numbers of finite size from this one on.
    AtLeast(f64),
    /// These.
    OneOf(&'static [u64]),
    /// The powers of two from the first to the second.
    PowerOfTwo(u64, u64),
}

/// A setting in the form in which it is shown to users.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SettingInfo {
    /// The setting's name, as in scene files.
    pub name: &'static str,
    /// The name of its kind: `bool`, `whole`, `number`, `choice`, `text` or `vector`.
    pub kind: &'static str,
    /// The default value, as it is written in a scene file.
    pub default: String,
    /// The least and the largest value of a number; `None` without a largest one.
    pub range: Option<[f64; 2]>,
    /// The values of a choice with their effects; empty for other kinds.
    pub choices: &'static [ChoiceSpec],
    /// The allowed values of a number, in words; empty if all are allowed.
    pub allowed: String,
    /// The same for widgets.
    #[serde(skip)]
    pub limits: Limits,
    /// The unit of a number; empty for pure numbers, counts included.
    pub unit: &'static str,
    /// The setting's effect, in sentences.
    pub help: &'static str,
}

impl SettingInfo {
    /// The allowed values of a number and their unit, in words: `4 to 4096 texels`; empty for other kinds.
    pub fn values(&self) -> String {
        format!("{} {}", self.allowed, self.unit).trim().to_owned()
    }
}

/// A type of the fields of settings structs.
pub trait SettingValue {
    /// The kind of its values.
    const KIND: SettingKind;
}

impl SettingValue for bool {
    const KIND: SettingKind = SettingKind::Bool;
}

impl SettingValue for u32 {
    const KIND: SettingKind = SettingKind::Whole;
}

impl SettingValue for u64 {
    const KIND: SettingKind = SettingKind::Whole;
}

impl SettingValue for f32 {
    const KIND: SettingKind = SettingKind::Number;
}

impl SettingValue for String {
    const KIND: SettingKind = SettingKind::Text;
}

impl SettingValue for [f32; 3] {
    const KIND: SettingKind = SettingKind::Vector;
}

impl SettingKind {
    /// The kind's name in lists.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bool => "bool",
            Self::Whole => "whole",
            Self::Number => "number",
            Self::Choice(_) => "choice",
            Self::Text => "text",
            Self::Vector => "vector",
        }
    }
}

impl Limits {
    fn range(self) -> Option<[f64; 2]> {
        match self {
            Self::Any | Self::AtLeast(_) => None,
            Self::Range(least, most) => Some([least, most]),
            Self::OneOf(values) => Some([*values.first()? as f64, *values.last()? as f64]),
            Self::PowerOfTwo(least, most) => Some([least as f64, most as f64]),
        }
    }

    /// Checks a whole number.
    fn check_whole(self, name: &str, value: i64) -> Result<(), String> {
        let within = |least: f64, most: f64| (least..=most).contains(&(value as f64));
        match self {
            Self::OneOf(values) if !values.iter().any(|one| *one as i64 == value) => {
                let values: Vec<String> = values.iter().map(ToString::to_string).collect();
                Err(format!("{name} = {value} is none of {}", values.join(", ")))
            }
            Self::PowerOfTwo(least, most) if !(value.count_ones() == 1 && within(least as f64, most as f64)) => {
                Err(format!("{name} = {value} is no power of two from {least} to {most}"))
            }
            Self::Range(least, most) if !within(least, most) => {
                Err(format!("{name} = {value} is outside {least} to {most}"))
            }
            _ => Ok(()),
        }
    }

    /// Checks a number in single precision, in which the limits are taken, too.
    fn check_number(self, name: &str, value: f32) -> Result<(), String> {
        match self {
            Self::Range(least, most) => within(name, value, least as f32, most as f32),
            Self::AtLeast(least) if !(value.is_finite() && value >= least as f32) => {
                Err(format!("{name} = {value} must be {least} or more"))
            }
            _ => Ok(()),
        }
    }
}

/// The allowed numbers in words; empty if all are allowed.
impl std::fmt::Display for Limits {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Any => Ok(()),
            Self::Range(least, most) => write!(formatter, "{least} to {most}"),
            Self::AtLeast(least) => write!(formatter, "{least} or more"),
            Self::OneOf(values) => {
                for (index, value) in values.iter().enumerate() {
                    let before = if index == 0 {
                        ""
                    } else if index + 1 == values.len() {
                        " or "
                    } else {
                        ", "
                    };
                    write!(formatter, "{before}{value}")?;
                }
                Ok(())
            }
            Self::PowerOfTwo(least, most) => write!(formatter, "a power of two from {least} to {most}"),
        }
    }
}

impl SettingSpec {
    /// A setting without limits and unit, on which no bake depends. The help is a doc comment's text.
    pub const fn new(name: &'static str, help: &'static str, kind: SettingKind) -> Self {
        Self { name, kind, limits: Limits::Any, unit: "", help: help.trim_ascii(), is_baked: false }
    }

    /// The same with limits.
    const fn limited(self, limits: Limits) -> Self {
        Self { limits, ..self }
    }

    /// The same for the numbers from `least` to `most`.
    pub const fn range(self, least: f64, most: f64) -> Self {
        self.limited(Limits::Range(least, most))
    }

    /// The same for the numbers from `least` on.
    pub const fn at_least(self, least: f64) -> Self {
        self.limited(Limits::AtLeast(least))
    }

    /// The same for these numbers.
    pub const fn one_of(self, values: &'static [u64]) -> Self {
        self.limited(Limits::OneOf(values))
    }

    /// The same for the powers of two from `least` to `most`.
    pub const fn power_of_two(self, least: u64, most: u64) -> Self {
        self.limited(Limits::PowerOfTwo(least, most))
    }

    /// The same with a unit.
    pub const fn unit(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }

    /// The same as a part of the identity of bakes.
    pub const fn baked(self) -> Self {
        Self { is_baked: true, ..self }
    }

    /// Checks a value of the right kind.
    fn check(&self, value: &Value) -> Result<(), String> {
        match value {
            Value::Integer(value) => self.limits.check_whole(self.name, *value),
            Value::Float(value) => self.limits.check_number(self.name, *value as f32),
            Value::Array(values) => match values.iter().all(|value| value.as_float().is_some_and(f64::is_finite)) {
                true => Ok(()),
                false => Err(format!("{} must be finite", self.name)),
            },
            _ => Ok(()),
        }
    }

    /// Checks a value as users write it.
    fn check_kind(&self, value: &Value) -> Result<(), String> {
        let is_number = |value: &Value| value.is_integer() || value.is_float();
        let (is_right, wanted) = match self.kind {
            SettingKind::Bool => (value.is_bool(), "must be true or false".to_owned()),
            SettingKind::Whole => {
                (value.as_integer().is_some_and(|value| value >= 0), "must be a whole number of 0 or more".into())
            }
            SettingKind::Number => (is_number(value), "must be a number".into()),
            SettingKind::Choice(choices) => {
                let is_known = value.as_str().is_some_and(|value| choices.iter().any(|choice| choice.name == value));
                let names: Vec<String> = choices.iter().map(|choice| format!("`{}`", choice.name)).collect();
                (is_known, format!("must be one of {}", names.join(", ")))
            }
            SettingKind::Text => (value.is_str(), "must be a text".into()),
            SettingKind::Vector => {
                let is_vector = value.as_array().is_some_and(|list| list.len() == 3 && list.iter().all(is_number));
                (is_vector, "must be three numbers in brackets, such as [0, 1, 0]".into())
            }
        };
        match (is_right, value) {
            (false, _) => Err(format!("{} = {value}: {wanted}", self.name)),
            (true, Value::Array(_)) => Ok(()),
            (true, _) => self.check(value),
        }
    }

    fn info(&self, default: Option<&Value>) -> SettingInfo {
        let choices = if let SettingKind::Choice(choices) = self.kind { choices } else { &[] };
        SettingInfo {
            name: self.name,
            kind: self.kind.name(),
            default: default.map_or_else(|| "none".into(), ToString::to_string),
            range: self.limits.range(),
            choices,
            allowed: self.limits.to_string(),
            limits: self.limits,
            unit: self.unit,
            help: self.help,
        }
    }
}

/// The value that a text on a command line or in a link stands for: TOML if it is that, else the text itself.
pub fn setting_value(text: &str) -> Value {
    match toml::from_str::<Table>(&format!("value = {text}")) {
        Ok(mut table) if table.len() == 1 => table.remove("value").unwrap_or_else(|| Value::String(text.into())),
        _ => Value::String(text.into()),
    }
}

/// Checks that a number lies in its range.
pub fn within(name: &str, value: f32, least: f32, most: f32) -> Result<(), String> {
    if (least..=most).contains(&value) { Ok(()) } else { Err(format!("{name} = {value} is outside {least} to {most}")) }
}

/// Checks that all names are known and all values are of the right kinds and within their limits.
fn check_kinds(schema: &[SettingSpec], table: &Table) -> Result<(), String> {
    for (name, value) in table {
        let Some(spec) = schema.iter().find(|spec| spec.name == name) else {
            let known: Vec<String> = schema.iter().map(|spec| format!("`{}`", spec.name)).collect();
            return Err(match known.is_empty() {
                true => format!("there is no setting `{name}`; it has none"),
                false => {
                    let hint = did_you_mean(name, schema.iter().map(|spec| spec.name));
                    format!("there is no setting `{name}`{hint}; there are: {}", known.join(", "))
                }
            });
        };
        spec.check_kind(value)?;
    }
    Ok(())
}

/// The message about settings of the right kinds that cannot be taken nevertheless: whole numbers may be too large.
fn unreadable(table: &Table) -> String {
    let is_large = |value: &Value| value.as_integer().is_some_and(|value| value > u32::MAX.into());
    match table.iter().find(|(_, value)| is_large(value)) {
        Some((name, value)) => format!("{name} = {value} is too large; at most {} is allowed", u32::MAX),
        None => "these settings cannot be read".into(),
    }
}

/// The same values with numbers of single precision by their fewest digits: 0.1, not 0.10000000149011612.
fn shortest(value: Value) -> Value {
    match value {
        Value::Float(number) => Value::Float((number as f32).to_string().parse().unwrap_or(number)),
        Value::Array(values) => Value::Array(values.into_iter().map(shortest).collect()),
        other => other,
    }
}

/// A method's settings struct; `declare_settings!` implements it.
pub trait Settings: Default + Serialize + DeserializeOwned {
    /// The method's id, for messages.
    const METHOD: &'static str;
    /// The declarations of all fields, in order.
    const SCHEMA: &'static [SettingSpec];

    /// The values of all settings that a table does not name, given what it does: those of its preset, else the
    /// defaults.
    fn start(&self) -> Self {
        Self::default()
    }

    /// Checks conditions that concern several settings.
    fn check_rules(&self) -> Result<(), String> {
        Ok(())
    }

    /// All settings, numbers with all digits; those without a value are left out.
    fn table(&self) -> Result<Table, String> {
        Table::try_from(self).map_err(|error| error.to_string())
    }

    /// Checks all values; the error names the setting and what is allowed.
    fn check(&self) -> Result<(), String> {
        let table = self.table()?;
        Self::SCHEMA.iter().try_for_each(|spec| table.get(spec.name).map_or(Ok(()), |value| spec.check(value)))?;
        self.check_rules()
    }

    /// The settings from a table; those that it does not name are as in [`Self::start`].
    ///
    /// # Errors
    /// [`RenderError::Setting`] for unknown names and values that are not allowed.
    fn from_table(table: &Table) -> Result<Self, RenderError> {
        let fail = |problem: String| RenderError::Setting { method: Self::METHOD, problem };
        let read = |table: Table| -> Result<Self, RenderError> {
            let given = table.clone();
            let read = Value::Table(table).try_into();
            read.map_err(|_: toml::de::Error| fail(unreadable(&given)))
        };
        check_kinds(Self::SCHEMA, table).map_err(fail)?;
        let start = read(table.clone())?.start().table().map_err(fail)?;
        let settings = read(start.into_iter().chain(table.clone()).collect())?;
        settings.check().map_err(fail)?;
        Ok(settings)
    }

    /// All settings with the values that a table of some of them leads to; those without a value are left out.
    ///
    /// # Errors
    /// As [`Self::from_table`].
    fn effective(table: &Table) -> Result<Table, RenderError> {
        let fail = |problem: String| RenderError::Setting { method: Self::METHOD, problem };
        let all = Self::from_table(table)?.table().map_err(fail)?;
        Ok(all.into_iter().map(|(name, value)| (name, shortest(value))).collect())
    }

    /// The settings that the results of a bake depend on.
    fn baked(&self) -> Table {
        let is_baked = |name: &String| Self::SCHEMA.iter().any(|spec| spec.is_baked && spec.name == name);
        self.table().unwrap_or_default().into_iter().filter(|(name, _)| is_baked(name)).collect()
    }

    /// All settings as they are shown to users.
    fn describe() -> Vec<SettingInfo> {
        let defaults = Self::effective(&Table::new()).unwrap_or_default();
        Self::SCHEMA.iter().map(|spec| spec.info(defaults.get(spec.name))).collect()
    }
}

/// Declares a method's settings: `struct NAME of METHOD { /// HELP FIELD: TYPE = DEFAULT, LIMITS...; }`. The limits
/// are the builders of [`SettingSpec`]. Hooks of [`Settings`] may follow the struct.
#[macro_export]
macro_rules! declare_settings {
    (
        $(#[$docs:meta])*
        pub struct $settings:ident of $method:literal {
            $($(#[doc = $help:literal])+ $field:ident: $type:ty = $default:expr $(, $limit:ident($($bound:expr),*))*;)+
        }
        $($hooks:tt)*
    ) => {
        $(#[$docs])*
        #[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct $settings {
            $($(#[doc = $help])+ pub $field: $type,)+
        }

        impl Default for $settings {
            fn default() -> Self {
                Self { $($field: $default,)+ }
            }
        }

        impl $crate::method::Settings for $settings {
            const METHOD: &'static str = $method;
            const SCHEMA: &'static [$crate::method::SettingSpec] = &[$(
                $crate::method::SettingSpec::new(
                    stringify!($field),
                    concat!($($help),+),
                    <$type as $crate::method::SettingValue>::KIND,
                )$(.$limit($($bound),*))*,
            )+];
            $($hooks)*
        }
    };
}

/// Declares the values of a setting: `enum NAME { /// HELP VALUE = "NAME IN FILES", }`.
#[macro_export]
macro_rules! declare_choices {
    (
        $(#[$docs:meta])*
        pub enum $choices:ident {
            $($(#[doc = $help:literal])+ $value:ident = $name:literal,)+
        }
    ) => {
        $(#[$docs])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
        pub enum $choices {
            $($(#[doc = $help])+ #[serde(rename = $name)] $value,)+
        }

        impl $crate::method::SettingValue for $choices {
            const KIND: $crate::method::SettingKind = $crate::method::SettingKind::Choice(&[$(
                $crate::method::ChoiceSpec::new($name, concat!($($help),+)),
            )+]);
        }
    };
}

impl ChoiceSpec {
    /// A value; the help is a doc comment's text.
    pub const fn new(name: &'static str, help: &'static str) -> Self {
        Self { name, help: help.trim_ascii() }
    }
}
