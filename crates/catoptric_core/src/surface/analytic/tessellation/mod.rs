//! Meshes of surfaces: sheets of a grid, bodies of revolution, polygons of a field.

pub(super) mod mesh;
pub(super) mod polygonise;
