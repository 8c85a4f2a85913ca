//! Edge functions, beams and coverage against rays that are followed one by one.

use catoptric_core::math::Aabb;
use catoptric_core::math::lanes::LANES;
use catoptric_core::math::random::Stream;
use catoptric_core::scene::Ray;
use catoptric_engine::light::wide_hierarchy::TriangleBlock;
use catoptric_projection::parts::{
    Beam, BundleFit, CandidateList, DrawnTriangle, EdgeFunctions, NOTHING, PixelLines, Quadratic, ROOT, RayBundle,
    RayModel, TERMS, TileArea, TileRay, TileSamples, value_at,
};
use glam::{Vec2, Vec3};

const SIZE: usize = 8;

/// The ray that leaves a mirror ball, or a flat mirror, where a place of the picture shows it.
fn reflected(is_flat: bool, at: Vec2) -> TileRay {
    let towards = Vec3::new((at.x - 40.0) * 0.002, (at.y - 40.0) * 0.002, -1.0);
    let length = towards.length();
    let direction = towards / length;
    let eye = Vec3::new(0.1, 0.2, 3.0);
    let (distance, normal) = if is_flat {
        let normal = Vec3::new(0.3, 0.2, 1.0).normalize();
        (-eye.dot(normal) / direction.dot(normal), normal)
    } else {
        let (along, rest) = (eye.dot(direction), eye.length_squared() - 1.0);
        let distance = -along - (along * along - rest).sqrt();
        (distance, eye + direction * distance)
    };
    let direction = direction - normal * (2.0 * direction.dot(normal));
    let ray = Ray { origin: eye + towards * (distance / length), direction };
    TileRay { at, ray, length }
}

/// The bundle of a tile of 8 x 8 pixels.
fn bundle(is_flat: bool, fit: &mut BundleFit) -> (RayBundle, Vec2) {
    let first = Vec2::splat(32.0);
    let places = (0..SIZE * SIZE).map(|i| first + Vec2::new((i % SIZE) as f32, (i / SIZE) as f32) + 0.5);
    let rays: Vec<TileRay> = places.map(|at| reflected(is_flat, at)).collect();
    let half = 0.5 * SIZE as f32;
    (RayBundle::fit(&rays, first + half, half, fit).expect("the rays are near each other"), first)
}

/// Triangles around points that rays of the tile come by.
fn triangles(is_flat: bool, count: usize, size: f32) -> Vec<TriangleBlock> {
    let mut random = Stream::new(11);
    let mut corners = || {
        let at = Vec2::new(random.next_between(28.0, 44.0), random.next_between(28.0, 44.0));
        let TileRay { ray, .. } = reflected(is_flat, at);
        let middle = ray.origin + ray.direction * random.next_between(0.5, 6.0);
        let mut corner = || middle + size * Vec3::from_array([0, 1, 2].map(|_| random.next_between(-1.0, 1.0)));
        [corner(), corner(), corner()]
    };
    let mut blocks = vec![TriangleBlock::EMPTY; count / LANES];
    for (index, block) in blocks.iter_mut().enumerate() {
        for lane in 0..LANES {
            block.set(lane, corners(), (index * LANES + lane) as u32);
        }
    }
    blocks
}

fn corners(block: &TriangleBlock, lane: usize) -> [Vec3; 3] {
    [0, 3, 6].map(|corner| Vec3::from_array([0, 1, 2].map(|axis| block.corners[corner + axis][lane])))
}

/// Weights of the corners and the distance (in lengths of the direction) at which a line meets a triangle's plane.
fn meets(ray: &Ray, [a, b, c]: [Vec3; 3]) -> ([f64; 3], f64) {
    let [a, b, c, o, d] = [a, b, c, ray.origin, ray.direction].map(|vector| vector.as_dvec3());
    let normal = (b - a).cross(c - a);
    let distance = (a - o).dot(normal) / d.dot(normal);
    let at = o + d * distance;
    let weight = |p: glam::DVec3, q: glam::DVec3| (p - at).cross(q - at).dot(normal) / normal.length_squared();
    ([weight(b, c), weight(c, a), weight(a, b)], distance)
}

