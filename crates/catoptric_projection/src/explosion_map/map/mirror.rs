//! Many points mirrored at once: the paper's virtual vertices, eight points abreast.

use super::ExplosionMap;
use super::chart::TURN;
use catoptric_core::math::lanes::{LANES, Lanes};
use glam::{Vec2, Vec3, Vec3A};

/// The look-up of eight points.
#[derive(Default)]
struct Lookup {
    /// The place in the map.
    u: Lanes,
    v: Lanes,
    /// The place in the first or second chart, in texels.
    column: Lanes,
    row: Lanes,
    /// The coordinate along the axis of the first chart, of the unit direction.
    height: Lanes,
    /// The reciprocal of the distance from the centre.
    nearness: Lanes,
    /// The number of spheres that are nearer, the first and the last two not counted.
    nearer: Lanes,
}

/// The spheres' constants for a batch.
struct Spheres<'a> {
    map: &'a ExplosionMap,
    size: f32,
    /// True if the first one is the reflector itself.
    itself: bool,
    /// The reciprocals of the spheres' radii, the nearest first; without the reflector itself.
    curvatures: Vec<f32>,
    /// The reciprocals of the differences between neighbouring `curvatures`.
    spans: Vec<f32>,
}

impl ExplosionMap {
    /// Finds the mirror images of points, from the first cell of each sphere; not finite where there is none. For
    /// reflectors that show a point once.
    pub(in super::super) fn mirror_images(&self, points: &[Vec3], images: &mut [Vec3]) {
        let curvatures: Vec<f32> =
            self.spheres.iter().filter_map(|sphere| sphere.radius).map(|radius| 1.0 / radius).collect();
        let spans = curvatures.windows(2).map(|pair| 1.0 / (pair[0] - pair[1])).collect();
        let itself = self.spheres.len() > curvatures.len();
        mirror(&Spheres { map: self, size: self.size as f32, itself, curvatures, spans }, points, images);
    }
}

#[multiversion::multiversion(targets("x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"))]
fn mirror(spheres: &Spheres<'_>, points: &[Vec3], images: &mut [Vec3]) {
    let mut lookup = Lookup::default();
    for (points, images) in points.chunks(LANES).zip(images.chunks_mut(LANES)) {
        let mut batch = [Vec3::ZERO; LANES];
        batch[..points.len()].copy_from_slice(points);
        look_up(spheres, &batch, &mut lookup);
        for (lane, image) in images.iter_mut().enumerate() {
            *image = mirrored(spheres, &lookup, lane, batch[lane]);
        }
    }
}

/// Finds the places of eight points: [`super::chart::Axes::place`] without branches.
#[inline(always)]
fn look_up(spheres: &Spheres<'_>, points: &[Vec3; LANES], lookup: &mut Lookup) {
    let center = spheres.map.center;
    let [right, down, ahead] = spheres.map.axes.all();
    let scale = 0.5 * spheres.size;
    let [mut xs, mut ys, mut zs] = [[0.0; LANES]; 3];
    for (lane, point) in points.iter().enumerate() {
        [xs[lane], ys[lane], zs[lane]] = (*point - center).to_array();
    }
    let middle = spheres.curvatures.get(1..spheres.curvatures.len().saturating_sub(1)).unwrap_or_default();
    for (lane, ((&x, &y), &z)) in xs.iter().zip(&ys).zip(&zs).enumerate() {
        let nearness = 1.0 / (x * x + y * y + z * z).sqrt();
        let along = |axis: Vec3| (x * axis.x + y * axis.y + z * axis.z) * nearness;
        let (across, below, height) = (along(right), along(down), along(ahead));
        let turn = if height < TURN { -1.0 } else { 1.0 };
        let shrink = 1.0 / (2.0 + 2.0 * height * turn).sqrt();
        let (u, v) = (across * shrink, below * turn * shrink);
        lookup.u[lane] = u;
        lookup.v[lane] = v;
        lookup.column[lane] = (u + 1.0) * scale;
        lookup.row[lane] = (v + 1.0) * scale;
        lookup.height[lane] = height;
        lookup.nearness[lane] = nearness;
        lookup.nearer[lane] = 0.0;
    }
    for curvature in middle {
        for lane in 0..LANES {
            lookup.nearer[lane] += if *curvature > lookup.nearness[lane] { 1.0 } else { 0.0 };
        }
    }
}

/// The mirror image of one of eight points: between those in the two spheres' tangent planes.
#[inline(always)]
fn mirrored(spheres: &Spheres<'_>, lookup: &Lookup, lane: usize, point: Vec3) -> Vec3 {
    let nearness = lookup.nearness[lane];
    let (chart, uv) = (usize::from(lookup.height[lane] < TURN), Vec2::new(lookup.u[lane], lookup.v[lane]));
    // Casts saturate, and places lie within the map.
    let texel = lookup.row[lane] as u32 * spheres.size as u32 + lookup.column[lane] as u32;
    let inner = spheres.itself && nearness > spheres.curvatures[0];
    let near = if inner { 0 } else { usize::from(spheres.itself) + lookup.nearer[lane] as usize };
    let [near_chart, far_chart] = [near, near + 1].map(|sphere| &spheres.map.spheres[sphere].charts[chart]);
    let (one, other) = (near_chart.first_in(texel as usize), far_chart.first_in(texel as usize));
    let (Some(one), Some(other)) = (one.or(other), other.or(one)) else { return Vec3::NAN };
    let ([here, here_normal], [there, there_normal]) = (one.at(uv), other.at(uv));
    let share = if inner {
        let [near, far] = [near, near + 1].map(|sphere| &spheres.map.spheres[sphere]);
        spheres.map.share([near, far], [here, there], 1.0 / nearness).0
    } else {
        let nearer = lookup.nearer[lane] as usize;
        let share = (spheres.curvatures[nearer] - nearness) * spheres.spans[nearer];
        // The share is 0 if it is not a number, too.
        if share > 0.0 { share.min(1.0) } else { 0.0 }
    };
    let point = Vec3A::from(point);
    let step_to_image =
        |position: Vec3A, normal: Vec3A| normal * (-2.0 * normal.dot(point - position) / normal.length_squared());
    let (near_step, far_step) = (step_to_image(here, here_normal), step_to_image(there, there_normal));
    (point + near_step + (far_step - near_step) * share).into()
}
