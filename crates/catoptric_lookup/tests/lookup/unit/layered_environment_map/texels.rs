//! Look-ups in layouts of texels.

use catoptric_core::math::lanes::Vec3Lanes;
use catoptric_core::math::random::Stream;
use catoptric_lookup::parts::{Footprints, LayerTexture, TexelLayout};
use glam::{Vec2, Vec3, Vec4};

/// The light of a texture at a place.
fn fetch(texture: &LayerTexture, place: Vec3, changes: [Vec3; 2]) -> Vec4 {
    let mut sum = Vec4::ZERO;
    let footprint = Footprints { places: Vec3Lanes::one(place), changes: changes.map(Vec3Lanes::one) };
    texture.layout.taps(&footprint, &[true], &mut |_, taps| sum += taps.sum(&texture.texels));
    sum
}

fn texture(layout: TexelLayout, value: impl Fn(Vec3) -> Vec4) -> LayerTexture {
    let side = layout.size;
    let mut texels = vec![Vec4::ZERO; layout.texel_count()];
    for face in 0..layout.faces {
        for (y, x) in (0..side).flat_map(|y| (0..side).map(move |x| (y, x))) {
            let at = (Vec2::new(x as f32, y as f32) + 0.5) * (2.0 / side as f32) - 1.0;
            texels[((face * side + y) * side + x) as usize] = value(layout.place_of(face, at));
        }
    }
    layout.fill_coarser(&mut texels);
    LayerTexture::new(layout, &texels)
}

#[test]
fn a_look_up_gives_what_is_there_also_across_edges() {
    let cube = texture(TexelLayout::cube(64), |direction| (direction.normalize() + 1.0).extend(0.5));
    let mut random = Stream::new(5);
    let mut number = || random.next_between(-1.0, 1.0);
    let mut directions: Vec<Vec3> = (0..2000).map(|_| Vec3::new(number(), number(), number()).normalize()).collect();
    directions.extend([Vec3::ONE.normalize(), Vec3::new(1.0, 1.0, 0.0).normalize()]);
    for direction in directions {
        let found = fetch(&cube, direction, [Vec3::ZERO; 2]);
        // The next texel of the other face stands in beyond an edge: off by less than a texel.
        assert!((found.truncate() - 1.0 - direction).length() < 0.02, "{direction}: {found}");
        assert!((found.w - 0.5).abs() < 1e-6);
    }
    let square = texture(TexelLayout::square(32), |place| Vec4::new(place.x, place.y, 1.0, 1.0));
    let found = fetch(&square, Vec3::new(0.3, -0.2, 0.0), [Vec3::ZERO; 2]);
    assert!((found - Vec4::new(0.3, -0.2, 1.0, 1.0)).length() < 1e-5, "{found}");
    assert_eq!(fetch(&square, Vec3::new(1.2, 0.0, 0.0), [Vec3::ZERO; 2]), Vec4::ZERO, "nothing is beyond a square");
    assert!(fetch(&square, Vec3::new(f32::INFINITY, f32::NAN, 0.0), [Vec3::ZERO; 2]).is_finite());
}

#[test]
fn weights_sum_to_one_and_wide_footprints_average() {
    let layout = TexelLayout::cube(16);
    for spread in [0.0, 0.1, 0.5, 3.0] {
        let mut sum = 0.0;
        let changes = [Vec3::Y * spread, Vec3::Z * (0.3 * spread)].map(Vec3Lanes::one);
        let footprint = Footprints { places: Vec3Lanes::one(Vec3::new(0.8, 0.6, 0.0)), changes };
        layout.taps(&footprint, &[true], &mut |_, taps| sum += taps.weights.iter().sum::<f32>());
        assert!((sum - 1.0).abs() < 1e-5, "{spread}: {sum}");
    }
    let cube = texture(TexelLayout::cube(64), |direction| direction.normalize().extend(1.0));
    let blurred = fetch(&cube, Vec3::X, [Vec3::Y * 3.0, Vec3::Z * 3.0]);
    assert!(blurred.x > 0.5 && blurred.y.abs() < 0.05 && blurred.z.abs() < 0.05, "{blurred}");
}
