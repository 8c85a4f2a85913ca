//! Bounds of depths.

use catoptric_core::math::lanes::Vec3Lanes;
use catoptric_core::math::random::Stream;
use catoptric_lookup::parts::{Depth, DepthBounds, Depths, TexelLayout};
use glam::Vec3;

#[test]
fn bounds_hold_all_that_straight_ways_pass() {
    let mut random = Stream::new(11);
    for size in [8, 64, 256] {
        let layout = TexelLayout::cube(size);
        // A few things before nothing.
        let things: Vec<(Vec3, f32)> = (0..12)
            .map(|_| {
                let middle = Vec3::from([0; 3].map(|_| random.next_between(-1.0, 1.0)));
                (middle.normalize(), random.next_between(0.3, 1.2))
            })
            .collect();
        let texel = |texel: u32| {
            let direction = layout.middle_of(texel).normalize();
            let shown = things.iter().find(|(middle, _)| middle.dot(direction) > 0.97);
            shown.map_or(Depth::NOTHING, |(_, share)| Depth { front: *share, back: 1.1 * share })
        };
        let depths = Depths::new((0..6 * size * size).map(texel));
        let bounds = DepthBounds::new(&layout, &depths);
        let (mut known, mut nothing, mut narrower) = (0, 0, 0);
        for _ in 0..400 {
            let mut vector = |size: f32| Vec3::from([0; 3].map(|_| random.next_between(-size, size)));
            // Four ways side by side, one of which is not wanted.
            let (start, end) = (vector(1.0), vector(1.0));
            let start = [0.1, 0.1, 0.1, 2.0].map(|aside| start + vector(aside));
            let end = [0.1, 0.1, 0.1, 2.0].map(|aside| end + vector(aside));
            let wanted = [true, true, true, false];
            let in_texels = |places: &Vec3Lanes<4>| layout.in_texels(places);
            let in_one = |place: &Vec3Lanes<1>| layout.in_texels(place);
            let ends = [&in_texels(&Vec3Lanes::new(&start)), &in_texels(&Vec3Lanes::new(&end))];
            let ranges = bounds.between(ends, &wanted);
            let is_nothing = bounds.is_nothing_between(ends, &wanted);
            nothing += u32::from(is_nothing);
            for (lane, (start, end)) in start.into_iter().zip(end).enumerate().take(3) {
                let range = ranges[lane];
                known += u32::from(range.most < f32::INFINITY);
                narrower += u32::from(range.least > 0.35 && range.most < 1.1);
                let alone = [start, end].map(|place| in_one(&Vec3Lanes::new(&[place])));
                let [range_alone] = bounds.between([&alone[0], &alone[1]], &[true]);
                assert_eq!(range, range_alone, "a lane's bounds are its own");
                for step in 0..=100 {
                    let place = start.lerp(end, step as f32 / 100.0);
                    let [texel] = layout.nearest(&Vec3Lanes::new(&[place]));
                    let word = depths.word(texel);
                    let (front, back) = (depths.front(word), depths.back(word));
                    let holds = range.least <= front && back <= range.most && !is_nothing;
                    assert!(front == f32::INFINITY || holds, "{place}: {front} to {back} in {range:?}");
                }
            }
        }
        assert!(known > 20 && nothing > 2 && narrower > 2, "{size}: {known}, {nothing}, {narrower}");
    }
}
