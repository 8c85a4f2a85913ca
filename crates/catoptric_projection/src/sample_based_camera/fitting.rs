//! Cameras fitted to all paths of a ray map.

use super::cameras::{CameraBuilder, CameraDemand, Cameras, Counts};
use super::rays::grid::RayGrid;
use super::rays::sampler::RaySampler;
use catoptric_core::math::Aabb;
use catoptric_core::parallel;
use catoptric_core::progress::{Cancelled, Progress};
use catoptric_core::scene::PreciseView;
use catoptric_engine::method::Report;
use catoptric_engine::method::projector::{PathBeginnings, SpecularPath};

/// The work of fitting cameras for each ray of the map. Measured on meshes of files.
const WORK_A_RAY: u64 = 30;

/// The further work for each ray that is traced between them, where they are too few to fit cameras.
const WORK_A_TRACED_RAY: u64 = 17;

impl RayGrid {
    /// Drops the groups of paths that are not wanted, and those that there is not enough work for, those of long paths
    /// first, and returns their paths.
    pub(super) fn drop_expensive(&mut self, work: u64, without: &PathBeginnings) -> Vec<SpecularPath> {
        let mut by_length: Vec<usize> = (0..self.groups.len()).collect();
        by_length.sort_by_key(|&group| self.groups[group].path.bounces.len());
        let (mut remaining, mut is_kept) = (work, vec![false; self.groups.len()]);
        for group in by_length {
            if without.hold(&self.groups[group].path) {
                continue;
            }
            let needed = WORK_A_RAY * self.groups[group].rays.len() as u64;
            if needed > remaining {
                // Longer ones are not drawn without it.
                break;
            }
            remaining -= needed;
            is_kept[group] = true;
        }
        let mut kept = is_kept.into_iter();
        let groups = std::mem::take(&mut self.groups);
        let (kept, dropped): (Vec<_>, Vec<_>) = groups.into_iter().partition(|_| kept.next().unwrap_or_default());
        self.groups = kept;
        dropped.into_iter().map(|group| group.path).collect()
    }

    /// Drops the groups more of whose blocks have no accurate camera than have one, and returns their paths.
    pub(super) fn drop_inaccurate(&mut self, cameras: &mut Vec<Cameras>) -> Vec<SpecularPath> {
        let is_accurate = |cameras: &Cameras| {
            let counts = cameras.counts();
            counts.unrefined_blocks <= counts.leaves
        };
        let groups = std::mem::take(&mut self.groups).into_iter().zip(std::mem::take(cameras));
        let (kept, dropped): (Vec<_>, Vec<_>) = groups.partition(|(_, cameras)| is_accurate(cameras));
        (self.groups, *cameras) = kept.into_iter().unzip();
        dropped.into_iter().map(|(group, _)| group.path).collect()
    }

    /// The cameras of each group, as accurate as its path's are to be, or none where they are left out; rays that they
    /// need are added to these, with the work that is left then.
    pub(super) fn cameras(
        &mut self,
        sampler: &RaySampler<'_>,
        view: &PreciseView,
        bounds: Aabb,
        (demand, of_path): (CameraDemand, impl Fn(&SpecularPath) -> (f32, bool) + Sync),
        work: u64,
        progress: &dyn Progress,
    ) -> Result<Vec<Cameras>, Cancelled> {
        let count: u64 = self.groups.iter().map(|group| group.rays.len() as u64).sum();
        let traced = work.saturating_sub(WORK_A_RAY * count) / WORK_A_TRACED_RAY;
        let demand = CameraDemand { traced_a_ray: (traced / count.max(1)).max(1), ..demand };
        let built = parallel::map_stage(progress, "fitting cameras", self.groups.len(), |group| {
            let group = &self.groups[group];
            let (accuracy_px, leaves_out) = of_path(&group.path);
            let demand = CameraDemand { accuracy_px: accuracy_px.into(), leaves_out, ..demand };
            CameraBuilder { group, view, bounds, sampler, demand }.cameras()
        })?;
        let with_rays = built.into_iter().zip(&mut self.groups);
        let cameras = with_rays.map(|((mut cameras, added), group)| {
            self.traced += added.traced;
            if !added.rays.is_empty() {
                cameras.renumber(&group.add(added.rays));
            }
            cameras
        });
        Ok(cameras.collect())
    }
}

/// Adds the counts and bytes of some grids of rays with their cameras.
pub(super) fn describe<'a>(grids: impl Iterator<Item = (&'a RayGrid, &'a [Cameras])> + Clone, report: &mut Report) {
    let counts: Vec<Counts> = grids.clone().flat_map(|(_, cameras)| cameras).map(Cameras::counts).collect();
    let groups = || grids.clone().flat_map(|(grid, _)| &grid.groups);
    let sum = |count: fn(&Counts) -> u64| counts.iter().map(count).sum::<u64>();
    report.counts.insert("ray_map_rays", groups().map(|group| group.count() as u64).sum());
    report.counts.insert("leaves", sum(|counts| counts.leaves));
    report.counts.insert("ray_lists", sum(|counts| counts.ray_lists));
    report.counts.insert("rays_in_lists", sum(|counts| counts.rays_in_lists));
    let left = [
        ("unrefined_blocks", sum(|counts| counts.unrefined_blocks)),
        ("unsplit_lists", sum(|counts| counts.unsplit_lists)),
    ];
    report.fallbacks.extend(left.into_iter().filter(|(_, count)| *count > 0));
    report.counts.insert("pieces", groups().map(|group| u64::from(group.piece_count)).sum());
    report.bytes.insert("cameras", sum(|counts| counts.bytes));
}
