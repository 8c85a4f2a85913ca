//! OpenEXR pictures, written here byte by byte.

use super::{load, picture, refusal, survives};
use catoptric_core::math::portable::PortableMath;
use glam::Vec3;

/// A file without compression.
struct File {
    /// First and last column and row.
    display: [i32; 4],
    data: [i32; 4],
    /// Names in the order of the alphabet; all of 32-bit or all of 16-bit floats.
    channels: Vec<&'static str>,
    is_half: bool,
    sampling: i32,
    compression: u8,
    /// Further attributes: name, kind and value.
    more: Vec<(&'static str, &'static str, Vec<u8>)>,
}

impl File {
    fn new(width: i32, height: i32) -> Self {
        Self {
            display: [0, 0, width - 1, height - 1],
            data: [0, 0, width - 1, height - 1],
            channels: vec!["B", "G", "R"],
            is_half: false,
            sampling: 1,
            compression: 0,
            more: Vec::new(),
        }
    }

    /// The bytes, with the value of a channel (by its place among them) at a column and row.
    fn bytes(&self, value: impl Fn(usize, i32, i32) -> f32) -> Vec<u8> {
        let mut bytes = vec![0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0];
        let mut attribute = |name: &str, kind: &str, value: &[u8]| {
            bytes.extend([name.as_bytes(), &[0], kind.as_bytes(), &[0]].concat());
            bytes.extend((value.len() as i32).to_le_bytes());
            bytes.extend(value);
        };
        let mut channels = Vec::new();
        for name in &self.channels {
            channels.extend([name.as_bytes(), &[0]].concat());
            let kind = if self.is_half { 1 } else { 2 };
            channels.extend([kind, 0, self.sampling, self.sampling].map(i32::to_le_bytes).concat());
        }
        channels.push(0);
        attribute("channels", "chlist", &channels);
        attribute("compression", "compression", &[self.compression]);
        attribute("dataWindow", "box2i", &self.data.map(i32::to_le_bytes).concat());
        attribute("displayWindow", "box2i", &self.display.map(i32::to_le_bytes).concat());
        attribute("lineOrder", "lineOrder", &[0]);
        attribute("pixelAspectRatio", "float", &1f32.to_le_bytes());
        attribute("screenWindowCenter", "v2f", &[0; 8]);
        attribute("screenWindowWidth", "float", &1f32.to_le_bytes());
        self.more.iter().for_each(|(name, kind, value)| attribute(name, kind, value));
        bytes.push(0);
        let [left, top, right, bottom] = self.data;
        let line_bytes = (right - left + 1) as usize * self.channels.len() * if self.is_half { 2 } else { 4 };
        let first = bytes.len() + 8 * (bottom - top + 1) as usize;
        for line in 0..=(bottom - top) as usize {
            bytes.extend(((first + line * (8 + line_bytes)) as u64).to_le_bytes());
        }
        for y in top..=bottom {
            bytes.extend(y.to_le_bytes());
            bytes.extend((line_bytes as i32).to_le_bytes());
            for channel in 0..self.channels.len() {
                for x in left..=right {
                    match self.is_half {
                        true => bytes.extend(exr::prelude::f16::from_f32(value(channel, x, y)).to_le_bytes()),
                        false => bytes.extend(value(channel, x, y).to_le_bytes()),
                    }
                }
            }
        }
        bytes
    }
}

/// A picture of one colour.
pub(super) fn flat(width: i32, height: i32, [red, green, blue]: [f32; 3]) -> Vec<u8> {
    File::new(width, height).bytes(|channel, _, _| [blue, green, red][channel])
}

#[test]
fn overflowed_suns_are_bright_and_broken_values_black() {
    let mut file = File::new(3, 1);
    let values = [f32::INFINITY, f32::NAN, f32::NEG_INFINITY];
    for is_half in [true, false] {
        file.is_half = is_half;
        let bytes = file.bytes(|channel, x, _| if channel == 2 { values[x as usize] } else { 0.5 });
        assert_eq!(picture("sky.exr", &bytes), [[65504.0, 0.5, 0.5], [0.0, 0.5, 0.5], [0.0, 0.5, 0.5]]);
    }
    survives("sky.exr", &flat(3, 2, [0.5, 0.25, 2.0]));
}

/// The data window is placed in the display window: black around it, cut off beyond.
#[test]
fn windows_are_kept() {
    let value = |channel: usize, x: i32, y: i32| (100 * channel as i32 + 10 * (y + 20) + (x + 20)) as f32;
    let color = |x: i32, y: i32| [value(2, x, y), value(1, x, y), value(0, x, y)];
    let mut file = File::new(8, 4);
    file.display = [-10, 5, -3, 8];
    for data in [[-9, 6, -4, 7], [-12, 3, 0, 12], [-12, 6, -6, 20], [-10, 5, -3, 8]] {
        file.data = data;
        let found = picture("sky.exr", &file.bytes(value));
        for (index, found) in found.into_iter().enumerate() {
            let (x, y) = (index as i32 % 8 - 10, index as i32 / 8 + 5);
            let is_inside = (data[0]..=data[2]).contains(&x) && (data[1]..=data[3]).contains(&y);
            assert_eq!(found, if is_inside { color(x, y) } else { [0.0; 3] }, "{data:?} at {x}, {y}");
        }
    }
    file.data = [0, 0, 3, 3];
    assert!(refusal("sky.exr", &file.bytes(value)).contains("display window"));
}

