//! Light at a surface: Fresnel factors, directions and their changes, attenuation.

use catoptric_core::scene::{Attenuation, Blend, Material, Role};
use catoptric_engine::optics::path::bundle::BounceKind;
use catoptric_engine::optics::step::{
    Facing, LightStep, crossed_medium, fresnel_dielectric, fresnel_schlick, medium_after, reflect, refract,
    relative_index, transmittance,
};
use glam::{Vec3, Vec4Swizzles};

/// The unit direction that arrives at this angle on a surface whose outer normal is +y.
fn arriving(angle: f32) -> Vec3 {
    Vec3::new(angle.sin(), -angle.cos(), 0.0)
}

/// The step at a flat surface whose outer normal is +y.
fn step(material: &Material, direction: Vec3) -> LightStep {
    let facing = Facing::new(direction, Vec3::Y, Vec3::Y);
    let tint = if material.role == Role::Coated { Vec3::splat(material.coat) } else { material.base_color.xyz() };
    LightStep::new(material, tint, false, facing, direction)
}

#[test]
fn snell_and_reversibility() {
    for degrees in [0.0f32, 10.0, 35.0, 60.0, 85.0] {
        let angle = degrees.to_radians();
        let incoming = arriving(angle);
        let inside = refract(incoming, Vec3::Y, 1.0 / 1.5).unwrap();
        assert!((inside.x * 1.5 - angle.sin()).abs() < 1e-6);
        let back = refract(-inside, -Vec3::Y, 1.5).unwrap();
        assert!((back + incoming).length() < 1e-4, "{degrees}: {back} against {incoming}");
        let mirrored = reflect(incoming, Vec3::Y);
        assert_eq!((mirrored, reflect(incoming, -Vec3::Y)), (incoming * Vec3::new(1.0, -1.0, 1.0), mirrored));
    }
}

#[test]
fn total_internal_reflection_starts_at_the_critical_angle() {
    let critical = (1.0f32 / 1.5).asin();
    for (offset, reflected) in [(-1e-3, false), (1e-3, true)] {
        let angle = critical + offset;
        assert_eq!(refract(arriving(angle), Vec3::Y, 1.5).is_none(), reflected);
        assert_eq!(fresnel_dielectric(angle.cos(), 1.5) == 1.0, reflected);
        let step = step(&Material::glass("", 1.5), arriving(angle) * Vec3::new(1.0, -1.0, 1.0));
        assert_eq!(
            step.outgoing(BounceKind::Transmit, arriving(angle) * Vec3::new(1.0, -1.0, 1.0)).is_none(),
            reflected
        );
        assert_eq!(step.transmitted == Vec3::ZERO, reflected);
    }
}

#[test]
fn fresnel_at_normal_incidence_and_brewster() {
    assert!((fresnel_dielectric(1.0, 1.0 / 1.5) - 0.04).abs() < 1e-6);
    let brewster = 1.5f32.atan();
    // At Brewster's angle only the perpendicular part is reflected: ((n^2-1)/(n^2+1))^2 / 2.
    let expected = 0.5 * ((1.5f32 * 1.5 - 1.0) / (1.5 * 1.5 + 1.0)).powi(2);
    assert!((fresnel_dielectric(brewster.cos(), 1.0 / 1.5) - expected).abs() < 1e-6);
    assert_eq!(fresnel_dielectric(0.0, 1.0), 1.0);
    assert_eq!(fresnel_dielectric(0.5, 1.0), 0.0);
}

#[test]
fn schlick_goes_from_the_colour_to_white() {
    let gold = Vec3::new(1.0, 0.7, 0.3);
    assert_eq!((fresnel_schlick(gold, 1.0), fresnel_schlick(gold, 0.0)), (gold, Vec3::ONE));
    let expected = gold + (Vec3::ONE - gold) / 32.0;
    assert!((fresnel_schlick(gold, 0.5) - expected).abs().max_element() < 1e-6);
}

#[test]
fn attenuation_multiplies_over_distance() {
    let absorption = Vec3::new(0.1, 1.0, 3.0);
    let once = transmittance(absorption, 2.0);
    let twice = transmittance(absorption, 1.0) * transmittance(absorption, 1.0);
    assert!((once - twice).abs().max_element() < 1e-6);
    assert!((once.y - (-2.0f32).exp()).abs() < 1e-6);
    assert_eq!(transmittance(Vec3::ZERO, f32::INFINITY), Vec3::ONE);
}

