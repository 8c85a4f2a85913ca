//! Triangles that are pieces of their source.

use super::*;
use catoptric_core::math::random::Stream;
use catoptric_core::progress::Silent;
use catoptric_engine::raster::LayerSurface;
use glam::Vec4;

/// Every triangle cut into four at the middles of its sides (in space), as pieces of it.
fn in_four(whole: &DrawList) -> DrawList {
    let mut pieces = DrawList { layer: whole.layer, stencil: whole.stencil, ..DrawList::default() };
    let corners = [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::new(0.5, 0.0), Vec2::new(0.5, 0.5), Vec2::new(0.0, 0.5)];
    for triangle in &whole.triangles {
        let [a, b, c] = triangle.vertices.map(|vertex| whole.vertices[vertex as usize]);
        let middle = |p: PicturePoint, q: PicturePoint| PicturePoint {
            xy: (p.xy + q.xy) * 0.5,
            w: (p.w + q.w) * 0.5,
            depth: (p.depth + q.depth) * 0.5,
        };
        let first = pieces.vertices.len() as u32;
        pieces.vertices.extend([a, b, c, middle(a, b), middle(b, c), middle(c, a)]);
        // The order of corners within a piece must not matter.
        for piece in [[0, 3, 5], [4, 3, 1], [5, 4, 2], [4, 5, 3]] {
            pieces.triangles.push(DrawTriangle { vertices: piece.map(|corner| first + corner), ..*triangle });
            pieces.corners.push(piece.map(|corner| corners[corner as usize]));
        }
    }
    pieces
}

fn random_triangles(seed: u64) -> DrawList {
    let mut random = Stream::new(seed);
    list((0..40).map(|_| {
        std::array::from_fn(|_| {
            let (x, y) = (random.next_between(-20.0, 84.0), random.next_between(-20.0, 68.0));
            at(x, y, random.next_between(1.0, 9.0))
        })
    }))
}

#[test]
fn pieces_carry_the_attributes_of_their_source() {
    let view = view(64, 48, true);
    let whole = random_triangles(13);
    let lists = [in_four(&whole), whole];
    let values = |surface: &LayerSurface| surface.barycentrics.value.extend(surface.source as f32);
    let changes = |surface: &LayerSurface| (surface.barycentrics.dx - surface.barycentrics.dy * 3.0).extend(0.0);
    // Parts of pixels stand for their share of the footprint, which seams change: changes are for whole pixels.
    let parts = [(1, values as fn(&LayerSurface) -> Vec3), (4, values), (1, changes)];
    for (samples, part) in parts {
        let [found, expected] = [0, 1].map(|index| {
            picture(&view, samples, &lists[index..=index], |fragment| fragment.chain.first().map_or(Vec3::ZERO, part))
        });
        let differ = |(a, b): &(&[f32; 4], &[f32; 4])| (Vec4::from(**a) - Vec4::from(**b)).abs().max_element() > 1e-3;
        // Corners are snapped to 1/256 pixel: new ones may move a border over a sample.
        let count = expected.pixels.iter().zip(&found.pixels).filter(differ).count();
        assert!(count <= 64 * 48 / 200, "{samples} samples: {count} pixels differ");
    }
}

#[test]
fn alpha_tests_of_pieces_use_their_source() {
    /// Nothing is there where the second vertex weighs more than a third.
    struct CutCorner;
    impl FragmentShader for CutCorner {
        fn shade(&self, fragment: &Fragment<'_>) -> Vec3 {
            coverage(fragment)
        }
        fn is_present(&self, surface: &LayerSurface, _position: Vec2) -> bool {
            surface.barycentrics.value.x < 1.0 / 3.0
        }
    }
    let view = view(32, 32, true);
    let mut whole = list([[at(1.3, 1.7, 1.0), at(31.0, 4.0, 4.0), at(5.0, 30.0, 2.0)]]);
    whole.triangles[0].alpha_tested = true;
    let [found, expected] = [in_four(&whole), whole].map(|list| {
        let mut target = Framebuffer::new(32, 32);
        draw(&view, 4, &[list], &CutCorner, &mut target, &Silent).unwrap();
        target
    });
    let differing = expected.pixels.iter().zip(&found.pixels).filter(|(a, b)| a != b).count();
    assert!(differing <= 4, "{differing}");
    assert!(expected.pixels.iter().filter(|pixel| pixel[0] == 1.0).count() > 20);
    assert!(expected.pixels.iter().filter(|pixel| pixel[0] == 0.0).count() > 300);
}
