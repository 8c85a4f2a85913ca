//! The size of textures by the texels that a view reads.
//!
//! Hakura, Snyder 2001, section 4.3, look for the most detailed level that test renderings access. Here rays of some
//! pixels, each with its neighbours, are followed out of their group to the shells, before anything is captured.

use super::inference::observations::differences;
use super::mesh::same_way;
use super::settings::LayeredEnvironmentMapSettings;
use super::shell::{RayLanes, Shell};
use super::shells::layer_geometry::LayerGeometry;
use catoptric_core::math::lanes::Lanes;
use catoptric_core::parallel;
use catoptric_core::scene::{Ray, RayDifferential, Scene, View};
use catoptric_engine::optics::path::bundle::BounceKind;
use glam::Vec3;

/// Sizes that are chosen: from here, since small textures take no time,
const LEAST: u32 = 64;

/// to here: a bound on the time of capturing, which grows with the square. Larger ones can be asked for: with 1024 the
/// pot of `colonnade` takes four times as long again. Chosen, not measured.
const MOST: u32 = 512;

/// Pixels along the longer side of a picture whose rays are followed. Chosen, not measured.
const PROBES: u32 = 64;

/// The share of the look-ups for which no texel is wider than their footprint. The rest is magnified: look-ups in the
/// middle of glass would ask for textures as large as they like. Chosen, not measured.
const SHARP: f32 = 0.8;

/// The size of the textures of all groups for a view.
pub(super) fn of_view(
    known: &LayerGeometry,
    settings: &LayeredEnvironmentMapSettings,
    scene: &Scene,
    view: &View,
) -> u32 {
    let apart = view.width.max(view.height).div_ceil(PROBES).max(1);
    let groups: Vec<_> = (0..known.groups.len()).map(|group| known.apart(settings, scene, group)).collect();
    let rows = parallel::map_collect(view.height.div_ceil(apart) as usize, |row| {
        let mut widths = Vec::new();
        for x in (apart / 2..view.width).step_by(apart as usize) {
            let y = (row as u32 * apart + apart / 2).min(view.height - 1);
            for (group, ray, change) in leaving(known, scene, view, [x, y]) {
                // The first surface that the ray meets.
                let specs = &groups[group];
                let mut met = None;
                specs.each_first(&ray, specs.all(), |layer, hit| {
                    met.get_or_insert((layer, hit.distance()));
                });
                if let Some((layer, distance)) = met
                    && let Some((shell, center)) = shell_of(known, group, layer)
                {
                    let distance = settings.depth.then_some(distance);
                    widths.push(width(shell, &RayLanes::new(&[(ray, change)], center), distance));
                }
            }
        }
        widths
    });
    let mut widths: Vec<f32> = rows.into_iter().flatten().filter(|width| *width > 0.0).collect();
    widths.sort_by(f32::total_cmp);
    let narrowest = widths.get(((1.0 - SHARP) * widths.len() as f32) as usize).copied();
    let wanted = narrowest.map_or(0.0, |width| MOST as f32 / width);
    (wanted as u32).clamp(LEAST, MOST).next_power_of_two()
}

/// The rays that leave a group from a pixel of it, by both ways, with their changes from pixel to pixel; none where
/// neighbours take other ways.
fn leaving<'a>(
    known: &'a LayerGeometry,
    scene: &'a Scene,
    view: &View,
    [x, y]: [u32; 2],
) -> impl Iterator<Item = (usize, Ray, RayDifferential)> + use<'a> {
    let rays = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)]
        .map(|(right, down)| view.ray(x as f32 + 0.5 + right, y as f32 + 0.5 + down));
    let near = view.near;
    let met = move |ray: &Ray| {
        let hit = known.everything.first_hit(scene, ray, near)?;
        let object = hit.object(scene);
        let group = known.group_of(object)?;
        Some((group, object, known.groups[group].group.tracer.point(scene, ray, &hit)))
    };
    BounceKind::BOTH.into_iter().filter_map(move |first| {
        let follow = |ray: &Ray| {
            let (group, object, point) = met(ray)?;
            Some((group, known.paths(scene, object)?.follow(ray.direction, point, first)))
        };
        let [(group, path), (_, right), (_, below)] = [follow(&rays[0])?, follow(&rays[1])?, follow(&rays[2])?];
        let is_one = same_way(&path, &right) && same_way(&path, &below);
        let (ray, right, below) = (path.leaving?, right.leaving?, below.leaving?);
        is_one.then(|| (group, ray, differences(&ray, &right, &below)))
    })
}

/// The shell of a layer that a group's rays look up, and its centre.
fn shell_of(known: &LayerGeometry, group: usize, layer: usize) -> Option<(&Shell, Vec3)> {
    let own = known.strata_of(group);
    let part = if layer < own.len() { group } else { known.groups.len() };
    let stratum = own.get(layer).or_else(|| known.strata_of(part).get(layer - own.len()))?;
    Some((&stratum.shell, known.center_of(part)))
}

/// The width of the narrower axis of a look-up's footprint, in texels of the largest texture; with depths the shell is
/// where the ray meets something.
fn width(shell: &Shell, rays: &RayLanes<1>, distance: Option<f32>) -> f32 {
    let footprints = match distance.map(Lanes::splat) {
        None => shell.footprints(rays),
        Some(distance) => {
            let places = rays.at(&distance);
            let mut shrunk = *rays;
            shrunk.shrink(&shell.shell_scale(&places));
            let mut footprints = shell.footprints(&shrunk);
            shell.hold_at(&mut footprints, &places, &rays.widths(&distance, &places));
            footprints
        }
    };
    shell.layout(MOST).width(&footprints)
}