#[test]
fn no_step_makes_light() {
    let coated = Material { role: Role::Coated, coat: 0.7, ..Material::default() };
    let schlick = Material { schlick: true, ..Material::mirror("", Vec3::new(0.9, 0.5, 0.1)) };
    for degrees in (0..180).filter(|&degrees| degrees != 90) {
        let direction = arriving((degrees as f32).to_radians());
        let glass = step(&Material::glass("", 1.5), direction);
        // A surface of clear glass keeps all.
        assert!((glass.reflected + glass.transmitted - 1.0).abs().max_element() < 1e-6 && glass.scattered == 0.0);
        let coat = step(&coated, direction);
        assert!((coat.reflected.x + coat.scattered - 1.0).abs() < 1e-6 && coat.transmitted == Vec3::ZERO);
        let metal = step(&schlick, direction);
        assert!(metal.reflected.max_element() <= 1.0 && metal.reflected.min_element() >= 0.1 && metal.scattered == 0.0);
        assert_eq!(step(&Material::diffuse("", Vec3::ONE), direction).scattered, 1.0);
    }
    let direction = arriving(0.3);
    let facing = Facing::new(direction, Vec3::Y, Vec3::Y);
    let blind = LightStep::new(&Material::mirror("", Vec3::ONE), Vec3::ONE, true, facing, direction);
    assert_eq!((blind.reflected, blind.transmitted, blind.scattered), (Vec3::ZERO, Vec3::ZERO, 0.0));
}

#[test]
fn blended_mirrors_divide_light_by_angle_and_distance() {
    let attenuation = Attenuation { distance: 2.0, specularity: [0.25, 0.75] };
    let mut blend = Blend { fresnel: Some([0.2, 0.8]), attenuation: None, diffuse: None, highlight_roughness: None };
    let tint = Vec3::new(1.0, 0.5, 0.25);
    let direction = arriving(60.0f32.to_radians());
    let by_angle = 0.2 + 0.6 * 0.25;
    let plain = step(&Material { blend: Some(blend), schlick: true, ..Material::mirror("", tint) }, direction);
    assert!((plain.reflected - tint * by_angle).abs().max_element() < 1e-6);
    assert!((plain.scattered - (1.0 - by_angle)).abs() < 1e-6 && plain.deferred(Vec3::ONE).is_none());
    blend.attenuation = Some(attenuation);
    let fading = step(&Material { blend: Some(blend), ..Material::mirror("", tint) }, direction);
    assert_eq!(fading.reflected, plain.reflected);
    for (distance, weight) in [(0.0, 0.75), (1.0, 0.75 - 0.5 * 0.25), (f32::INFINITY, 0.25)] {
        let (own, factor) = fading.deferred(Vec3::splat(3.0)).unwrap().settled(distance);
        assert!((factor - weight).abs() < 1e-6 && (own - 3.0 * (1.0 - by_angle * weight)).abs().max_element() < 1e-6);
    }
    assert!((fading.scattered - (1.0 - by_angle * 0.25)).abs() < 1e-6);
}

#[test]
fn new_directions_stay_on_their_side_of_the_flat_surface() {
    for shading in [Vec3::Y, Vec3::new(0.7, 0.3, 0.1).normalize(), Vec3::new(-0.9, 0.1, 0.0).normalize()] {
        for degrees in (0..180).filter(|&degrees| degrees != 90) {
            let direction = arriving((degrees as f32).to_radians());
            let facing = Facing::new(direction, Vec3::Y, shading);
            assert_eq!((facing.outside, facing.sign()), (degrees < 90, if degrees < 90 { 1.0 } else { -1.0 }));
            assert!(direction.dot(facing.normal) < 0.0 && (facing.normal.length() - 1.0).abs() < 1e-5);
            let side = |kind| facing.outgoing(kind, direction, 1.0 / 1.5).map(|outgoing| outgoing.y * facing.sign());
            assert!(side(BounceKind::Reflect).unwrap() > 0.0 && side(BounceKind::Transmit).unwrap() < 0.0);
        }
    }
}

#[test]
fn media_follow_a_path_through_nested_lenses() {
    let (air, glass, water) = (1.0, 1.5, 1.33);
    let (reflect, transmit) = (BounceKind::Reflect, BounceKind::Transmit);
    let entered = medium_after(transmit, true, glass, crossed_medium(true, true, glass, air), air);
    assert_eq!(entered, glass);
    // A mirror in the glass, then the glass from inside, then out.
    assert_eq!(medium_after(reflect, true, air, crossed_medium(false, true, air, entered), air), glass);
    assert_eq!(medium_after(reflect, false, glass, crossed_medium(true, false, glass, entered), air), glass);
    assert_eq!(medium_after(transmit, false, glass, crossed_medium(true, false, glass, entered), air), air);
    // A lens within the glass: the medium about it is determined again at the glass itself.
    let within = medium_after(transmit, true, water, crossed_medium(true, true, water, entered), air);
    assert_eq!((within, medium_after(transmit, false, water, within, air)), (water, air));
    assert_eq!(crossed_medium(true, false, glass, air), glass);
    assert_eq!((relative_index(1.5, true), relative_index(1.5, false)), (1.0 / 1.5, 1.5));
}
