//! The textures and tables of a picture: kept for the next one of the same size.

use super::paths::Paths;
use super::rough::RoughTables;
use super::targets::Targets;
use super::tiles::TileTables;
use crate::device::context::Context;
use crate::error::GpuError;
use std::sync::{Arc, Mutex, PoisonError};

/// The textures and tables that pictures of a size are drawn with. Pictures that are
/// drawn one after the other share them: each fills all that it reads.
#[derive(Debug)]
pub(crate) struct PictureTables {
    size: [u32; 2],
    samples: u32,
    pub(crate) targets: Targets,
    pub(crate) tiles: TileTables,
    /// The light of rough mirrors.
    pub(crate) rough: RoughTables,
}

impl PictureTables {
    /// The tables of the last picture if they serve, for bands of so many columns and rows of cells.
    pub(crate) fn get(
        context: &Context,
        last: &Mutex<Option<Arc<Self>>>,
        size: [u32; 2],
        cells: [u32; 2],
        samples: u32,
        paths: Paths,
    ) -> Result<Arc<Self>, GpuError> {
        let mut last = last.lock().unwrap_or_else(PoisonError::into_inner);
        let serves = |tables: &&Arc<Self>| {
            let has_grids = tables.rough.byte_count() > 0;
            let serve = tables.tiles.serve(cells, samples, paths) && has_grids == paths.has_grids;
            (tables.size, tables.samples) == (size, samples) && serve
        };
        if let Some(tables) = last.as_ref().filter(serves) {
            return Ok(tables.clone());
        }
        // Frees its memory first.
        *last = None;
        let targets = Targets::new(context, size, samples, paths.drawn())?;
        let tiles = TileTables::new(context, cells, samples, paths)?;
        let rough = RoughTables::new(context, size, paths.has_grids);
        context.check()?;
        Ok(last.insert(Arc::new(Self { size, samples, targets, tiles, rough })).clone())
    }
}
