//! A farthest layer that several groups share: its texture is kept once (Hakura, Snyder 2001, section 4.3).

use super::group_layers::GroupLayers;
use super::layers::{LayerHit, LayerSpec, first_met};
use crate::layered_environment_map::settings::Shells;
use crate::layered_environment_map::shell::Shell;
use glam::Vec3;

/// The layer that all groups of a scene share, about a centre of its own.
pub(crate) struct SharedLayer {
    /// The middle of the groups' centres.
    pub(crate) center: Vec3,
    pub(crate) stratum: LayerSpec,
    /// The objects of all groups, ascending.
    pub(crate) within: Vec<u32>,
}

impl SharedLayer {
    /// Takes the objects that are in the farthest layers of all groups out of these (the rest of them joins the next
    /// layers); each group has its own hits on its surroundings. `None` if there is no such object, or a single group.
    pub(crate) fn taken_from(groups: &mut [GroupLayers], meetings: &[Vec<LayerHit>], shells: Shells) -> Option<Self> {
        let [first, others @ ..] = &*groups else { return None };
        let is_farthest =
            |object: &u32, group: &GroupLayers| group.strata.last().is_some_and(|last| last.objects.contains(object));
        let mut common = first.strata.last()?.objects.clone();
        common.retain(|object| others.iter().all(|group| is_farthest(object, group)));
        common.sort_unstable();
        let center = groups.iter().map(|group| group.group.center()).sum::<Vec3>() / groups.len() as f32;
        let met = |(group, meetings): (&GroupLayers, &Vec<LayerHit>)| {
            let offset = group.group.center() - center;
            first_met(meetings, &common).into_iter().map(move |point| point + offset).collect::<Vec<_>>()
        };
        let points = groups.iter().zip(meetings).flat_map(met).collect::<Vec<_>>();
        if others.is_empty() || points.is_empty() {
            return None;
        }
        for (group, meetings) in groups.iter_mut().zip(meetings) {
            let Some(mut rest) = group.strata.pop() else { continue };
            rest.objects.retain(|object| common.binary_search(object).is_err());
            if rest.objects.is_empty() {
                continue;
            }
            // The group's other farthest objects join the next layer.
            rest.objects.extend(group.strata.pop().into_iter().flat_map(|next| next.objects));
            rest.objects.sort_unstable();
            rest.shell = Shell::fit(shells, &first_met(meetings, &rest.objects));
            group.strata.push(rest);
        }
        let mut within: Vec<u32> = groups.iter().flat_map(|group| group.group.objects.iter().copied()).collect();
        within.sort_unstable();
        Some(Self { center, stratum: LayerSpec { objects: common, shell: Shell::fit(shells, &points) }, within })
    }
}
