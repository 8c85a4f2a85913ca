//! Rows of views: captured here, or baked and in a file.

use super::layout::{Layout, SLABS};
use super::texels::Levels;
use crate::error::RenderError;
use crate::methods::bake::Baked;
use crate::parallel;
use crate::progress::Progress;
use std::sync::Arc;

/// One row of a slab's views.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Row {
    /// View after view, level after level, row after row: [`packed`](super::texels::packed) radiance.
    pub(super) texels: Vec<u32>,
    /// View after view, row after row: how far what a pixel shows is shifted in the next view, as
    /// [`stored`](super::texels::stored).
    pub(super) parallax: Vec<i16>,
}

/// The same, wherever it is kept.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RowView<'a> {
    pub(super) texels: &'a [u32],
    pub(super) parallax: &'a [i16],
}

/// How many of each a row has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct RowSize {
    pub(super) texels: usize,
    pub(super) parallax: usize,
}

impl RowSize {
    pub(super) fn new(layout: &Layout, levels: &Levels) -> Self {
        let (st, uv) = (layout.st as usize, layout.uv as usize);
        Self { texels: st * levels.count as usize, parallax: st * uv * uv }
    }

    /// Bytes of a row as it is baked.
    pub(super) fn bytes(self) -> usize {
        4 * self.texels + 2 * self.parallax
    }
}

impl Row {
    /// As it is baked: texels, then parallaxes, the lowest byte of each first.
    pub(super) fn bytes(&self) -> Vec<u8> {
        let texels = self.texels.iter().flat_map(|texel| texel.to_le_bytes());
        texels.chain(self.parallax.iter().flat_map(|parallax| parallax.to_le_bytes())).collect()
    }

    fn from_bytes(bytes: &[u8], size: RowSize) -> Self {
        let (texels, parallax) = bytes.split_at(4 * size.texels);
        let (texels, parallax) = (texels.as_chunks::<4>().0, parallax.as_chunks::<2>().0);
        Self {
            texels: texels.iter().map(|bytes| u32::from_le_bytes(*bytes)).collect(),
            parallax: parallax.iter().map(|bytes| i16::from_le_bytes(*bytes)).collect(),
        }
    }

    fn view(&self) -> RowView<'_> {
        RowView { texels: &self.texels, parallax: &self.parallax }
    }
}

/// All rows of the slabs about a region, slab after slab.
#[derive(Clone)]
pub(super) enum Rows {
    Captured(Vec<Row>),
    /// From a unit of a bake on, where they lie in memory as they are used.
    Baked {
        units: Arc<dyn Baked>,
        first: usize,
        size: RowSize,
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
    /// Those that `row` makes by their numbers.
    ///
    /// # Errors
    /// The first of `row`'s, in order.
    pub(super) fn captured(
        layout: &Layout,
        progress: &dyn Progress,
        row: impl Fn(usize) -> Result<Row, RenderError> + Sync + Send,
    ) -> Result<Self, RenderError> {
        let count = SLABS * layout.st as usize;
        progress.begin("capturing light-field slabs", count as u64);
        let rows = parallel::map_collect(count, |number| {
            let row = row(number);
            progress.advance(1);
            row
        });
        progress.end();
        rows.into_iter().collect::<Result<_, _>>().map(Self::Captured)
    }

    /// Those of a bake, from a unit on; none where it has not so many, or of another size.
    pub(super) fn baked(units: &Arc<dyn Baked>, first: usize, layout: &Layout, levels: &Levels) -> Option<Self> {
        let size = RowSize::new(layout, levels);
        let numbers = first..first + SLABS * layout.st as usize;
        if numbers.end > units.unit_count() || numbers.clone().any(|unit| units.unit(unit).len() != size.bytes()) {
            return None;
        }
        let mut all = numbers.clone().map(|unit| units.unit(unit));
        if cfg!(target_endian = "little") && all.all(|bytes| split(bytes, size).is_some()) {
            return Some(Self::Baked { units: units.clone(), first, size });
        }
        Some(Self::Captured(numbers.map(|unit| Row::from_bytes(units.unit(unit), size)).collect()))
    }

    #[inline(always)] // for the instructions of its caller
    pub(super) fn row(&self, number: usize) -> RowView<'_> {
        match self {
            Self::Captured(rows) => rows[number].view(),
            // It was whole when it was opened.
            Self::Baked { units, first, size } => split(units.unit(first + number), *size).unwrap_or_default(),
        }
    }
}

/// The parts of a baked row; none where they do not lie in memory as numbers must.
#[inline(always)] // for the instructions of its caller
fn split(bytes: &[u8], size: RowSize) -> Option<RowView<'_>> {
    let (texels, parallax) = bytes.split_at_checked(4 * size.texels)?;
    Some(RowView { texels: bytemuck::try_cast_slice(texels).ok()?, parallax: bytemuck::try_cast_slice(parallax).ok()? })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Aabb;
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

    fn row(seed: u32, size: RowSize) -> Row {
        Row {
            texels: (0..size.texels as u32).map(|k| (k + 7 * seed).wrapping_mul(0x9E37_79B9)).collect(),
            parallax: (0..size.parallax as i32).map(|k| (k * 31 - 5000 * seed as i32) as i16).collect(),
        }
    }

    #[test]
    fn baked_rows_are_those_that_were_captured() {
        let layout = Layout::new(Aabb { min: Vec3::ZERO, max: Vec3::ONE }, 3, 5);
        let levels = Levels::new(5);
        let size = RowSize::new(&layout, &levels);
        let rows: Vec<Row> = (0..2 * 18).map(|seed| row(seed, size)).collect();
        // Where numbers may lie, and where they may not.
        for from in [0, 1] {
            let mut bytes = vec![0; from];
            bytes.extend(rows.iter().flat_map(Row::bytes));
            let units: Arc<dyn Baked> = Arc::new(Units { bytes, from, length: size.bytes() });
            let second = Rows::baked(&units, 18, &layout, &levels).unwrap();
            for number in 0..18 {
                let (found, expected) = (second.row(number), &rows[18 + number]);
                assert_eq!((found.texels, found.parallax), (&expected.texels[..], &expected.parallax[..]));
            }
            assert!(Rows::baked(&units, 19, &layout, &levels).is_none(), "one is missing");
            assert!(Rows::baked(&units, 0, &layout, &Levels::new(6)).is_none(), "of another size");
        }
    }
}
