//! Rows of views: captured here, or baked and in a file.

use super::blocks::{byte_count, compress, decompress};
use super::texels::ViewLevels;
use crate::error::RenderError;
use crate::methods::bake::Baked;
use crate::methods::lookup::light_field::layout::{SLABS, SlabLayout};
use crate::methods::lookup::light_field::settings::Compression;
use crate::parallel;
use crate::progress::Progress;
use std::sync::Arc;

/// One row of a slab's views.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct ViewRow {
    /// View after view, level after level, row after row: [`packed`](super::texels::packed) radiance.
    pub(crate) texels: Vec<u32>,
    /// View after view, row after row: how far what a pixel shows is shifted in the next view, as
    /// [`stored`](super::texels::stored).
    pub(crate) parallax: Vec<i16>,
}

/// The same, wherever it is kept.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct RowView<'a> {
    pub(crate) texels: &'a [u32],
    pub(crate) parallax: &'a [i16],
}

/// Sizes of a row's tables, and their form in a bake.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RowSize {
    compression: Compression,
    /// Pixels a side of a view.
    side: u32,
    levels: ViewLevels,
    texels: usize,
    parallax: usize,
    /// Bytes of the texels as they are baked.
    light_bytes: usize,
}

impl RowSize {
    pub(crate) fn new(layout: &SlabLayout, compression: Compression) -> Self {
        let (st, uv, levels) = (layout.st as usize, layout.uv as usize, ViewLevels::new(layout.uv));
        let texels = st * levels.count as usize;
        let light_bytes = byte_count(compression, layout.uv).map_or(4 * texels, |view| st * view);
        Self { compression, side: layout.uv, levels, texels, parallax: st * uv * uv, light_bytes }
    }

    /// Rays of a row.
    pub(crate) fn rays(&self) -> usize {
        self.parallax
    }

    /// Bytes of a row as it is baked.
    pub(crate) fn baked_bytes(&self) -> usize {
        self.light_bytes + 2 * self.parallax
    }

    /// Bytes of a row as it is looked up.
    pub(crate) fn bytes(&self) -> usize {
        4 * self.texels + 2 * self.parallax
    }
}

impl ViewRow {
    /// An empty one.
    pub(crate) fn with_room_for(layout: &SlabLayout) -> Self {
        let RowSize { texels, parallax, .. } = RowSize::new(layout, Compression::None);
        Self { texels: Vec::with_capacity(texels), parallax: Vec::with_capacity(parallax) }
    }

    /// Bytes of a bake: texels, or blocks of the finest levels, then parallaxes, the lowest byte of each first.
    pub(crate) fn baked(&self, size: &RowSize) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(size.baked_bytes());
        match size.compression {
            Compression::None => bytes.extend(self.texels.iter().flat_map(|texel| texel.to_le_bytes())),
            compression => {
                for view in self.texels.chunks(size.levels.count as usize) {
                    compress(compression, size.side, view, &mut bytes);
                }
            }
        }
        bytes.extend(self.parallax.iter().flat_map(|parallax| parallax.to_le_bytes()));
        bytes
    }

    fn from_baked(bytes: &[u8], size: &RowSize) -> Self {
        let (light, parallax) = bytes.split_at(size.light_bytes);
        let parallax = parallax.as_chunks::<2>().0.iter().map(|bytes| i16::from_le_bytes(*bytes)).collect();
        let mut texels = Vec::with_capacity(size.texels);
        match byte_count(size.compression, size.side) {
            None => texels.extend(light.as_chunks::<4>().0.iter().map(|bytes| u32::from_le_bytes(*bytes))),
            Some(bytes_a_view) => {
                for blocks in light.chunks_exact(bytes_a_view) {
                    decompress(size.compression, size.side, blocks, &mut texels);
                    size.levels.append(&mut texels);
                }
            }
        }
        Self { texels, parallax }
    }

    /// The row as it is after baking.
    fn after_baking(self, size: &RowSize) -> Self {
        match size.compression {
            Compression::None => self,
            _ => Self::from_baked(&self.baked(size), size),
        }
    }

    fn view(&self) -> RowView<'_> {
        RowView { texels: &self.texels, parallax: &self.parallax }
    }
}

/// All rows of the slabs about a region, slab after slab.
#[derive(Clone)]
pub(crate) enum Rows {
    /// In memory: captured, or decompressed.
    Captured(Vec<ViewRow>),
    /// From a unit of a bake on, where they lie in memory as they are used.
    Baked {
        units: Arc<dyn Baked>,
        first: usize,
        /// Of a row.
        texels: usize,
    },
}

impl std::fmt::Debug for Rows {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Captured(rows) => write!(formatter, "{} captured rows", rows.len()),
            Self::Baked { first, .. } => write!(formatter, "rows of a bake from its unit {first} on"),
        }
    }
}

