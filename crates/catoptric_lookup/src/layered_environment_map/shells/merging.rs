//! The assignment of objects to layers by the shapes that stand in for them.

use crate::layered_environment_map::settings::Shells;
use crate::layered_environment_map::shell::Shell;
use catoptric_core::parallel;
use glam::Vec3;

/// Points of all things together that shapes are fitted to, about. A bound on time; chosen, not measured.
const MAX_POINTS: usize = 3000;

/// Points of a thing, at least, where it has this many. Chosen, not measured.
const MIN_POINTS: usize = 8;

/// Clusters in the beginning, at most: neighbours by distance begin together where things are more. A bound on time;
/// chosen, not measured.
const MAX_CLUSTERS: usize = 32;

/// The number of each object's cluster, from the objects' points (from the centre); at most `count` clusters.
///
/// Each object starts as a cluster of its own. Then, again and again, the pair is merged whose common shell adds the
/// least error to its two: the parallax for an eye beside the centre, which is the difference of the inverse distances.
pub fn merged_by_shape(things: &[Vec<Vec3>], count: usize, shells: Shells) -> Vec<usize> {
    let total: usize = things.iter().map(Vec::len).sum();
    let stride = total.div_ceil(MAX_POINTS).max(1);
    let sampled = |points: &Vec<Vec3>| -> Vec<Vec3> {
        let stride = stride.min(points.len() / MIN_POINTS).max(1);
        points.iter().step_by(stride).copied().collect()
    };
    let mut order: Vec<usize> = (0..things.len()).collect();
    let mean = |thing: &usize| {
        let points = &things[*thing];
        points.iter().map(|point| point.length()).sum::<f32>() / points.len().max(1) as f32
    };
    order.sort_by(|a, b| mean(a).total_cmp(&mean(b)));
    let begin = order.len().div_ceil(MAX_CLUSTERS).max(1);
    let mut clusters: Vec<Cluster> = order
        .chunks(begin)
        .map(|things_of| {
            let points = things_of.iter().flat_map(|thing| sampled(&things[*thing])).collect();
            Cluster::new(things_of.to_vec(), points, shells)
        })
        .collect();
    // The error that merging a pair adds; pairs with removed clusters are never looked at.
    let loss = |clusters: &[Cluster], a: usize, b: usize| {
        let both = clusters[a].joined(&clusters[b], shells);
        both.error - clusters[a].error - clusters[b].error
    };
    let mut losses: Vec<Vec<f64>> =
        parallel::map_collect(clusters.len(), |b| (0..b).map(|a| loss(&clusters, a, b)).collect());
    while clusters.len() > count.max(1) {
        let pairs = losses.iter().enumerate().flat_map(|(b, row)| (0..row.len()).map(move |a| (a, b)));
        let Some((a, b)) = pairs.min_by(|(a, b), (c, d)| losses[*b][*a].total_cmp(&losses[*d][*c])) else { break };
        clusters[a] = clusters[a].joined(&clusters[b], shells);
        clusters.remove(b);
        losses.remove(b);
        for row in losses.iter_mut().filter(|row| row.len() > b) {
            row.remove(b);
        }
        let anew =
            parallel::map_collect(clusters.len(), |other| if other == a { 0.0 } else { loss(&clusters, a, other) });
        for (other, loss) in anew.into_iter().enumerate().filter(|(other, _)| *other != a) {
            losses[a.max(other)][a.min(other)] = loss;
        }
    }
    let mut cluster_of = vec![0; things.len()];
    for (number, cluster) in clusters.iter().enumerate() {
        cluster.things.iter().for_each(|thing| cluster_of[*thing] = number);
    }
    cluster_of
}

/// Things with a shell in common.
struct Cluster {
    things: Vec<usize>,
    points: Vec<Vec3>,
    /// The sum of the squares of differences of inverse distances.
    error: f64,
}

impl Cluster {
    fn new(things: Vec<usize>, points: Vec<Vec3>, shells: Shells) -> Self {
        let shell = Shell::fit(shells, &points);
        let square = |point: &Vec3| {
            let length = point.length().max(f32::MIN_POSITIVE);
            let shift = 1.0 / shell.distance(Vec3::ZERO, *point / length).max(f32::MIN_POSITIVE) - 1.0 / length;
            f64::from(shift * shift)
        };
        let error = points.iter().map(square).sum();
        Self { things, points, error }
    }

    fn joined(&self, other: &Self, shells: Shells) -> Self {
        let things = self.things.iter().chain(&other.things).copied().collect();
        let points = self.points.iter().chain(&other.points).copied().collect();
        Self::new(things, points, shells)
    }
}
