//! Appearances at the nodes around an eye.

use glam::{Mat3, Vec3};

/// The most nodes around an eye: the corners of a tetrahedron.
pub(crate) const MOST_NODES: usize = 4;

/// An appearance at one node.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Sighting {
    /// The first reflection point, and how it changes with the scene point.
    pub(crate) first: Vec3,
    pub(crate) change: Mat3,
    /// How it changes with the eye; not known after several bounces, and of glass.
    pub(crate) change_with_eye: Option<Mat3>,
    /// Unit normal there, on the side from which other nodes see it, if it is beyond this node's horizon.
    pub(crate) normal: Vec3,
    /// Optical length from the node to the scene point.
    pub(crate) length: f32,
    pub(crate) last_segment: f32,
    /// How far the reflection point may be off.
    pub(crate) error: f32,
}

/// An appearance that all nodes around the eye know of.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct NodeSightings {
    pub(crate) focal_index: u32,
    pub(crate) at: [Sighting; MOST_NODES],
}
