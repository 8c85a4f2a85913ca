//! LDR-FLIP: the visible difference of two pictures shown in alternation.
//!
//! Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström and Fairchild 2020, "FLIP: A Difference Evaluator for
//! Alternating Images". Colours are filtered with the eye's contrast sensitivity and compared in an opponent space
//! (sections 4.1 and 4.2 there); edges and points are compared apart (4.3); a feature that differs amplifies the
//! colour difference (4.4). All filters are sums of separable ones. Pictures are continued by their border pixels.

use super::error::{MetricError, check};
use catoptric_core::framebuffer::Framebuffer;
use catoptric_core::parallel;
use std::f32::consts::PI;

/// Pixels per degree of visual angle for a 0.7 m wide screen of 3840 pixels seen from 0.7 m, the paper's default.
pub const DEFAULT_PIXELS_PER_DEGREE: f32 = 67.020_6;

/// Exponent on the colour difference.
const COLOR_EXPONENT: f32 = 0.7;
/// Exponent on the feature difference.
const FEATURE_EXPONENT: f32 = 0.5;
/// Colour differences up to this part of the largest one...
const COLOR_KNEE: f32 = 0.4;
/// ...are stretched to this part of the range.
const ERROR_AT_KNEE: f32 = 0.95;
/// Width of the feature detectors, degrees.
const FEATURE_WIDTH_DEG: f32 = 0.082;

/// Rows of linear RGB to XYZ for sRGB primaries, and of its inverse.
const XYZ_FROM_RGB: [[f32; 3]; 3] = [
    [0.412_386_56, 0.357_591_5, 0.180_450_5],
    [0.212_636_82, 0.715_183, 0.072_180_2],
    [0.019_330_62, 0.119_197_16, 0.950_372_6],
];
const RGB_FROM_XYZ: [[f32; 3]; 3] = [
    [3.241_003_3, -1.537_399, -0.498_615_9],
    [-0.969_224_3, 1.875_93, 0.041_554_22],
    [0.055_639_42, -0.204_011_2, 1.057_149],
];
/// XYZ of white (illuminant D65).
const WHITE: [f32; 3] = [0.950_428_55, 1.0, 1.088_900_4];

type FloatPlane = Vec<f32>;

/// LDR-FLIP of every pixel, 0 to 1, rows from the top. Linear values are clamped to 0..1 first; NaN counts as 0.
///
/// `pixels_per_degree` of visual angle is clamped to 1..1000; see [`DEFAULT_PIXELS_PER_DEGREE`].
///
/// # Errors
/// [`MetricError`] when the pictures' sizes differ.
pub fn flip_map(test: &Framebuffer, reference: &Framebuffer, pixels_per_degree: f32) -> Result<Vec<f32>, MetricError> {
    check(test, reference)?;
    let (width, height) = (test.width as usize, test.height as usize);
    if width == 0 || height == 0 {
        return Ok(Vec::new());
    }
    let pixels_per_degree = if pixels_per_degree.is_finite() { pixels_per_degree.clamp(1.0, 1000.0) } else { 1000.0 };
    let size = PictureSize { width, height };
    let filters = Filters::new(pixels_per_degree);
    let [test, reference] = [test, reference].map(|picture| FilteredPicture::new(picture, size, &filters));
    let largest = {
        let green = hunt_adjusted_lab([0.0, 1.0, 0.0]);
        let blue = hunt_adjusted_lab([0.0, 0.0, 1.0]);
        hyab(green, blue).powf(COLOR_EXPONENT)
    };
    let mut map = vec![0.0; width * height];
    parallel::for_each_chunk_mut(&mut map, width, |row, out| {
        for (column, value) in out.iter_mut().enumerate() {
            let index = row * width + column;
            let color = hyab(test.lab[index], reference.lab[index]).powf(COLOR_EXPONENT);
            let knee = COLOR_KNEE * largest;
            let color = if color < knee {
                color * ERROR_AT_KNEE / knee
            } else {
                ERROR_AT_KNEE + (color - knee) / (largest - knee) * (1.0 - ERROR_AT_KNEE)
            };
            let edge = (test.edges[index] - reference.edges[index]).abs();
            let point = (test.points[index] - reference.points[index]).abs();
            let feature = (std::f32::consts::FRAC_1_SQRT_2 * edge.max(point)).powf(FEATURE_EXPONENT);
            *value = color.clamp(0.0, 1.0).powf(1.0 - feature.clamp(0.0, 1.0));
        }
    });
    Ok(map)
}

