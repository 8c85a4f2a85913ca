//! A clear sky with its sun as light from infinity.
//!
//! The sky's luminance and chromaticity are those of Preetham, Shirley, Smits, "A Practical Analytic Model for
//! Daylight" (1999), which follow Perez, Seals, Michalsky (1993); the sun is dimmed by air and haze as in their
//! appendix, without ozone and water vapour.

use catoptric_core::math::portable::PortableMath;
use catoptric_core::scene::Environment;
use glam::{DMat3, DVec3};
use std::f64::consts::{PI, TAU};

const WIDTH: u32 = 1024;
const HEIGHT: u32 = 512;

/// The haze: 2 is very clear, 10 is hazy.
const TURBIDITY: f64 = 2.5;

/// The sun stands 45 degrees high, to the left behind an eye that looks along -z.
const TO_SUN: DVec3 = DVec3::new(-0.642, 1.0, 0.766);

/// The sun's angular radius in radians, and its illuminance above the air in kilolux.
const SUN_RADIUS: f64 = 0.2666 * PI / 180.0;
const SUN_KILOLUX: f64 = 127.5;

/// Wavelengths that stand for red, green and blue, in micrometres.
const WAVELENGTHS: DVec3 = DVec3::new(0.615, 0.55, 0.465);

/// The share of light that the ground scatters.
const GROUND: DVec3 = DVec3::new(0.24, 0.21, 0.17);

/// Radiance of a white surface that lies flat: bright, and not burnt out where it faces the sun.
const WHITE: f64 = 0.8;

/// Weights of linear Rec. 709 colours in luminance.
const LUMINANCE: DVec3 = DVec3::new(0.2126, 0.7152, 0.0722);

/// A clear sky with the sun 45 degrees high, towards -x and +z, above grey ground. A white surface that lies flat is
/// nearly white.
pub fn sky() -> Environment {
    let sun = TO_SUN.normalize();
    let model = Preetham::new(sun);
    let texels: Vec<Texel> = texels().collect();
    // In thousands of candelas a square metre.
    let mut radiance: Vec<DVec3> = texels.iter().map(|texel| model.radiance(texel.towards)).collect();
    let sunlight = sunlight(sun.y);
    let scattered = texels.iter().zip(&radiance).map(|(texel, light)| *light * (texel.towards.y.max(0.0) * texel.area));
    let irradiance = scattered.sum::<DVec3>() + sunlight * sun.y;
    let ground = GROUND * irradiance / PI;
    for (texel, light) in texels.iter().zip(&mut radiance).filter(|(texel, _)| texel.towards.y < 0.0) {
        // The horizon lies in haze.
        let share = (texel.towards.y / -0.06).min(1.0);
        *light = light.lerp(ground, share * share * (3.0 - 2.0 * share));
    }
    // The sun's light spread over the texels that its disc covers, all of it.
    let disc: Vec<(usize, f64)> = (0..texels.len())
        .filter(|index| texels[*index].towards.dot(sun) > (4.0 * SUN_RADIUS).cosine())
        .map(|index| (index, covered(index, sun)))
        .collect();
    let area: f64 = disc.iter().map(|(index, share)| texels[*index].area * share).sum();
    for (index, share) in disc {
        radiance[index] += sunlight * (share / area);
    }
    let scale = WHITE * PI / irradiance.dot(LUMINANCE);
    let radiance = radiance.into_iter().map(|light| (light * scale).as_vec3().to_array()).collect();
    Environment::new("sky", WIDTH, HEIGHT, radiance)
}

/// A texel of the picture: the direction of its middle and its solid angle.
struct Texel {
    towards: DVec3,
    area: f64,
}

/// The texels, rows from the top.
fn texels() -> impl Iterator<Item = Texel> {
    (0..WIDTH * HEIGHT).map(|index| {
        let (column, row) = (index % WIDTH, index / WIDTH);
        let polar = |edge: u32| (PI * f64::from(edge) / f64::from(HEIGHT)).cosine();
        let area = TAU / f64::from(WIDTH) * (polar(row) - polar(row + 1));
        Texel { towards: direction(f64::from(column) + 0.5, f64::from(row) + 0.5), area }
    })
}

/// The direction of a place in the picture, in texels ([`Environment::direction`] in double precision).
fn direction(x: f64, y: f64) -> DVec3 {
    let (sine, cosine) = (y / f64::from(HEIGHT) * PI).sine_cosine();
    let (across_sine, across_cosine) = ((x / f64::from(WIDTH) - 0.5) * TAU).sine_cosine();
    DVec3::new(sine * across_cosine, cosine, sine * across_sine)
}

/// The share of a texel that the sun's disc covers.
fn covered(index: usize, sun: DVec3) -> f64 {
    const PLACES: usize = 16;
    let (column, row) = (index % WIDTH as usize, index / WIDTH as usize);
    let within = |place: usize| (place as f64 + 0.5) / PLACES as f64;
    let least = SUN_RADIUS.cosine();
    let is_in = |place: &usize| {
        let (x, y) = (column as f64 + within(place % PLACES), row as f64 + within(place / PLACES));
        direction(x, y).dot(sun) > least
    };
    (0..PLACES * PLACES).filter(is_in).count() as f64 / (PLACES * PLACES) as f64
}

