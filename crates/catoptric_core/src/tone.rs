//! Exposure and tone curves: what makes radiance of any range a picture for a screen.

use crate::framebuffer::{Framebuffer, linear_from_srgb};
use crate::math::portable::PortableMath;
use crate::parallel;
use glam::{Mat3, Vec3};

/// How bright radiance becomes display light between 0 and 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ToneCurve {
    /// As it is; brighter than 1 is white.
    #[default]
    None,
    /// Khronos PBR Neutral (Khronos 2024): colours up to 0.76 stay as they are.
    Neutral,
    /// AgX (Sobotka), in the polynomial form of Wrensch 2023, its base look.
    Agx,
    /// The Academy's reference transforms, fitted by Hill 2016.
    Aces,
}

/// The grey that automatic exposure makes of a picture's mean.
pub const MIDDLE_GREY: f32 = 0.18;

/// Automatic exposure changes a picture by no more than this, in stops.
const MOST_STOPS: f32 = 8.0;

/// By this many stops a picture becomes darker at most: snow in the sun, in physical units, needs 15.
const STOPS_OF_SUNLIGHT: f32 = 16.0;

impl ToneCurve {
    /// All of them, with the names that programs know them by.
    pub const NAMES: [(Self, &'static str); 4] =
        [(Self::None, "none"), (Self::Neutral, "neutral"), (Self::Agx, "agx"), (Self::Aces, "aces")];

    /// The name that programs know the curve by.
    pub fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(curve, _)| *curve == self).map_or("none", |(_, name)| name)
    }

    /// The display light of a linear colour, linear as well.
    pub fn of(self, color: Vec3) -> Vec3 {
        match self {
            Self::None => color,
            Self::Neutral => neutral(color),
            Self::Agx => agx(color),
            Self::Aces => aces(color),
        }
    }
}

fn neutral(color: Vec3) -> Vec3 {
    const DESATURATION: f32 = 0.15;
    const START: f32 = 0.8 - 0.04;
    let least = color.min_element();
    let offset = if least < 0.08 { least - 6.25 * least * least } else { 0.04 };
    let color = color - offset;
    let peak = color.max_element();
    if peak < START {
        return color;
    }
    let rest = 1.0 - START;
    let new_peak = 1.0 - rest * rest / (peak + rest - START);
    let grey = 1.0 - 1.0 / (DESATURATION * (peak - new_peak) + 1.0);
    (color * (new_peak / peak)).lerp(Vec3::splat(new_peak), grey)
}

fn agx(color: Vec3) -> Vec3 {
    const INSET: Mat3 = Mat3::from_cols_array(&[
        0.842_479_06,
        0.042_328_242,
        0.042_375_655,
        0.078_433_6,
        0.878_468_6,
        0.078_433_6,
        0.079_223_745,
        0.079_166_13,
        0.879_143,
    ]);
    const OUTSET: Mat3 = Mat3::from_cols_array(&[
        1.196_879,
        -0.052_896_85,
        -0.052_971_636,
        -0.098_020_88,
        1.151_903,
        -0.098_043_45,
        -0.099_029_74,
        -0.098_961_18,
        1.151_073_7,
    ]);
    /// Stops of the least and the brightest light.
    const STOPS: [f32; 2] = [-12.473_93, 4.026_069];
    let contrast = |value: f32| {
        let stops = value.max(1e-10).logarithm2().clamp(STOPS[0], STOPS[1]);
        let x = (stops - STOPS[0]) / (STOPS[1] - STOPS[0]);
        ((((((15.5 * x - 40.14) * x + 31.96) * x - 6.868) * x + 0.4298) * x + 0.1191) * x - 0.002_32).max(0.0)
    };
    let encoded = OUTSET * (INSET * color).map(contrast);
    encoded.map(|value| value.clamp(0.0, 1.0).power(2.2))
}

fn aces(color: Vec3) -> Vec3 {
    const INPUT: Mat3 = Mat3::from_cols_array(&[
        0.597_19, 0.076_0, 0.028_4, 0.354_58, 0.908_34, 0.133_83, 0.048_23, 0.015_66, 0.837_77,
    ]);
    const OUTPUT: Mat3 = Mat3::from_cols_array(&[
        1.604_75, -0.102_08, -0.003_27, -0.531_08, 1.108_13, -0.072_76, -0.073_67, -0.006_05, 1.076_02,
    ]);
    let curve = |v: f32| (v * (v + 0.024_578_6) - 0.000_090_537) / (v * (0.983_729 * v + 0.432_951) + 0.238_081);
    (OUTPUT * (INPUT * color).map(curve)).clamp(Vec3::ZERO, Vec3::ONE)
}

/// How radiance becomes light of a screen: times two to the power of the exposure, through a tone curve. The default
/// leaves it as it is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Display {
    /// In stops.
    pub exposure_stops: f32,
    /// The tone curve that follows the exposure.
    pub curve: ToneCurve,
}

