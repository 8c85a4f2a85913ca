//! Radiance pictures, written here byte by byte.

use super::{load_with_warnings, picture, refusal, survives};

/// A header with these lines and this line of the size.
fn header(lines: &str, size: &str) -> Vec<u8> {
    format!("#?RADIANCE\n{lines}\n{size}\n").into_bytes()
}

/// Pixels of 8 columns and 4 rows, from the top: different ones.
fn pixel(x: usize, y: usize) -> [u8; 4] {
    [128 + 10 * x as u8, 130 + 20 * y as u8, 140, 129]
}

/// The radiance of a pixel: its mantissas times 2 to the power of the exponent less 136.
fn radiance([red, green, blue, exponent]: [u8; 4]) -> [f32; 3] {
    [red, green, blue].map(|mantissa| f32::from(mantissa) * 2f32.powi(i32::from(exponent) - 136))
}

fn all() -> Vec<[f32; 3]> {
    (0..32).map(|index| radiance(pixel(index % 8, index / 8))).collect()
}

/// The file of all pixels, as they are.
fn flat(lines: &str) -> Vec<u8> {
    let mut bytes = header(lines, "-Y 4 +X 8");
    (0..32).for_each(|index| bytes.extend(pixel(index % 8, index / 8)));
    bytes
}

#[test]
fn both_encodings_are_read() {
    assert_eq!(picture("sky.hdr", &flat("")), all());
    let mut bytes = header("# a remark\nFORMAT=32-bit_rle_rgbe\n", "-Y 4 +X 8");
    for y in 0..4 {
        bytes.extend([2, 2, 0, 8, 8]);
        bytes.extend((0..8).map(|x| pixel(x, y)[0]));
        for component in 1..4 {
            // Runs of 5 and 3, and literal ones between.
            let value = pixel(0, y)[component];
            bytes.extend([128 + 5, value, 1, value, 128 + 2, value]);
        }
    }
    assert_eq!(picture("sky.hdr", &bytes), all());
    // The older one: a pixel, and how often it is repeated; 3 and 1 times 256.
    let mut bytes = header("", "-Y 1 +X 260");
    bytes.extend([200, 100, 50, 128, 1, 1, 1, 3, 1, 1, 1, 1]);
    assert_eq!(picture("sky.hdr", &bytes), [radiance([200, 100, 50, 128]); 260]);
    assert_eq!(picture("sky.hdr", &[&b"#?RGBE\n\n-Y 4 +X 8\n"[..], &flat("")[22..]].concat()), all());
    survives("sky.hdr", &bytes);
}

#[test]
fn radiance_is_divided_by_all_exposures() {
    let found = picture("sky.hdr", &flat("EXPOSURE=2\nEXPOSURE= 4.0\nCOLORCORR=1 2 0.5\nPIXASPECT=1\n"));
    for (found, plain) in found.iter().zip(all()) {
        assert_eq!(*found, [plain[0] / 8.0, plain[1] / 16.0, plain[2] / 4.0]);
    }
    for (line, named) in
        [("EXPOSURE=dark\n", "EXPOSURE=dark"), ("EXPOSURE=0\n", "EXPOSURE"), ("FORMAT=8\n", "FORMAT=8")]
    {
        let message = refusal("sky.hdr", &flat(line));
        assert!(message.contains(named), "{message}");
    }
}

/// All eight orders of pixels show one picture.
#[test]
fn pixels_may_come_in_any_order() {
    for [x_sign, y_sign] in [["+", "-"], ["+", "+"], ["-", "-"], ["-", "+"]] {
        let across = |place: usize| if x_sign == "+" { place } else { 7 - place };
        let down = |place: usize| if y_sign == "-" { place } else { 3 - place };
        let mut rows = header("", &format!("{y_sign}Y 4 {x_sign}X 8"));
        (0..32).for_each(|index| rows.extend(pixel(across(index % 8), down(index / 8))));
        assert_eq!(picture("sky.hdr", &rows), all(), "{x_sign}X {y_sign}Y");
        let mut columns = header("", &format!("{x_sign}X 8 {y_sign}Y 4"));
        (0..32).for_each(|index| columns.extend(pixel(across(index / 4), down(index % 4))));
        assert_eq!(picture("sky.hdr", &columns), all(), "{x_sign}X {y_sign}Y, columns first");
    }
    for size in ["-Y 4", "-Z 4 +X 8", "-Y 4 -Y 8", "-Y four +X 8", "-Y 0 +X 8", "-Y 99999 +X 8"] {
        assert!(refusal("sky.hdr", &header("", size)).contains(size.split(' ').next_back().unwrap()));
    }
}

/// X, Y, Z of the white of sRGB, and of its red, are those colours.
#[test]
fn tristimulus_values_become_colours() {
    // Mantissas over 256 and powers of 2 of 0.9505, 1, 1.0890 and of twice 0.4124, 0.2126, 0.0193.
    for (xyz, expected) in [([122u8, 128, 139, 129], [1.0f32; 3]), ([211, 109, 10, 128], [2.0, 0.0, 0.0])] {
        let mut bytes = header("FORMAT=32-bit_rle_xyze\n", "-Y 1 +X 1");
        bytes.extend(xyz);
        let [found] = picture("sky.hdr", &bytes)[..] else { panic!("one pixel") };
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 0.02, "{xyz:?}: {found}, {expected}");
        }
    }
}

#[test]
fn large_pictures_are_halved() {
    // Just above the limit; rows alternate between 1 and 3, each a pixel and its repetitions.
    let mut bytes = header("", "-Y 1026 +X 32768");
    for row in 0..1026 {
        let value = if row % 2 == 0 { 128 } else { 192 };
        let exponent = if row % 2 == 0 { 129 } else { 130 };
        bytes.extend([value, value, value, exponent, 1, 1, 1, 255, 1, 1, 1, 127]);
    }
    let (sky, warnings) = load_with_warnings("sky.hdr", &bytes).expect("a sound file");
    let (width, height, radiance) = sky.picture();
    assert_eq!((width, height), (16384, 513));
    assert!(radiance.iter().all(|value| *value == [2.0; 3]));
    let [warning] = &warnings[..] else { panic!("{warnings:?}") };
    assert!(warning.contains("half") && warning.contains("16384 x 513"), "{warning}");
    assert!(refusal("sky.hdr", b"#?RADIANCE\n\n-Y 8192 +X 16384\n").contains("cut off"));
}

/// As Photoshop writes it, and with it most libraries of environments.
#[test]
fn primaries_of_zeros_name_none() {
    for line in ["PRIMARIES=0 0 0 0 0 0 0 0\n", "PRIMARIES=0.3 0.3 0.3 0.3 0.3 0.3 0.3 0.3\n"] {
        assert_eq!(picture("sky.hdr", &flat(&format!("# Made with Adobe Photoshop\nGAMMA=1\n{line}"))), all());
    }
}

/// The default of Radiance itself, whose white is that of equal energy: white stays white.
#[test]
fn primaries_are_converted() {
    let bytes = flat("PRIMARIES=0.640 0.330 0.290 0.600 0.150 0.060 0.333333 0.333333\n");
    for ([red, green, blue], [as_red, as_green, as_blue]) in picture("sky.hdr", &bytes).into_iter().zip(all()) {
        // Green of 0.29 is a little less red than that of Rec. 709, whose x is 0.30.
        assert!((red - as_red).abs() < 0.15 && (green - as_green).abs() < 0.05 && (blue - as_blue).abs() < 0.05);
    }
}
