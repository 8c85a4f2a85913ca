//! Radiance along rays that slabs hold.

mod blocks;
mod depth_blocks;
mod form;
mod rows;
mod texels;

use catoptric_core::math::Aabb;
use catoptric_core::math::random::Stream;
use catoptric_core::progress::Silent;
use catoptric_engine::method::bake::Baked;
use catoptric_lookup::light_field::{Compression, Disparity, LightFieldSettings, Slabs};
use catoptric_lookup::parts::{
    FieldLayout, Rows, SLABS, SlabLayout, ViewForm, ViewLevels, ViewRow, across, packed, stored, unpacked,
};
use glam::{Vec2, Vec3};
use std::sync::Arc;

const ST: u32 = 4;
const UV: u32 = 9;

struct Units(Vec<Vec<u8>>);

impl Baked for Units {
    fn unit_count(&self) -> usize {
        self.0.len()
    }

    fn unit(&self, number: usize) -> &[u8] {
        self.0.get(number).map(Vec::as_slice).unwrap_or_default()
    }
}

fn layout() -> SlabLayout {
    SlabLayout::new(Aabb { min: Vec3::new(-1.0, 0.5, -0.2), max: Vec3::new(0.5, 1.0, 2.0) }, ST, UV)
}

fn fields() -> FieldLayout {
    FieldLayout::Slabs(layout())
}

fn settings(disparity: Disparity) -> LightFieldSettings {
    LightFieldSettings { st: ST, uv: UV, disparity, ..LightFieldSettings::default() }
}

fn vector(random: &mut Stream) -> Vec3 {
    Vec3::from([0; 3].map(|_| random.next_between(-1.0, 1.0)))
}

/// Rows that are at hand, not compressed.
fn plain(rows: &[ViewRow]) -> Rows {
    let form = ViewForm::new(UV, Compression::None);
    Rows::captured(&fields(), &form, &Silent, |number| Ok(rows[number].clone())).unwrap()
}

/// Rows of random light, and of parallaxes that differ little.
fn rows(random: &mut Stream) -> Vec<ViewRow> {
    let row = |_| {
        let mut row = ViewRow::default();
        for _ in 0..ST {
            row.texels.extend((0..UV * UV).map(|_| packed(vector(random).abs())));
            ViewLevels::new(UV).append(&mut row.texels);
            row.parallax.extend((0..UV * UV).map(|_| stored(random.next_between(0.2, 0.4))));
        }
        row
    };
    (0..SLABS as u32 * ST).map(row).collect()
}

/// Rays from points of the region, and some that nothing holds.
fn rays(random: &mut Stream) -> (Vec<Vec3>, Vec<Vec3>) {
    let region = layout().region;
    let place = |random: &mut Stream| region.center() + region.size() * 0.5 * vector(random);
    let mut rays: Vec<(Vec3, Vec3)> = (0..500).map(|_| (place(random), vector(random).normalize())).collect();
    for k in (0..500).step_by(7) {
        rays[k] = match k % 4 {
            0 => (Vec3::splat(50.0), rays[k].1),
            1 => (Vec3::new(0.0, f32::NAN, 0.0), rays[k].1),
            2 => (rays[k].0, Vec3::new(f32::NAN, 1.0, f32::INFINITY)),
            _ => (rays[k].0, Vec3::ZERO),
        };
    }
    rays.into_iter().unzip()
}

#[test]
fn many_rays_see_what_each_sees() {
    let mut random = Stream::new(21);
    let (rows, (points, directions)) = (rows(&mut random), rays(&mut random));
    let form = ViewForm::new(UV, Compression::None);
    let units: Arc<dyn Baked> = Arc::new(Units(rows.iter().map(|row| row.baked(&form)).collect()));
    for disparity in [Disparity::None, Disparity::Plane, Disparity::Depth] {
        let baked = Rows::baked(&units, 0, &fields(), &form).unwrap();
        for rows in [plain(&rows), baked] {
            let slabs = Slabs::new(&settings(disparity), fields(), rows);
            let one = |k: usize| {
                let sharp = [Vec3::ZERO; 2];
                slabs.radiance(points[k], directions[k], sharp, sharp)
            };
            for count in [0, 1, 8, 31, 32, 33, 500] {
                let mut found = vec![Vec3::NAN; count];
                slabs.radiance_batch(&points, &directions, &mut found);
                for (k, found) in found.into_iter().enumerate() {
                    let expected = one(k).unwrap_or_default();
                    assert!(found.distance(expected) < 1e-5, "{disparity:?}, ray {k}: {found}, {expected}");
                    assert_eq!(one(k).is_some(), k % 7 != 0);
                }
            }
        }
    }
}

/// The blend of the paper, written down as it is.
#[test]
fn views_are_blended_linearly_along_four_axes() {
    let mut random = Stream::new(22);
    let rows = rows(&mut random);
    let (region, count) = (layout().region, ViewLevels::new(UV).count);
    let slabs = Slabs::new(&settings(Disparity::Plane), fields(), plain(&rows));
    let (layout, planes) = (layout(), slabs.tables().expect("they are slabs").planes());
    for _ in 0..500 {
        let (point, direction) = (region.center() + region.size() * 0.5 * vector(&mut random), vector(&mut random));
        let axis = direction.abs().max_position();
        let number = 2 * axis + usize::from(direction[axis] < 0.0);
        let (slab, focal) = (&layout.slabs[number], planes[number].focal);
        let slope = across(axis, direction / direction[axis].abs());
        let face = if slab.sign > 0.0 { region.max } else { region.min };
        let on_plane = across(axis, point) + slope * (face - point)[axis].abs();
        let st = (on_plane - across(axis, slab.eye(0, 0))) / slab.spacing;
        let mut sum = Vec3::ZERO;
        for (s, t) in (0..ST).flat_map(|t| (0..ST).map(move |s| (s, t))) {
            let off = st - Vec2::new(s as f32, t as f32);
            let share = (1.0 - off.abs()).max(Vec2::ZERO);
            let there = slope + off * slab.spacing / slab.spacing.max_element() * focal;
            let uv = (there + 1.0625) / (2.0 * 1.0625) * (UV - 1) as f32;
            let uv = uv.clamp(Vec2::ZERO, Vec2::splat((UV - 1) as f32));
            for (u, v) in (0..UV).flat_map(|v| (0..UV).map(move |u| (u, v))) {
                let weight = (1.0 - (uv - Vec2::new(u as f32, v as f32)).abs()).max(Vec2::ZERO);
                let texel = rows[number * ST as usize + t as usize].texels[(s * count + v * UV + u) as usize];
                sum += unpacked(texel) * (share.x * share.y * weight.x * weight.y);
            }
        }
        let sharp = [Vec3::ZERO; 2];
        let found = slabs.radiance(point, direction, sharp, sharp).unwrap();
        assert!(found.distance(sum) < 1e-4, "{point} {direction}: {found}, {sum}");
        let uv = (slope + 1.0625) / (2.0 * 1.0625) * (UV - 1) as f32;
        let found = slabs.coordinates(point, direction).unwrap();
        assert_eq!(found.slab as usize, number);
        assert!(found.view.distance(st) < 1e-4 && found.pixel.distance(uv) < 1e-4, "{found:?}");
    }
}