#[test]
fn edge_functions_are_weights_and_depths_of_rays_in_a_flat_mirror() {
    let mut fit = BundleFit::default();
    let (bundle, first) = bundle(true, &mut fit);
    assert!(bundle.error_px(&fit, [0.1, 10.0]) < 2e-3, "{}", bundle.error_px(&fit, [0.1, 10.0]));
    let mut checked = 0;
    for block in triangles(true, 200, 0.7) {
        let functions = EdgeFunctions::new(&bundle, None, &block);
        for lane in 0..LANES {
            for place in [Vec2::new(1.3, 6.2), Vec2::new(0.0, 0.0), Vec2::new(7.9, 3.1)] {
                let at = first + place;
                let TileRay { ray, .. } = reflected(true, at);
                let (weights, distance) = meets(&ray, corners(&block, lane));
                let uv = (at - bundle.center) * bundle.scale;
                let [a, b, c, plane] =
                    functions.of_lane::<Quadratic>(lane, 1.0).map(|function| value_at(&function, uv.x, uv.y));
                let sum = a + b + c;
                let grazes = weights.iter().any(|weight| weight.abs() > 20.0) || distance.abs() > 50.0;
                if grazes {
                    continue;
                }
                let depth = (ray.origin + ray.direction * distance as f32 - bundle.origin).dot(bundle.axes[2]);
                assert!((plane / sum - depth).abs() < 2e-3 * depth.abs().max(1.0), "{} {depth}", plane / sum);
                for (function, weight) in [a, b, c].iter().zip(weights) {
                    assert!((f64::from(function / sum) - weight).abs() < 2e-3 * weight.abs().max(1.0));
                }
                checked += 1;
            }
        }
    }
    assert!(checked > 300, "{checked}");
}

#[test]
fn neighbours_share_the_function_of_their_edge_to_the_bit() {
    let mut random = Stream::new(5);
    let mut fit = BundleFit::default();
    let (bundle, _) = bundle(false, &mut fit);
    for _ in 0..500 {
        let mut point = || Vec3::from_array([0, 1, 2].map(|_| random.next_between(-4.0, 4.0)));
        let [a, b, c, d] = [point(), point(), point(), point()];
        let mut block = TriangleBlock::EMPTY;
        block.set(0, [a, b, c], 0);
        block.set(1, [c, b, d], 1);
        let functions = EdgeFunctions::new(&bundle, None, &block);
        // Opposite to a in the first: from b to c; opposite to d in the second: from c to b.
        let of = |edge: usize, lane: usize| -> [f32; TERMS] {
            std::array::from_fn(|term| functions.quadratics[edge][term][lane])
        };
        assert_eq!(of(0, 0), of(2, 1).map(|coefficient| -coefficient));
    }
}

#[test]
fn beams_hold_all_triangles_that_rays_of_their_tile_meet() {
    for is_flat in [true, false] {
        let mut fit = BundleFit::default();
        let (bundle, first) = bundle(is_flat, &mut fit);
        let bounds = Aabb { min: Vec3::splat(-12.0), max: Vec3::splat(12.0) };
        let beam = Beam::new(&bundle, &fit, &bounds);
        for size in [0.02, 0.3, 4.0] {
            let parent = CandidateList::of(&triangles(is_flat, 400, size));
            let mut list = CandidateList::default();
            list.filter(&parent, &beam);
            let kept: Vec<u32> = list.blocks.iter().flat_map(|block| block.triangles).collect();
            assert!(list.count() < parent.count(), "nothing was left out");
            let mut met = 0;
            for block in &parent.blocks {
                for lane in 0..LANES {
                    let corners = corners(block, lane);
                    // Rays through samples anywhere in the pixels.
                    let is_met = (0..40 * 40).any(|i| {
                        let at = first + Vec2::new((i % 40) as f32, (i / 40) as f32) * (SIZE as f32 / 39.0);
                        let (weights, distance) = meets(&reflected(is_flat, at).ray, corners);
                        distance > 0.0 && weights.iter().all(|weight| *weight >= 0.0)
                    });
                    met += u32::from(is_met);
                    assert!(!is_met || kept.contains(&block.triangles[lane]), "{is_flat} {size} {corners:?}");
                }
            }
            assert!(met > 20, "{met} of size {size}");
        }
    }
}

#[test]
fn every_sample_of_a_divided_square_is_covered_and_depths_decide() {
    for is_flat in [true, false] {
        let mut fit = BundleFit::default();
        let (bundle, first) = bundle(is_flat, &mut fit);
        // A fan that holds the tile's rays at two distances; the nearer one has the smaller numbers.
        let mut block = TriangleBlock::EMPTY;
        for (layer, distance) in [2.0, 3.0].into_iter().enumerate() {
            let point = |x: f32, y: f32| {
                let TileRay { ray, .. } = reflected(is_flat, first + Vec2::new(x, y));
                ray.origin + ray.direction * distance
            };
            let hub = point(3.7, 4.1);
            let rim = [point(-40.0, -40.0), point(60.0, -40.0), point(60.0, 60.0), point(-40.0, 60.0)];
            for side in 0..4 {
                block.set(layer * 4 + side, [hub, rim[side], rim[(side + 1) % 4]], 0);
            }
        }
        let functions = EdgeFunctions::new(&bundle, None, &block);
        assert_covered(&functions, &Quadratic::new(&bundle, SIZE));
        assert_covered(&functions, &lines(is_flat, &bundle, first));
    }
}

