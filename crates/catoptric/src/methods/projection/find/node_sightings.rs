//! Appearances at the nodes around an eye.

use glam::{Mat3, Vec3};

/// The most nodes around an eye: the corners of a tetrahedron.
pub(in crate::methods::projection) const MOST_NODES: usize = 4;

/// An appearance at one node.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::methods::projection) struct Sighting {
    /// The first reflection point, and how it changes with the scene point.
    pub(in crate::methods::projection) first: Vec3,
    pub(in crate::methods::projection) change: Mat3,
    /// How it changes with the eye; not known after several bounces, and of glass.
    pub(in crate::methods::projection) change_with_eye: Option<Mat3>,
    /// Unit normal there, on the side from which other nodes see it, if it is beyond this node's horizon.
    pub(in crate::methods::projection) normal: Vec3,
    /// Optical length from the node to the scene point.
    pub(in crate::methods::projection) length: f32,
    pub(in crate::methods::projection) last_segment: f32,
    /// How far the reflection point may be off.
    pub(in crate::methods::projection) error: f32,
}

/// An appearance that all nodes around the eye know of.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::methods::projection) struct NodeSightings {
    pub(in crate::methods::projection) focal_index: u32,
    pub(in crate::methods::projection) at: [Sighting; MOST_NODES],
}
