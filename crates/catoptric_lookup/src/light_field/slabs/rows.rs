//! Rows of views: captured here, or baked and in a file.

use super::blocks::compress;
use super::depth_blocks;
use super::form::{RowView, ViewForm};
use crate::light_field::layout::FieldLayout;
use crate::light_field::settings::Compression;
use catoptric_core::parallel;
use catoptric_core::progress::Progress;
use catoptric_engine::error::RenderError;
use catoptric_engine::method::bake::Baked;
use std::sync::Arc;

/// A row of views.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ViewRow {
    /// View after view, level after level, row after row: [`packed`](super::texels::packed) radiance.
    pub texels: Vec<u32>,
    /// View after view, row after row: the shift of a pixel's contents in the next view, as
    /// [`stored`](super::texels::stored).
    pub parallax: Vec<i16>,
}

impl ViewRow {
    /// An empty one for a number of views.
    pub(crate) fn with_room_for(views: u32, form: &ViewForm) -> Self {
        let (texels, rays) = (views * form.levels.count, u64::from(views) * form.rays_a_view());
        Self { texels: Vec::with_capacity(texels as usize), parallax: Vec::with_capacity(rays as usize) }
    }

    /// Bytes as they are baked, and kept where they are compressed: texels, or blocks of all levels, then parallaxes,
    /// or their blocks; the lowest byte of each number first.
    pub fn baked(&self, form: &ViewForm) -> Vec<u8> {
        let views = self.parallax.len() / form.rays_a_view() as usize;
        let mut bytes = Vec::with_capacity(views * form.bytes_a_view());
        if form.compression == Compression::None {
            bytes.extend(self.texels.iter().flat_map(|texel| texel.to_le_bytes()));
            bytes.extend(self.parallax.iter().flat_map(|parallax| parallax.to_le_bytes()));
            return bytes;
        }
        for view in self.texels.chunks(form.levels.count as usize) {
            for &(first, side) in &form.levels.levels {
                compress(form.compression, side, &view[first as usize..], &mut bytes);
            }
        }
        for view in self.parallax.chunks(form.rays_a_view() as usize) {
            depth_blocks::compress(form.side(), view, &mut bytes);
        }
        bytes
    }

    /// An uncompressed one.
    fn from_baked(bytes: &[u8], light_bytes: usize) -> Self {
        let (light, parallax) = bytes.split_at_checked(light_bytes).unwrap_or_default();
        let parallax = parallax.as_chunks::<2>().0.iter().map(|bytes| i16::from_le_bytes(*bytes)).collect();
        let texels = light.as_chunks::<4>().0.iter().map(|bytes| u32::from_le_bytes(*bytes)).collect();
        Self { texels, parallax }
    }

    fn view(&self) -> RowView<'_> {
        RowView { texels: &self.texels, parallax: &self.parallax, ..RowView::default() }
    }
}

/// The rows of views about a region, slab after slab or side after side.
#[derive(Clone)]
pub struct Rows {
    kept: Kept,
    /// Bytes of the light of each row, where they lie as they are baked.
    light_bytes: Vec<usize>,
}

#[derive(Clone)]
enum Kept {
    /// Rows in memory, not compressed.
    Plain(Vec<ViewRow>),
    /// Rows in memory, compressed.
    Blocks(Vec<Vec<u8>>),
    /// Units of a bake, from a first one on, where they lie in memory as they are used.
    Baked { units: Arc<dyn Baked>, first: usize, are_blocks: bool },
}

impl std::fmt::Debug for Rows {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match &self.kept {
            Kept::Plain(rows) => write!(formatter, "{} rows", rows.len()),
            Kept::Blocks(rows) => write!(formatter, "{} compressed rows", rows.len()),
            Kept::Baked { first, .. } => write!(formatter, "rows of a bake from its unit {first} on"),
        }
    }
}

