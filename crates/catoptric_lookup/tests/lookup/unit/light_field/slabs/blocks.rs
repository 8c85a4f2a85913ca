//! Compressed light.

use catoptric_core::math::random::Stream;
use catoptric_lookup::light_field::Compression;
use catoptric_lookup::parts::blocks::{BRIGHTEST, bits8, byte_count, compress, decompress, from_bits8};
use catoptric_lookup::parts::{packed, unpacked};
use glam::Vec3;

const ALL: [Compression; 3] = [Compression::Bc1, Compression::Bc6h, Compression::Bc7];

fn restored(compression: Compression, side: u32, view: &[Vec3]) -> Vec<Vec3> {
    let view: Vec<u32> = view.iter().copied().map(packed).collect();
    let (mut bytes, mut texels) = (Vec::new(), Vec::new());
    compress(compression, side, &view, &mut bytes);
    assert_eq!(Some(bytes.len()), byte_count(compression, side));
    decompress(compression, side, &bytes, &mut texels);
    texels.into_iter().map(unpacked).collect()
}

#[test]
fn eight_bits_hold_radiance_to_their_steps() {
    for step in 0..=400 {
        let x = 0.01 * 10.0_f32.powf(step as f32 / 100.0);
        let found = from_bits8(bits8(Vec3::splat(x))).x;
        if x > 0.1 && x < 2.0 {
            assert!((found / x - 1.0).abs() < 0.016, "{x} became {found}");
        }
        if x >= BRIGHTEST {
            assert!((found / BRIGHTEST - 1.0).abs() < 1e-4, "{x} became {found}");
        }
    }
    assert_eq!(from_bits8(bits8(Vec3::ZERO)), Vec3::ZERO);
}

/// The difference of two radiances, in steps of eight bits.
fn steps(a: Vec3, b: Vec3) -> i32 {
    let [a, b] = [a, b].map(|radiance| bits8(radiance).map(i32::from));
    (0..3).map(|k| (a[k] - b[k]).abs()).max().unwrap()
}

/// Half a step of five bits, of seven, and about one of eight that half floats of ten take.
const ALLOWED: [(Compression, i32); 3] = [(Compression::Bc1, 5), (Compression::Bc6h, 1), (Compression::Bc7, 2)];

#[test]
fn views_of_one_colour_keep_it() {
    for (compression, allowed) in ALLOWED {
        for side in [1, 4, 5, 16] {
            for radiance in [Vec3::ZERO, Vec3::new(0.3, 0.7, 0.5), Vec3::new(1.4, 0.2, 0.9)] {
                let view = vec![radiance; (side * side) as usize];
                for found in restored(compression, side, &view) {
                    let off = steps(found, radiance);
                    assert!(off <= allowed, "{compression:?}: {radiance} became {found}, {off} steps off");
                }
            }
        }
    }
}

/// Texels of a block lie between two colours: a ramp is kept, and every pixel stays at its place.
#[test]
fn ramps_stay_where_they_are() {
    const SIDE: u32 = 13;
    let ramp = |pixel: u32| {
        let (x, y) = ((pixel % SIDE) as f32 / SIDE as f32, (pixel / SIDE) as f32 / SIDE as f32);
        Vec3::new(1.0, 0.8, 0.5) * (0.2 + 0.5 * x + 0.2 * y)
    };
    let view: Vec<Vec3> = (0..SIDE * SIDE).map(ramp).collect();
    // The next pixel differs by 9 steps at the dark end, the next row by 4.
    for (compression, allowed) in ALLOWED {
        let found = restored(compression, SIDE, &view);
        assert_eq!(found.len(), view.len());
        let off: Vec<i32> = found.iter().zip(&view).map(|(found, wanted)| steps(*found, *wanted)).collect();
        let mean = off.iter().sum::<i32>() as f32 / off.len() as f32;
        assert!(mean < 0.5 * allowed as f32 + 0.5, "{compression:?}: {mean}");
        assert!(off.iter().all(|off| *off <= 2 * allowed), "{compression:?}: {off:?}");
    }
}

/// Blocks follow their formats: another decoder reads the same values.
#[test]
fn other_decoders_read_the_blocks() {
    let mut random = Stream::new(8);
    let view: Vec<u32> = (0..64).map(|_| packed(Vec3::from([0; 3].map(|_| 2.0 * random.next_unit())))).collect();
    for compression in ALL {
        let (mut bytes, mut texels) = (Vec::new(), Vec::new());
        compress(compression, 8, &view, &mut bytes);
        decompress(compression, 8, &bytes, &mut texels);
        for (number, block) in bytes.chunks(bytes.len() / 4).enumerate() {
            let (mut bits, mut floats) = ([0; 64], [0.0; 48]);
            match compression {
                Compression::Bc1 => bcdec_rs::bc1(block, &mut bits, 16),
                Compression::Bc7 => bcdec_rs::bc7(block, &mut bits, 16),
                _ => bcdec_rs::bc6h_float(block, &mut floats, 12, false),
            }
            for pixel in 0..16 {
                let expected = match compression {
                    Compression::Bc6h => Vec3::from_slice(&floats[3 * pixel..]),
                    _ => from_bits8([bits[4 * pixel], bits[4 * pixel + 1], bits[4 * pixel + 2], 255]),
                };
                let (x, y) = (number % 2 * 4 + pixel % 4, number / 2 * 4 + pixel / 4);
                assert_eq!(texels[y * 8 + x], packed(expected), "{compression:?}, block {number}, pixel {pixel}");
            }
        }
    }
}

/// Half floats keep values beyond those of eight bits.
#[test]
fn half_floats_keep_bright_lights() {
    for found in restored(Compression::Bc6h, 4, &[Vec3::new(3000.0, 2500.0, 1000.0); 16]) {
        assert!((found / Vec3::new(3000.0, 2500.0, 1000.0) - 1.0).abs().max_element() < 0.02, "{found}");
    }
}

/// Files are checked by their sums, but their authors may write any blocks.
#[test]
fn any_blocks_are_radiance() {
    let mut random = Stream::new(7);
    for compression in ALL {
        let count = byte_count(compression, 32).unwrap();
        for _ in 0..50 {
            let bytes: Vec<u8> = (0..count).map(|_| (random.next_unit() * 256.0) as u8).collect();
            let mut texels = Vec::new();
            decompress(compression, 32, &bytes, &mut texels);
            assert_eq!(texels.len(), 32 * 32);
            assert!(texels.into_iter().all(|texel| unpacked(texel).is_finite()));
        }
    }
}
