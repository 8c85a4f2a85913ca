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

/// One row of views.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct ViewRow {
    /// View after view, level after level, row after row: [`packed`](super::texels::packed) radiance.
    pub(crate) texels: Vec<u32>,
    /// View after view, row after row: how far what a pixel shows is shifted in the next view, as
    /// [`stored`](super::texels::stored).
    pub(crate) parallax: Vec<i16>,
}

impl ViewRow {
    /// An empty one for a number of views.
    pub(crate) fn with_room_for(views: u32, form: &ViewForm) -> Self {
        let (texels, rays) = (views * form.levels.count, u64::from(views) * form.rays_a_view());
        Self { texels: Vec::with_capacity(texels as usize), parallax: Vec::with_capacity(rays as usize) }
    }

    /// Bytes as they are baked, and kept where they are compressed: texels, or blocks of all levels, then parallaxes,
    /// or their blocks; the lowest byte of each number first.
    pub(crate) fn baked(&self, form: &ViewForm) -> Vec<u8> {
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

/// All rows of views about a region, slab after slab or side after side.
#[derive(Clone)]
pub(crate) struct Rows {
    kept: Kept,
    /// Bytes of the light of each row, where they lie as they are baked.
    light_bytes: Vec<usize>,
}

#[derive(Clone)]
enum Kept {
    /// In memory, not compressed.
    Plain(Vec<ViewRow>),
    /// In memory, compressed.
    Blocks(Vec<Vec<u8>>),
    /// From a unit of a bake on, where they lie in memory as they are used.
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
    pub(crate) fn captured(
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

    /// Rows that are at hand.
    #[cfg(test)]
    pub(crate) fn plain(layout: &FieldLayout, rows: Vec<ViewRow>) -> Self {
        let form = ViewForm::new(layout.uv(), Compression::None);
        Self { kept: Kept::Plain(rows), light_bytes: light_bytes(layout, &form) }
    }

    /// Rows of a bake, from a unit on; returns `None` if it has fewer, or of another size.
    pub(crate) fn baked(units: &Arc<dyn Baked>, first: usize, layout: &FieldLayout, form: &ViewForm) -> Option<Self> {
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
    pub(crate) fn row(&self, number: usize) -> RowView<'_> {
        let Some(&light_bytes) = self.light_bytes.get(number) else { return RowView::default() };
        match &self.kept {
            Kept::Plain(rows) => rows[number].view(),
            Kept::Blocks(rows) => blocks(&rows[number], light_bytes),
            // It was whole when it was opened.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light_field::settings::{Layout, LightFieldSettings};
    use catoptric_core::math::Aabb;
    use catoptric_core::progress::Silent;
    use glam::Vec3;

    /// Bytes from an odd or an even place on.
    struct Units {
        bytes: Vec<u8>,
        /// Where each begins, and where the last ends.
        starts: Vec<usize>,
    }

    impl Units {
        fn new(from: usize, units: impl Iterator<Item = Vec<u8>>) -> Self {
            let mut made = Self { bytes: vec![0; from], starts: vec![from] };
            for unit in units {
                made.bytes.extend(unit);
                made.starts.push(made.bytes.len());
            }
            made
        }
    }

    impl Baked for Units {
        fn unit_count(&self) -> usize {
            self.starts.len() - 1
        }

        fn unit(&self, number: usize) -> &[u8] {
            let ends = self.starts.get(number).zip(self.starts.get(number + 1));
            ends.map(|(start, end)| &self.bytes[*start..*end]).unwrap_or_default()
        }
    }

    fn row(seed: u32, views: u32, form: &ViewForm) -> ViewRow {
        let (texels, rays) = (views * form.levels.count, views * form.rays_a_view() as u32);
        ViewRow {
            texels: (0..texels).map(|k| (k + 7 * seed).wrapping_mul(0x9E37_79B9)).collect(),
            parallax: (0..rays as i32).map(|k| (k * 31 - 5000 * seed as i32) as i16).collect(),
        }
    }

    fn layout(layout: Layout, st: u32, uv: u32) -> FieldLayout {
        let settings = LightFieldSettings { layout, st, uv, ..LightFieldSettings::default() };
        FieldLayout::new(&settings, Aabb { min: Vec3::ZERO, max: Vec3::new(1.0, 1.0, 0.6) })
    }

    #[test]
    fn baked_rows_are_those_that_were_captured() {
        for of in [Layout::Slabs, Layout::Box] {
            let fields = layout(of, 3, 5);
            let count = fields.row_count();
            for compression in [Compression::None, Compression::Bc1, Compression::Bc6h, Compression::Bc7] {
                let form = ViewForm::new(5, compression);
                let made = |number: usize| row(number as u32, fields.views_in_row(number % count), &form);
                let rows: Vec<ViewRow> = (0..2 * count).map(made).collect();
                let captured =
                    Rows::captured(&fields, &form, &Silent, |number| Ok(rows[count + number].clone())).unwrap();
                // Where numbers may lie, and where they may not.
                for from in [0, 1] {
                    let units = Units::new(from, rows.iter().map(|row| row.baked(&form)));
                    let units: Arc<dyn Baked> = Arc::new(units);
                    let second = Rows::baked(&units, count, &fields, &form).unwrap();
                    for number in 0..count {
                        let (found, expected) = (second.row(number), captured.row(number));
                        assert_eq!((found.texels, found.parallax), (expected.texels, expected.parallax));
                        assert_eq!((found.blocks, found.depths), (expected.blocks, expected.depths));
                        let same = expected.texels == &rows[count + number].texels[..];
                        assert_eq!(same, compression == Compression::None, "noise does not fit into blocks");
                    }
                    assert!(Rows::baked(&units, count + 1, &fields, &form).is_none(), "one is missing");
                    let other = layout(of, 3, 9);
                    let of_other = ViewForm::new(9, compression);
                    assert!(Rows::baked(&units, 0, &other, &of_other).is_none(), "of another size");
                }
            }
        }
    }
}