/// The illuminance of a surface that faces the sun, in kilolux: what is left of white light behind so much air.
fn sunlight(sine_of_height: f64) -> DVec3 {
    let height_deg = sine_of_height.arc_sine().to_degrees();
    // Kasten 1965: how much more air there is than above.
    let air = 1.0 / (sine_of_height + 0.15 * (3.885 + height_deg).power(-1.253));
    let haze = 0.04608 * TURBIDITY - 0.04586;
    let left = |wavelength: f64| {
        let depth = 0.008735 * wavelength.power(-4.08) + haze * wavelength.power(-1.3);
        SUN_KILOLUX * (-depth * air).exponential()
    };
    DVec3::from(WAVELENGTHS.to_array().map(left))
}

/// The distribution of luminance and chromaticity over the sky.
struct Preetham {
    sun: DVec3,
    /// Luminance in thousands of candelas a square metre, and chromaticity, above.
    zenith: [f64; 3],
    /// The five numbers of each one's distribution.
    distributions: [[f64; 5]; 3],
    /// The values of the distributions above.
    above: [f64; 3],
}

impl Preetham {
    fn new(sun: DVec3) -> Self {
        const SLOPES: [[f64; 5]; 3] = [
            [0.1787, -0.3554, -0.0227, 0.1206, -0.0670],
            [-0.0193, -0.0665, -0.0004, -0.0641, -0.0033],
            [-0.0167, -0.0950, -0.0079, -0.0441, -0.0109],
        ];
        const STARTS: [[f64; 5]; 3] = [
            [-1.4630, 0.4275, 5.3251, -2.5771, 0.3703],
            [-0.2592, 0.0008, 0.2125, -0.8989, 0.0452],
            [-0.2608, 0.0092, 0.2102, -1.6537, 0.0529],
        ];
        // By powers of the turbidity and of the sun's angle from the zenith, highest first.
        const ZENITH: [[[f64; 4]; 3]; 2] = [
            [
                [0.00166, -0.00375, 0.00209, 0.0],
                [-0.02903, 0.06377, -0.03202, 0.00394],
                [0.11693, -0.21196, 0.06052, 0.25886],
            ],
            [
                [0.00275, -0.00610, 0.00317, 0.0],
                [-0.04214, 0.08970, -0.04153, 0.00516],
                [0.15346, -0.26756, 0.06670, 0.26688],
            ],
        ];
        let angle = sun.y.arc_cosine();
        let polynomial = |terms: &[f64], at: f64| terms.iter().fold(0.0, |sum, term| sum * at + term);
        let chromaticity = |rows: &[[f64; 4]; 3]| polynomial(&rows.map(|row| polynomial(&row, angle)), TURBIDITY);
        let spread = (4.0 / 9.0 - TURBIDITY / 120.0) * (PI - 2.0 * angle);
        let luminance = (4.0453 * TURBIDITY - 4.9710) * spread.tangent() - 0.2155 * TURBIDITY + 2.4192;
        let number = |kind: usize, index: usize| SLOPES[kind][index] * TURBIDITY + STARTS[kind][index];
        let distributions = [0, 1, 2].map(|kind| [0, 1, 2, 3, 4].map(|index| number(kind, index)));
        let zenith = [luminance, chromaticity(&ZENITH[0]), chromaticity(&ZENITH[1])];
        let above = distributions.map(|numbers| perez(numbers, 1.0, angle));
        Self { sun, zenith, distributions, above }
    }

    /// The linear radiance towards a direction; below the horizon that of the horizon.
    fn radiance(&self, towards: DVec3) -> DVec3 {
        let from_sun = towards.dot(self.sun).clamp(-1.0, 1.0).arc_cosine();
        let height = towards.y.max(0.01);
        let [luminance, x, y] = [0, 1, 2]
            .map(|kind| self.zenith[kind] * perez(self.distributions[kind], height, from_sun) / self.above[kind]);
        // Near the horizon the model is purple. Skies at day are no less green than the CIE's daylight illuminants are
        // (Judd, MacAdam, Wyszecki 1964).
        let y = y.max((2.87 - 3.0 * x) * x - 0.275);
        let xyz = DVec3::new(x / y, 1.0, (1.0 - x - y) / y) * luminance;
        (rec_709_from_xyz() * xyz).max(DVec3::ZERO)
    }
}

/// The distribution of Perez, by the sine of the height above the horizon and the angle from the sun.
fn perez([a, b, c, d, e]: [f64; 5], sine_of_height: f64, from_sun: f64) -> f64 {
    let cosine = from_sun.cosine();
    (1.0 + a * (b / sine_of_height).exponential()) * (1.0 + c * (d * from_sun).exponential() + e * cosine * cosine)
}

/// From the tristimulus values X, Y, Z to linear Rec. 709 colours.
fn rec_709_from_xyz() -> DMat3 {
    DMat3::from_cols(
        DVec3::new(3.2404542, -0.9692660, 0.0556434),
        DVec3::new(-1.5371385, 1.8760108, -0.2040259),
        DVec3::new(-0.4985314, 0.0415560, 1.0572252),
    )
}
