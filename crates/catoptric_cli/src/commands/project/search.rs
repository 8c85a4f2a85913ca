//! The exact search for paths.

use catoptric::error::RenderError;
use catoptric::methods::projection::exact_search::{ExactSearch, SearchSettings};
use catoptric::methods::projection::finder::PathSearch;
use catoptric::scene::Scene;
use glam::DVec3;

/// What `--method` calls it.
pub(super) const EXACT: &str = "exact";

/// The exact search for all paths of one to `order` bounces on these objects; blocked ones too, as far as they are
/// found, unless `visible_only`.
pub(super) fn exact_search<'a>(
    scene: &'a Scene,
    eye: DVec3,
    order: u32,
    objects: &[u32],
    visible_only: bool,
) -> Result<Box<dyn PathSearch + 'a>, RenderError> {
    let settings = SearchSettings { visible_only, ..SearchSettings::default() };
    Ok(Box::new(ExactSearch::new(scene, eye, order, objects, &settings)?))
}
