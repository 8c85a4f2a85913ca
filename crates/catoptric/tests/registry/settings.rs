//! The declarations of the methods' settings: what is made of them, and what they refuse.

use catoptric::methods::{self, MethodInfo, Quality, SettingInfo};
use catoptric_testkit::Session;
use catoptric_testkit::drawing;
use catoptric_testkit::readme::readmes;
use catoptric_testkit::scenes::sphere_in_room;
use toml::Value;

fn refusal(info: &MethodInfo, name: &str, value: impl Into<Value>) -> Option<String> {
    let table = [(name.to_owned(), value.into())].into_iter().collect();
    methods::create(info.id, &table).err().map(|error| error.to_string())
}

fn value(setting: &SettingInfo) -> Value {
    let table: toml::Table = toml::from_str(&format!("value = {}", setting.default)).expect("defaults are TOML");
    table["value"].clone()
}

#[test]
fn tables_in_readmes_are_current() {
    for readme in readmes().expect("READMEs are there") {
        let path = readme.path.display();
        assert!(readme.text == readme.current, "{path} is not current: run `cargo figures settings` and commit it");
    }
}

#[test]
fn defaults_are_allowed_and_written_with_few_digits() {
    for info in methods::all() {
        for setting in (info.settings)() {
            let name = format!("{}.{}", info.id, setting.name);
            assert_eq!(refusal(info, setting.name, value(&setting)), None, "{name}");
            assert!(setting.default.len() < 16 && setting.help.ends_with('.'), "{name} = {}", setting.default);
        }
    }
}

#[test]
fn values_outside_the_limits_are_refused_with_what_is_allowed() {
    for info in methods::all() {
        for setting in (info.settings)() {
            let name = format!("{}.{}", info.id, setting.name);
            match (setting.kind, setting.range) {
                ("choice", _) => {
                    let message = refusal(info, setting.name, "no such choice").expect(&name);
                    assert!(setting.choices.iter().all(|choice| message.contains(choice.name)), "{message}");
                }
                ("whole", Some([least, most])) => {
                    for wrong in [least as i64 - 1, most as i64 + 1] {
                        let message = refusal(info, setting.name, wrong).expect(&name);
                        let is_named = message.contains(setting.name) && message.contains(&most.to_string());
                        assert!(is_named || wrong < 0, "{message}");
                    }
                }
                ("number", range) => {
                    let [least, most] = range.unwrap_or([0.0, f64::INFINITY]);
                    for wrong in [least - 0.01, 2.0 * most, f64::NAN] {
                        let message = refusal(info, setting.name, wrong).expect(&name);
                        assert!(message.contains(setting.name) && message.contains(&least.to_string()), "{message}");
                    }
                }
                ("vector", _) => {
                    let wrong = vec![Value::from(0.0), Value::from(f64::INFINITY), Value::from(0.0)];
                    assert!(refusal(info, setting.name, wrong).expect(&name).contains("must be finite"));
                }
                _ => assert!(refusal(info, setting.name, Value::Array(Vec::new())).is_some(), "{name}"),
            }
        }
    }
}

#[test]
fn choices_and_the_ends_of_ranges_are_allowed() {
    for info in methods::all() {
        for setting in (info.settings)() {
            let name = format!("{}.{}", info.id, setting.name);
            for choice in setting.choices {
                assert_eq!(refusal(info, setting.name, choice.name), None, "{name}");
            }
            for end in setting.range.into_iter().flatten() {
                let end = if setting.kind == "whole" { Value::from(end as i64) } else { Value::from(end) };
                let refused = refusal(info, setting.name, end);
                // The finest spacing may not be above the spacing.
                assert!(
                    refused.is_none() || refused.is_some_and(|message| message.contains("is larger than")),
                    "{name}"
                );
            }
        }
    }
}

#[test]
fn presets_lead_to_their_values_and_given_ones_stay() {
    for (id, preset, name, value) in [
        ("sample_based_camera", "faithful", "camera", "pinhole"),
        ("explosion_map", "faithful", "virtual_vertex", "mirrored"),
        ("light_field", "faithful", "transfer", "first"),
        ("path_perturbation", "faithful", "candidates", "nearest"),
        ("reflector_search", "faithful", "search", "maximum"),
        ("layered_environment_map", "faithful", "textures", "inferred"),
    ] {
        let info = methods::find(id).expect("it is registered");
        assert!((info.settings)().iter().any(|setting| setting.name == "preset"), "{id} hides its preset");
        let all = |text: &str| (info.effective)(&toml::from_str(text).expect("valid")).expect("allowed");
        assert_eq!(all(&format!("preset = '{preset}'"))[name].as_str(), Some(value));
        let before = all("")[name].as_str().expect("a choice").to_owned();
        assert_eq!(all(&format!("preset = '{preset}'\n{name} = '{before}'"))[name].as_str(), Some(&*before));
    }
}

#[test]
fn settings_that_do_not_exist_are_named() {
    let scene = sphere_in_room(true);
    for info in methods::all() {
        let session = Session::new(info.id, "no_such_setting = 1", &scene, Quality { samples: 1, order: 1 });
        let message = drawing::refusal(session);
        assert!(message.contains("no_such_setting") && message.contains(info.id), "{message}");
        for setting in (info.settings)() {
            assert!(message.contains(setting.name), "{message}");
        }
    }
    assert!(methods::find("nothing").unwrap_err().to_string().contains("reference"));
}
