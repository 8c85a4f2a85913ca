//! What is known of a group of reflectors and lenses, and of the layers about it.

use super::capture::{projected, shares};
use super::distances::Distances;
use super::groups::LensGroup;
use super::layers::{Meeting, Stratum, strata};
use super::maps::{Layer, LayeredMap};
use super::settings::LayeredEnvironmentMapSettings;
use super::surroundings::{Strata, Surroundings};
use super::texels::Texture;
use super::viewpoints::{Viewspace, picture_of};
use crate::methods::lookup::greedy::{First, GreedyPaths};
use crate::parallel;
use crate::progress::Progress;
use crate::scene::Scene;
use crate::surface::tracer::Tracer;
use std::collections::HashSet;

/// Viewpoints of a row that say where layers are, at most.
const MOST_CLUSTERED: u32 = 45;

/// Pixels a side of the pictures from them.
const CLUSTER_SIZE: u32 = 40;

/// A group with its layers.
pub(super) struct GroupLayers {
    pub(super) group: LensGroup,
    pub(super) viewspace: Viewspace,
    /// What is in the layers, and their shells; the nearest first.
    pub(super) strata: Vec<Stratum>,
}

impl GroupLayers {
    /// Of a group, with paths of up to `order` events; `everything` is the hierarchy of all objects.
    pub(super) fn new(
        settings: &LayeredEnvironmentMapSettings,
        scene: &Scene,
        everything: &Tracer,
        group: LensGroup,
        order: u32,
    ) -> Self {
        let viewspace = Viewspace::new(settings, scene, &group);
        let strata = group_strata(settings, Surroundings { scene, everything, group: &group }, &viewspace, order);
        Self { group, viewspace, strata }
    }

    /// The layers without textures; none of them knows more of what it shows than its shell where `settings` say so.
    pub(super) fn bare(
        &self,
        settings: &LayeredEnvironmentMapSettings,
        apart: &Strata<'_>,
        progress: &dyn Progress,
    ) -> LayeredMap {
        let size = settings.size;
        let mut shares = settings.depth.then(|| shares(apart, &self.strata, size, progress).into_iter());
        let layer = |stratum: &Stratum| {
            let layout = stratum.shell.layout(size);
            let shares = shares.as_mut().and_then(Iterator::next);
            let distances = shares.map(|shares| Distances::new(&stratum.shell, layout.clone(), &shares));
            Layer { shell: stratum.shell, distances, texture: Texture { layout, texels: Vec::new() } }
        };
        LayeredMap { center: self.group.center(), layers: self.strata.iter().map(layer).collect() }
    }

    /// Gives layers the textures that are seen from the middle of the shells.
    pub(super) fn project(
        &self,
        settings: &LayeredEnvironmentMapSettings,
        apart: &Strata<'_>,
        map: &mut LayeredMap,
        progress: &dyn Progress,
    ) {
        let textures = projected(apart, &self.strata, settings.size, settings.capture_samples, progress);
        map.layers.iter_mut().zip(textures).for_each(|(layer, texture)| layer.texture = texture);
    }
}

/// The layers about a group: of what rays through it meet that come from all viewpoints.
fn group_strata(
    settings: &LayeredEnvironmentMapSettings,
    around: Surroundings<'_>,
    viewspace: &Viewspace,
    order: u32,
) -> Vec<Stratum> {
    let Surroundings { scene, group, .. } = around;
    let paths = GreedyPaths { scene, tracer: &group.tracer, order };
    let step = viewspace.len().div_ceil(MOST_CLUSTERED);
    let rays_a_view = 2 * CLUSTER_SIZE * CLUSTER_SIZE;
    let meetings = parallel::map_collect(viewspace.len().div_ceil(step) as usize, |number| {
        let eye = viewspace.eye(number as u32 * step, 0.0);
        let view = picture_of(scene, group, eye, CLUSTER_SIZE);
        let mut meetings: Vec<Meeting> = Vec::new();
        let mut ray_number = number as u32 * rays_a_view;
        for pixel in 0..CLUSTER_SIZE * CLUSTER_SIZE {
            let ray = view.ray((pixel % CLUSTER_SIZE) as f32 + 0.5, (pixel / CLUSTER_SIZE) as f32 + 0.5);
            let Some(hit) = group.tracer.first_hit(scene, &ray, 0.0) else { continue };
            let encounter = group.tracer.encounter(scene, &ray, &hit, None);
            for first in First::BOTH {
                if let Some(leaving) = paths.follow(ray.direction, encounter, first).leaving {
                    around.meet(ray_number, &leaving, &mut meetings);
                    ray_number += 1;
                }
            }
        }
        meetings
    })
    .concat();
    let met: HashSet<u32> = meetings.iter().map(|meeting| meeting.object).collect();
    let is_other = |object: &u32| !met.contains(object) && !group.holds(*object);
    let distance = |object: u32| (object, scene.objects[object as usize].bounds.center().distance(group.center()));
    let others: Vec<(u32, f32)> = (0..scene.objects.len() as u32).filter(is_other).map(distance).collect();
    strata(&meetings, &others, settings.layers, settings.shells, settings.clustering)
}
