//! Reflection by microscopic facets: the distribution of Trowbridge and Reitz (GGX; Walter et al. 2007), Smith's
//! height-correlated masking and shadowing (Heitz 2014), Schlick's approximation of Fresnel's equations.
//!
//! Bodies are scalar and without branches, so that loops over lanes become vector instructions. `alpha` is the square
//! of the perceptual roughness, `n_l`, `n_v`, `l_h` are cosines between the normal, the directions to light and viewer,
//! and the half vector between them.

use crate::math::portable::PortableMath;
use glam::{Vec2, Vec3, Vec4};
use std::f32::consts::{FRAC_1_PI, PI, TAU};
use std::sync::LazyLock;

/// Perceptual roughness of the smoothest surface that is lit: its highlight is a tenth of a degree wide.
pub const LEAST_ROUGHNESS: f32 = 0.03;

/// The least cosine towards a viewer: interpolated and mapped normals may turn away from who sees the surface.
pub(super) const LEAST_COSINE: f32 = 1e-4;

/// The distribution's value times masking and shadowing, over four times both cosines: what Fresnel's share is
/// multiplied with.
///
/// The half vector is given by squares of its cosine and sine to the normal: both, as one of them is small and the
/// other one says little about it. Integrated over all facets that face the normal, the distribution is 1.
#[inline(always)]
pub fn lobe(alpha: f32, half_cosine2: f32, half_sine2: f32, n_l: f32, n_v: f32) -> f32 {
    let alpha2 = alpha * alpha;
    let spread = half_sine2 + alpha2 * half_cosine2;
    // Without a half vector, opposite to the light, both are 0.
    let spread = if spread > 1e-9 { spread } else { 1e-9 };
    let masking =
        n_l * (n_v * n_v * (1.0 - alpha2) + alpha2).sqrt() + n_v * (n_l * n_l * (1.0 - alpha2) + alpha2).sqrt();
    let masking = if masking > 1e-12 { masking } else { 1e-12 };
    (0.5 * FRAC_1_PI) * alpha2 / (spread * spread * masking)
}

/// Fifth power of one minus a cosine: how far Schlick's reflectance is from that at normal incidence to that at grazing
/// angles.
#[inline(always)]
pub fn grazing_share(cosine: f32) -> f32 {
    let m = 1.0 - cosine;
    let m = if m > 0.0 { m } else { 0.0 };
    let m2 = m * m;
    m2 * m2 * m
}

/// A facet that a viewer sees, chosen by two numbers between 0 and 1: [`VisibleFacets::facet`].
#[inline(always)] // for the instructions of its caller
pub fn visible_facet(alpha: f32, towards_viewer: Vec3, number: Vec2) -> Vec3 {
    VisibleFacets::new(alpha, towards_viewer).facet(disc_point(number))
}

/// A point of the unit disc for two numbers between 0 and 1; all of its parts are equally likely.
#[inline(always)] // for the instructions of its caller
pub fn disc_point(number: Vec2) -> Vec2 {
    let (radius, angle) = (number.x.sqrt(), TAU * number.y);
    Vec2::new(radius * angle.cosine(), radius * angle.sine())
}

/// The facets that a viewer sees (Heitz 2018, Sampling the GGX distribution of visible normals).
#[derive(Clone, Copy, Debug)]
pub struct VisibleFacets {
    alpha: Vec2,
    /// The hemisphere that the stretched view sees.
    view: Vec3,
    across: Vec3,
    along: Vec3,
}

impl VisibleFacets {
    /// The facets seen from a direction, in a frame whose z axis is the surface's normal; the direction is above it.
    #[inline(always)] // for the instructions of its caller
    pub fn new(alpha: f32, towards_viewer: Vec3) -> Self {
        Self::stretched(Vec2::splat(alpha), towards_viewer)
    }

