//! Appearances of points at nodes: sorted by what belongs together, kept from frame to frame, and interpolated.

pub(crate) mod around_eye;
pub(crate) mod between;
pub(crate) mod cache;
mod cubes;
pub(crate) mod field;
pub(crate) mod lookout;
mod walk;

pub(super) use around_eye::AroundEye;
pub(super) use between::half_way;
pub(super) use cache::PointCache;
pub(super) use field::SightingField;
pub(super) use lookout::{Lookout, Node, NodeAnswer, REACH, Sightings, known, known_once};
pub(super) use walk::Mirror;
