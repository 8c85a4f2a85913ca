//! Messages about wrong usage.

use crate::workplace::Workplace;

#[test]
fn samples_that_a_method_cannot_take_are_wrong_usage() {
    let place = Workplace::new();
    let render = ["render", "scene.toml", "-o", "out.png", "--samples", "3", "--size", "8x8"];
    let message = place.fails(2, &[&render[..], &["--method", "environment_map"]].concat());
    assert!(message.contains("--samples 3") && message.contains("1, 2, 4, 8, 16"), "{message}");
    let message = place.fails(2, &["compare", "scene.toml", "--report", "report", "--samples", "3"]);
    assert!(message.contains("--samples 3"), "{message}");
    assert_eq!(place.files(), ["scene.toml"]);
    place.ok(&render);
}
