//! Coverage of samples by triangles.

use super::*;
use catoptric_core::math::lanes::LANES;
use catoptric_core::math::random::Stream;
use catoptric_core::tone::Display;
use catoptric_engine::raster::{
    BLOCK, EMPTY, Ids, Keys, LayerSamples, Pattern, PictureSetup, SAMPLE_COUNTS, SetupTriangle, TILE, TilePlace,
    draw_triangles, draw_triangles_portably, set_up,
};

const SIZE: u32 = TILE as u32;

/// The samples of a picture of one tile.
struct TileSamples {
    keys: Vec<Keys>,
    ids: Vec<Ids>,
}

impl TileSamples {
    fn new(samples: u32) -> Self {
        let groups = TILE * TILE * samples as usize / LANES;
        Self { keys: vec![Keys([f32::NEG_INFINITY; LANES]); groups], ids: vec![Ids([EMPTY; LANES]); groups] }
    }

    fn ids(&self) -> &[u32] {
        bytemuck::cast_slice(&self.ids)
    }
}

fn set_up_all(frame: &PictureSetup, list: &DrawList) -> Vec<SetupTriangle> {
    let mut setup = Vec::new();
    for (id, triangle) in list.triangles.iter().enumerate() {
        let corners = triangle.vertices.map(|vertex| &list.vertices[vertex as usize]);
        set_up(frame, corners, [0.0; 3], id as u32, false, |triangle| setup.push(triangle));
    }
    setup
}

const PLACE: TilePlace = TilePlace { pixel: [0, 0], from_center: [-(SIZE as i32) / 2, -(SIZE as i32) / 2] };

fn draw_one_by_one(samples: u32, list: &DrawList, mut each: impl FnMut(&TileSamples)) {
    let pattern = Pattern::new(samples).expect("the count is supported");
    let frame = PictureSetup::new(&view(SIZE, SIZE, true), pattern.clone());
    let setup = set_up_all(&frame, list);
    for index in 0..setup.len() as u32 {
        let mut result = TileSamples::new(samples);
        let mut target = LayerSamples { keys: &mut result.keys, ids: &mut result.ids };
        draw_triangles(&pattern, &PLACE, &setup, &[index], None, &mut target);
        each(&result);
    }
}

/// The number of triangles that cover each sample, each triangle drawn alone.
fn times_covered(samples: u32, list: &DrawList) -> Vec<u32> {
    let mut times = vec![0; (SIZE * SIZE * samples) as usize];
    draw_one_by_one(samples, list, |result| {
        for (count, id) in times.iter_mut().zip(result.ids()) {
            *count += u32::from(*id != EMPTY);
        }
    });
    times
}

#[test]
fn fans_cover_every_sample_exactly_once() {
    let mut random = Stream::new(1);
    for round in 0..60 {
        // Half of the hubs lie exactly on a place where samples may lie.
        let mut place = || {
            let value = random.next_between(2.0, 30.0);
            if round % 2 == 0 { (value * 16.0).round() / 16.0 } else { value }
        };
        let hub = at(place(), place(), 3.0);
        let spokes = 3 + round % 9;
        let rim: Vec<PicturePoint> = (0..spokes)
            .map(|spoke| {
                let angle = (spoke as f32 + random.next_between(0.0, 0.6)) / spokes as f32 * std::f32::consts::TAU;
                // Far enough for a fan of three to hold the whole picture, sometimes beyond the guard band.
                let radius = if spoke % 3 == 2 && spokes > 6 { 30_000.0 } else { 900.0 };
                at(16.0 + angle.cos() * radius, 16.0 + angle.sin() * radius, random.next_between(1.0, 9.0))
            })
            .collect();
        let fan = list((0..spokes).map(|spoke| {
            let (a, b) = (rim[spoke], rim[(spoke + 1) % spokes]);
            if random.next_unit() < 0.5 { [hub, a, b] } else { [b, a, hub] }
        }));
        for samples in SAMPLE_COUNTS {
            let times = times_covered(samples, &fan);
            assert!(times.iter().all(|count| *count == 1), "round {round}, {samples} samples");
        }
    }
}

#[test]
fn grids_cover_every_sample_exactly_once() {
    let mut random = Stream::new(2);
    for round in 0..12 {
        let cells = 1 + round;
        let step = 48.0 / cells as f32;
        let mut points = Vec::new();
        for row in 0..=cells {
            for column in 0..=cells {
                let inner = row % cells != 0 && column % cells != 0;
                let jitter = if inner { random.next_between(-0.2, 0.2) * step } else { 0.0 };
                // Every second grid lies on whole pixels and half pixels.
                let jitter = if round % 2 == 0 { (jitter * 2.0).round() / 2.0 } else { jitter };
                points.push(at(column as f32 * step - 8.0 + jitter, row as f32 * step - 8.0 - jitter, 2.0));
            }
        }
        let quads = (0..cells * cells).flat_map(|cell| {
            let first = cell / cells * (cells + 1) + cell % cells;
            let [a, b, c, d] = [first, first + 1, first + cells + 2, first + cells + 1].map(|i| points[i]);
            if cell % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[b, a, d], [d, c, b]] }
        });
        let grid = list(quads);
        for samples in SAMPLE_COUNTS {
            assert!(times_covered(samples, &grid).iter().all(|count| *count == 1), "round {round}, {samples} samples");
        }
    }
}

