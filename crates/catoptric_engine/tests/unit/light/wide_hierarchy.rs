//! Hierarchies against all triangles, one by one.

use catoptric_core::math::random::Stream;
use catoptric_core::scene::model::{LocalTransform, MeshAsset, Model, Node, Primitive};
use catoptric_core::scene::{Camera, Material, Projection, Ray, Scene, View};
use catoptric_engine::light::wide_hierarchy::{
    Beam, NO_TRIANGLE, Portable, PrimitiveMet, Treelet, TriangleBlock, TriangleHit, Visitor, WideHierarchy, WideNode,
    meet,
};
use glam::{Vec2, Vec3};

/// Triangles of all sizes, those of two objects, the second of them moved.
fn scene(shift: Vec3) -> Scene {
    let mut random = Stream::new(21);
    let mut model = Model { materials: vec![Material::default()], ..Model::default() };
    for object in 0..2 {
        let mut primitive = Primitive::default();
        for triangle in 0..700u32 {
            let size = 0.02 * 1.007f32.powi(triangle as i32);
            let mut point = |size: f32| Vec3::from_array([0, 1, 2].map(|_| random.next_between(-size, size)));
            let middle = point(4.0);
            primitive.positions.extend([middle + point(size), middle + point(size), middle + point(size)]);
            primitive.triangles.push([3 * triangle, 3 * triangle + 1, 3 * triangle + 2]);
        }
        model.meshes.push(MeshAsset { primitives: vec![primitive], ..MeshAsset::default() });
        let local = LocalTransform::at(shift * object as f32);
        model.nodes.push(Node { mesh: Some(object), local, ..Node::default() });
    }
    model.pose(&Default::default()).expect("the model is valid")
}

fn rays() -> impl Iterator<Item = Ray> {
    let mut random = Stream::new(22);
    (0..2000).map(move |_| {
        let mut point = |size: f32| Vec3::from_array([0, 1, 2].map(|_| random.next_between(-size, size)));
        Ray { origin: point(6.0), direction: point(1.0).normalize_or(Vec3::X) }
    })
}

/// The nearest of all triangles, tested one by one.
fn nearest_of_all(scene: &Scene, ray: &Ray) -> Option<TriangleHit> {
    let mut best: Option<TriangleHit> = None;
    for (triangle, vertices) in (0..).zip(&scene.triangles) {
        let corners = vertices.map(|vertex| scene.positions[vertex as usize].to_array());
        let met = meet(corners, [ray.origin.to_array(), ray.direction.to_array()]);
        if met.inside && met.distance >= 0.0 && met.distance < best.map_or(f32::INFINITY, |best| best.distance) {
            let barycentrics = Vec2::from_array(met.weights);
            best = Some(TriangleHit { distance: met.distance, triangle, barycentrics });
        }
    }
    best
}

#[test]
fn the_nearest_triangle_is_that_of_all_triangles_also_after_a_refit() {
    let (before, after) = (scene(Vec3::ZERO), scene(Vec3::new(1.5, -0.5, 0.25)));
    let mut moved = WideHierarchy::build(&before, |_| true);
    assert!(moved.refit(&after));
    let mut hits = 0;
    for (name, hierarchy) in [("built", WideHierarchy::build(&after, |_| true)), ("refitted", moved)] {
        for ray in rays() {
            let found = hierarchy.nearest::<Portable>(&ray, 0.0, f32::INFINITY, |_| true);
            assert_eq!(found, nearest_of_all(&after, &ray), "{name}: {ray:?}");
            if let Some(hit) = found {
                hits += 1;
                let (at, distance) = after.plane_met(hit.triangle, &ray).expect("the triangle has a plane");
                assert!((at - hit.barycentrics).length() < 1e-2 && (distance - hit.distance).abs() < 1e-3);
            }
        }
    }
    assert!(hits > 1000, "{hits}");
}

/// The triangles of all leaves.
struct Seen(Vec<u32>);

impl Visitor for Seen {
    fn children(&self, _: &WideNode) -> u32 {
        0xff
    }

    fn leaf(&mut self, block: &TriangleBlock) -> bool {
        self.0.extend(block.triangles.into_iter().filter(|triangle| *triangle != NO_TRIANGLE));
        true
    }
}

/// The triangles that a walk through all leaves comes by, in order of their numbers.
fn walked(hierarchy: &WideHierarchy) -> Vec<u32> {
    let mut visitor = Seen(Vec::new());
    hierarchy.walk(&mut Vec::new(), &mut visitor);
    let Seen(mut seen) = visitor;
    seen.sort_unstable();
    seen
}

/// Triangles on a line are in no hierarchy; one that opens later is missed by none.
#[test]
fn triangles_without_extent_are_left_out_until_they_open() {
    let flat = |third: Vec3| {
        let mut scene = scene(Vec3::ZERO);
        for number in 0..1000u16 {
            let first = scene.positions.len() as u32;
            let along = |share: f32| Vec3::new(0.1, 0.7, -0.3) * (share + f32::from(number) * 1e-3);
            scene.positions.extend([along(0.0), along(0.3), along(0.7) + third]);
            scene.triangles.push([first, first + 1, first + 2]);
        }
        scene.objects[0].triangles.end = scene.objects[0].triangles.start;
        scene.objects[1].triangles = scene.triangles.len() as u32 - 1000..scene.triangles.len() as u32;
        scene
    };
    let on_a_line = flat(Vec3::ZERO);
    let mut hierarchy = WideHierarchy::build(&on_a_line, |object| object == 1);
    // The numbers of those left out are all that it holds.
    assert!(walked(&hierarchy).is_empty());
    assert_eq!(hierarchy.byte_count(), 1000 * size_of::<u32>() as u64);
    assert!(hierarchy.refit(&on_a_line));
    let open = flat(Vec3::X * 1e-3);
    assert!(!hierarchy.refit(&open));
    assert_eq!(walked(&WideHierarchy::build(&open, |object| object == 1)), (1400..2400).collect::<Vec<u32>>());
}

