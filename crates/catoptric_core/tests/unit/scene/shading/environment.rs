//! Light from infinity.

use catoptric_core::math::portable::PortableMath;
use catoptric_core::math::random::Stream;
use catoptric_core::scene::Environment;
use glam::{Vec2, Vec3};

#[test]
fn a_uniform_sky_gives_pi_times_its_radiance() {
    let sky = Environment::new("white", 64, 32, vec![[1.0; 3]; 64 * 32]);
    for normal in [Vec3::X, Vec3::Y, Vec3::NEG_Z, Vec3::ONE.normalize()] {
        assert!((sky.irradiance(normal).x - std::f32::consts::PI).abs() < 0.01);
        assert_eq!(sky.radiance(normal), Vec3::ONE);
    }
}

#[test]
fn level_floors_under_a_low_sun_look_alike_from_all_sides() {
    // A sun of a few degrees at a height of 20 degrees: the irradiance of a level floor is its energy times sin 20.
    let (width, height) = (256u32, 128u32);
    for column in [128u32, 200, 64, 0, 30] {
        let row = (70.0 / 180.0 * height as f32) as u32;
        let mut radiance = vec![[0.0; 3]; (width * height) as usize];
        radiance[(row * width + column) as usize] = [1e5; 3];
        let sky = Environment::new("sun", width, height, radiance);
        let polar = |edge: u32| (edge as f32 / height as f32 * std::f32::consts::PI).cos();
        let energy = 1e5 * std::f32::consts::TAU / width as f32 * (polar(row) - polar(row + 1));
        let towards = Environment::direction((column as f32 + 0.5) / width as f32, (row as f32 + 0.5) / height as f32);
        let found = sky.irradiance(Vec3::Y).x;
        assert!((found / (energy * towards.y) - 1.0).abs() < 0.01, "{column}: {found} for {}", energy * towards.y);
    }
}

#[test]
fn angles_are_right_all_round() {
    for step in 0..10_000 {
        let angle = (step as f32 + 0.5) / 10_000.0 * std::f32::consts::TAU - std::f32::consts::PI;
        let position = Environment::position(Vec3::new(3.0 * angle.cos(), 0.0, 3.0 * angle.sin()));
        let found = (position.x - 0.5) * std::f32::consts::TAU;
        assert!((found - angle).abs() < 2e-6, "{found} for {angle}");
    }
    assert!(Environment::position(Vec3::ZERO).is_finite());
}

#[test]
fn positions_and_directions_are_inverse() {
    for (u, v) in [(0.5, 0.5), (0.75, 0.5), (0.1, 0.2), (0.99, 0.9)] {
        let position = Environment::position(Environment::direction(u, v));
        assert!((position - Vec2::new(u, v)).length() < 1e-5);
    }
    assert!((Environment::direction(0.5, 0.5) - Vec3::X).length() < 1e-6);
    assert!((Environment::direction(0.75, 0.5) - Vec3::Z).length() < 1e-6);
}

#[test]
fn means_over_pixels_are_those_of_many_directions() {
    // A picture of blocks of very different brightness, 4 x 4 texels each.
    let (width, height) = (256u32, 128u32);
    let texel = |index: u32| (index % width / 4 * 37 + index / width / 4 * 61) % 17;
    let radiance = (0..width * height).map(|index| [texel(index) as f32, 1.0, 0.0]).collect();
    let sky = Environment::new("blocks", width, height, radiance);
    let mut random = Stream::new(5);
    let mut worst = 0.0f32;
    for size_texels in [0.3, 1.0, 3.0, 12.0, 40.0] {
        let mut squares = 0.0;
        for _ in 0..200 {
            let mut number = || random.next_between(-1.0, 1.0);
            let direction = Vec3::new(number(), 0.7 * number(), number()).normalize_or(Vec3::X);
            let across = direction.any_orthonormal_vector();
            let size = size_texels * std::f32::consts::TAU / width as f32;
            let change = [across * size, direction.cross(across) * size * 0.7];
            let mut sum = Vec3::ZERO;
            for place in 0..1024 {
                let (x, y) = ((place % 32) as f32 / 32.0 - 0.484_375, (place / 32) as f32 / 32.0 - 0.484_375);
                sum += sky.radiance((direction + change[0] * x + change[1] * y).normalize());
            }
            let found = sky.radiance_over(direction, change);
            squares += (found.x - sum.x / 1024.0).powi(2);
            assert!((found.y - 1.0).abs() < 1e-4 && found.z == 0.0, "{found}");
        }
        worst = worst.max((squares / 200.0).sqrt());
    }
    // One direction alone is off by 4.9, the spread of the blocks, at the largest size.
    assert!(worst < 1.2, "{worst}");
    assert!(sky.radiance_over(Vec3::Y, [Vec3::NAN, Vec3::X]).is_finite());
    assert!(sky.radiance_over(Vec3::Y, [Vec3::splat(1e30), Vec3::X]).is_finite());
}

#[test]
fn broken_values_are_black_and_overflowed_ones_bright() {
    let sky = Environment::new("broken", 2, 1, vec![[f32::NAN, f32::INFINITY, -3.0]; 2]);
    assert_eq!(sky.radiance(Vec3::X), Vec3::new(0.0, 65504.0, 0.0));
    let values = [f32::NEG_INFINITY, -0.0, 0.5, 2e6].map(Environment::kept);
    assert_eq!(values, [0.0, 0.0, 0.5, 1e6]);
}

