//! Rows of views, captured and baked.

use catoptric_core::math::Aabb;
use catoptric_core::progress::Silent;
use catoptric_engine::method::bake::Baked;
use catoptric_lookup::light_field::{Compression, Layout, LightFieldSettings};
use catoptric_lookup::parts::{FieldLayout, Rows, ViewForm, ViewRow};
use glam::Vec3;
use std::sync::Arc;

/// Bytes from an odd or an even place on.
struct Units {
    bytes: Vec<u8>,
    /// The start of each unit, and the end of the last.
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
            let captured = Rows::captured(&fields, &form, &Silent, |number| Ok(rows[count + number].clone())).unwrap();
            // The first start is aligned for numbers, the second is not.
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
