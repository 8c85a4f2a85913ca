//! A group of reflectors and lenses, and the layers about it.

use super::distant_geometry::DistantGeometry;
use super::groups::LensGroup;
use super::layers::{LayerHit, LayerSpec, strata};
use super::viewpoints::{Viewspace, picture_of};
use crate::layered_environment_map::settings::LayeredEnvironmentMapSettings;
use crate::layered_environment_map::shell::Shell;
use catoptric_core::parallel;
use catoptric_core::scene::Scene;
use catoptric_engine::light::tracer::Tracer;
use catoptric_engine::light::two_path_tracer::TwoPathTracer;
use catoptric_engine::optics::path::bundle::BounceKind;
use std::collections::HashSet;

/// Viewpoints of a row that say where layers are, at most. A bound on time; chosen, not measured.
const MAX_CLUSTERED: u32 = 45;

/// Pixels a side of the pictures from them. Chosen, not measured.
const CLUSTER_SIZE: u32 = 40;

/// A group with its layers.
pub struct GroupLayers {
    /// The group.
    pub group: LensGroup,
    /// The viewpoints about it.
    pub viewspace: Viewspace,
    /// Objects of the layers, and their shells; the nearest first.
    pub(crate) strata: Vec<LayerSpec>,
}

impl GroupLayers {
    /// A group with its layers, for paths of up to `order` events, and the hits of rays through it; `everything` is the
    /// hierarchy of all objects.
    pub(crate) fn new(
        settings: &LayeredEnvironmentMapSettings,
        scene: &Scene,
        everything: &Tracer,
        group: LensGroup,
        order: u32,
    ) -> (Self, Vec<LayerHit>) {
        let viewspace = Viewspace::new(settings, scene, &group);
        let around = DistantGeometry { scene, everything, within: &group.objects, center: group.center() };
        let meetings = meetings(around, &group, &viewspace, order);
        let met: HashSet<u32> = meetings.iter().map(|meeting| meeting.object).collect();
        let is_other = |object: &u32| !met.contains(object) && !group.holds(*object);
        let distance = |object: u32| (object, scene.objects[object as usize].bounds.center().distance(group.center()));
        let others: Vec<(u32, f32)> = (0..scene.objects.len() as u32).filter(is_other).map(distance).collect();
        let strata = strata(&meetings, &others, settings.layers, settings.shells, settings.clustering);
        (Self { group, viewspace, strata }, meetings)
    }
}

impl GroupLayers {
    /// A group whose layers come from a bake: their objects are not known.
    pub(crate) fn of_shells(
        settings: &LayeredEnvironmentMapSettings,
        scene: &Scene,
        group: LensGroup,
        shells: &[Shell],
    ) -> Self {
        let viewspace = Viewspace::new(settings, scene, &group);
        Self { group, viewspace, strata: shells.iter().map(LayerSpec::of_shell).collect() }
    }
}

/// Hits of rays through a group from all viewpoints.
fn meetings(around: DistantGeometry<'_>, group: &LensGroup, viewspace: &Viewspace, order: u32) -> Vec<LayerHit> {
    let scene = around.scene;
    let paths = TwoPathTracer { scene, tracer: &group.tracer, order };
    let step = viewspace.count().div_ceil(MAX_CLUSTERED);
    let rays_a_view = 2 * CLUSTER_SIZE * CLUSTER_SIZE;
    let of_view = |number: usize| {
        let eye = viewspace.eye(number as u32 * step, 0.0);
        let view = picture_of(scene, group, eye, CLUSTER_SIZE);
        let mut meetings: Vec<LayerHit> = Vec::new();
        let mut ray_number = number as u32 * rays_a_view;
        for pixel in 0..CLUSTER_SIZE * CLUSTER_SIZE {
            let ray = view.ray((pixel % CLUSTER_SIZE) as f32 + 0.5, (pixel / CLUSTER_SIZE) as f32 + 0.5);
            let Some(hit) = group.tracer.first_hit(scene, &ray, 0.0) else { continue };
            let point = group.tracer.point(scene, &ray, &hit);
            for first in BounceKind::BOTH {
                if let Some(leaving) = paths.follow(ray.direction, point, first).leaving {
                    around.meet(ray_number, &leaving, &mut meetings);
                    ray_number += 1;
                }
            }
        }
        meetings
    };
    parallel::map_collect(viewspace.count().div_ceil(step) as usize, of_view).concat()
}