    /// The same of facets whose slopes differ along the frame's x and y axes.
    #[inline(always)] // for the instructions of its caller
    pub fn stretched(alpha: Vec2, towards_viewer: Vec3) -> Self {
        let view = Vec3::new(alpha.x * towards_viewer.x, alpha.y * towards_viewer.y, towards_viewer.z);
        let view = view.normalize_or(Vec3::Z);
        let length2 = view.x * view.x + view.y * view.y;
        let across = if length2 > 1e-14 { Vec3::new(-view.y, view.x, 0.0) / length2.sqrt() } else { Vec3::X };
        Self { alpha, view, across, along: view.cross(across) }
    }

    /// The normal, in the same frame, of the facet that belongs to a point of the unit disc ([`disc_point`]).
    #[inline(always)] // for the instructions of its caller
    pub fn facet(&self, disc: Vec2) -> Vec3 {
        let Self { alpha, view, across, along } = *self;
        let (x, y) = (disc.x, disc.y);
        let share = 0.5 * (1.0 + view.z);
        let y = (1.0 - share) * (1.0 - x * x).max(0.0).sqrt() + share * y;
        let facet = across * x + along * y + view * (1.0 - x * x - y * y).max(0.0).sqrt();
        let facet = Vec3::new(alpha.x * facet.x, alpha.y * facet.y, facet.z.max(1e-6));
        facet * (1.0 / facet.length())
    }
}

/// The share of light from a facet that a viewer sees ([`visible_facet`]) which arrives at the facet, too: masking and
/// shadowing over masking alone.
#[inline(always)] // for the instructions of its caller
pub fn unshadowed_share(alpha: f32, n_l: f32, n_v: f32) -> f32 {
    let n_l = if n_l > 0.0 { n_l } else { 0.0 };
    let alpha2 = alpha * alpha;
    let slope = |cosine: f32| (alpha2 + (1.0 - alpha2) * cosine * cosine).sqrt();
    let (of_light, of_viewer) = (n_v * slope(n_l), n_l * slope(n_v));
    // G2 / G1 with both in Smith's form.
    n_l * (n_v + slope(n_v)) / (of_light + of_viewer).max(1e-12)
}

/// [`unshadowed_share`] of facets whose slopes differ along two axes: directions in the frame of these axes and the
/// normal.
pub fn unshadowed_share_stretched(alpha: Vec2, light: Vec3, viewer: Vec3) -> f32 {
    let slope = |to: Vec3| Vec3::new(alpha.x * to.x, alpha.y * to.y, to.z).length();
    let (n_l, n_v) = (light.z.max(0.0), viewer.z);
    n_l * (n_v + slope(viewer)) / (n_v * slope(light) + n_l * slope(viewer)).max(1e-12)
}

/// [`extent_of_sample`] of facets whose slopes differ along two axes: the facet in the frame of these axes and the
/// normal.
pub fn extent_of_stretched_sample(alpha: Vec2, facet: Vec3, n_v: f32, count: u32) -> f32 {
    let spread = (facet / alpha.extend(1.0)).length_squared();
    let density = 1.0 / (PI * alpha.x * alpha.y * spread * spread) / (4.0 * n_v);
    1.0 / (count as f32 * density.max(1e-9))
}

/// The solid angle that the light of one of `count` facets stands for, chosen by [`visible_facet`], by the cosines of
/// facet and viewer with the normal.
///
/// The density of facets that a viewer sees is their distribution times the facet's over the viewer's cosine, without
/// masking; a mirror spreads it over four times the solid angle, times the cosine between both.
#[inline(always)] // for the instructions of its caller
pub fn extent_of_sample(alpha: f32, n_h: f32, n_v: f32, count: u32) -> f32 {
    let spread = 1.0 - n_h * n_h * (1.0 - alpha * alpha);
    let density = alpha * alpha / (PI * spread * spread) / (4.0 * n_v);
    1.0 / (count as f32 * density.max(1e-9))
}

