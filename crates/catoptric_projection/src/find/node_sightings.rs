//! Appearances at the nodes around an eye.

use glam::{Mat3, Vec3};

/// The most nodes around an eye: the corners of a tetrahedron.
pub const MOST_NODES: usize = 4;

/// An appearance at one node.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sighting {
    /// The first reflection point.
    pub first: Vec3,
    /// How it changes with the scene point.
    pub change: Mat3,
    /// How it changes with the eye; not known after several bounces, and of glass.
    pub change_with_eye: Option<Mat3>,
    /// Unit normal there, on the side from which other nodes see it, if it is beyond this node's horizon.
    pub normal: Vec3,
    /// Optical length from the node to the scene point.
    pub length: f32,
    /// The length from the last reflection point to the scene point.
    pub last_segment: f32,
    /// How far the reflection point may be off.
    pub error: f32,
}

/// An appearance that all nodes around the eye know of.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NodeSightings {
    /// How many focal points light passes.
    pub focal_index: u32,
    /// At each node.
    pub at: [Sighting; MOST_NODES],
}