#[test]
fn walks_come_by_every_triangle_once() {
    let scene = scene(Vec3::ONE);
    let hierarchy = WideHierarchy::build(&scene, |object| object == 1);
    assert_eq!(walked(&hierarchy), (700..1400).collect::<Vec<u32>>());
}

#[test]
fn nothing_is_met_where_there_is_nothing() {
    let hierarchy = WideHierarchy::build(&scene(Vec3::ZERO), |_| false);
    let mut rays = rays();
    assert!(rays.all(|ray| hierarchy.nearest::<Portable>(&ray, 0.0, f32::INFINITY, |_| true).is_none()));
}

#[test]
fn rays_of_a_beam_meet_among_its_leaves_what_they_meet_among_all() {
    let scene = scene(Vec3::ONE);
    let hierarchy = WideHierarchy::build_for_rays(&scene, |_| true, |_| false);
    let (mut gathered, mut hits, mut treelet) = (0, 0, Treelet::default());
    for orthographic in [false, true] {
        let mut camera = Camera::look_at("", Vec3::new(5.0, 3.0, 7.0), Vec3::ZERO, Vec3::Y, 50.0);
        if orthographic {
            camera.projection = Projection::Orthographic { half_height: 4.5 };
        }
        let view = View::new(&camera, 64, 48, 1e-3).rays();
        for tile in 0..192u32 {
            let low = Vec2::new((tile % 16 * 4) as f32, (tile / 16 * 4) as f32);
            hierarchy.gather::<Portable, 4>(&Beam::through(&view, low, low + 4.0), &mut treelet);
            for place in 0..25u32 {
                let at = low + Vec2::new((place % 5) as f32, (place / 5) as f32);
                let ray = view.ray(at.x, at.y);
                let found = treelet.nearest::<Portable>(&hierarchy, &ray, 0.5, |_| true, |_, _| None, &mut ());
                let Some(found) = found else { continue };
                let expected = hierarchy.nearest::<Portable>(&ray, 0.5, f32::INFINITY, |_| true);
                assert_eq!(found, expected.map(PrimitiveMet::Triangle), "{at}");
                gathered += 1;
                hits += u32::from(found.is_some());
            }
        }
    }
    assert!(gathered > 5000 && hits > 2000, "{gathered} rays, {hits} hits");
}

/// Merging so many pair by pair would take minutes.
const PILED: u32 = 30_000;

/// Triangles, each of three corners by its number's share.
fn piled(corners: impl Fn(f32) -> [Vec3; 3]) -> Scene {
    let mut primitive = Primitive::default();
    for number in 0..PILED {
        primitive.positions.extend(corners((number + 1) as f32 / PILED as f32));
        primitive.triangles.push([3 * number, 3 * number + 1, 3 * number + 2]);
    }
    let mut model = Model { materials: vec![Material::default()], ..Model::default() };
    model.meshes.push(MeshAsset { primitives: vec![primitive], ..MeshAsset::default() });
    model.nodes.push(Node { mesh: Some(0), ..Node::default() });
    model.pose(&Default::default()).expect("the model is valid")
}

#[test]
fn of_copies_in_one_place_one_is_met_until_they_part() {
    let base = [Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, -1.0, 0.0), Vec3::Y];
    let together = piled(|_| base);
    let mut hierarchy = WideHierarchy::build_for_rays(&together, |_| true, |_| false);
    assert_eq!((walked(&hierarchy), hierarchy.place_count()), (vec![0], 1));
    assert!(hierarchy.refit(&together));
    let apart = piled(|share| base.map(|corner| corner + Vec3::Z * share));
    assert!(!hierarchy.refit(&apart));
    let all: Vec<u32> = (0..PILED).collect();
    assert_eq!(walked(&WideHierarchy::build(&apart, |_| true)), all);
}

#[test]
fn triangles_in_each_other_or_at_even_distances_are_met_as_others_are() {
    let nested = piled(|share| [Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, -1.0, 0.1), Vec3::Y].map(|at| at * share));
    let fan = piled(|share| {
        let at = |turn: f32| Vec3::new((turn * 6.2).cos(), (turn * 6.2).sin(), 0.1);
        [Vec3::ZERO, at(share), at(share + 1e-3)]
    });
    let sheets = piled(|share| [Vec3::new(-1.0, -1.0, share), Vec3::new(1.0, -1.0, share), Vec3::new(0.0, 1.0, share)]);
    for scene in [nested, fan, sheets] {
        let hierarchy = WideHierarchy::build_for_rays(&scene, |_| true, |_| false);
        let mut met = 0;
        for ray in rays().take(60) {
            let ray = Ray { direction: (Vec3::new(0.01, 0.02, 0.05) - ray.origin).normalize(), ..ray };
            let found = hierarchy.nearest::<Portable>(&ray, 0.0, f32::INFINITY, |_| true);
            let expected = nearest_of_all(&scene, &ray);
            assert_eq!(found.map(|hit| hit.distance), expected.map(|hit| hit.distance));
            met += u32::from(found.is_some());
        }
        assert!(met > 10, "{met}");
    }
}
