//! The long precomputation, in units.

use super::{{type}}Settings;
use catoptric_engine::error::RenderError;
use catoptric_engine::method::bake::BakeWork;
use catoptric_engine::method::{Quality, Settings};
use catoptric_core::scene::Scene;

/// The work of a bake; refused until there is some.
pub(super) fn work<'b>(
    table: &toml::Table,
    _scene: &'b Scene,
    _quality: Quality,
) -> Result<Box<dyn BakeWork + 'b>, RenderError> {
    {{type}}Settings::from_table(table)?;
    Err(RenderError::Limit { method: super::INFO.id, problem: "its bake has no units yet".into() })
}