#[test]
fn rectangles_cover_their_area() {
    let mut random = Stream::new(3);
    let view = view(45, 39, true);
    for samples in SAMPLE_COUNTS {
        for _ in 0..10 {
            let mut whole = |limit: f32| random.next_between(0.0, limit).floor();
            let (low, size) = (Vec2::new(whole(30.0), whole(30.0)), Vec2::new(whole(14.0), whole(9.0)) + 1.0);
            let drawn = picture(&view, samples, &[list(rectangle(low, low + size, 4.0))], coverage);
            let sum: f32 = drawn.pixels.iter().map(|pixel| pixel[0]).sum();
            assert_eq!(sum, size.x * size.y, "{samples} samples");
            let inside = drawn.pixel(low.x as u32, low.y as u32);
            assert_eq!(inside, [1.0; 4]);
        }
    }
    // Half pixels: two of the four samples lie in each half, whichever is taken.
    let half = list(rectangle(Vec2::new(3.5, 2.0), Vec2::new(8.0, 6.0), 4.0));
    let drawn = picture(&view, 4, &[half], coverage);
    assert_eq!(drawn.pixel(3, 3)[0], 0.5);
    assert_eq!(drawn.pixels.iter().map(|pixel| pixel[0]).sum::<f32>(), 4.5 * 4.0);
}

/// A screen shows white at most: samples are limited to it one by one, or pixels at edges of what is brighter were
/// white as a whole.
#[test]
fn edges_before_a_bright_ground_are_smooth_on_a_screen() {
    let view = view(45, 39, true);
    let sheet = [list([[at(3.2, 2.1, 4.0), at(31.7, 8.9, 4.0), at(12.4, 35.3, 4.0)]])];
    for samples in SAMPLE_COUNTS {
        let covered = picture(&view, samples, &sheet, coverage);
        let bright = picture(&view, samples, &sheet, |fragment| Vec3::splat(100.0) - 100.0 * coverage(fragment));
        let shown = Display::default().of(&bright);
        for (index, (shown, covered)) in shown.pixels.iter().zip(&covered.pixels).enumerate() {
            assert!((shown[0].min(1.0) - (1.0 - covered[0])).abs() < 1e-4, "{samples} samples, pixel {index}");
        }
        let is_edge = |pixel: &&[f32; 4]| pixel[0] > 0.01 && pixel[0] < 0.99;
        assert_eq!(shown.pixels.iter().filter(is_edge).count() > 20, samples > 1, "{samples} samples");
        // Radiance itself is what it was.
        assert!(bright.pixels.iter().zip(&covered.pixels).all(|(a, b)| (a[0] - 100.0 * (1.0 - b[0])).abs() < 1e-3));
    }
}

#[test]
fn a_sample_on_an_edge_belongs_to_the_right_or_lower_triangle() {
    // Edges through pixel centres: top and left edges take their samples, bottom and right ones do not.
    let square = list(rectangle(Vec2::new(1.5, 1.5), Vec2::new(4.5, 4.5), 1.0));
    let drawn = picture(&view(8, 8, true), 1, &[square], coverage);
    for y in 0..8 {
        for x in 0..8 {
            let inside = (1..4).contains(&x) && (1..4).contains(&y);
            assert_eq!(drawn.pixel(x, y)[0], f32::from(inside), "{x}, {y}");
        }
    }
}

/// A random triangle in front of, around or behind the eye.
fn random_triangle(random: &mut Stream) -> [Vec3; 3] {
    let size = 0.3 + 3.0 * random.next_unit();
    let mut vector = || Vec3::from_array(std::array::from_fn(|_| random.next_between(-1.0, 1.0)));
    let center: Vec3 = vector() * Vec3::new(1.5, 1.5, 2.0) - Vec3::Z * 1.5;
    [center + vector() * size, center + vector() * size, center + vector() * size]
}

