//! The content of pictures of `catoptric render`: formats, parts, transparency, masks and layers.

use crate::workplace::Workplace;
use catoptric::framebuffer::{Framebuffer, srgb_from_linear};
use catoptric::picture::{read, read_channel, write};

const SMALL: [&str; 6] = ["render", "scene.toml", "--size", "64x48", "--samples", "4"];

/// The light that comes from everywhere.
const SKY: [f32; 3] = [0.75, 0.5, 0.25];

impl Workplace {
    fn drawn(&self, output: &str, more: &[&str]) -> Framebuffer {
        self.ok(&[&SMALL, &["-o", output][..], more].concat());
        read(&self.path(output)).unwrap()
    }

    /// The scene with light that is the same everywhere.
    fn with_sky() -> Self {
        let place = Self::new();
        let [r, g, b] = SKY;
        write(&place.path("sky.exr"), &Framebuffer::of_pixels(8, 4, vec![[r, g, b, 1.0]; 32])).unwrap();
        place.write("scene.toml", format!("environment = 'sky.exr'\n{}", place.text("scene.toml")));
        place
    }
}

fn largest_difference(one: &Framebuffer, other: &Framebuffer) -> f32 {
    let of_pixels = one.pixels.iter().flatten().zip(other.pixels.iter().flatten());
    of_pixels.map(|(one, other)| (one - other).abs()).fold(0.0, f32::max)
}

#[test]
fn every_format_holds_the_same_picture() {
    let place = Workplace::with_sky();
    let png = place.drawn("a.png", &[]);
    assert_eq!(place.drawn("a.webp", &[]), png, "lossless");
    let fine = place.drawn("b.png", &["--bits", "16"]);
    // Bits a sample and the kind of colour, as the format has them in its header.
    assert_eq!(
        (place.bytes("a.png")[24..26].to_vec(), place.bytes("b.png")[24..26].to_vec()),
        (vec![8, 2], vec![16, 2])
    );
    assert!(fine != png && fine.to_srgb8() == png.to_srgb8());
    let jpeg = place.drawn("a.jpg", &[]);
    let off = |(one, other): (&u8, &u8)| f64::from(one.abs_diff(*other));
    let mean = jpeg.to_srgb8().iter().zip(&png.to_srgb8()).map(off).sum::<f64>() / (64.0 * 48.0 * 3.0);
    assert!(mean < 2.0 && jpeg != png, "{mean} of 255");
    let linear = place.drawn("a.exr", &[]);
    assert_eq!(linear.to_srgb8(), png.to_srgb8());
    assert!(place.bytes("a.exr").len() < 64 * 48 * 16 / 2, "compressed");
    let half = place.drawn("b.exr", &["--half"]);
    // Eleven bits.
    let is_near = |(one, other): (&f32, &f32)| (one - other).abs() <= one / 2048.0 + 1e-7;
    assert!(linear.pixels.iter().flatten().zip(half.pixels.iter().flatten()).all(is_near) && half != linear);
    for name in ["a.webp", "a.jpg", "a.exr"] {
        let before = place.bytes(name);
        place.drawn(name, &["--threads", "1"]);
        assert!(place.bytes(name) == before, "{name}");
    }
}

#[test]
fn what_a_format_cannot_hold_is_wrong_usage() {
    let place = Workplace::new();
    let faults: [(&[&str], &str); 13] = [
        (&["-o", "a.bmp"], ".png, .jpg, .webp or .exr"),
        (&["-o", "a.exr", "--bits", "16"], "--half"),
        (&["-o", "a.png", "--bits", "12"], "16"),
        (&["-o", "a.png", "--half"], "--bits 16"),
        (&["-o", "-", "--layers"], ".exr"),
        (&["-o", "a.jpg", "--transparent"], ".png or .webp"),
        (&["-o", "a.png", "--transparent", "--backend", "gpu"], "--backend gpu"),
        (&["-o", "a.exr", "--layers", "--budget-ms", "9"], "--budget-ms"),
        (&["-o", "a.png", "--mask", "a.jpg"], ".png or .exr"),
        (&["-o", "a.png", "--region", "0,0,65,1"], "--size 64x48"),
        (&["-o", "a.png", "--region", "63,47,1,2"], "--region 63,47,1,2"),
        (&["-o", "a.png", "--region", "0,0,0,1"], "1 at least"),
        (&["-o", "a.png", "--region", "1,2,3"], "X,Y,W,H"),
    ];
    place.names_faults(2, &SMALL, &faults);
}

