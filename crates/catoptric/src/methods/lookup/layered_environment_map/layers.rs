//! Which things around a group of reflectors and lenses share a layer, and what stands in for it.

use super::settings::Shells;
use super::shell::Shell;
use glam::Vec3;

/// Where a ray that leaves the group meets a thing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Meeting {
    /// The ray: one number for all that it meets, one after the other.
    pub(super) ray: u32,
    pub(super) object: u32,
    /// From the group's centre.
    pub(super) position: Vec3,
}

/// Steps after which clusters are as good as they get.
const MOST_STEPS: usize = 100;

/// A layer: what is in it, and what stands in for it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Stratum {
    pub(super) objects: Vec<u32>,
    pub(super) shell: Shell,
}

/// The layers about a group, the nearest first; at most `count`.
///
/// Meetings are clustered by their distances to the centre (Linde, Buzo, Gray 1980), those of all viewpoints together, and each
/// thing goes whole to the cluster that has the most of its meetings (Hakura, Snyder 2001, section 4.2). Of several meetings of a ray
/// with a layer the first one counts for where its shell is. Things that no ray meets (`others`, with their distances) go to
/// the nearest layer.
pub(super) fn strata(meetings: &[Meeting], others: &[(u32, f32)], count: u32, shells: Shells) -> Vec<Stratum> {
    let distances: Vec<f32> = meetings.iter().map(|meeting| meeting.position.length()).collect();
    let centers = clusters(&distances, count as usize);
    if centers.is_empty() {
        return Vec::new();
    }
    let most = meetings.iter().map(|meeting| meeting.object).max().map_or(0, |object| object as usize + 1);
    let mut votes = vec![vec![0u32; centers.len()]; most];
    for (meeting, distance) in meetings.iter().zip(&distances) {
        votes[meeting.object as usize][nearest(&centers, *distance)] += 1;
    }
    let mut objects = vec![Vec::new(); centers.len()];
    let mut layer_of = vec![usize::MAX; most];
    for (object, votes) in votes.iter().enumerate() {
        // Of equals the nearer one.
        let winner = (0..votes.len()).rev().max_by_key(|layer| votes[*layer]).unwrap_or(0);
        if votes[winner] > 0 {
            objects[winner].push(object as u32);
            layer_of[object] = winner;
        }
    }
    let mut points = vec![Vec::new(); centers.len()];
    let mut last_ray = vec![u32::MAX; centers.len()];
    for meeting in meetings {
        let layer = layer_of[meeting.object as usize];
        if last_ray[layer] != meeting.ray {
            last_ray[layer] = meeting.ray;
            points[layer].push(meeting.position);
        }
    }
    let layers = objects.into_iter().zip(points).filter(|(objects, _)| !objects.is_empty());
    let mut strata: Vec<(f64, Stratum)> = layers
        .map(|(objects, points)| {
            let mean = points.iter().map(|point| f64::from(point.length())).sum::<f64>() / points.len() as f64;
            (mean, Stratum { objects, shell: Shell::fit(shells, &points) })
        })
        .collect();
    strata.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (object, distance) in others {
        let off = |stratum: &(f64, Stratum)| (stratum.0 - f64::from(*distance)).abs();
        if let Some(stratum) = strata.iter_mut().min_by(|a, b| off(a).total_cmp(&off(b))) {
            stratum.1.objects.push(*object);
        }
    }
    strata.into_iter().map(|(_, stratum)| stratum).collect()
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

/// The middles of at most `count` clusters of distances, ascending: started evenly among the sorted distances, then moved to the
/// means of those nearest to them until none changes its cluster.
fn clusters(distances: &[f32], count: usize) -> Vec<f32> {
    let mut sorted: Vec<f32> = distances.iter().copied().filter(|distance| distance.is_finite()).collect();
    sorted.sort_by(f32::total_cmp);
    let (Some(first), Some(last)) = (sorted.first(), sorted.last()) else { return Vec::new() };
    // Evenly in distance and not in number: what is met often would have all clusters to itself.
    let start = |number: usize| first + (last - first) * (number as f32 + 0.5) / count as f32;
    let mut centers: Vec<f32> = (0..count).map(start).collect();
    centers.dedup();
    for _ in 0..MOST_STEPS {
        let mut next = Vec::with_capacity(centers.len());
        let mut rest = &sorted[..];
        for (number, center) in centers.iter().enumerate() {
            let edge = centers.get(number + 1).map_or(f32::INFINITY, |above| 0.5 * (center + above));
            let (own, others) = rest.split_at(rest.partition_point(|distance| *distance <= edge));
            rest = others;
            if !own.is_empty() {
                next.push((own.iter().map(|value| f64::from(*value)).sum::<f64>() / own.len() as f64) as f32);
            }
        }
        if next == centers {
            break;
        }
        centers = next;
    }
    centers
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_fall_into_their_clusters() {
        let distances: Vec<f32> = (0..300).map(|k| [1.0, 5.0, 5.2, 20.0][k % 4] + 0.01 * (k % 7) as f32).collect();
        let found = clusters(&distances, 3);
        assert_eq!(found.len(), 3);
        for (found, expected) in found.iter().zip([1.03, 5.13, 20.03]) {
            assert!((found - expected).abs() < 0.01, "{found}");
        }
        assert_eq!(clusters(&[2.0; 10], 3), [2.0], "there are no more clusters than distances");
        assert!(clusters(&[], 3).is_empty());
    }

    #[test]
    fn things_stay_whole_and_only_the_first_meeting_of_a_ray_counts() {
        // A wall from 4 to 12 away, mostly at 10; a thing at 1; another one behind the first, met by the same rays.
        let mut meetings = Vec::new();
        for ray in 0..100u32 {
            let aside = ray as f32 / 100.0;
            let mut meet = |object, x: f32| meetings.push(Meeting { ray, object, position: Vec3::new(x, aside, 0.0) });
            meet(7, 1.0);
            meet(8, 1.5);
            meet(3, if ray < 30 { 4.0 } else { 10.0 });
        }
        let found = strata(&meetings, &[(9, 11.0), (5, 0.0)], 2, Shells::Sphere);
        assert_eq!(found.len(), 2);
        assert_eq!((&found[0].objects[..], &found[1].objects[..]), (&[7, 8, 5][..], &[3, 9][..]));
        let radius = found[0].shell.distance(Vec3::ZERO, Vec3::X);
        let mean: f32 = (0..100).map(|ray| Vec3::new(1.0, ray as f32 / 100.0, 0.0).length()).sum::<f32>() / 100.0;
        assert!((radius - mean).abs() < 1e-4, "{radius}: of the first things alone, not {mean}");
    }
}
