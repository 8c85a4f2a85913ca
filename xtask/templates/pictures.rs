//! {{title}} against the reference.

use catoptric::methods::Quality;
use catoptric_engine::method::Settings as _;
use catoptric_{{family}}::{{name}}::{{type}}Settings;
use catoptric_testkit::drawing::{error, scene};

#[test]
fn a_ball_in_a_room_is_near_the_reference() {
    let scene = scene("sphere_room?tess=24");
    let error = error("{{name}}", "", &scene, &scene.default_view(120, 90), Quality { samples: 1, order: 1 });
    assert!(error.over_0_1 < 0.1, "fill in {{name}}/{{role}}.rs: {error:?}");
}

#[test]
fn without_settings_there_are_defaults() {
    let settings = {{type}}Settings::from_table(&toml::Table::new()).expect("defaults are allowed");
    assert_eq!(settings, {{type}}Settings::default());
}
