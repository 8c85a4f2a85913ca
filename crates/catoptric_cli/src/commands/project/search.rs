//! The exact search for paths.

use catoptric::error::RenderError;
use catoptric::methods::projection::finder::PathSearch;
use catoptric::scene::Scene;
use glam::DVec3;

/// What `--method` calls it.
pub(super) const EXACT: &str = "exact";

/// The exact search for all paths of one to `order` bounces on these objects.
pub(super) fn exact_search<'a>(
    _scene: &'a Scene,
    _eye: DVec3,
    _order: u32,
    _objects: &[u32],
) -> Result<Box<dyn PathSearch + 'a>, RenderError> {
    let problem = "this build lacks the exact search; choose a method that projects points".into();
    Err(RenderError::Limit { method: EXACT, problem })
}