/// A turned environment shows towards a turned direction what it showed before: in all of its look-ups.
#[test]
fn a_turn_moves_light_counter_clockwise_seen_from_above() {
    let sunny = || {
        let (width, height) = (128usize, 64usize);
        let texel = |index: usize| {
            let (column, row) = (index % width, index / width);
            let is_sun = (40..43).contains(&column) && (20..23).contains(&row);
            if is_sun { [400.0, 300.0, 200.0] } else { [(column % 7) as f32, 1.0, (row % 5) as f32] }
        };
        Environment::new("sunny", width as u32, height as u32, (0..width * height).map(texel).collect())
    };
    let sky = sunny();
    // By 90 degrees +x comes to lie at -z.
    let quarter = sunny().turned(std::f64::consts::FRAC_PI_2);
    assert!((quarter.radiance(Vec3::NEG_Z) - sky.radiance(Vec3::X)).length() < 1e-3);
    for degrees in [0.7f64, 33.0, 181.3, 359.9999, -20.0, 725.0] {
        let turned = sunny().turned(degrees.to_radians());
        let about_y = glam::Quat::from_rotation_y(degrees.to_radians() as f32);
        for towards in [Vec3::X, Vec3::new(0.3, 0.5, -0.8), Vec3::new(-0.6, -0.2, 0.1), Vec3::new(0.01, 0.9, 0.02)] {
            let towards = towards.normalize();
            let there = about_y * towards;
            let pairs = [
                (sky.radiance(towards), turned.radiance(there)),
                (sky.irradiance(towards), turned.irradiance(there)),
                (sky.glossy(towards, 0.2), turned.glossy(there, 0.2)),
                (sky.radiance_within(towards, 0.3), turned.radiance_within(there, 0.3)),
            ];
            for (before, after) in pairs {
                assert!((before - after).length() < 2e-3 * (1.0 + before.length()), "{degrees}: {before} {after}");
            }
        }
        let [before, after] = [&sky, &turned].map(|sky| sky.lamps().expect("the sun").all()[0].towards);
        assert!((about_y * before - after).length() < 1e-5);
    }
    let both = sunny().turned(1.0).turned(-1.0);
    assert_eq!(both.turn(), 0.0);
}

#[test]
fn a_factor_scales_all_light() {
    let sky = || Environment::new("sky", 64, 32, (0..64 * 32).map(|index| [(index % 9) as f32, 1.0, 0.5]).collect());
    let (before, after) = (sky(), sky().scaled(2.5));
    let towards = Vec3::new(0.3, 0.5, -0.8).normalize();
    for (before, after) in [
        (before.radiance(towards), after.radiance(towards)),
        (before.irradiance(towards), after.irradiance(towards)),
        (before.glossy(towards, 0.5), after.glossy(towards, 0.5)),
        (before.radiance_within(towards, 0.5), after.radiance_within(towards, 0.5)),
    ] {
        assert!((before * 2.5 - after).length() < 1e-5 * after.length(), "{before} {after}");
    }
    assert_eq!(sky().scaled(0.0).irradiance(towards), Vec3::ZERO);
}

/// Lamps have the light that the rest lacks: a surface is lit by both as by the whole.
#[test]
fn lamps_and_the_rest_are_all_light() {
    let (width, height) = (128usize, 64usize);
    let radiance: Vec<[f32; 3]> = (0..width * height)
        .map(|index| {
            if (30..34).contains(&(index % width)) && (10..14).contains(&(index / width)) {
                [300.0, 200.0, 100.0]
            } else {
                [0.5; 3]
            }
        })
        .collect();
    let environment = Environment::new("lit", width as u32, height as u32, radiance);
    let lamps = environment.lamps().expect("a lamp");
    let towards = Environment::direction(32.0 / width as f32, 12.0 / height as f32);
    assert!(lamps.all().iter().all(|lamp| lamp.towards.dot(towards) > 0.99));
    let irradiance: Vec3 = lamps.all().iter().map(|lamp| lamp.light * lamp.towards.dot(towards)).sum();
    let mut of_rest = Vec3::ZERO;
    for row in 0..height {
        for column in 0..width {
            let [u, v] = [(column as f32 + 0.5) / width as f32, (row as f32 + 0.5) / height as f32];
            let direction = Environment::direction(u, v);
            let area = std::f32::consts::TAU / width as f32 * std::f32::consts::PI / height as f32;
            let solid_angle = area * (v * std::f32::consts::PI).sine();
            let rest = environment.radiance_within_beside(lamps, direction, 0.0, 0.0);
            of_rest += rest * (direction.dot(towards).max(0.0) * solid_angle);
        }
    }
    let all = environment.irradiance(towards);
    assert!((irradiance + of_rest - all).length() < 0.02 * all.length(), "{irradiance} + {of_rest}, {all}");
    assert!(irradiance.length() > 0.5 * all.length());
    assert!(Environment::new("even", 64, 32, vec![[2.0; 3]; 64 * 32]).lamps().is_none());
}
