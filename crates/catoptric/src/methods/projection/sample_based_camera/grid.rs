//! The dense ray map: every d-th view ray in both directions, followed through reflectors and lenses.

use crate::methods::projection::ray_map::{RayField, Specular};
use crate::methods::projection::{MAX_BOUNCES, SpecularPath};
use crate::optics::bundle::{Bounce, BounceKind};
use crate::parallel;
use crate::scene::{Ray, Role};
use glam::DVec3;

/// Cells a path has no ray in.
pub(super) const NO_RAY: u32 = u32::MAX;

/// An outgoing ray, without the path that led to it.
#[derive(Clone, Copy, Debug)]
pub(super) struct GridRay {
    /// The first bounce point, and the unit normal there, on the side of the eye.
    pub(super) first: DVec3,
    pub(super) normal: DVec3,
    /// Its tail, the last bounce point, and unit direction.
    pub(super) tail: DVec3,
    pub(super) direction: DVec3,
    /// Optical length from the eye (its plane) to the tail.
    pub(super) length: f64,
    /// Index of refraction of what it runs through.
    pub(super) medium: f64,
}

/// All rays of one path, on the grid.
#[derive(Clone, Debug)]
pub(super) struct GroupRays {
    pub(super) path: SpecularPath,
    pub(super) rays: Vec<GridRay>,
    /// The ray of each cell, or [`NO_RAY`].
    pub(super) ray_of_cell: Vec<u32>,
}

/// The rays of every path, on one grid of `columns` by `rows` cells.
#[derive(Clone, Debug, Default)]
pub(super) struct RayGrid {
    pub(super) columns: u32,
    pub(super) rows: u32,
    /// Pixels between neighbouring rays; those of cell `(i, j)` are at `(i + 1/2, j + 1/2)` times this in the field.
    pub(super) spacing_px: f32,
    pub(super) groups: Vec<GroupRays>,
    /// Rays traced, bounces included.
    pub(super) traced: u64,
}

impl RayGrid {
    /// Follows the rays of a field.
    pub(super) fn new(specular: &Specular<'_>, field: &dyn RayField, spacing_px: f32) -> Self {
        let cells = field.size_px().map(|size| ((size / spacing_px).ceil() as u32).max(1));
        let [columns, rows] = cells;
        let followed = parallel::map_collect(rows as usize, |row| {
            let mut found: Vec<(u32, Bounces, GridRay)> = Vec::new();
            let mut traced = 0;
            for column in 0..columns {
                let place = |index: u32| (index as f32 + 0.5) * spacing_px;
                let (ray, near) = field.ray(place(column), place(row as u32));
                let cell = row as u32 * columns + column;
                traced += follow(specular, &ray, near, &mut |bounces, ray| found.push((cell, bounces, ray)));
            }
            (found, traced)
        });
        let mut groups: Vec<(Bounces, GroupRays)> = Vec::new();
        for (cell, bounces, ray) in followed.iter().flat_map(|(found, _)| found) {
            let group = match groups.iter().position(|(known, _)| known == bounces) {
                Some(group) => group,
                None => {
                    let path = SpecularPath { bounces: bounces.bounces[..bounces.count].to_vec() };
                    let ray_of_cell = vec![NO_RAY; (columns * rows) as usize];
                    groups.push((*bounces, GroupRays { path, rays: Vec::new(), ray_of_cell }));
                    groups.len() - 1
                }
            };
            let group = &mut groups[group].1;
            group.ray_of_cell[*cell as usize] = group.rays.len() as u32;
            group.rays.push(*ray);
        }
        let mut groups: Vec<GroupRays> = groups.into_iter().map(|(_, group)| group).collect();
        groups.sort_by(|a, b| a.path.cmp(&b.path));
        Self { columns, rows, spacing_px, groups, traced: followed.iter().map(|(_, traced)| traced).sum() }
    }
}