#[test]
fn a_region_has_the_pixels_of_the_whole_picture() {
    let place = Workplace::with_sky();
    for (kind, more) in [("png", &["--exposure", "auto"][..]), ("exr", &["--layers", "--transparent"])] {
        let [whole, part] = ["whole", "part"].map(|name| format!("{name}.{kind}"));
        let all = place.drawn(&whole, &[more, &["--mask", "whole_mask.exr"]].concat());
        let cut = ["--region", "20,9,31,22", "--mask", "mask.exr"];
        let found = place.drawn(&part, &[more, &cut].concat());
        assert_eq!((found.width, found.height), (31, 22));
        let inside = |x: u32, y: u32| (20 + x, 9 + y);
        let places = || (0..22).flat_map(|y| (0..31).map(move |x| (x, y)));
        assert!(places().all(|(x, y)| found.pixel(x, y) == all.pixel(inside(x, y).0, inside(x, y).1)), "{kind}");
        for (all, found, channel) in [("whole_mask.exr", "mask.exr", "Y"), ("whole.exr", "part.exr", "depth.Z")] {
            if channel == "depth.Z" && kind == "png" {
                continue;
            }
            let [(_, _, all), (_, _, found)] =
                [all, found].map(|name| read_channel(&place.path(name), &[channel]).unwrap());
            let same = |(x, y): (u32, u32)| found[(y * 31 + x) as usize] == all[((9 + y) * 64 + 20 + x) as usize];
            assert!(places().all(same), "{channel}");
        }
    }
}

#[test]
fn what_is_cut_out_over_its_background_is_the_picture() {
    let place = Workplace::with_sky();
    // One of each kind of shader.
    for id in ["reference", "auto", "environment_map", "layered_environment_map", "planar_mirror"] {
        let whole = place.drawn("whole.exr", &["--method", id]);
        let cut = place.drawn("cut.exr", &["--method", id, "--transparent"]);
        let alphas = || cut.pixels.iter().map(|pixel| pixel[3]);
        let [none, all] = [0.0, 1.0].map(|wanted| alphas().filter(|alpha| *alpha == wanted).count());
        assert!(none > 500 && all > 500 && none + all < 64 * 48 - 20, "{id}: {none} without, {all} covered");
        // Alpha compositing (Porter, Duff 1984): the picture is what is cut out, over the sky.
        let over = |[r, g, b, alpha]: &[f32; 4]| {
            let [sky_r, sky_g, sky_b] = SKY.map(|light| light * (1.0 - alpha));
            [r + sky_r, g + sky_g, b + sky_b, 1.0]
        };
        let over = Framebuffer::of_pixels(64, 48, cut.pixels.iter().map(over).collect());
        let error = largest_difference(&over, &whole);
        assert!(error < 2e-3, "{id}: {error}");
        // The mirror shows the sky still.
        assert!(cut.pixel(32, 16)[0] > 0.1, "{id}: {:?}", cut.pixel(32, 16));
    }
}

