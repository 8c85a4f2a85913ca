//! Virtual objects: the image of a scene in a reflector is another object behind it.
//!
//! Shared by the methods that find, for every point, about where on a reflector it appears, and mirror the point in
//! the tangent plane there (Ofek, Rappoport 1998; Estalella et al. 2005): reflectors as meshes with rays at their
//! vertices, the virtual point of a bounce, and the recursion: the virtual object of a path's last bounce is an object
//! for the bounce before.

mod arrivals;
mod descent;
mod eye_image;
mod locator;
pub(crate) mod mesh;
pub(crate) mod path_tree;
mod piece;
mod project;
pub(crate) mod rays;

pub(crate) use descent::Recursion;
pub(crate) use eye_image::{EyeImage, NOTHING};
pub use locator::{Locator, Reflector};
pub(crate) use mesh::Extrusion;
pub use mesh::ReflectorMesh;
pub(crate) use path_tree::{PathLimits, PathTree, map_size};
pub use piece::{CORNERS, in_front, interpolated, weights_of};
pub(crate) use project::{Options, VirtualObjects};
pub use rays::{ReflectionPoint, ReflectionPoints, VertexRays, outer};
