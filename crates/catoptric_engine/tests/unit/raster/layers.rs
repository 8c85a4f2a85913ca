//! Layers, stencils, chains and alpha tests.

use super::*;
use catoptric_core::progress::Silent;
use catoptric_engine::error::RenderError;
use catoptric_engine::raster::{BlockMask, Branch, LayerSurface, SAMPLE_COUNTS, Stencil};

/// A full picture at a depth, in a layer, with a group.
fn full(depth: f32, layer: u32, group: u32, stencil: Option<Stencil>) -> DrawList {
    let mut list = list(rectangle(Vec2::splat(-3.0), Vec2::splat(99.0), depth));
    list.triangles.iter_mut().for_each(|triangle| triangle.group = group);
    DrawList { layer, stencil, ..list }
}

fn stencil(list: u32, group: u32) -> Option<Stencil> {
    Some(Stencil { list, group, ..Stencil::default() })
}

#[test]
fn layers_show_only_in_their_groups_recursively() {
    // Layer 0: a left mirror (group 1), a right mirror (group 2) and a wall (group 0) below both.
    let mut first = list(
        rectangle(Vec2::ZERO, Vec2::new(20.0, 30.0), 2.0)
            .into_iter()
            .chain(rectangle(Vec2::new(20.0, 0.0), Vec2::new(40.0, 30.0), 2.0))
            .chain(rectangle(Vec2::new(0.0, 30.0), Vec2::new(40.0, 40.0), 2.0)),
    );
    for (index, triangle) in first.triangles.iter_mut().enumerate() {
        triangle.group = [1, 2, 0][index / 2];
    }
    // Layer 1: in the left mirror another mirror (group 5) over the columns 5 to 35; in the right one a wall over the
    // rows 0 to 10, nearer than anything in layer 0, which must not matter.
    let mut left = list(rectangle(Vec2::new(5.0, 0.0), Vec2::new(35.0, 40.0), 9.0));
    left.triangles.iter_mut().for_each(|triangle| triangle.group = 5);
    let left = DrawList { layer: 1, stencil: stencil(0, 1), ..left };
    let right = list(rectangle(Vec2::ZERO, Vec2::new(40.0, 10.0), 1.0));
    let right = DrawList { layer: 1, stencil: stencil(0, 2), ..right };
    // Layer 2: something everywhere in the mirror of the left mirror.
    let deep = full(3.0, 2, 0, stencil(1, 5));
    // Lists of a layer may stand anywhere in the call.
    let lists = [first, left, deep, right];
    for samples in SAMPLE_COUNTS {
        let drawn = picture(&view(40, 40, true), samples, &lists, |fragment| {
            let chain: Vec<u32> = fragment.chain.iter().map(|surface| surface.list).collect();
            let (x, y) = (fragment.position.x, fragment.position.y);
            let expected: &[u32] = match () {
                () if y > 30.0 => &[0],
                () if x > 5.0 && x < 20.0 => &[0, 1, 2],
                () if x < 20.0 => &[0],
                () if y < 10.0 => &[0, 3],
                () => &[0],
            };
            assert_eq!(chain, expected, "{x}, {y}");
            Vec3::ONE
        });
        assert!(drawn.pixels.iter().all(|pixel| *pixel == [1.0; 4]));
    }
}

#[test]
fn chains_of_many_layers_are_whole() {
    let lists: Vec<DrawList> =
        (0..17).map(|layer: u32| full(2.0, layer, layer, layer.checked_sub(1).and_then(|l| stencil(l, l)))).collect();
    let drawn = picture(&view(33, 5, false), 2, &lists, |fragment| {
        assert!(fragment.chain.iter().enumerate().all(|(index, surface)| surface.list == index as u32));
        Vec3::splat(fragment.chain.len() as f32)
    });
    assert!(drawn.pixels.iter().all(|pixel| pixel[0] == 17.0));
}

#[test]
fn surfaces_of_a_layer_compete_by_depth() {
    let mirror = full(2.0, 0, 1, None);
    let far = full(8.0, 1, 0, stencil(0, 1));
    let near = DrawList { vertices: full(4.0, 1, 0, None).vertices, ..far.clone() };
    let drawn = picture(&view(9, 9, true), 4, &[mirror, far, near], |fragment| {
        assert_eq!(fragment.chain.len(), 2);
        Vec3::splat(fragment.chain[1].list as f32)
    });
    assert!(drawn.pixels.iter().all(|pixel| pixel[0] == 2.0));
}

