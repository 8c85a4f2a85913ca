//! Texels as they are kept.

use catoptric_core::math::random::Stream;
use catoptric_lookup::parts::{LARGEST, MAX_PARALLAX, ViewLevels, packed, restored, stored, unpacked};
use glam::Vec3;

#[test]
fn packed_radiance_is_off_by_a_half_of_the_last_bit() {
    let mut random = Stream::new(4);
    for case in 0..100_000 {
        let size = 2.0f32.powf(random.next_between(-12.0, 15.9));
        let mut radiance = Vec3::from([0; 3].map(|_| random.next_unit())) * size;
        if case % 7 == 0 {
            radiance.y = radiance.x;
        }
        let found = unpacked(packed(radiance));
        let limit = (radiance.max_element() * (0.5 / 256.0)).max(0.5f32.powi(25)) * 1.00001;
        assert!((found - radiance).abs().max_element() <= limit, "{radiance} became {found}");
    }
}

#[test]
fn what_cannot_be_stored_becomes_what_can() {
    assert_eq!(unpacked(packed(Vec3::ZERO)), Vec3::ZERO);
    assert_eq!(unpacked(packed(Vec3::NAN)), Vec3::ZERO);
    assert_eq!(unpacked(packed(Vec3::new(-1.0, f32::INFINITY, 0.0))), Vec3::new(0.0, LARGEST, 0.0));
    assert_eq!(unpacked(packed(Vec3::ONE)), Vec3::ONE);
    assert!(unpacked(packed(Vec3::splat(1e-9))).length() < 1e-4);
    assert!(unpacked(packed(Vec3::splat(511.9))).distance(Vec3::splat(512.0)) < 1.0);
}

#[test]
fn coarser_levels_hold_the_mean() {
    let levels = ViewLevels::new(8);
    assert_eq!(levels.levels, [(0, 8), (64, 4), (80, 2), (84, 1)]);
    let mut view: Vec<u32> = (0..64).map(|k| packed(Vec3::splat(k as f32))).collect();
    levels.append(&mut view);
    assert_eq!(view.len(), levels.count as usize);
    assert!((unpacked(view[84]).x - 31.5).abs() < 0.1);
    assert_eq!(ViewLevels::new(5).levels, [(0, 5), (25, 2), (29, 1)]);
}

#[test]
fn parallax_is_kept_to_a_ten_thousandth() {
    for parallax in [0.0, 0.1, -1.3, 1.99] {
        assert!((restored(stored(parallax)) - parallax).abs() < 1e-4);
    }
    assert_eq!(restored(stored(9.0)), MAX_PARALLAX);
    assert_eq!(restored(stored(f32::NAN)), 0.0);
    assert!(restored(stored(f32::NEG_INFINITY)) < -1.99);
}