/// The lines of the pixels of a tile.
fn lines(is_flat: bool, bundle: &RayBundle, first: Vec2) -> PixelLines {
    let own = |column: f32, row: f32| {
        let TileRay { ray, length, .. } = reflected(is_flat, first + Vec2::new(column, row) + 0.5);
        bundle.coordinates(&ray, length)
    };
    let mut lines = PixelLines::default();
    for pixel in 0..SIZE * SIZE {
        let [column, row] = [pixel % SIZE, pixel / SIZE];
        lines.set([column, row], &own(column as f32, row as f32));
    }
    lines.difference_all(SIZE);
    for at in 0..SIZE {
        for end in [0, SIZE - 1] {
            let beside =
                |x: f32, y: f32| [Some(own(end as f32 - x, at as f32 - y)), Some(own(end as f32 + x, at as f32 + y))];
            lines.set_change([end, at], 0, &beside(1.0, 0.0));
            let beside =
                |x: f32, y: f32| [Some(own(at as f32 - x, end as f32 - y)), Some(own(at as f32 + x, end as f32 + y))];
            lines.set_change([at, end], 1, &beside(0.0, 1.0));
        }
    }
    lines.find_missed(bundle, &[0xff; ROOT], SIZE);
    lines
}

/// Asserts that every sample of a tile shows one of the four triangles with the smallest numbers.
fn assert_covered<M: RayModel>(functions: &EdgeFunctions, model: &M) {
    let area = TileArea { size: SIZE, rows: [0xff; ROOT] };
    let mut samples = TileSamples::default();
    samples.begin(catoptric_engine::raster::sample_positions(16).expect("there is a pattern"));
    for lane in (0..LANES).rev() {
        for sign in [1.0, -1.0] {
            let functions = functions.of_lane::<M>(lane, sign);
            let triangle = DrawnTriangle { number: lane as u32, functions, margin: Some(0.0) };
            samples.draw(model, &area, &triangle, 0, 0..SIZE);
        }
    }
    let shown: Vec<u32> = (0..SIZE).flat_map(|row| samples.shown[row * ROOT * 16..][..SIZE * 16].to_vec()).collect();
    assert!(shown.iter().all(|number| *number != NOTHING && *number < 4), "{shown:?}");
    assert!((0..4).all(|side| shown.contains(&side)));
}

#[test]
fn lines_of_pixels_are_exact_and_their_changes_nearly() {
    let mut fit = BundleFit::default();
    let (bundle, first) = bundle(false, &mut fit);
    let lines = lines(false, &bundle, first);
    let mut checked = 0;
    for block in triangles(false, 200, 0.7) {
        let functions = EdgeFunctions::new(&bundle, lines.missed(), &block);
        for lane in 0..LANES {
            let [a, b, c, plane] = functions.of_lane::<PixelLines>(lane, 1.0);
            for [column, row] in [[0, 0], [3, 4], [7, 2]] {
                // The places are the centre, and a sample.
                for (offset, tolerance) in [(Vec2::ZERO, 1e-3), (Vec2::new(0.4, -0.3), 6e-3)] {
                    let at = first + Vec2::new(column as f32, row as f32) + 0.5 + offset;
                    let ray = reflected(false, at).ray;
                    let (weights, distance) = meets(&ray, corners(&block, lane));
                    if weights.iter().any(|weight| weight.abs() > 5.0) || distance.abs() > 20.0 {
                        continue;
                    }
                    let value = |function: &[f32; TERMS]| {
                        let [value, dx, dy] = lines.pixel(function, [column, row]);
                        value + dx * offset.x + dy * offset.y
                    };
                    let sum = value(&a) + value(&b) + value(&c);
                    for (function, weight) in [a, b, c].iter().zip(weights) {
                        let found = f64::from(value(function) / sum);
                        assert!(
                            (found - weight).abs() < tolerance * weight.abs().max(1.0),
                            "{found} {weight} {offset}"
                        );
                    }
                    let depth = (ray.origin + ray.direction * distance as f32 - bundle.origin).dot(bundle.axes[2]);
                    let found = value(&plane) / sum;
                    assert!((found - depth).abs() < tolerance as f32 * depth.abs().max(1.0), "{found} {depth}");
                    checked += 1;
                }
            }
        }
    }
    assert!(checked > 200, "{checked}");
}