/// A cube map and a latitude-longitude map of one smooth light, both by the directions of their pixels that OpenEXR's
/// ImfEnvmap defines, look alike.
#[test]
fn cube_maps_look_as_their_panoramas() {
    let light = |towards: Vec3| {
        let Vec3 { x, y, z } = towards.normalize();
        Vec3::new(1.0 + x, 1.0 + y, 1.0 + 0.5 * z + 0.5 * x * y)
    };
    const SIDE: i32 = 33;
    let mut cube = File::new(SIDE, 6 * SIDE);
    cube.more = vec![("envmap", "envmap", vec![1])];
    let of_cube = cube.bytes(|channel, x, y| {
        let [right, down] = [x, y % SIDE].map(|at| 2.0 * at as f32 / (SIDE - 1) as f32 - 1.0);
        let towards = match y / SIDE {
            0 => Vec3::new(1.0, -down, right),
            1 => Vec3::new(-1.0, -down, -right),
            2 => Vec3::new(right, 1.0, -down),
            3 => Vec3::new(right, -1.0, down),
            4 => Vec3::new(-right, -down, 1.0),
            _ => Vec3::new(right, -down, -1.0),
        };
        light(towards)[2 - channel]
    });
    let (width, height) = (128, 64);
    let mut panorama = File::new(width, height);
    panorama.more = vec![("envmap", "envmap", vec![0])];
    let of_panorama = panorama.bytes(|channel, x, y| {
        let longitude = std::f32::consts::TAU * (0.5 - (x as f32 + 0.5) / width as f32);
        let latitude = std::f32::consts::PI * (0.5 - (y as f32 + 0.5) / height as f32);
        let (sine, cosine) = latitude.sine_cosine();
        light(Vec3::new(longitude.sine() * cosine, sine, longitude.cosine() * cosine))[2 - channel]
    });
    let [cube, panorama] = [of_cube, of_panorama].map(|bytes| load("sky.exr", &bytes).expect("a sound file"));
    assert_eq!(cube.picture().0, 4 * SIDE as u32);
    for index in 0..500 {
        let at = |step: f32| ((index as f32 + 0.3) * step).fract() * 2.0 - 1.0;
        let towards = Vec3::new(at(0.37), at(0.61), at(0.83)).normalize();
        let [of_cube, of_panorama] = [&cube, &panorama].map(|sky| sky.radiance(towards));
        assert!((of_cube - of_panorama).length() < 0.01, "{towards}: {of_cube}, {of_panorama}");
    }
    let mut other = File::new(SIDE, 5 * SIDE);
    other.more = vec![("envmap", "envmap", vec![1])];
    assert!(refusal("sky.exr", &other.bytes(|_, _, _| 1.0)).contains("six faces"));
}

/// Colours by other primaries become those of Rec. 709.
#[test]
fn chromaticities_are_converted() {
    let with = |places: [f32; 8], [red, green, blue]: [f32; 3]| {
        let mut file = File::new(1, 1);
        file.more = vec![("chromaticities", "chromaticities", places.map(f32::to_le_bytes).concat())];
        picture("sky.exr", &file.bytes(|channel, _, _| [blue, green, red][channel]))[0]
    };
    let rec_709 = [0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290];
    let rec_2020 = [0.708, 0.292, 0.170, 0.797, 0.131, 0.046, 0.3127, 0.3290];
    let xyz = [1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0 / 3.0, 1.0 / 3.0];
    // The Academy's AP0: its white is another, and becomes white.
    let ap0 = [0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.077, 0.32168, 0.33767];
    for (places, color, expected) in [
        (rec_709, [0.2, 0.5, 0.9], [0.2, 0.5, 0.9]),
        // Recommendation ITU-R BT.2087-0; the blue that is less than none is none.
        (rec_2020, [0.5, 0.4, 0.3], [0.5734, 0.3884, 0.2863]),
        (rec_2020, [1.0, 1.0, 1.0], [1.0, 1.0, 1.0]),
        // IEC 61966-2-1: X, Y and Z of sRGB's green and of its white.
        (xyz, [0.3576, 0.7152, 0.1192], [0.0, 1.0, 0.0]),
        (xyz, [0.9505, 1.0, 1.0890], [1.0, 1.0, 1.0]),
        (ap0, [1.0, 1.0, 1.0], [1.0, 1.0, 1.0]),
    ] {
        let found = with(places, color);
        let is_near = found.iter().zip(expected).all(|(found, expected): (&f32, f32)| (found - expected).abs() < 2e-3);
        assert!(is_near, "{places:?}, {color:?}: {found:?}, {expected:?}");
    }
}

