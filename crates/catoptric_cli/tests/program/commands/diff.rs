//! Pictures compared by `catoptric diff`.

use crate::workplace::Workplace;
use catoptric::framebuffer::Framebuffer;
use catoptric::picture;

/// 4 x 4 pixels of one colour, the first of which may have another.
fn picture_of(color: [f32; 3], first: [f32; 3]) -> Framebuffer {
    let opaque = |[r, g, b]: [f32; 3]| [r, g, b, 1.0];
    let mut pixels = vec![opaque(color); 16];
    pixels[0] = opaque(first);
    Framebuffer::of_pixels(4, 4, pixels)
}

fn place() -> Workplace {
    let place = Workplace::new();
    let grey = [0.2; 3];
    for (name, first) in [("a", grey), ("b", [0.7, 0.2, 0.2])] {
        for kind in ["png", "exr"] {
            picture::write(&place.path(&format!("{name}.{kind}")), &picture_of(grey, first)).unwrap();
        }
    }
    place
}

#[test]
fn the_difference_of_two_pictures_is_measured() {
    let place = place();
    let same = place.listed(&["diff", "a.exr", "a.exr", "--json"]);
    for zero in ["flip_mean", "flip_p99", "rmse", "over_0_1", "differing_pixels"] {
        assert_eq!(same[zero].as_f64(), Some(0.0), "{zero}: {same}");
    }
    // One channel of one pixel of sixteen is off by a half.
    let found = place.listed(&["diff", "a.exr", "b.exr", "--json"]);
    let rmse = (0.25f64 / (3.0 * 16.0)).sqrt();
    assert!((found["rmse"].as_f64().unwrap() - rmse).abs() < 1e-7, "{found}");
    assert_eq!(found["over_0_1"].as_f64(), Some(1.0 / 16.0));
    assert_eq!((found["differing_pixels"].as_u64(), found["size"][0].as_u64()), (Some(1), Some(4)));
    assert!(found["flip_mean"].as_f64().unwrap() > 0.0 && found["rounded"].is_null());
    let text = place.ok(&["diff", "a.exr", "b.exr", "-o", "heat.png"]);
    assert!(text.contains("1 of 16 pixels") && text.contains("6.250 % of the pixels"), "{text}");
    let heat = picture::read(&place.path("heat.png")).unwrap();
    let brightness = |pixel: [f32; 4]| pixel[0] + pixel[1] + pixel[2];
    assert!(brightness(heat.pixels[0]) > brightness(heat.pixels[15]), "{:?}", heat.pixels);
}

#[test]
fn linear_pictures_are_rounded_as_png_files_are() {
    let place = place();
    let found = place.listed(&["diff", "b.exr", "b.png", "--json"]);
    assert_eq!((found["differing_pixels"].as_u64(), found["rounded"].as_str()), (Some(0), Some("b.exr")));
    let text = place.ok(&["diff", "b.png", "b.exr"]);
    assert!(text.contains("b.exr: linear, compared as the .png that it would be"), "{text}");
    assert!(!place.ok(&["diff", "b.exr", "a.exr"]).contains("linear, compared"));
}

#[test]
fn exit_codes_tell_pictures_that_differ_too_much() {
    let place = place();
    place.ok(&["diff", "a.png", "a.png", "--max-flip", "0"]);
    let text = place.ends(3, &["diff", "a.png", "b.png", "--max-flip", "0.0001"]);
    assert!(text.contains("more than --max-flip 0.0001"), "{text}");
    assert_eq!(place.ends(3, &["diff", "a.png", "b.png", "--max-flip", "0", "--quiet"]), "");
    place.ok(&["diff", "a.png", "b.png", "--max-flip", "1"]);
    let wide = Framebuffer::of_pixels(8, 2, vec![[0.0; 4]; 16]);
    picture::write(&place.path("wide.png"), &wide).unwrap();
    place.write("text.png", "no picture");
    place.names_faults(
        1,
        &["diff"],
        &[
            (&["a.png", "wide.png"], "a.png has 4x4 pixels, wide.png has 8x2: sizes must agree"),
            (&["a.png", "none.png"], "none.png: cannot read it"),
            (&["text.png", "a.png"], "text.png: picture: is neither PNG"),
            (&["a.png", "b.png", "-o", "no/heat.png"], "no/heat.png: cannot write it"),
        ],
    );
    place.names_faults(
        2,
        &["diff", "a.png", "b.png"],
        &[
            (&["-o", "./a.png"], "a.png: is both a picture to compare and the output"),
            (&["-o", "heat.exr"], ".png"),
            (&["--max-flip", "2"], "from 0 to 1"),
            (&["--max-flip", "nan"], "from 0 to 1"),
        ],
    );
}
