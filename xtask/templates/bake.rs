//! The long precomputation, in units.

use super::{{type}}Settings;
use crate::error::RenderError;
use crate::methods::bake::BakeWork;
use crate::methods::{Quality, Settings};
use crate::scene::Scene;

/// The work of a bake; refused until there is some.
pub(super) fn work<'b>(
    table: &toml::Table,
    _scene: &'b Scene,
    _quality: Quality,
) -> Result<Box<dyn BakeWork + 'b>, RenderError> {
    {{type}}Settings::from_table(table)?;
    Err(RenderError::Limit { method: super::INFO.id, problem: "its bake has no units yet".into() })
}