impl Rows {
    /// Rows that `row` makes by their numbers, as they are after baking.
    ///
    /// # Errors
    /// The first of `row`'s, in order; [`RenderError::Cancelled`].
    pub(crate) fn captured(
        layout: &SlabLayout,
        compression: Compression,
        progress: &dyn Progress,
        row: impl Fn(usize) -> Result<ViewRow, RenderError> + Sync + Send,
    ) -> Result<Self, RenderError> {
        let (count, size) = (SLABS * layout.st as usize, RowSize::new(layout, compression));
        let rows = parallel::map_stage(progress, "capturing light-field slabs", count, |number| {
            row(number).map(|row| row.after_baking(&size))
        })?;
        rows.into_iter().collect::<Result<_, _>>().map(Self::Captured)
    }

    /// Rows of a bake, from a unit on; returns `None` if it has fewer, or of another size.
    pub(crate) fn baked(
        units: &Arc<dyn Baked>,
        first: usize,
        layout: &SlabLayout,
        compression: Compression,
    ) -> Option<Self> {
        let size = RowSize::new(layout, compression);
        let numbers = first..first + SLABS * layout.st as usize;
        let fits = |unit: usize| units.unit(unit).len() == size.baked_bytes();
        if numbers.end > units.unit_count() || !numbers.clone().all(fits) {
            return None;
        }
        let lies_as_numbers_must = |unit: usize| split(units.unit(unit), size.texels).is_some();
        let as_it_is = compression == Compression::None && cfg!(target_endian = "little");
        if as_it_is && numbers.clone().all(lies_as_numbers_must) {
            return Some(Self::Baked { units: units.clone(), first, texels: size.texels });
        }
        let row = |number: usize| ViewRow::from_baked(units.unit(first + number), &size);
        Some(Self::Captured(parallel::map_collect(numbers.len(), row)))
    }

    #[inline(always)] // for the instructions of its caller
    pub(crate) fn row(&self, number: usize) -> RowView<'_> {
        match self {
            Self::Captured(rows) => rows[number].view(),
            // It was whole when it was opened.
            Self::Baked { units, first, texels } => split(units.unit(first + number), *texels).unwrap_or_default(),
        }
    }
}

/// The parts of a baked row; returns `None` if they are not aligned in memory.
#[inline(always)] // for the instructions of its caller
fn split(bytes: &[u8], texels: usize) -> Option<RowView<'_>> {
    let (texels, parallax) = bytes.split_at_checked(4 * texels)?;
    Some(RowView { texels: bytemuck::try_cast_slice(texels).ok()?, parallax: bytemuck::try_cast_slice(parallax).ok()? })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Aabb;
    use crate::progress::Silent;
    use glam::Vec3;

    /// Bytes from an odd or an even place on.
    struct Units {
        bytes: Vec<u8>,
        from: usize,
        length: usize,
    }

    impl Baked for Units {
        fn unit_count(&self) -> usize {
            (self.bytes.len() - self.from) / self.length
        }

        fn unit(&self, number: usize) -> &[u8] {
            let start = self.from + number * self.length;
            self.bytes.get(start..start + self.length).unwrap_or_default()
        }
    }

    fn row(seed: u32, size: &RowSize) -> ViewRow {
        ViewRow {
            texels: (0..size.texels as u32).map(|k| (k + 7 * seed).wrapping_mul(0x9E37_79B9)).collect(),
            parallax: (0..size.parallax as i32).map(|k| (k * 31 - 5000 * seed as i32) as i16).collect(),
        }
    }

    #[test]
    fn baked_rows_are_those_that_were_captured() {
        let layout = SlabLayout::new(Aabb { min: Vec3::ZERO, max: Vec3::ONE }, 3, 5);
        for compression in [Compression::None, Compression::Bc1, Compression::Bc6h, Compression::Bc7] {
            let size = RowSize::new(&layout, compression);
            let rows: Vec<ViewRow> = (0..2 * 18).map(|seed| row(seed, &size)).collect();
            let captured =
                Rows::captured(&layout, compression, &Silent, |number| Ok(rows[18 + number].clone())).unwrap();
            // Where numbers may lie, and where they may not.
            for from in [0, 1] {
                let mut bytes = vec![0; from];
                bytes.extend(rows.iter().flat_map(|row| row.baked(&size)));
                let units: Arc<dyn Baked> = Arc::new(Units { bytes, from, length: size.baked_bytes() });
                let second = Rows::baked(&units, 18, &layout, compression).unwrap();
                for number in 0..18 {
                    let (found, expected) = (second.row(number), captured.row(number));
                    assert_eq!((found.texels, found.parallax), (expected.texels, expected.parallax));
                    assert_eq!(expected.parallax, &rows[18 + number].parallax[..], "parallax is not compressed");
                    let same = expected.texels == &rows[18 + number].texels[..];
                    assert_eq!(same, compression == Compression::None, "noise does not fit into blocks");
                }
                assert!(Rows::baked(&units, 19, &layout, compression).is_none(), "one is missing");
                let other = SlabLayout::new(layout.region, 3, 6);
                assert!(Rows::baked(&units, 0, &other, compression).is_none(), "of another size");
            }
        }
    }
}