#[test]
fn every_chain_of_a_pixel_is_shaded_once() {
    // One pixel, sixteen samples: a mirror on its right half, in it something on the upper half.
    let mut mirror = list(rectangle(Vec2::new(0.5, 0.0), Vec2::new(1.0, 1.0), 2.0));
    mirror.triangles.iter_mut().for_each(|triangle| triangle.group = 3);
    let seen = list(rectangle(Vec2::ZERO, Vec2::new(1.0, 0.5), 2.0));
    let seen = DrawList { layer: 1, stencil: stencil(0, 3), ..seen };
    let mut target = Framebuffer::new(1, 1);
    let shader = Paint(|fragment: &Fragment<'_>| match fragment.chain.len() {
        0 => Vec3::X,
        1 => Vec3::Y,
        _ => Vec3::Z,
    });
    let report = draw(&view(1, 1, true), 16, &[mirror, seen], &shader, &mut target, &Silent).unwrap();
    let [none, mirror, both, alpha] = target.pixel(0, 0);
    // The rectangles' diagonals split a chain into two triangles' parts.
    assert!(report.fragments <= 1 + 2 + 4, "{}", report.fragments);
    assert_eq!((none, mirror + both, alpha), (0.5, 0.5, 1.0));
    assert!(both > 0.15 && mirror > 0.15);
}

/// No surface left of column 20.25.
struct CutLeft;

impl FragmentShader for CutLeft {
    fn shade(&self, fragment: &Fragment<'_>) -> Vec3 {
        fragment.chain.first().map_or(Vec3::ZERO, |surface| if surface.source < 2 { Vec3::X } else { Vec3::Y })
    }

    fn is_present(&self, surface: &LayerSurface, position: Vec2) -> bool {
        assert_eq!(surface.list, 0);
        // The shader receives the same place twice.
        let expected = position / 64.0;
        let at = surface.barycentrics.value;
        let place = if surface.source == 0 { Vec2::new(at.x + at.y, at.y) } else { Vec2::new(at.x, at.x + at.y) };
        assert!((place - expected).length() < 1e-3, "{place} against {expected}");
        position.x >= 20.25
    }
}

#[test]
fn alpha_tests_cut_holes_before_depth_is_written() {
    let mut near = list(rectangle(Vec2::ZERO, Vec2::splat(64.0), 2.0));
    near.triangles.iter_mut().for_each(|triangle| triangle.alpha_tested = true);
    for (source, triangle) in list(rectangle(Vec2::ZERO, Vec2::splat(64.0), 5.0)).triangles.iter().enumerate() {
        let vertices = triangle.vertices.map(|vertex| vertex + 6);
        near.triangles.push(DrawTriangle { vertices, source: source as u32 + 2, ..*triangle });
    }
    near.vertices.extend(list(rectangle(Vec2::ZERO, Vec2::splat(64.0), 5.0)).vertices);
    for samples in SAMPLE_COUNTS {
        let mut target = Framebuffer::new(64, 64);
        draw(&view(64, 64, true), samples, &[near.clone()], &CutLeft, &mut target, &Silent).unwrap();
        for y in 0..64 {
            assert_eq!(target.pixel(19, y), [0.0, 1.0, 0.0, 1.0]);
            assert_eq!(target.pixel(21, y), [1.0, 0.0, 0.0, 1.0]);
            let [cut, behind, ..] = target.pixel(20, y);
            assert_eq!(cut + behind, 1.0);
            if samples == 16 {
                assert_eq!(cut, 0.75, "samples are asked one by one");
            }
        }
    }
}

#[test]
fn stencils_must_name_a_list_of_the_layer_below() {
    let base = full(2.0, 0, 1, None);
    let cases = [
        vec![full(2.0, 0, 0, stencil(0, 1))],
        vec![full(2.0, 1, 0, None)],
        vec![base.clone(), full(2.0, 1, 0, stencil(1, 0))],
        vec![base.clone(), full(2.0, 2, 0, stencil(0, 1))],
        vec![base.clone(), full(2.0, 1, 0, stencil(7, 1))],
        vec![base, full(2.0, 64, 0, stencil(0, 1))],
    ];
    for lists in cases {
        let mut target = Framebuffer::new(4, 4);
        let result = draw(&view(4, 4, true), 1, &lists, &Paint(coverage), &mut target, &Silent);
        assert!(matches!(result, Err(RenderError::Limit { .. })));
    }
}

/// A fragment's groups as the digits of a number, weighted by its branches; a one to be counted; its branches.
fn chains_by_branch(fragment: &Fragment<'_>) -> Vec3 {
    let digits = fragment.chain.iter().fold(0, |sum, surface| sum * 10 + surface.group);
    let place = fragment.second_branches as i32;
    Vec3::new(digits as f32 * 1e-3 * 2f32.powi(-2 * place), 1.0, place as f32)
}

