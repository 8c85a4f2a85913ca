//! Virtual objects: what a scene looks like in a reflector is another object behind it.
//!
//! What the methods share that find, for every point, about where on a reflector it appears, and mirror the point in
//! the tangent plane there (Ofek, Rappoport 1998; Estalella et al. 2005): reflectors as meshes with rays at their
//! vertices, the virtual point of a bounce, and the recursion: the virtual object of a path's last bounce is an object
//! for the bounce before.

mod eye_image;
mod levels;
mod mesh;
mod projector;
mod rays;

pub(super) use eye_image::{EyeImage, NOTHING};
pub(super) use levels::{Levels, Locator, Recursion, Reflector};
pub(super) use mesh::ReflectorMesh;
pub(super) use projector::{Options, VirtualObjects};
pub(super) use rays::{Foot, VertexRays, outer, weights_of};
