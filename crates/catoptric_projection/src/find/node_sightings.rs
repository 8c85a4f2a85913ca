//! Appearances at the nodes around an eye.

use glam::{Mat3, Vec3};

/// The maximum number of nodes around an eye: the corners of a tetrahedron.
pub const MOST_NODES: usize = 4;

/// An appearance at one node.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sighting {
    /// The first reflection point.
    pub first: Vec3,
    /// The derivative of the reflection point with respect to the scene point.
    pub change: Mat3,
    /// The derivative of the reflection point with respect to the eye; `None` after several bounces, and of glass.
    pub change_with_eye: Option<Mat3>,
    /// Unit normal there, on the side from which other nodes see it, if it is beyond this node's horizon.
    pub normal: Vec3,
    /// Optical length from the node to the scene point.
    pub length: f32,
    /// The length from the last reflection point to the scene point.
    pub last_segment: f32,
    /// The error of the reflection point, in scene units.
    pub error: f32,
}

/// An appearance that all nodes around the eye know of.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NodeSightings {
    /// The number of focal points that light passes.
    pub focal_index: u32,
    /// The sighting at each node.
    pub at: [Sighting; MOST_NODES],
}
