//! The exact search for paths.

use catoptric::error::RenderError;
use catoptric::methods::Job;
use catoptric::methods::path_query::PathSearch;
use catoptric::methods::projection::find::exact_search::{ExactSearch, SearchSettings};
use glam::DVec3;

/// The name of the exact search in `--method`.
pub(super) const EXACT: &str = "exact";

/// The exact search for all paths of one to `job.quality.order` bounces on these objects; blocked ones too, as far as
/// they are found, unless `visible_only`.
pub(super) fn exact_search<'a>(
    job: &Job<'a>,
    eye: DVec3,
    objects: &[u32],
    visible_only: bool,
) -> Result<Box<dyn PathSearch + 'a>, RenderError> {
    let settings = SearchSettings { visible_only, ..SearchSettings::default() };
    Ok(Box::new(ExactSearch::new(job.scene, eye, job.quality.order, objects, &settings, job.progress)?))
}
