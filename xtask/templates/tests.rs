//! Tests of the parts of `{{name}}`; its pictures are tested in `tests/{{family}}/{{name}}.rs`.

use super::*;

#[test]
fn without_settings_there_are_defaults() {
    let settings = {{type}}Settings::from_table(&toml::Table::new()).expect("defaults are allowed");
    assert_eq!(settings, {{type}}Settings::default());
}