/// Cells of the table a side, less one.
pub const CELLS: usize = 32;

/// The reflection of light that arrives from all around, by the surface's roughness, then the cosine towards the
/// viewer.
pub struct ReflectanceTable([[Vec4; CELLS + 1]; CELLS + 1]);

/// A surface's reflection of light that arrives from all around (Karis 2013's split sum), in two factors.
#[derive(Clone, Copy, Debug)]
pub struct ReflectedSurroundings {
    /// The factor on the reflectance at normal incidence.
    pub at_normal: f32,
    /// The factor on that at grazing angles.
    pub at_grazing: f32,
    /// Where the middle of the highlight lies on the way from the normal to the mirror direction: facets that lean far
    /// away from the normal are masked.
    pub tilt: f32,
    /// The factor on alpha that gives a highlight, seen along the normal, of the same spread.
    pub spread: f32,
}

static TABLE: LazyLock<ReflectanceTable> = LazyLock::new(ReflectanceTable::new);

/// A surface's reflection, summed over facets that a viewer sees.
struct Reflected {
    at_normal: f32,
    at_grazing: f32,
    /// The mean direction of light, not of unit length.
    mean: Vec3,
    viewer: Vec3,
}

impl Reflected {
    fn new(roughness: f32, n_v: f32) -> Self {
        // Few facets lean far: their places must be fine along the first number.
        const RINGS: u32 = 40;
        const SPOKES: u32 = 9;
        let (roughness, n_v) = (roughness.max(LEAST_ROUGHNESS), n_v.max(1e-3));
        let alpha = roughness * roughness;
        let viewer = Vec3::new((1.0 - n_v * n_v).sqrt(), 0.0, n_v);
        let mut sum = Self { at_normal: 0.0, at_grazing: 0.0, mean: Vec3::ZERO, viewer };
        for place in 0..RINGS * SPOKES {
            let (ring, spoke) = ((place / SPOKES) as f32 + 0.5, (place % SPOKES) as f32 + 0.5);
            let facet = visible_facet(alpha, viewer, Vec2::new(ring / RINGS as f32, spoke / SPOKES as f32));
            let v_h = viewer.dot(facet);
            let light = facet * (2.0 * v_h) - viewer;
            let share = unshadowed_share(alpha, light.z, n_v) / (RINGS * SPOKES) as f32;
            let grazing = grazing_share(v_h);
            sum.at_normal += share * (1.0 - grazing);
            sum.at_grazing += share * grazing;
            sum.mean += light * share;
        }
        sum.mean /= (sum.at_normal + sum.at_grazing).max(1e-6);
        sum
    }

    /// How far directions are spread: 1 less the length of their mean.
    fn spread(&self) -> f32 {
        (1.0 - self.mean.length()).max(0.0)
    }

    /// See [`ReflectedSurroundings::tilt`].
    fn tilt(&self) -> f32 {
        let mirrored = Vec3::new(-self.viewer.x, 0.0, self.viewer.z);
        // The share at which the way from the normal crosses the mean direction, in the plane of both.
        let (x, z) = (self.mean.x, self.mean.z);
        let across = z * mirrored.x - x * (mirrored.z - 1.0);
        if across.abs() < 1e-4 { 1.0 } else { (x / across).clamp(0.0, 1.0) }
    }
}

