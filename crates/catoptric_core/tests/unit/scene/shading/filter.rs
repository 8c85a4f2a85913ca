//! Look-ups in textures, several at a time.

use catoptric_core::math::lanes::Lanes;
use catoptric_core::math::random::Stream;
use catoptric_core::scene::{
    MipFilter, Sampler, Texture, TextureLookUps, UvFootprint, Wrap, floor, index, log2, sample,
};
use glam::{Vec2, Vec4};

#[test]
fn logarithms_and_floors_are_right() {
    let mut random = Stream::new(3);
    for _ in 0..10_000 {
        let value = 2.0f32.powf(random.next_between(-60.0, 60.0));
        assert!((log2(value) - value.log2()).abs() < 1e-6 * (1.0 + value.log2().abs()), "{value}");
        let value = random.next_between(-4e6, 4e6);
        assert_eq!(floor(value), value.floor());
        let near = (value.floor() / 1024.0).floor() + random.next_between(-1e-3, 1e-3);
        assert_eq!(floor(near), near.floor());
    }
    for whole in [0.0f32, 1.0, 4095.0, 100_000.0] {
        assert_eq!((index(whole), floor(whole), floor(-whole)), (whole as u32, whole, -whole));
    }
}

#[test]
fn lanes_do_not_influence_each_other() {
    let mut random = Stream::new(4);
    let wraps = [Wrap::ClampToEdge, Wrap::Repeat, Wrap::MirroredRepeat];
    let mips = [MipFilter::None, MipFilter::Nearest, MipFilter::Linear];
    let textures: Vec<Texture> = (0..18u32)
        .map(|number| {
            let sampler = Sampler {
                wrap_u: wraps[number as usize % 3],
                wrap_v: wraps[number as usize / 3 % 3],
                magnify_linear: number % 2 == 0,
                minify_linear: number % 5 != 0,
                mip_filter: mips[number as usize % 7 % 3],
            };
            let (width, height) = (1 + number * 3 % 16, 1 + number * 7 % 11);
            let texels = (0..width * height).map(|i| [(i * 7919 % 65_536) as u16, i as u16 * 99, 65_535, 0]);
            Texture::from_linear16("", width, height, texels.collect(), sampler)
        })
        .collect();
    for round in 0..2000 {
        let scale = [0.3, 3.0, 1e5, 1e12][round % 4];
        let mut vector = |scale: f32| Vec2::new(random.next_between(-scale, scale), random.next_between(-scale, scale));
        let places: [(Vec2, UvFootprint); 8] = std::array::from_fn(|lane| {
            let size = [0.0, 0.01, 0.4, 30.0][(round + lane) / 4 % 4];
            (vector(scale), UvFootprint { dx: vector(size), dy: vector(size), samples: 1 << ((round + lane) % 5) })
        });
        let texture = &textures[round % 18];
        let lanes = |value: &dyn Fn(&(Vec2, UvFootprint)) -> Vec2| {
            [0, 1].map(|axis| Lanes(std::array::from_fn(|i| value(&places[i])[axis])))
        };
        let samples = places.each_ref().map(|place| place.1.samples);
        let at = TextureLookUps { uv: lanes(&|p| p.0), dx: lanes(&|p| p.1.dx), dy: lanes(&|p| p.1.dy), samples };
        let mut together = [Vec4::ZERO; 8];
        sample(texture, &at, 8, &mut together);
        for lane in 0..8 {
            let alone = texture.sample(places[lane].0, &places[lane].1);
            assert_eq!(together[lane], alone);
            assert!(alone.min_element() >= 0.0 && alone.max_element() <= 1.0 + 1e-6, "{alone}");
        }
    }
}

#[test]
fn mirrors_and_clamps_continue_at_the_edges() {
    let texels: Vec<[u16; 4]> = (0..4).map(|i| [i * 20_000; 4]).collect();
    let with = |wrap_u| {
        let sampler = Sampler { wrap_u, ..Sampler::default() };
        Texture::from_linear16("", 4, 1, texels.clone(), sampler)
    };
    let still = UvFootprint::default();
    let value = |wrap, u: f32| with(wrap).sample(Vec2::new(u, 0.5), &still).x * 65535.0;
    let near = |a: f32, b: f32| assert!((a - b).abs() < 1.0, "{a} against {b}");
    near(value(Wrap::MirroredRepeat, 1.125), 60_000.0);
    near(value(Wrap::MirroredRepeat, 1.0), 60_000.0);
    near(value(Wrap::MirroredRepeat, -0.375), 20_000.0);
    near(value(Wrap::MirroredRepeat, 2.25), 10_000.0);
    near(value(Wrap::ClampToEdge, 7.0), 60_000.0);
    near(value(Wrap::ClampToEdge, -7.0), 0.0);
    near(value(Wrap::Repeat, 0.0), 30_000.0);
    near(value(Wrap::Repeat, 1.0), 30_000.0);
    near(value(Wrap::Repeat, -0.25), 50_000.0);
}
