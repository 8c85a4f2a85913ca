//! Measures of errors of pictures.

mod flip;
mod heat;

use catoptric_core::framebuffer::{Framebuffer, linear_from_srgb};
use catoptric_engine::metrics::{Comparison, PictureError, percentile};

fn flat(width: u32, height: u32, value: f32) -> Framebuffer {
    Framebuffer::of_pixels(width, height, vec![[value, value, value, 1.0]; (width * height) as usize])
}

#[test]
fn equal_pictures_have_no_error() {
    let picture = flat(7, 5, 0.3);
    let error = Comparison::new(&picture, &picture).unwrap().whole().unwrap();
    assert_eq!(error, PictureError { flip_mean: 0.0, flip_p99: 0.0, rmse: 0.0, over_0_1: 0.0 });
}

#[test]
fn rmse_and_visible_share_by_hand() {
    let reference = flat(2, 2, 0.0);
    let mut test = reference.clone();
    test.pixels[3][1] = 0.6;
    test.pixels[0][0] = linear_from_srgb(0.09);
    let comparison = Comparison::new(&test, &reference).unwrap();
    let error = comparison.whole().unwrap();
    let small = f64::from(test.pixels[0][0]);
    assert!((error.rmse - ((0.36 + small * small) / 12.0).sqrt()).abs() < 1e-7);
    assert_eq!(error.over_0_1, 0.25);
    let masked = comparison.masked(&[false, false, false, true]).unwrap().unwrap();
    assert!((masked.rmse - (0.36f64 / 3.0).sqrt()).abs() < 1e-7);
    assert_eq!(masked.over_0_1, 1.0);
    assert_eq!(masked.flip_mean, f64::from(comparison.flip[3]));
}

#[test]
fn sizes_and_masks_are_checked() {
    let error = Comparison::new(&flat(2, 3, 0.0), &flat(3, 2, 0.0)).unwrap_err();
    assert!(error.to_string().contains("2x3") && error.to_string().contains("3x2"), "{error}");
    let comparison = Comparison::new(&flat(2, 3, 0.1), &flat(2, 3, 0.2)).unwrap();
    assert!(comparison.masked(&[true; 5]).is_err());
    assert_eq!(comparison.masked(&[false; 6]).unwrap(), None);
    let empty = flat(0, 0, 0.0);
    assert_eq!(Comparison::new(&empty, &empty).unwrap().whole(), None);
    let short = Framebuffer::of_pixels(2, 2, vec![[0.0; 4]]);
    assert!(Comparison::new(&short, &short).is_err());
}

#[test]
fn broken_pixels_count_as_infinitely_wrong() {
    let mut test = flat(4, 4, 0.5);
    test.pixels[5] = [f32::NAN, f32::INFINITY, 0.5, 1.0];
    let error = Comparison::new(&test, &flat(4, 4, 0.5)).unwrap().whole().unwrap();
    assert_eq!(error.rmse, f64::INFINITY);
    assert!(error.flip_mean.is_finite() && error.flip_mean > 0.0 && error.flip_p99 <= 1.0);
}

#[test]
fn percentiles_by_rank() {
    let mut values: Vec<f32> = (1..=100).map(|value| value as f32).rev().collect();
    assert_eq!(percentile(&mut values, 0.99), 99.0);
    assert_eq!(percentile(&mut values, 1.0), 100.0);
    assert_eq!(percentile(&mut values, 0.0), 1.0);
    assert_eq!(percentile(&mut [3.0], 0.99), 3.0);
    assert_eq!(percentile(&mut [], 0.5), 0.0);
}
