//! The CPU rasteriser: draws real and moved (virtual) geometry alike into layers of coverage samples, tile by tile,
//! and hands each visible surface to a shader once a pixel.
//!
//! A call sets up and sorts the triangles into tiles, then draws tile after tile on all cores: its samples stay in
//! the cache, and nothing is kept a sample for the whole picture. Pictures do not depend on the number of threads.

mod attributes;
mod bin;
mod fragment;
pub mod id_map;
mod ids;
mod kernel;
mod lists;
mod plan;
mod report;
mod samples;
mod scene_list;
mod setup;
pub mod source;
mod tile;

pub use fragment::{Fragment, FragmentBatch, FragmentShader, LayerSurface};
pub use lists::{BlockMask, Branch, DrawList, DrawTriangle, Stencil};
pub use report::RasterReport;
pub use samples::{SAMPLE_COUNTS, sample_positions};
pub use scene_list::{LookShader, SceneShader, ShadingRequest, scene_draw_list};
pub use scene_list::{is_seen_from_behind, patch_of_triangle, shade_looks};
#[doc(hidden)]
pub use {
    attributes::barycentrics,
    kernel::{
        BLOCK, EMPTY, Ids, Keys, LayerSamples, StencilMask, TILE, TilePlace, draw_triangles, draw_triangles_portably,
    },
    samples::Pattern,
    setup::{PictureSetup, SetupOutcome, SetupTriangle, set_up},
};

use crate::error::RenderError;
use bin::{Bins, TileGrid, bin};
use catoptric_core::clock::Stopwatch;
use catoptric_core::framebuffer::{EdgeSamples, Framebuffer};
use catoptric_core::parallel;
use catoptric_core::progress::{Cancelled, Progress, Silent};
use catoptric_core::scene::View;
use plan::Plan;
use setup::MAX_PICTURE_PX;
use source::{LayerSource, ListsAlone};
use std::sync::{Mutex, PoisonError};
use tile::{TileReport, TileScratch, TileWork};

/// Draws `lists` into `target`, which has the view's size, with `samples` coverage samples a pixel.
///
/// Every pixel becomes the mean over its samples of the shader's colours, summed over the branches that they show;
/// alpha becomes 1.
///
/// # Errors
/// [`RenderError::Samples`] when `samples` is none of [`SAMPLE_COUNTS`]; [`RenderError::Limit`] when the picture is
/// larger than 16,384 pixels or differs in size from the target, when a list is in a layer beyond 63, or when a stencil
/// is missing or names no list of the layer below; [`RenderError::Cancelled`], the target is then drawn in part.
pub fn draw<S: FragmentShader + ?Sized>(
    view: &View,
    samples: u32,
    lists: &[DrawList],
    shader: &S,
    target: &mut Framebuffer,
    progress: &dyn Progress,
) -> Result<RasterReport, RenderError> {
    draw_with(view, samples, lists, &ListsAlone, shader, target, progress)
}

/// As [`draw`], with surfaces that a source finds where no list goes on.
///
/// # Errors
/// As [`draw`].
pub fn draw_with<S: FragmentShader + ?Sized, L: LayerSource>(
    view: &View,
    samples: u32,
    lists: &[DrawList],
    source: &L,
    shader: &S,
    target: &mut Framebuffer,
    progress: &dyn Progress,
) -> Result<RasterReport, RenderError> {
    let pixels = view.width as usize * view.height as usize;
    if (target.width, target.height) != (view.width, view.height) || target.pixels.len() != pixels {
        let (width, height, have, rows) = (view.width, view.height, target.width, target.height);
        return Err(limit(format!("the view has {width} x {height} pixels, but the target {have} x {rows}")));
    }
    let mut clock = Stopwatch::new();
    let sorted = Sorted::new(view, samples, lists)?;
    let mut report = sorted.report();
    report.raster_ms = clock.lap_ms();
    if pixels == 0 {
        return Ok(report);
    }
    let mut tiles = split_into_tiles(target, &sorted.grid);
    sorted.for_each_tile(progress, &mut tiles, source, shader, |work, scratch, tile| {
        tile.done = work.draw(scratch, &mut tile.rows);
        tile.edges = work.edges(scratch, &tile.rows);
    })?;
    let (mut done, mut edges) = (TileReport::default(), EdgeSamples::default());
    for tile in tiles {
        done.add(tile.done);
        edges.append(tile.edges);
    }
    target.edges = edges;
    report.fragments = done.fragments;
    let of_threads = done.raster_ms + done.shade_ms + done.resolve_ms;
    // Without a clock all of them are 0.
    let share = if of_threads > 0.0 { clock.lap_ms() / of_threads } else { 0.0 };
    report.raster_ms += done.raster_ms * share;
    report.shade_ms += done.shade_ms * share;
    report.resolve_ms += done.resolve_ms * share;
    Ok(report)
}

