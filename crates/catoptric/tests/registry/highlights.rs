//! Where highlights lie (Popescu, Sacks, Mei 2006, figure 13), against the light's shortest paths.

use catoptric::methods::{self, Family};
use catoptric_testkit::highlights::Figure13;

#[test]
fn highlights_lie_where_each_surfaces_own_eye_vector_puts_them() {
    // A pixel is as large as in a picture of 680 rows: of the middle a part is seen.
    let figure = Figure13::new(48, [480, 320], 16.0);
    let expected = figure.expected();
    let wrong = figure.with_wrong_eye_vector();
    assert!(wrong.distance(expected.on_reflection) > 10.0, "{wrong} and {expected:?}");
    for method in [
        "reference",
        "auto",
        "multiperspective",
        "path_perturbation",
        "sample_based_camera",
        "explosion_map",
        "reflector_search",
        "environment_map",
        "light_field",
        "layered_environment_map",
    ] {
        let info = methods::find(method).expect("it is a method");
        // Look-ups show the ball, and its highlight, elsewhere in the mirror: their captures may be coarse.
        let is_look_up = info.family == Family::Lookup;
        let (_, found) = figure.drawn(method, if is_look_up { info.limits.settings } else { "" }, 4);
        let mut all = vec![("ball", found.on_ball, expected.on_ball), ("mirror", found.on_mirror, expected.on_mirror)];
        if !is_look_up {
            all.push(("reflection", found.on_reflection, expected.on_reflection));
        }
        for (name, found, expected) in all {
            assert!(found.distance(expected) < 1.0, "{method}, on the {name}: {found} for {expected}");
        }
    }
}
