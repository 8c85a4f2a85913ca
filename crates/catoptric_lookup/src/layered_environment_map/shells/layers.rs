//! The assignment of objects around a group of reflectors and lenses to layers, and the shells that stand in for them.

use super::merging::merged_by_shape;
use crate::layered_environment_map::settings::{Clustering, Shells};
use crate::layered_environment_map::shell::Shell;
use glam::Vec3;

/// Hit of an object by a ray that leaves the group.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayerHit {
    /// The ray: one number for all that it meets, one after the other.
    pub ray: u32,
    /// The object that is met.
    pub object: u32,
    /// The hit's position, from the group's centre.
    pub position: Vec3,
}

/// Steps after which clusters are as good as they get. A bound on time; chosen, not measured.
const MAX_STEPS: usize = 100;

/// A layer: its objects, and the shell that stands in for them.
#[derive(Clone, Debug, PartialEq)]
pub struct LayerSpec {
    /// The objects that it shows.
    pub objects: Vec<u32>,
    /// The shell that stands for them.
    pub shell: Shell,
}

impl LayerSpec {
    /// A layer of a bake, whose objects are not needed.
    pub(crate) fn of_shell(shell: &Shell) -> Self {
        Self { objects: Vec::new(), shell: *shell }
    }
}

/// The layers about a group, the nearest first; at most `count`.
///
/// Each object goes whole to one layer. The first of several hits of a ray on a layer counts for the place of its shell
/// (Hakura, Snyder 2001, section 4.2). Objects that no ray meets (`others`, with their distances) go to the nearest
/// layer.
pub fn strata(
    meetings: &[LayerHit],
    others: &[(u32, f32)],
    count: u32,
    shells: Shells,
    clustering: Clustering,
) -> Vec<LayerSpec> {
    let most = meetings.iter().map(|meeting| meeting.object).max().map_or(0, |object| object as usize + 1);
    let layer_of = match clustering {
        Clustering::Distance => layers_by_distance(meetings, most, count as usize),
        Clustering::Shape => {
            let mut points = vec![Vec::new(); most];
            meetings.iter().for_each(|meeting| points[meeting.object as usize].push(meeting.position));
            let (objects, points): (Vec<usize>, Vec<Vec<Vec3>>) =
                points.into_iter().enumerate().filter(|(_, points)| !points.is_empty()).unzip();
            let mut layer_of = vec![usize::MAX; most];
            let clusters = merged_by_shape(&points, count as usize, shells);
            objects.into_iter().zip(clusters).for_each(|(object, cluster)| layer_of[object] = cluster);
            layer_of
        }
    };
    let layers = layer_of.iter().filter(|layer| **layer != usize::MAX).max().map_or(0, |layer| layer + 1);
    let mut objects = vec![Vec::new(); layers];
    for (object, layer) in layer_of.iter().enumerate().filter(|(_, layer)| **layer != usize::MAX) {
        objects[*layer].push(object as u32);
    }
    let mut strata: Vec<(f64, LayerSpec)> = objects
        .into_iter()
        .filter(|objects| !objects.is_empty())
        .map(|objects| {
            let points = first_met(meetings, &objects);
            let mean = points.iter().map(|point| f64::from(point.length())).sum::<f64>() / points.len() as f64;
            (mean, LayerSpec { objects, shell: Shell::fit(shells, &points) })
        })
        .collect();
    strata.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (object, distance) in others {
        let off = |stratum: &(f64, LayerSpec)| (stratum.0 - f64::from(*distance)).abs();
        if let Some(stratum) = strata.iter_mut().min_by(|a, b| off(a).total_cmp(&off(b))) {
            stratum.1.objects.push(*object);
        }
    }
    strata.into_iter().map(|(_, stratum)| stratum).collect()
}

/// First hits of rays on some objects (ascending numbers).
pub(crate) fn first_met(meetings: &[LayerHit], objects: &[u32]) -> Vec<Vec3> {
    let mut last_ray = None;
    let own = meetings.iter().filter(|meeting| objects.binary_search(&meeting.object).is_ok());
    own.filter(|meeting| last_ray.replace(meeting.ray) != Some(meeting.ray)).map(|meeting| meeting.position).collect()
}