/// Calls `seen` with the pixel (column, row) and the triangle for all triangles of a list in layer 0 that show at
/// the samples of a picture's pixels; pixels come in any order and on all threads, those of one triangle and pixel
/// possibly more than once. Nothing is shaded, and nothing is drawn if none of the list's triangles may show.
///
/// # Errors
/// The errors of [`draw`].
pub fn for_each_seen<S: FragmentShader + ?Sized>(
    view: &View,
    samples: u32,
    lists: &[DrawList],
    list: u32,
    shader: &S,
    seen: impl Fn([u32; 2], &DrawTriangle) + Sync,
) -> Result<(), RenderError> {
    let sorted = Sorted::new(view, samples, lists)?;
    let mut tiles = vec![(); sorted.grid.columns * sorted.grid.rows];
    let work = |work: &TileWork<'_, S, _>, scratch: &mut TileScratch<()>, (): &mut ()| {
        work.for_each_seen(list, scratch, &seen)
    };
    Ok(sorted.for_each_tile(&Silent, &mut tiles, &ListsAlone, shader, work)?)
}

fn limit(problem: String) -> RenderError {
    RenderError::Limit { method: "raster", problem }
}

/// Lists that are ready to be drawn tile by tile.
struct Sorted<'a> {
    frame: PictureSetup,
    plan: Plan<'a>,
    grid: TileGrid,
    bins: Vec<Bins>,
}

impl<'a> Sorted<'a> {
    fn new(view: &View, samples: u32, lists: &'a [DrawList]) -> Result<Self, RenderError> {
        let (width, height) = (view.width, view.height);
        if width > MAX_PICTURE_PX || height > MAX_PICTURE_PX {
            return Err(limit(format!("the picture has {width} x {height} pixels; a side can have {MAX_PICTURE_PX}")));
        }
        let frame = PictureSetup::new(view, Pattern::new(samples)?);
        let total: usize = lists.iter().map(|list| list.triangles.len()).sum();
        let piece_size = (total / (parallel::thread_count() * 8)).clamp(1024, 65_536) as u32;
        let plan = Plan::new(lists, piece_size)?;
        let grid = TileGrid::new(&frame);
        // A picture without pixels shows nothing.
        let pieces = if width == 0 || height == 0 { 0 } else { plan.pieces.len() };
        let bins = parallel::map_collect(pieces, |index| {
            let piece = &plan.pieces[index];
            bin(&frame, &grid, &lists[piece.list as usize], piece)
        });
        Ok(Self { frame, plan, grid, bins })
    }

    fn report(&self) -> RasterReport {
        let mut report = RasterReport::default();
        for piece in &self.bins {
            report.triangles += piece.report.triangles;
            report.clipped += piece.report.clipped;
            report.binned += piece.report.binned;
        }
        report
    }

    /// Calls `work` for every tile, on all cores.
    fn for_each_tile<S: FragmentShader + ?Sized, L: LayerSource, T: Send>(
        &self,
        progress: &dyn Progress,
        tiles: &mut [T],
        source: &L,
        shader: &S,
        work: impl Fn(&TileWork<'_, S, L>, &mut TileScratch<L::Found>, &mut T) + Sync,
    ) -> Result<(), Cancelled> {
        let scratches: Mutex<Vec<TileScratch<L::Found>>> = Mutex::default();
        parallel::for_each_mut_stage(progress, "drawing", tiles, |index, tile| {
            let locked = || scratches.lock().unwrap_or_else(PoisonError::into_inner);
            let mut scratch = locked().pop().unwrap_or_default();
            let Self { frame, plan, grid, bins } = self;
            let place = grid.place(frame, index);
            work(&TileWork { frame, plan, bins, source, shader, tile: index, place }, &mut scratch, tile);
            locked().push(scratch);
        })
    }
}

/// The pixels of a tile in the picture.
struct TileTarget<'a> {
    rows: Vec<&'a mut [[f32; 4]]>,
    edges: EdgeSamples,
    done: TileReport,
}

fn split_into_tiles<'a>(target: &'a mut Framebuffer, grid: &TileGrid) -> Vec<TileTarget<'a>> {
    let mut tiles: Vec<TileTarget<'a>> = Vec::with_capacity(grid.columns * grid.rows);
    tiles.resize_with(grid.columns * grid.rows, || TileTarget {
        rows: Vec::with_capacity(TILE),
        edges: EdgeSamples::default(),
        done: TileReport::default(),
    });
    for (row, pixels) in target.pixels.chunks_mut(target.width as usize).enumerate() {
        for (column, piece) in pixels.chunks_mut(TILE).enumerate() {
            tiles[row / TILE * grid.columns + column].rows.push(piece);
        }
    }
    tiles
}