#[derive(Clone, Copy)]
struct PictureSize {
    width: usize,
    height: usize,
}

/// A picture filtered by the eye's contrast sensitivity.
struct FilteredPicture {
    /// L*, a*, b* after the contrast filter, a* and b* scaled by lightness (Hunt's effect).
    lab: Vec<[f32; 3]>,
    /// Strength of edges.
    edges: FloatPlane,
    /// Strength of points.
    points: FloatPlane,
}

impl FilteredPicture {
    fn new(picture: &Framebuffer, size: PictureSize, filters: &Filters) -> Self {
        let opponent = opponent_planes(picture, size);
        let (edges, points) = features(&opponent[0], size, filters);
        let [achromatic, red_green, blue_yellow] = opponent;
        let filtered = [
            separable(&achromatic, size, &filters.achromatic, &filters.achromatic),
            separable(&red_green, size, &filters.red_green, &filters.red_green),
            separable(&blue_yellow, size, &filters.blue_yellow[0], &filters.blue_yellow[0]),
            separable(&blue_yellow, size, &filters.blue_yellow[1], &filters.blue_yellow[1]),
        ];
        let mut lab = vec![[0.0; 3]; size.width * size.height];
        parallel::for_each_chunk_mut(&mut lab, size.width, |row, out| {
            for (column, value) in out.iter_mut().enumerate() {
                let [a, rg, by, more_by] = [0, 1, 2, 3].map(|plane| filtered[plane][row * size.width + column]);
                let rgb = multiply(&RGB_FROM_XYZ, xyz_from_opponent([a, rg, by + more_by]));
                *value = hunt_adjusted_lab(rgb.map(|value| value.clamp(0.0, 1.0)));
            }
        });
        Self { lab, edges, points }
    }
}

/// The three planes of YCxCz, the opponent space in which the eye's sensitivity is given.
fn opponent_planes(picture: &Framebuffer, size: PictureSize) -> [FloatPlane; 3] {
    std::array::from_fn(|channel| {
        let mut plane = vec![0.0; size.width * size.height];
        parallel::for_each_chunk_mut(&mut plane, size.width, |row, out| {
            let pixels = &picture.pixels[row * size.width..][..out.len()];
            for (value, pixel) in out.iter_mut().zip(pixels) {
                let rgb = [pixel[0], pixel[1], pixel[2]].map(|c| if c > 0.0 { c.min(1.0) } else { 0.0 });
                let xyz = multiply(&XYZ_FROM_RGB, rgb);
                let [x, y, z] = std::array::from_fn(|axis| xyz[axis] / WHITE[axis]);
                *value = match channel {
                    0 => 116.0 * y - 16.0,
                    1 => 500.0 * (x - y),
                    _ => 200.0 * (y - z),
                };
            }
        });
        plane
    })
}

fn xyz_from_opponent([achromatic, red_green, blue_yellow]: [f32; 3]) -> [f32; 3] {
    let y = (achromatic + 16.0) / 116.0;
    [(y + red_green / 500.0) * WHITE[0], y * WHITE[1], (y - blue_yellow / 200.0) * WHITE[2]]
}

fn multiply(matrix: &[[f32; 3]; 3], vector: [f32; 3]) -> [f32; 3] {
    matrix.map(|row| row[0] * vector[0] + row[1] * vector[1] + row[2] * vector[2])
}

/// L*a*b* of a linear colour, with a* and b* scaled by lightness.
fn hunt_adjusted_lab(rgb: [f32; 3]) -> [f32; 3] {
    const DELTA: f32 = 6.0 / 29.0;
    let curve = |t: f32| if t > DELTA * DELTA * DELTA { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 };
    let xyz = multiply(&XYZ_FROM_RGB, rgb);
    let [x, y, z] = std::array::from_fn(|axis| curve(xyz[axis] / WHITE[axis]));
    let lightness = 116.0 * y - 16.0;
    [lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z)]
}

/// The distance of two colours: city block in lightness, Euclidean in hue and chroma.
fn hyab(a: [f32; 3], b: [f32; 3]) -> f32 {
    (a[0] - b[0]).abs() + ((a[1] - b[1]).powi(2) + (a[2] - b[2]).powi(2)).sqrt()
}

/// Strength of edges and points in the lightness of a picture.
fn features(achromatic: &[f32], size: PictureSize, filters: &Filters) -> (FloatPlane, FloatPlane) {
    let lightness: FloatPlane = achromatic.iter().map(|value| (value + 16.0) / 116.0).collect();
    let strength = |filter: &Kernel| {
        let mut along_x = separable(&lightness, size, filter, &filters.feature_blur);
        let along_y = separable(&lightness, size, &filters.feature_blur, filter);
        for (x, y) in along_x.iter_mut().zip(along_y) {
            *x = (*x * *x + y * y).sqrt();
        }
        along_x
    };
    (strength(&filters.edge), strength(&filters.point))
}

