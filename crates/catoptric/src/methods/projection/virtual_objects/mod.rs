//! Virtual objects: what a scene looks like in a reflector is another object behind it.
//!
//! What the methods share that find, for every point, about where on a reflector it appears, and mirror the point in
//! the tangent plane there (Ofek, Rappoport 1998; Estalella et al. 2005): reflectors as meshes with rays at their
//! vertices, the virtual point of a bounce, and the recursion: the virtual object of a path's last bounce is an object
//! for the bounce before.

mod arrivals;
mod extrusion;
mod eye_image;
mod facets;
mod kept;
mod levels;
mod mesh;
mod piece;
mod projector;
mod rays;

pub(super) use extrusion::Extrusion;
pub(super) use eye_image::{EyeImage, NOTHING};
pub(super) use kept::{Kept, LONGEST_EDGE};
#[cfg(test)]
pub(super) use levels::Levels;
pub(super) use levels::{Locator, Recursion, Reflector};
pub(super) use mesh::ReflectorMesh;
pub(super) use piece::{CORNERS, in_front, interpolated, weights_of};
pub(super) use projector::Options;
pub(super) use rays::{Foot, VertexRays, outer};
