//! Texels of views in every form.

use catoptric_core::math::random::Stream;
use catoptric_lookup::light_field::Compression;
use catoptric_lookup::parts::{RowView, ViewForm, ViewRow, packed};
use glam::Vec3;

/// Texels that are read one by one are those that are decompressed at once.
#[test]
fn four_texels_are_those_of_the_view() {
    let mut random = Stream::new(11);
    for (compression, side) in
        [(Compression::None, 9), (Compression::Bc1, 9), (Compression::Bc6h, 8), (Compression::Bc7, 13)]
    {
        let form = ViewForm::new(side, compression);
        let mut row = ViewRow::default();
        for _ in 0..3 {
            let light = |_| packed(Vec3::from([0; 3].map(|_| random.next_unit())));
            row.texels.extend((0..side * side).map(light));
            form.levels.append(&mut row.texels);
            row.parallax.extend((0..side * side).map(|k| (k * 577) as i16));
        }
        let bytes = row.baked(&form);
        assert_eq!(bytes.len(), 3 * form.bytes_a_view());
        let (blocks, depths) = bytes.split_at(3 * form.light_bytes());
        let kept = match compression {
            Compression::None => RowView { texels: &row.texels, parallax: &row.parallax, ..RowView::default() },
            _ => RowView { blocks, depths, ..RowView::default() },
        };
        let (texels, parallaxes) = (form.texels(&kept), form.parallaxes(&kept));
        assert_eq!((texels.len(), parallaxes.len()), (row.texels.len(), row.parallax.len()));
        for (level, &(first, side)) in form.levels.levels.iter().enumerate() {
            for (x, y) in (0..side.max(2) - 1).flat_map(|y| (0..side.max(2) - 1).map(move |x| (x, y))) {
                let at = |x: u32, y: u32| texels[(2 * form.levels.count + first + y * side + x) as usize];
                let next = u32::from(side > 1);
                let expected = [at(x, y), at(x + next, y), at(x, y + next), at(x + next, y + next)];
                assert_eq!(form.four(&kept, 2, level, [x, y]), expected, "{compression:?} {level} {x} {y}");
            }
        }
        for pixel in 0..side * side {
            let expected = parallaxes[(side * side + pixel) as usize];
            assert_eq!(form.parallax(&kept, 1, pixel % side, pixel / side), expected);
        }
        assert_eq!(form.four(&RowView::default(), 0, 0, [0, 0]), [0; 4]);
    }
}