#[test]
fn both_branches_of_divided_surfaces_are_drawn_and_added() {
    // Glass over the left half, a wall over the right half.
    let mut first = list(rectangle(Vec2::ZERO, Vec2::new(40.0, 80.0), 2.0).into_iter().chain(rectangle(
        Vec2::new(40.0, 0.0),
        Vec2::new(80.0, 80.0),
        2.0,
    )));
    for (index, triangle) in first.triangles.iter_mut().enumerate() {
        triangle.group = [1, 0][index / 2];
    }
    let over = |low: f32, group: u32, layer: u32, list_below: u32, group_below: u32, branch: Branch| {
        let mut list = list(rectangle(Vec2::new(0.0, low), Vec2::new(80.0, 80.0), 3.0));
        list.triangles.iter_mut().for_each(|triangle| triangle.group = group);
        DrawList { layer, stencil: Some(Stencil { list: list_below, group: group_below, branch }), ..list }
    };
    let lists = [
        first,
        // Reflected: a wall below row 50. Refracted: glass below row 20.
        over(50.0, 2, 1, 0, 1, Branch::First),
        over(20.0, 3, 1, 0, 1, Branch::Second),
        // Within that glass: reflected a wall below row 60, refracted nothing at all.
        over(60.0, 4, 2, 2, 3, Branch::First),
        DrawList {
            layer: 2,
            stencil: Some(Stencil { list: 2, group: 3, branch: Branch::Second }),
            ..DrawList::default()
        },
    ];
    for samples in SAMPLE_COUNTS {
        let drawn = picture(&view(80, 80, true), samples, &lists, chains_by_branch);
        for (column, row) in [(10, 10), (10, 40), (10, 55), (10, 70), (60, 70)] {
            // Digits by branches: first only, second at layer 0, and at layers 0 and 1.
            let expected: &[(u32, i32)] = match (column, row) {
                (60, _) => &[(0, 0)],
                (_, 10) => &[(1, 0), (1, 1)],
                (_, 40) => &[(1, 0), (13, 1), (13, 3)],
                (_, 55) => &[(12, 0), (13, 1), (13, 3)],
                _ => &[(12, 0), (134, 1), (13, 3)],
            };
            let sum: f32 = expected.iter().map(|(digits, place)| *digits as f32 * 1e-3 * 2f32.powi(-2 * place)).sum();
            let places: i32 = expected.iter().map(|(_, place)| place).sum();
            let [digits, count, place, alpha] = drawn.pixel(column, row);
            assert!((digits - sum).abs() < 1e-6, "{samples} samples at {column}, {row}: {digits} against {sum}");
            assert_eq!((count, place, alpha), (expected.len() as f32, places as f32, 1.0), "{column}, {row}");
        }
    }
}

#[test]
fn lists_are_not_drawn_in_their_holes() {
    let mut holes = BlockMask::new([40, 40]);
    assert!(holes.is_empty() && holes.count() == 0);
    // The blocks in rows 1 and 2, columns 2 and 3, and those in the right half of the last row.
    holes.add_box(Vec2::new(16.0, 15.9), Vec2::new(31.9, 23.0));
    holes.add_box(Vec2::new(25.0, 39.0), Vec2::splat(f32::INFINITY));
    // Beside the picture, and nowhere.
    holes.add_box(Vec2::splat(-9.0), Vec2::splat(-1.0));
    holes.add_box(Vec2::splat(41.0), Vec2::splat(60.0));
    holes.add_box(Vec2::splat(9.0), Vec2::splat(5.0));
    let is_hole = |x: usize, y: usize| (2..4).contains(&x) && (1..3).contains(&y) || x >= 3 && y == 4;
    assert_eq!(holes.count(), 6);
    let mut rest = holes.clone();
    rest.invert();
    for (x, y) in (0..5).flat_map(|y| (0..5).map(move |x| (x, y))) {
        assert_eq!((holes.has(x, y), rest.has(x, y)), (is_hole(x, y), !is_hole(x, y)), "{x}, {y}");
    }
    assert!(!rest.has(5, 0) && !rest.has(0, 5) && rest.count() == 19);
    let below = full(2.0, 0, 1, None);
    for tested in [false, true] {
        let mut above = DrawList { holes: holes.clone(), ..full(3.0, 1, 0, stencil(0, 1)) };
        above.triangles.iter_mut().for_each(|triangle| triangle.alpha_tested = tested);
        // Lists with one stencil have holes of their own each.
        let other = DrawList { holes: rest.clone(), ..full(4.0, 1, 0, stencil(0, 1)) };
        picture(&view(40, 40, true), 4, &[below.clone(), above, other], |fragment| {
            let [x, y] = [fragment.position.x, fragment.position.y].map(|px| px as usize / 8);
            let chain: Vec<u32> = fragment.chain.iter().map(|surface| surface.list).collect();
            assert_eq!(chain, [0, if is_hole(x, y) { 2 } else { 1 }], "{x}, {y}");
            Vec3::ONE
        });
    }
}
