//! Depths as they are kept.

use catoptric_core::math::random::Stream;
use catoptric_lookup::parts::{Depth, Depths};

#[test]
fn depths_are_kept_to_a_few_digits() {
    let mut random = Stream::new(6);
    for (least, most, error) in [(0.4f32, 1.1, 2e-5), (0.01, 2.5, 6.2e-5), (1e-6, 1e3, 5e-4), (1.0, 1.0, 0.0)] {
        let mut share = || least * (most / least).powf(random.next_unit());
        let mut depths: Vec<Depth> = (0..500).map(|_| Depth { front: share(), back: share() }).collect();
        depths.extend([Depth { front: least, back: least }, Depth { front: most, back: most }, Depth::NOTHING]);
        depths.push(Depth { front: 0.5 * (least + most), back: f32::INFINITY });
        let kept = Depths::new(depths.iter().copied());
        for (number, (found, depth)) in kept.iter().zip(&depths).enumerate() {
            let is_near = |found: f32, share: f32| found == share || (found - share).abs() <= error * share;
            assert!(is_near(found.front, depth.front) && is_near(found.back, depth.back), "{depth:?}: {found:?}");
            assert_eq!(found.front == found.back, depth.front == depth.back);
            let word = kept.word(number as u32);
            assert_eq!((kept.front(word), kept.back(word)), (found.front, found.back));
        }
        let beyond = kept.word(depths.len() as u32);
        assert_eq!((kept.front(beyond), kept.back(beyond)), (f32::INFINITY, f32::INFINITY));
        assert_eq!(kept.words_of_two(depths.len() as u32 - 1), [beyond; 2], "not both are there");
    }
    let nothing = Depths::new([Depth::NOTHING; 3].into_iter());
    assert!(nothing.iter().all(|depth| depth == Depth::NOTHING));
}