#[test]
fn colours_of_transparent_png_pictures_are_straight() {
    let place = Workplace::with_sky();
    let linear = place.drawn("cut.exr", &["--transparent"]);
    for output in ["cut.png", "cut.webp"] {
        let shown = place.drawn(output, &["--transparent", "--exposure", "0", "--tone", "none"]);
        let mut at_edges = 0;
        for (shown, linear) in shown.pixels.iter().zip(&linear.pixels) {
            assert!((shown[3] - linear[3]).abs() < 0.51 / 255.0, "{shown:?} for {linear:?}");
            at_edges += usize::from(linear[3] > 0.0 && linear[3] < 1.0);
            for channel in 0..3 {
                let straight = if linear[3] > 0.0 { linear[channel] / linear[3] } else { 0.0 };
                let off = srgb_from_linear(shown[channel]) - srgb_from_linear(straight);
                // Samples beyond white are limited one by one within surfaces.
                assert!(off.abs() < 0.6 / 255.0 || linear[3] == 1.0, "{output}: {shown:?} for {linear:?}");
            }
        }
        assert!(at_edges > 20, "{at_edges}");
    }
    let fine = place.drawn("fine.png", &["--transparent", "--bits", "16"]);
    assert!(fine.pixels.iter().zip(&linear.pixels).all(|(fine, linear)| (fine[3] - linear[3]).abs() < 1e-5));
    // A colour with alpha, of 16 bits.
    assert_eq!(place.bytes("fine.png")[24..26], [16, 6]);
}

#[test]
fn a_mask_is_the_shadow_that_a_ball_throws_on_the_picture() {
    let place = Workplace::new();
    for samples in ["16", "50"] {
        let method = if samples == "50" { "reference" } else { "auto" };
        let more = ["--samples", samples, "--method", method, "--mask", "mask.exr"];
        place.ok(&[&SMALL[..4], &["-o", "out.png"], &more].concat());
        let (width, height, shares) = read_channel(&place.path("mask.exr"), &["Y"]).unwrap();
        assert_eq!((width, height), (64, 48));
        // The eye looks at the middle of the ball: its picture is a circle, of the tangent of the cone around it.
        let pixels_per_unit = 24.0 / (22.5f64).to_radians().tan();
        let area = std::f64::consts::PI * pixels_per_unit.powi(2) * 0.64 / (16.25 - 0.64);
        let found: f64 = shares.iter().map(|share| f64::from(*share)).sum();
        assert!((found / area - 1.0).abs() < 0.01, "{samples}: {found} pixels of {area}");
        assert!(shares.iter().filter(|share| **share > 0.0 && **share < 1.0).count() > 40, "{samples}");
    }
}

#[test]
fn layers_hold_depth_normals_objects_and_reflections() {
    let place = Workplace::with_sky();
    place.write(
        "scene.toml",
        place.text("scene.toml").replace("name = \"wall\"", "name = \"wäll\"").replace("wall =", "\"wäll\" ="),
    );
    for method in ["auto", "reference", "environment_map", "planar_mirror"] {
        let picture = place.drawn("out.exr", &["--layers", "--method", method]);
        let channel = |name: &str| read_channel(&place.path("out.exr"), &[name]).unwrap().2;
        let [depth, ids] = ["depth.Z", "object.id"].map(channel);
        let normals = ["normal.X", "normal.Y"].map(channel);
        let at = |x: usize, y: usize| y * 64 + x;
        let middle = at(32, 24);
        // The eye is the square root of 16.25 away from the middle of the ball, whose radius is 0.8.
        assert!((depth[middle] - (16.25f32.sqrt() - 0.8)).abs() < 2e-3, "{method}: {}", depth[middle]);
        assert_eq!((ids[middle], ids[at(8, 16)], ids[at(0, 0)]), (1.0, 2.0, 0.0), "{method}");
        assert!(depth[at(0, 0)].is_infinite() && normals[0][at(0, 0)] == 0.0);
        // The wall stands upright across z; rays to it have the depth of the plane through the pixel.
        assert!(normals.iter().all(|channel| channel[at(8, 16)].abs() < 1e-6), "{method}");
        let header = String::from_utf8_lossy(&place.bytes("out.exr")).into_owned();
        assert!(header.contains(r#""objects":{"1":"ball","2":"w\u00e4ll"}"#), "{method}");
        let reflection = channel("reflection.R");
        let red = |pixel: usize| picture.pixels[pixel][0];
        assert_eq!(reflection[at(8, 16)], 0.0, "{method}: the wall mirrors nothing");
        assert_eq!(reflection[middle], red(middle), "{method}: a mirror shows nothing else");
    }
}
