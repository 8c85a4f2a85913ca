//! The parts of the engine one by one: paths of light, hierarchies, tracers, the rasteriser and measures of pictures.

mod light;
mod metrics;
mod optics;
mod raster;