/// Weights from `-radius` to `radius`.
type Kernel = Vec<f32>;

struct Filters {
    achromatic: Kernel,
    red_green: Kernel,
    /// Two separable filters to be summed.
    blue_yellow: [Kernel; 2],
    feature_blur: Kernel,
    edge: Kernel,
    point: Kernel,
}

impl Filters {
    fn new(pixels_per_degree: f32) -> Self {
        // Sensitivity of each opponent channel as sums of Gaussians a sqrt(pi / b) exp(-pi^2 x^2 / b), x in degrees
        // (table 1 of the paper).
        const WIDEST: f32 = 0.04;
        let radius = (3.0 * (WIDEST / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as i32;
        let gaussian = |b: f32| -> Kernel {
            (-radius..=radius).map(|x| (-(PI * x as f32 / pixels_per_degree).powi(2) / b).exp()).collect()
        };
        let normalized = |mut kernel: Kernel| {
            let sum: f32 = kernel.iter().sum();
            kernel.iter_mut().for_each(|weight| *weight /= sum);
            kernel
        };
        let terms = [(34.1f32, 0.04f32), (13.5, 0.025)].map(|(a, b)| (a * (PI / b).sqrt(), gaussian(b)));
        let total: f32 = terms.iter().map(|(weight, kernel)| weight * kernel.iter().sum::<f32>().powi(2)).sum();
        let blue_yellow = terms.map(|(weight, kernel)| {
            let scale = (weight / total).sqrt();
            kernel.into_iter().map(|value| value * scale).collect()
        });

        let sigma = 0.5 * FEATURE_WIDTH_DEG * pixels_per_degree;
        let feature_radius = (3.0 * sigma).ceil() as i32;
        let feature = |shape: &dyn Fn(f32) -> f32| -> Kernel {
            (-feature_radius..=feature_radius)
                .map(|x| {
                    let x = x as f32;
                    shape(x) * (-x * x / (2.0 * sigma * sigma)).exp()
                })
                .collect()
        };
        Self {
            achromatic: normalized(gaussian(0.0047)),
            red_green: normalized(gaussian(0.0053)),
            blue_yellow,
            feature_blur: normalized(feature(&|_| 1.0)),
            edge: balanced(feature(&|x| -x)),
            point: balanced(feature(&|x| x * x / (sigma * sigma) - 1.0)),
        }
    }
}

/// Scales positive weights to the sum 1 and negative ones to -1.
fn balanced(mut kernel: Kernel) -> Kernel {
    let positive: f32 = kernel.iter().filter(|weight| **weight > 0.0).sum();
    let negative: f32 = -kernel.iter().filter(|weight| **weight < 0.0).sum::<f32>();
    for weight in &mut kernel {
        *weight /= if *weight > 0.0 { positive } else { negative };
    }
    kernel
}

/// The plane filtered with `horizontal` along rows and `vertical` along columns.
fn separable(plane: &[f32], size: PictureSize, horizontal: &[f32], vertical: &[f32]) -> FloatPlane {
    let PictureSize { width, height } = size;
    let mut rows = vec![0.0; plane.len()];
    parallel::for_each_chunk_mut(&mut rows, width, |row, out| {
        let source = &plane[row * width..][..width];
        let radius = horizontal.len() / 2;
        // With the border repeated, the inner loop runs over whole slices, which compilers turn into SIMD.
        let mut padded = Vec::with_capacity(width + 2 * radius);
        padded.resize(radius, source[0]);
        padded.extend_from_slice(source);
        padded.resize(width + 2 * radius, source[width - 1]);
        for (offset, weight) in horizontal.iter().enumerate() {
            for (value, neighbour) in out.iter_mut().zip(&padded[offset..]) {
                *value += neighbour * weight;
            }
        }
    });
    let mut filtered = vec![0.0; plane.len()];
    parallel::for_each_chunk_mut(&mut filtered, width, |row, out| {
        let radius = vertical.len() / 2;
        for (offset, weight) in vertical.iter().enumerate() {
            let from = (row + offset).saturating_sub(radius).min(height - 1);
            for (value, neighbour) in out.iter_mut().zip(&rows[from * width..][..width]) {
                *value += neighbour * weight;
            }
        }
    });
    filtered
}