#[test]
fn layers_and_grey_are_found_by_their_channels() {
    let value = |channel: usize, _: i32, _: i32| 0.25 * (channel + 1) as f32;
    let of = |channels: &[&'static str]| File { channels: channels.to_vec(), ..File::new(2, 1) }.bytes(value);
    for (channels, expected) in [
        (
            &["ViewLayer.Combined.A", "ViewLayer.Combined.B", "ViewLayer.Combined.G", "ViewLayer.Combined.R"][..],
            [1.0, 0.75, 0.5],
        ),
        (&["Y"], [0.25; 3]),
        (&["A", "Y", "Z"], [0.5; 3]),
        (&["B", "G", "R", "light.B", "light.G", "light.R"], [0.75, 0.5, 0.25]),
        (&["L.Combined.B", "L.Combined.G", "L.Combined.R", "L.Light.B", "L.Light.G", "L.Light.R"], [0.75, 0.5, 0.25]),
    ] {
        assert_eq!(picture("sky.exr", &of(channels)), [expected; 2], "{channels:?}");
    }
    for (channels, named) in [
        (&["X", "Y", "Z"][..], "has the channels X, Y, Z; "),
        (&["BY", "RY", "Y"], "has the channels BY, RY, Y; "),
        (&["A", "depth.Z"], "needs R, G and B"),
        (&["a.B", "a.G", "a.R", "b.B", "b.G", "b.R"], "several layers"),
    ] {
        let message = refusal("sky.exr", &of(channels));
        assert!(message.contains(named), "{message}");
    }
}

#[test]
fn what_is_not_read_is_named() {
    let with = |change: fn(&mut File)| {
        let mut file = File::new(4, 2);
        change(&mut file);
        refusal("sky.exr", &file.bytes(|_, _, _| 0.5))
    };
    for (message, named) in [
        (with(|file| file.compression = 10), "HTJ2K"),
        (with(|file| file.compression = 77), "method 77"),
        (with(|file| (file.channels, file.sampling) = (vec!["BY", "RY", "Y"], 2)), "channels BY, RY, Y"),
    ] {
        assert!(message.contains(named) && message.contains("save it"), "{message}");
    }
    let mut deep = File::new(4, 2);
    deep.more = vec![("type", "string", b"deepscanline".to_vec())];
    let mut deep = deep.bytes(|_, _, _| 0.5);
    deep[5] |= 1 << 3;
    assert!(refusal("sky.exr", &deep).contains("deep"));
    let sound = flat(4, 2, [1.0; 3]);
    assert!(refusal("sky.exr", &sound[..sound.len() - 5]).contains("cut off"));
    // A table that leads to one line twice.
    let mut twice = sound.clone();
    let second = sound.len() - 2 * (8 + 48) - 8;
    twice.copy_within(second - 8..second, second);
    assert!(refusal("sky.exr", &twice).contains("twice"));
}

/// Blocks of DWA begin with the sizes of their parts, which a broken file has as large as it likes.
#[test]
fn blocks_that_ask_for_more_than_their_pixels_are_refused() {
    use exr::prelude::{Compression, Encoding, Image, Layer, LayerAttributes, SpecificChannels, WritableImage};
    let channels = SpecificChannels::rgb(|at: exr::math::Vec2<usize>| {
        let wave = (at.x() as f32 * 0.7).sin() + (at.y() as f32 * 0.4).cos();
        (wave, wave * 0.5, 1.0)
    });
    let encoding = Encoding { compression: Compression::DWAA(None), ..Encoding::default() };
    let layer = Layer::new((48, 24), LayerAttributes::named("sky"), encoding, channels);
    let mut bytes = std::io::Cursor::new(Vec::new());
    Image::from_layer(layer).write().to_buffered(&mut bytes).unwrap();
    let bytes = bytes.into_inner();
    load("dwa.exr", &bytes).unwrap();
    // The block is the file's end: its size, then eleven counters, the first of which is the version, 2.
    let counter = |at: usize| u64::from_le_bytes(*bytes[at..].first_chunk().unwrap());
    let size = |at: usize| i32::from_le_bytes(*bytes[at..].first_chunk().unwrap());
    let is_start = |at: &usize| counter(*at) == 2 && size(at - 4) as usize == bytes.len() - at;
    let start = (300..bytes.len() - 88).find(is_start).unwrap();
    for index in [1, 6, 7, 8, 9] {
        let mut broken = bytes.clone();
        broken[start + 8 * index..][..8].copy_from_slice(&(1u64 << 49).to_le_bytes());
        let problem = refusal("dwa.exr", &broken);
        assert!(problem.contains("claims to hold"), "{index}: {problem}");
    }
}