impl Display {
    /// A display that shows the surfaces in a picture well: as they are where a screen can show them. Too bright ones
    /// become darker until one pixel in twenty is beyond white, so that white things stay white; too dark ones become
    /// brighter, by [`automatic_exposure`], but neither they nor the background brighter than that. Both with
    /// [`ToneCurve::Neutral`].
    ///
    /// `is_surface` says of each pixel whether it shows a surface or the background.
    pub fn fitting(picture: &Framebuffer, is_surface: &[bool]) -> Self {
        let white = |of_surfaces| exposure_of_white(pixels_where(picture, is_surface, of_surfaces));
        let exposure_stops = match range(pixels_where(picture, is_surface, true)) {
            Range::OfScreen => return Self::default(),
            Range::TooBright => white(true).max(-STOPS_OF_SUNLIGHT),
            Range::TooDark => automatic_exposure(picture, is_surface).min(white(true)).min(white(false)).max(0.0),
        };
        match exposure_stops == 0.0 {
            true => Self::default(),
            false => Self { exposure_stops, curve: ToneCurve::Neutral },
        }
    }

    /// The factor on radiance before the tone curve.
    pub fn scale(self) -> f32 {
        2f32.power(self.exposure_stops)
    }

    /// A picture for a screen; linear. Where the samples of a pixel are known, the exposure and the curve are those of
    /// each of them.
    #[must_use]
    pub fn of(self, picture: &Framebuffer) -> Framebuffer {
        displayed(picture, self.scale(), self.curve)
    }

    /// A picture at this exposure, without a tone curve: as pictures are compared.
    #[must_use]
    pub fn exposed(self, picture: &Framebuffer) -> Framebuffer {
        let scale = self.scale();
        let exposed = |[r, g, b, coverage]: &[f32; 4]| [r * scale, g * scale, b * scale, *coverage];
        Framebuffer::of_pixels(picture.width, picture.height, picture.pixels.iter().map(exposed).collect())
    }
}

fn displayed(picture: &Framebuffer, scale: f32, curve: ToneCurve) -> Framebuffer {
    let mut shown = Framebuffer::of_pixels(picture.width, picture.height, picture.pixels.clone());
    parallel::for_each_chunk_mut(&mut shown.pixels, 4096, |_, pixels| {
        for pixel in pixels {
            let [r, g, b, coverage] = *pixel;
            *pixel = curve.of(Vec3::new(r, g, b) * scale).extend(coverage).to_array();
        }
    });
    for (pixel, samples) in picture.edges.iter() {
        let sum: Vec3 = samples.iter().map(|sample| curve.of(*sample * scale).clamp(Vec3::ZERO, Vec3::ONE)).sum();
        let pixel = &mut shown.pixels[pixel as usize];
        *pixel = (sum / samples.len() as f32).extend(pixel[3]).to_array();
    }
    shown
}

/// Luminance of linear sRGB (IEC 61966-2-1).
fn luminance([r, g, b, _]: [f32; 4]) -> f32 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// The pixels that show surfaces, or those that show the background.
fn pixels_where(picture: &Framebuffer, is_surface: &[bool], of_surfaces: bool) -> impl Iterator<Item = [f32; 4]> {
    let chosen = picture.pixels.iter().zip(is_surface).filter(move |(_, is_surface)| **is_surface == of_surfaces);
    chosen.map(|(pixel, _)| *pixel)
}

/// The exposure, in stops, that brings the mean of the logarithm of the luminance of surfaces to [`MIDDLE_GREY`], eight
/// at most; 0 without surfaces. `is_surface` says of each pixel whether it shows one.
pub fn automatic_exposure(picture: &Framebuffer, is_surface: &[bool]) -> f32 {
    // Black must not decide: below a step of eight bits after the brightest exposure all is the same.
    const BLACK: f32 = 1e-5;
    let (mut sum, mut count) = (0.0f64, 0u32);
    for pixel in pixels_where(picture, is_surface, true) {
        sum += f64::from(luminance(pixel).max(BLACK).logarithm2());
        count += 1;
    }
    match count {
        0 => 0.0,
        count => {
            let mean = (sum / f64::from(count)) as f32;
            (MIDDLE_GREY.logarithm2() - mean).clamp(-MOST_STOPS, MOST_STOPS)
        }
    }
}

/// The exposure, in stops, with which one in twenty pixels is beyond white in one of its channels; infinite without
/// pixels.
fn exposure_of_white(pixels: impl Iterator<Item = [f32; 4]>) -> f32 {
    let mut brightest: Vec<f32> = pixels.map(|[r, g, b, _]| r.max(g).max(b)).collect();
    if brightest.is_empty() {
        return f32::INFINITY;
    }
    let place = (brightest.len() - 1) * 19 / 20;
    let (_, white, _) = brightest.select_nth_unstable_by(place, f32::total_cmp);
    -white.max(f32::MIN_POSITIVE).logarithm2()
}

/// How much of pixels a screen shows as they stand.
enum Range {
    OfScreen,
    /// Their mean is below a fiftieth of white.
    TooDark,
    /// A tenth of them is beyond white in one of its channels.
    TooBright,
}

fn range(pixels: impl Iterator<Item = [f32; 4]>) -> Range {
    let (mut sum, mut clipped, mut count) = (0.0f64, 0u32, 0u32);
    for pixel in pixels {
        sum += f64::from(luminance(pixel).min(1.0));
        clipped += u32::from(pixel[..3].iter().any(|channel| *channel > 1.0));
        count += 1;
    }
    let least_sum = f64::from(linear_from_srgb(0.15)) * f64::from(count);
    match (clipped * 10 > count, sum < least_sum) {
        (true, _) => Range::TooBright,
        (false, true) => Range::TooDark,
        (false, false) => Range::OfScreen,
    }
}