/// A path so far.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Bounces {
    count: usize,
    bounces: [Bounce; MAX_BOUNCES],
}

/// A ray on its way.
#[derive(Clone, Copy)]
struct Waiting {
    ray: Ray,
    near: f32,
    from: DVec3,
    direction: DVec3,
    first: Option<(DVec3, DVec3)>,
    length: f64,
    medium: f64,
    bounces: Bounces,
}

/// Calls `found` for the outgoing ray of every path that a view ray begins; how many rays were traced.
fn follow(specular: &Specular<'_>, ray: &Ray, near: f32, found: &mut impl FnMut(Bounces, GridRay)) -> u64 {
    let most = (specular.order as usize).min(MAX_BOUNCES);
    if most == 0 {
        return 0;
    }
    let none = Bounces { count: 0, bounces: [Bounce { object: 0, kind: BounceKind::Reflect }; MAX_BOUNCES] };
    let mut waiting = vec![Waiting {
        ray: *ray,
        near,
        from: ray.origin.as_dvec3(),
        direction: ray.direction.as_dvec3().normalize_or_zero(),
        first: None,
        length: 0.0,
        medium: 1.0,
        bounces: none,
    }];
    let mut traced = 0;
    while let Some(before) = waiting.pop() {
        traced += 1;
        let Some(hit) = specular.tracer.first_hit(specular.scene, &before.ray, before.near) else { continue };
        let Some((object, site)) = specular.surfaces.site_of(&before.ray, &hit) else { continue };
        let Some(frame) = specular.surfaces.frame(object, &site) else { continue };
        let lens = specular.scene.role_of(object) == Role::Lens;
        let cosine = before.direction.dot(frame.normal);
        let outside = cosine <= 0.0;
        if outside && specular.scene.objects[object as usize].inside {
            continue; // the blind side
        }
        let index = specular.surfaces.index_of(object);
        // Whoever meets a lens from inside was inside it.
        let medium = if lens && !outside { index } else { before.medium };
        let length = before.length + medium * before.from.distance(frame.position);
        for kind in [BounceKind::Transmit, BounceKind::Reflect] {
            let (direction, medium) = match kind {
                BounceKind::Reflect => (before.direction - frame.normal * (2.0 * cosine), medium),
                BounceKind::Transmit if lens => {
                    let ratio = if outside { 1.0 / index } else { index };
                    let Some(direction) = refracted(before.direction, frame.normal, cosine, ratio) else { continue };
                    (direction, if outside { index } else { 1.0 })
                }
                BounceKind::Transmit => continue,
            };
            // With shading normals light may seem to come from behind the flat triangle.
            let geometric = frame.geometric_normal();
            if (direction.dot(geometric) > 0.0) != (outside == (kind == BounceKind::Reflect)) {
                continue;
            }
            let mut bounces = before.bounces;
            bounces.bounces[bounces.count] = Bounce { object, kind };
            bounces.count += 1;
            let first = before.first.unwrap_or((frame.position, if outside { frame.normal } else { -frame.normal }));
            let tail = frame.position;
            found(bounces, GridRay { first: first.0, normal: first.1, tail, direction, length, medium });
            if bounces.count < most {
                let offset = 16.0 * f64::from(f32::EPSILON) * tail.abs().max_element();
                let origin = (tail + geometric * offset.copysign(direction.dot(geometric))).as_vec3();
                let ray = Ray { origin, direction: direction.as_vec3().normalize() };
                let first = Some(first);
                waiting.push(Waiting { ray, near: 0.0, from: tail, direction, first, length, medium, bounces });
            }
        }
    }
    traced
}

/// Snell's law; none where there is total reflection. `ratio`: the index before over that behind.
fn refracted(direction: DVec3, normal: DVec3, cosine: f64, ratio: f64) -> Option<DVec3> {
    let behind = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
    (behind >= 0.0).then(|| direction * ratio + normal * (behind.sqrt().copysign(cosine) - ratio * cosine))
}