#[test]
fn visible_triangles_are_those_that_rays_meet() {
    // Vertices are snapped to 1/256 pixel: where rays a little to all sides agree, the sample must agree with them.
    let view = View { width: SIZE, height: SIZE, ..view(SIZE, SIZE, true) };
    let transform = view.picture_from_world();
    let unit = 2.0 * (30.0f64.to_radians()).tan() / SIZE as f64;
    let mut random = Stream::new(4);
    let (mut compared, mut clipped) = (0, 0);
    for round in 0..150 {
        let samples = SAMPLE_COUNTS[round % SAMPLE_COUNTS.len()];
        let triangles: Vec<[Vec3; 3]> = (0..3).map(|_| random_triangle(&mut random)).collect();
        let near = view.near as f64;
        let nearest = |x: f64, y: f64| {
            let half = SIZE as f64 * 0.5;
            let direction = DVec3::new((x - half) * unit, (half - y) * unit, -1.0);
            let hits = triangles.iter().enumerate().filter_map(|(index, corners)| {
                meet(corners, direction).filter(|hit| hit.0 >= near).map(|hit| (hit.0, index as u32))
            });
            hits.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(EMPTY, |hit| hit.1)
        };
        clipped += triangles.iter().filter(|t| t.iter().any(|p| -p.z < view.near)).count();
        let pattern = Pattern::new(samples).unwrap();
        let frame = PictureSetup::new(&view, pattern.clone());
        let setup = set_up_all(&frame, &list(triangles.iter().map(|t| t.map(|p| transform.apply(p)))));
        let indices: Vec<u32> = (0..setup.len() as u32).collect();
        let mut result = TileSamples::new(samples);
        let mut target = LayerSamples { keys: &mut result.keys, ids: &mut result.ids };
        draw_triangles(&pattern, &PLACE, &setup, &indices, None, &mut target);
        for (index, id) in result.ids().iter().enumerate() {
            let (pixel, sample) = (index / samples as usize, index % samples as usize);
            let (block, pixel) = (pixel / (BLOCK * BLOCK), pixel % (BLOCK * BLOCK));
            let column = block % (TILE / BLOCK) * BLOCK + pixel % BLOCK;
            let row = block / (TILE / BLOCK) * BLOCK + pixel / BLOCK;
            let position = pattern.positions[sample] + Vec2::new(column as f32, row as f32);
            let expected = nearest(position.x as f64, position.y as f64);
            let reach = 1.0 / 200.0;
            let agree =
                [(1.0, 0.0), (0.7, 0.7), (0.0, 1.0), (-0.7, 0.7), (-1.0, 0.0), (-0.7, -0.7), (0.0, -1.0), (0.7, -0.7)]
                    .iter()
                    .all(|(x, y)| nearest(position.x as f64 + x * reach, position.y as f64 + y * reach) == expected);
            if agree {
                compared += 1;
                assert_eq!(*id, expected, "round {round}, {samples} samples, at {position}: {triangles:?}");
            }
        }
    }
    assert!(compared > 800_000, "{compared}");
    assert!(clipped > 100, "{clipped} triangles cross the near plane");
}

#[test]
fn instruction_sets_agree_bit_for_bit() {
    let view = view(SIZE, SIZE, true);
    let transform = view.picture_from_world();
    let mut random = Stream::new(5);
    for samples in SAMPLE_COUNTS {
        let pattern = Pattern::new(samples).unwrap();
        let frame = PictureSetup::new(&view, pattern.clone());
        let triangles: Vec<_> = (0..200).map(|_| random_triangle(&mut random).map(|p| transform.apply(p))).collect();
        let setup = set_up_all(&frame, &list(triangles));
        let indices: Vec<u32> = (0..setup.len() as u32).collect();
        let (mut fast, mut portable) = (TileSamples::new(samples), TileSamples::new(samples));
        let mut target = LayerSamples { keys: &mut fast.keys, ids: &mut fast.ids };
        draw_triangles(&pattern, &PLACE, &setup, &indices, None, &mut target);
        let mut target = LayerSamples { keys: &mut portable.keys, ids: &mut portable.ids };
        draw_triangles_portably(&pattern, &PLACE, &setup, &indices, None, &mut target);
        assert!(fast.ids() == portable.ids());
        let bits = |keys: &[Keys]| -> Vec<u32> { keys.iter().flat_map(|k| k.0.map(f32::to_bits)).collect() };
        assert!(bits(&fast.keys) == bits(&portable.keys));
    }
}

#[test]
fn the_first_drawn_wins_at_equal_depth() {
    let [[a, b, c], _] = rectangle(Vec2::ZERO, Vec2::splat(8.0), 2.0);
    let same = list([[a, b, c], [b, c, a], [c, b, a]]);
    let drawn = picture(&view(8, 8, true), 4, &[same.clone(), same], |fragment| {
        let Some(surface) = fragment.chain.first() else { return Vec3::ZERO };
        assert_eq!((surface.list, surface.source), (0, 0));
        Vec3::ONE
    });
    assert_eq!(drawn.pixel(6, 1)[0], 1.0);
}
