//! Rules by name.

use catoptric_core::scene::roles::RoleRule;
use catoptric_core::scene::{Material, Role};

#[test]
fn names_globs_and_indices_of_refraction() {
    let rule = RoleRule::parse_lens("Glass*:1.7").unwrap();
    assert!(rule.matches("GlassBall", "") && rule.matches("", "Glass") && !rule.matches("Ball", ""));
    assert_eq!(rule.apply(&Material::default()).ior, 1.7);
    let all = RoleRule::new("*", Role::Reflector, None).unwrap();
    assert!(all.matches("", "") && all.matches("", "Glass") && !rule.matches("", ""));
    let literal = RoleRule::new("a[1", Role::Reflector, None).unwrap();
    assert!(literal.matches("a[1", ""));
    assert!(RoleRule::parse_lens("x:99").is_err());
    assert_eq!(RoleRule::parse_lens("na:me").unwrap().pattern(), "na:me");
}