/// The number of each object's layer, of `objects` that may be met; none: [`usize::MAX`].
///
/// Meetings are clustered by their distances to the centre (Linde, Buzo, Gray 1980), those of all viewpoints together,
/// and each thing goes to the cluster that has the most of its meetings (Hakura, Snyder 2001, section 4.2).
fn layers_by_distance(meetings: &[LayerHit], objects: usize, count: usize) -> Vec<usize> {
    let distances: Vec<f32> = meetings.iter().map(|meeting| meeting.position.length()).collect();
    let centers = clusters(&distances, count);
    let mut votes = vec![vec![0u32; centers.len()]; objects];
    for (meeting, distance) in meetings.iter().zip(&distances) {
        votes[meeting.object as usize][nearest(&centers, *distance)] += 1;
    }
    // The nearer one of equals.
    let winner = |votes: &Vec<u32>| (0..votes.len()).rev().max_by_key(|layer| votes[*layer]);
    votes.iter().map(|votes| winner(votes).filter(|layer| votes[*layer] > 0).unwrap_or(usize::MAX)).collect()
}

/// The number of the center that is nearest to a distance, of ascending ones.
fn nearest(centers: &[f32], distance: f32) -> usize {
    let above = centers.partition_point(|center| *center < distance);
    match above {
        0 => 0,
        above if above == centers.len() => above - 1,
        above if distance - centers[above - 1] <= centers[above] - distance => above - 1,
        above => above,
    }
}

/// The middles of at most `count` clusters of distances, ascending. From one cluster on, the one with the largest error
/// is divided and all are moved to the means of the distances that are nearest to them, until none changes its cluster.
pub fn clusters(distances: &[f32], count: usize) -> Vec<f32> {
    let mut sorted: Vec<f32> = distances.iter().copied().filter(|distance| distance.is_finite()).collect();
    sorted.sort_by(f32::total_cmp);
    let Some(first) = sorted.first() else { return Vec::new() };
    let mut centers = settled(&sorted, vec![*first]);
    while centers.len() < count {
        let error = |own: &[f32], center: f32| own.iter().map(|value| f64::from(value - center).powi(2)).sum::<f64>();
        let errors = members(&sorted, &centers).into_iter().zip(&centers).map(|(own, center)| error(own, *center));
        let worst = errors.enumerate().max_by(|a, b| a.1.total_cmp(&b.1));
        let Some((worst, _)) = worst.filter(|(_, error)| *error > 0.0) else { break };
        let own = members(&sorted, &centers)[worst];
        let mut divided = centers.clone();
        divided.splice(worst..=worst, [own[0], own[own.len() - 1]]);
        centers = settled(&sorted, divided);
    }
    centers
}

/// Ranges of ascending distances that are nearest to each of ascending centres.
fn members<'a>(sorted: &'a [f32], centers: &[f32]) -> Vec<&'a [f32]> {
    let mut rest = sorted;
    let own = |(number, center): (usize, &f32)| {
        let edge = centers.get(number + 1).map_or(f32::INFINITY, |above| 0.5 * (center + above));
        let own;
        (own, rest) = rest.split_at(rest.partition_point(|distance| *distance <= edge));
        own
    };
    centers.iter().enumerate().map(own).collect()
}

/// Centres moved to the means of the values nearest to them, until they stay. Centres without such values are left out.
fn settled(sorted: &[f32], mut centers: Vec<f32>) -> Vec<f32> {
    for _ in 0..MAX_STEPS {
        let own = members(sorted, &centers).into_iter().filter(|own| !own.is_empty());
        let mean = |own: &[f32]| (own.iter().map(|value| f64::from(*value)).sum::<f64>() / own.len() as f64) as f32;
        let next: Vec<f32> = own.map(mean).collect();
        if next == centers {
            break;
        }
        centers = next;
    }
    centers
}
