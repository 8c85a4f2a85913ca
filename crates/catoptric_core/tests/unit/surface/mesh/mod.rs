//! Triangle meshes as geometry alone.

mod adjacency;
mod convexity;
mod parts;
mod weld;
