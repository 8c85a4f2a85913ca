//! The description of a built-in scene.

use super::parameters::{ParameterInfo, Values, integer};
use catoptric_core::scene::Model;

/// The description and the parameters of a built-in scene.
#[derive(Debug)]
pub struct BuiltinInfo {
    /// The name that [`load`](super::load) and `builtin:NAME` take.
    pub name: &'static str,
    /// One line for tables.
    pub summary: &'static str,
    /// The parameters that can be changed.
    pub parameters: &'static [ParameterInfo],
    /// A command line that shows the scene well.
    pub command: &'static str,
    /// Makes the scene from checked values, one for every parameter.
    pub(super) build: fn(&str, &Values<'_>) -> Model,
}

/// The smallest `tess`.
const MIN_TESS: u64 = 3;
/// The largest `tess`: a sphere of a million triangles.
const MAX_TESS: u64 = 512;

pub(super) const TESS: ParameterInfo = integer(
    "tess",
    "64",
    "tessellation of curved surfaces: a sphere has this many rings and twice as many segments",
    MIN_TESS,
    MAX_TESS,
);