impl ReflectanceTable {
    /// The table; the first call makes it.
    pub fn get() -> &'static Self {
        &TABLE
    }

    /// The table's cells: rows by perceptual roughness, columns by the cosine towards the viewer, both from 0 to 1; the
    /// fields of [`ReflectedSurroundings`] in their order. Between them look-ups are linear.
    pub fn rows(&self) -> &[[Vec4; CELLS + 1]; CELLS + 1] {
        &self.0
    }

    fn new() -> Self {
        let at = |cell: usize| cell as f32 / CELLS as f32;
        let along_normal: Vec<f32> = (0..=CELLS).map(|row| Reflected::new(at(row), 1.0).spread()).collect();
        let mut rows = [[Vec4::ZERO; CELLS + 1]; CELLS + 1];
        for (row, cells) in rows.iter_mut().enumerate() {
            for (column, cell) in cells.iter_mut().enumerate() {
                let reflected = Reflected::new(at(row), at(column));
                // The roughness that, seen along the normal, spreads light as far.
                let spread = reflected.spread();
                let above = along_normal.partition_point(|known| *known < spread).clamp(1, CELLS);
                let (low, high) = (along_normal[above - 1], along_normal[above]);
                let share = ((spread - low) / (high - low).max(1e-9)).clamp(0.0, 1.0);
                let equal = at(above - 1) + share / CELLS as f32;
                let spread = if row == 0 { 1.0 } else { (equal / at(row)).powi(2).clamp(0.25, 4.0) };
                *cell = Vec4::new(reflected.at_normal, reflected.at_grazing, reflected.tilt(), spread);
            }
        }
        Self(rows)
    }

    /// The reflection at a perceptual roughness and a cosine towards the viewer; factors to about 0.005.
    #[inline(always)]
    pub fn reflected(&self, roughness: f32, n_v: f32) -> ReflectedSurroundings {
        let at = |value: f32| {
            let scaled = (value * CELLS as f32).clamp(0.0, CELLS as f32 - 1e-3);
            (scaled as usize, scaled - scaled.floor())
        };
        let ((row, down), (column, right)) = (at(roughness), at(n_v));
        let [upper, lower] = [&self.0[row], &self.0[row + 1]];
        let [upper, lower] = [upper, lower].map(|row| row[column] * (1.0 - right) + row[column + 1] * right);
        let [at_normal, at_grazing, tilt, spread] = (upper * (1.0 - down) + lower * down).to_array();
        ReflectedSurroundings { at_normal, at_grazing, tilt, spread }
    }
}

impl ReflectedSurroundings {
    /// The middle of the highlight's directions of light.
    #[inline(always)]
    pub fn middle(&self, normal: Vec3, mirrored: Vec3) -> Vec3 {
        (normal + (mirrored - normal) * self.tilt).normalize_or(normal)
    }

    /// The alpha of a highlight, seen along the normal, of the same spread.
    #[inline(always)]
    pub fn alpha(&self, alpha: f32) -> f32 {
        (alpha * self.spread).min(1.0)
    }
}

/// Roughness widened by facets' normals that vary within what is shaded: `variance` is the mean square, along two axes
/// together, of their distance to the mean (Kaplanyan, Hill, Patney, Lefohn 2016; a distribution's alpha squared is
/// twice its slopes' variance an axis).
#[inline(always)]
pub fn widened_alpha(alpha: f32, variance: f32) -> f32 {
    let widened = (alpha * alpha + variance).sqrt();
    if widened < 1.0 { widened } else { 1.0 }
}

/// Variance of normals over a pixel: `change2` is the sum of squares of their changes along columns and rows. Position
/// within a pixel has a variance of 1 over 2 pi along each, and what comes out is bounded, as Tokuyoshi and Kaplanyan
/// propose (2019, listing 5).
#[inline(always)]
pub fn variance_over_pixel(change2: f32) -> f32 {
    let variance = change2 * (0.5 * FRAC_1_PI);
    if variance < 0.18 { variance } else { 0.18 }
}

/// Variance of normals whose mean has this length: for the lobes of facets' normals, 1 less the length is half the sum
/// of the variances along both axes (Toksvig 2005).
#[inline(always)]
pub fn variance_of_mean(length: f32) -> f32 {
    // Below the steps of sixteen bits it is no variance.
    let lost = 1.0 - length - 4e-5;
    let lost = if lost > 0.0 { lost } else { 0.0 };
    2.0 * lost / (if length > 0.1 { length } else { 0.1 })
}
