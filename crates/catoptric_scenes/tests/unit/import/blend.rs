//! The keys of a mirror's blend.

use super::{reflector, wrong_key};
use catoptric_core::scene::{Attenuation, Model};

fn ball(lines: &str) -> Result<Model, String> {
    reflector("sphere", &format!("radius = 1\n{lines}"))
}

#[test]
fn keys_are_checked() {
    let blend = |lines: &str| ball(lines).unwrap().materials[0].blend;
    assert_eq!(blend("fresnel = [0.25, 0.5]").unwrap().fresnel, Some([0.25, 0.5]));
    assert_eq!(blend(""), None);
    let found = blend("attenuation = { distance = 2, specularity = [0, 1] }").unwrap();
    assert_eq!(found.attenuation, Some(Attenuation { distance: 2.0, specularity: [0.0, 1.0] }));
    for (lines, key) in [
        ("fresnel = [0.5, 0.2]", "fresnel"),
        ("fresnel = [0.5, 1.2]", "fresnel"),
        ("diffuse = [0.5, 0.5, 0.5]", "diffuse"),
        ("fresnel = [0.25, 0.5]\ndiffuse = [-0.5, -0.5, -0.5]", "diffuse"),
        ("highlight_roughness = 0.0", "highlight_roughness"),
        ("attenuation = { specularity = [0, 1] }", "attenuation.distance"),
        ("attenuation = { distance = 0, specularity = [0, 1] }", "attenuation.distance"),
        ("attenuation = { distance = 1 }", "attenuation.specularity"),
        ("attenuation = { distance = 1, specularity = [-0.1, 1] }", "attenuation.specularity"),
    ] {
        assert_eq!(wrong_key(ball(lines)), key, "{lines}");
    }
}