fn light_bytes(layout: &FieldLayout, form: &ViewForm) -> Vec<usize> {
    (0..layout.row_count()).map(|row| layout.views_in_row(row) as usize * form.light_bytes()).collect()
}

impl Rows {
    /// Rows that `row` makes by their numbers, as they are after baking.
    ///
    /// # Errors
    /// The first of `row`'s, in order; [`RenderError::Cancelled`].
    pub fn captured(
        layout: &FieldLayout,
        form: &ViewForm,
        progress: &dyn Progress,
        row: impl Fn(usize) -> Result<ViewRow, RenderError> + Sync + Send,
    ) -> Result<Self, RenderError> {
        let (count, stage) = (layout.row_count(), "capturing light-field slabs");
        let kept = match form.compression {
            Compression::None => {
                let rows = parallel::map_stage(progress, stage, count, row)?;
                Kept::Plain(rows.into_iter().collect::<Result<_, _>>()?)
            }
            _ => {
                let rows = parallel::map_stage(progress, stage, count, |number| row(number).map(|row| row.baked(form)));
                Kept::Blocks(rows?.into_iter().collect::<Result<_, _>>()?)
            }
        };
        Ok(Self { kept, light_bytes: light_bytes(layout, form) })
    }

    /// Rows of a bake, from a unit on; returns `None` if it has fewer, or of another size.
    pub fn baked(units: &Arc<dyn Baked>, first: usize, layout: &FieldLayout, form: &ViewForm) -> Option<Self> {
        let count = layout.row_count();
        let bytes = |row: usize| layout.views_in_row(row) as usize * form.bytes_a_view();
        let fits = |row: usize| units.unit(first + row).len() == bytes(row);
        if first + count > units.unit_count() || !(0..count).all(fits) {
            return None;
        }
        let light_bytes = light_bytes(layout, form);
        let are_blocks = form.compression != Compression::None;
        let lies_as_numbers_must = |row: usize| numbers(units.unit(first + row), light_bytes[row]).is_some();
        let as_it_is = are_blocks || cfg!(target_endian = "little") && (0..count).all(lies_as_numbers_must);
        let kept = if as_it_is {
            Kept::Baked { units: units.clone(), first, are_blocks }
        } else {
            let row = |row: usize| ViewRow::from_baked(units.unit(first + row), light_bytes[row]);
            Kept::Plain(parallel::map_collect(count, row))
        };
        Some(Self { kept, light_bytes })
    }

    /// The row of a number; an empty one where there is none.
    #[inline(always)] // for the instructions of its caller
    pub fn row(&self, number: usize) -> RowView<'_> {
        let Some(&light_bytes) = self.light_bytes.get(number) else { return RowView::default() };
        match &self.kept {
            Kept::Plain(rows) => rows[number].view(),
            Kept::Blocks(rows) => blocks(&rows[number], light_bytes),
            // Baked units were complete when they were opened.
            Kept::Baked { units, first, are_blocks: false } => {
                numbers(units.unit(first + number), light_bytes).unwrap_or_default()
            }
            Kept::Baked { units, first, are_blocks: true } => blocks(units.unit(first + number), light_bytes),
        }
    }
}

/// The parts of a baked row that is not compressed; returns `None` if they are not aligned in memory.
#[inline(always)] // for the instructions of its caller
fn numbers(bytes: &[u8], light_bytes: usize) -> Option<RowView<'_>> {
    let (texels, parallax) = bytes.split_at_checked(light_bytes)?;
    let (texels, parallax) = (bytemuck::try_cast_slice(texels).ok()?, bytemuck::try_cast_slice(parallax).ok()?);
    Some(RowView { texels, parallax, ..RowView::default() })
}

/// The parts of a compressed row.
#[inline(always)] // for the instructions of its caller
fn blocks(bytes: &[u8], light_bytes: usize) -> RowView<'_> {
    let (blocks, depths) = bytes.split_at_checked(light_bytes).unwrap_or_default();
    RowView { blocks, depths, ..RowView::default() }
}
