//! The compared methods and their settings.

use crate::failure::Failure;
use crate::settings;
use catoptric::error::did_you_mean;
use catoptric::methods::{self, MethodInfo};
use toml::Table;

/// The id of our own reference.
pub(super) const REFERENCE: &str = "reference";

/// A method to be compared.
#[derive(Debug)]
pub(super) struct Selected {
    pub(super) id: String,
    /// As it was given: `ID` or `ID:KEY=VALUE,...`.
    pub(super) label: String,
    /// The part after the colon.
    pub(super) variant: Option<String>,
    pub(super) settings: Table,
}

/// The longest name of a picture before its number and extension.
const MOST_STEM: usize = 100;

/// The selection of a comparison.
#[derive(Debug)]
pub(super) struct Selection {
    /// Settings of the reference that all are measured against.
    pub(super) truth: Table,
    pub(super) methods: Vec<Selected>,
}

impl Selected {
    /// A file name that names the method.
    pub(super) fn file_stem(&self) -> String {
        let safe = |c: char| if c.is_ascii_alphanumeric() || "._-".contains(c) { c } else { '-' };
        // File systems have names of 255 bytes.
        self.label.chars().map(safe).take(MOST_STEM).collect()
    }
}

/// Reads `--method` and `--set`; without methods all are taken. With another's picture to measure against our own
/// reference is a method like others, and only there if it is wanted.
pub(super) fn select(wanted: &[String], set: &[(String, String)], is_own: bool) -> Result<Selection, Failure> {
    let mut chosen = Vec::new();
    for label in wanted {
        let (id, variant) = match label.split_once(':') {
            Some((id, variant)) => (id, Some(variant.to_owned())),
            None => (label.as_str(), None),
        };
        chosen.push((methods::find(id).map_err(Failure::usage)?, label.clone(), variant));
    }
    if wanted.is_empty() {
        let all = methods::all().iter().filter(|info| is_own || info.id != REFERENCE);
        chosen = all.map(|info| (*info, info.id.to_owned(), None)).collect();
    }
    let mut used = vec![false; set.len()];
    let truth = match is_own {
        true => settings_for(methods::find(REFERENCE).map_err(Failure::usage)?, set, &mut used),
        false => Table::new(),
    };
    let mut selected = Vec::new();
    for (info, label, variant) in chosen {
        let mut settings = settings_for(info, set, &mut used);
        settings.extend(settings::of_variant(&label, variant.as_deref())?);
        selected.push(Selected { id: info.id.into(), label, variant, settings });
    }
    if let Some(index) = used.iter().position(|used| !used) {
        let (key, _) = &set[index];
        return Err(Failure::usage(format!("--set {key}: {}", known(key, &selected))));
    }
    Ok(Selection { truth, methods: selected })
}

/// The settings for this method, among those given; marks these as used.
fn settings_for(info: &MethodInfo, set: &[(String, String)], used: &mut [bool]) -> Table {
    let names: Vec<&str> = (info.settings)().into_iter().map(|setting| setting.name).collect();
    let mut table = Table::new();
    for ((key, text), used) in set.iter().zip(used) {
        let name = match key.split_once('.') {
            // An unknown name is kept: the method's own message lists the names that it has.
            Some((id, name)) if id == info.id => name,
            None if names.contains(&key.as_str()) => key,
            _ => continue,
        };
        table.insert(name.into(), settings::value(text));
        *used = true;
    }
    table
}

fn known(key: &str, selected: &[Selected]) -> String {
    let ids: Vec<&str> = selected.iter().map(|method| method.id.as_str()).collect();
    match key.split_once('.') {
        Some((id, _)) if methods::find(id).is_ok() => format!("method `{id}` is not compared"),
        Some((id, _)) => {
            let hint = did_you_mean(id, ids.iter().copied());
            format!("there is no method `{id}`{hint}; those compared are: {}", ids.join(", "))
        }
        None => {
            let mut names: Vec<String> = Vec::new();
            for info in ids.iter().filter_map(|id| methods::find(id).ok()) {
                names.extend((info.settings)().into_iter().map(|setting| format!("{}.{}", info.id, setting.name)));
            }
            names.dedup();
            let settings = names.iter().filter_map(|name| name.split_once('.'));
            let hint = did_you_mean(key, settings.map(|(_, setting)| setting));
            format!("none of the methods compared has this setting{hint}; there are: {}", names.join(", "))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(pairs: &[(&str, &str)]) -> Vec<(String, String)> {
        pairs.iter().map(|(key, value)| ((*key).into(), (*value).into())).collect()
    }

    fn problem(result: Result<Selection, Failure>) -> String {
        match result {
            Err(Failure::Usage(problem)) => problem,
            Err(Failure::Input(error)) => panic!("not a usage error: {error}"),
            Ok(selection) => panic!("accepted: {selection:?}"),
        }
    }

    #[test]
    fn all_methods_by_default_the_reference_first() {
        let Ok(selection) = select(&[], &[], true) else { panic!("refused") };
        assert_eq!(selection.methods.len(), methods::all().len());
        assert_eq!(selection.methods[0].id, "reference");
        let Ok(selection) = select(&[], &[], false) else { panic!("refused") };
        assert_eq!(selection.methods.len(), methods::all().len() - 1);
        assert!(selection.methods.iter().all(|method| method.id != "reference"));
    }

    #[test]
    fn settings_go_to_the_methods_that_have_them() {
        let wanted = ["reference".to_owned(), "reference:seed=7,paths=two_path".to_owned()];
        let Ok(selection) = select(&wanted, &set(&[("seed", "5"), ("reference.samples", "random")]), true) else {
            panic!("refused")
        };
        assert_eq!(selection.truth["seed"], toml::Value::Integer(5));
        assert_eq!(selection.methods[0].settings["samples"], toml::Value::String("random".into()));
        assert_eq!(selection.methods[1].settings["seed"], toml::Value::Integer(7));
        assert_eq!(selection.methods[1].file_stem(), "reference-seed-7-paths-two_path");
    }

    #[test]
    fn what_no_method_has_is_refused() {
        assert!(problem(select(&[], &set(&[("no_such", "1")]), true)).contains("reference.seed"));
        assert!(problem(select(&[], &set(&[("nobody.seed", "1")]), true)).contains("nobody"));
        assert!(problem(select(&["nobody".into()], &[], true)).contains("reference"));
        assert!(problem(select(&["reference:seed".into()], &[], true)).contains("KEY=VALUE"));
        assert!(problem(select(&[], &set(&[("reference.seed", "1")]), false)).contains("is not compared"));
    }
}
