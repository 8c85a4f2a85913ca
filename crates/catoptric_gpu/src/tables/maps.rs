//! Environment maps of reflectors, as tables.

use crate::error::GpuError;
use crate::layout::ReflectorMap;
use catoptric::methods::lookup::environment_map::{CubeMap, ParallaxProxy, ReflectorCubeMap};
use std::sync::Arc;

/// The maps of all objects, and the texels of their cubes.
#[derive(Clone, Debug, Default)]
pub struct MapTables {
    /// The record of every object.
    pub records: Vec<ReflectorMap>,
    /// Cube by cube, as [`CubeMap::texels`].
    pub texels: Vec<[f32; 4]>,
}

/// The tables of a scene's maps; cubes that objects share are stored once.
///
/// # Errors
/// [`GpuError::Unsupported`] for shapes that no environment map has.
pub fn map_tables(maps: &[Option<ReflectorCubeMap>]) -> Result<MapTables, GpuError> {
    let mut tables = MapTables::default();
    let mut known: Vec<(Arc<CubeMap>, u32)> = Vec::new();
    for map in maps {
        let Some(ReflectorCubeMap { center, cube, proxy }) = map else {
            tables.records.push(ReflectorMap::default());
            continue;
        };
        let mut record = ReflectorMap { center: center.to_array(), ..ReflectorMap::default() };
        match *proxy {
            ParallaxProxy::Infinite => record.shape = 1 << 8,
            ParallaxProxy::Box(bounds) => {
                record.shape = 2 << 8;
                (record.low, record.high) = (bounds.min.to_array(), bounds.max.to_array());
            }
            ParallaxProxy::Sphere(radius) => (record.shape, record.low[0]) = (3 << 8, radius),
            ParallaxProxy::Cylinder { .. } => {
                return Err(GpuError::Unsupported { what: "cylinders around environment maps".into() });
            }
        }
        if let Some(cube) = cube {
            record.size = cube.size();
            let stored = known.iter().find(|(other, _)| Arc::ptr_eq(other, cube)).map(|(_, first)| *first);
            record.first = stored.unwrap_or_else(|| {
                let first = tables.texels.len() as u32;
                tables.texels.extend(cube.texels());
                known.push((cube.clone(), first));
                first
            });
        }
        tables.records.push(record);
    }
    Ok(tables)
}
