//! Inference as a whole: its matrix, its solutions, and the pictures that it takes.

mod direct;
mod least_squares;
mod observations;

use catoptric_core::math::Aabb;
use catoptric_core::math::random::Stream;
use catoptric_core::progress::Silent;
use catoptric_core::scene::{Scene, View};
use catoptric_engine::light::tracer::Tracer;
use catoptric_lookup::layered_environment_map::LayeredEnvironmentMapSettings;
use catoptric_lookup::parts::{
    Equations, HIDDEN_WEIGHT, Inference, Layer, LayerGeometry, LayerTexture, Observations, Observer, STOP, equations,
    picture_of, radiance,
};
use catoptric_scenes::builtin;
use glam::{Vec3, Vec4, Vec4Swizzles};
use std::collections::BTreeSet;

/// A built-in scene, all of whose reflectors and lenses are one group.
fn scene(name: &str) -> Scene {
    let mut scene = builtin::parse(name).unwrap().pose(&Default::default()).unwrap();
    let boxes = scene.specular_objects().into_iter().map(|object| scene.objects[object as usize].bounds);
    scene.region = Some(boxes.fold(Aabb::EMPTY, Aabb::union));
    scene
}

/// Inference for a scene, of textures of a size from pictures of a size, with all else as it is by default.
fn with_inference(name: &str, size: u32, picture_size: u32, work: impl FnOnce(&Inference<'_>, &[Layer])) {
    let scene = scene(name);
    let settings = LayeredEnvironmentMapSettings { size, picture_size, ..LayeredEnvironmentMapSettings::default() };
    let known = LayerGeometry::new(&settings, &scene, 4);
    let projected = known.projected(&settings, &scene, &Silent).unwrap();
    work(&Inference { scene: &scene, settings: &settings, known: &known }, &projected[0]);
}

/// The picture of a group from a place beside a viewpoint.
fn picture(inference: &Inference<'_>, observer: &Observer<'_>, viewpoint: u32, offset: f32) -> View {
    let eye = observer.known.viewspace.eye(viewpoint, offset);
    picture_of(inference.scene, &observer.known.group, eye, inference.settings.picture_size)
}

/// Sum of the squares of every texel's weights.
fn squares(equations: &Equations, count: usize) -> Vec<f32> {
    let mut squares = vec![0.0; count];
    let terms = equations.texels.iter().zip(&equations.weights);
    terms.for_each(|(texel, weight)| squares[*texel as usize] += weight * weight);
    squares
}

/// Has equations hold for texels.
fn show(equations: &mut Equations, texels: &[Vec4]) {
    let mut values = vec![Vec4::ZERO; equations.values.len()];
    equations.times(texels, &mut values);
    equations.values = values;
}

#[test]
fn textures_that_made_the_pictures_come_back() {
    // Pictures as they are made of a scene, where random textures with mip levels show in its place.
    with_inference("sphere_room?tess=16", 16, 384, |inference, projected| {
        let systems = inference.systems(0, projected, 0, &Silent).unwrap();
        let mut random = Stream::new(8);
        for (number, (systems, layer)) in systems.into_iter().zip(projected).enumerate() {
            let layout = &layer.texture.layout;
            // Half floats hold them, and their means.
            let mut eighths = || (random.next_between(0.2, 1.0) * 8.0).round() / 8.0;
            let mut truth: Vec<Vec4> =
                (0..layout.texel_count()).map(|_| Vec4::new(eighths(), eighths(), 0.625, 1.0)).collect();
            layout.fill_coarser(&mut truth);
            let mut equations = Equations::joined(systems);
            show(&mut equations, &truth);
            let read = squares(&equations, layout.texel_count());
            let (found, residual) = inference.fitted(layer, equations);
            let mut checked = 0u32;
            let (mut off, mut was_off, mut worst) = (0.0f32, 0.0f32, 0.0f32);
            // Trust pulls these by half a percent at most to the expected values, which are far off.
            for (texel, truth) in truth.iter().enumerate().filter(|(texel, _)| read[*texel] > 1.0) {
                let of = |texture: &LayerTexture| (texture.texels[texel].value() - *truth) / *truth;
                checked += 1;
                off += of(&found).length_squared();
                was_off += of(&layer.texture).length_squared();
                worst = worst.max(of(&found).abs().max_element());
            }
            let [off, was_off] = [off, was_off].map(|sum| (sum / (4 * checked) as f32).sqrt());
            let found = format!("{number}: {checked} off by {off}, {worst} at worst, before {was_off}; {residual:?}");
            assert!(checked > 180 && off < 0.005 && worst < 0.065 && was_off > 0.45, "{found}");
            assert!(residual.after < 0.006 * residual.before && residual.steps < STOP.most_steps, "{found}");
        }
    });
}

#[test]
fn the_matrix_times_the_texture_is_what_is_drawn() {
    // Rays of a picture, side by side as they are drawn, by layers with depths that rays search.
    with_inference("colonnade?tess=12", 64, 192, |inference, projected| {
        let observations = inference.seen(0, 0).unwrap();
        let rays: Vec<_> = observations.list.iter().map(|observation| (observation.ray, observation.change)).collect();
        for (number, layer) in projected.iter().enumerate() {
            assert!(layer.distances.is_some(), "depths are the default");
            let texels: Vec<Vec4> = layer.texture.texels.iter().map(|texel| texel.value()).collect();
            let matrix = equations(layer, &observations, number, |_| 1.0);
            let mut seen = vec![Vec4::ZERO; rays.len()];
            matrix.times(&texels, &mut seen);
            let (mut part, mut nothing) = (0, 0);
            radiance(&[(vec![layer], 1.0)], inference.scene, &rays, |index, drawn| {
                let seen = seen[index];
                assert_eq!(inference.scene.background(rays[index].0.direction), Vec3::ZERO, "layers are seen alone");
                let expected = seen.xyz().max(Vec3::ZERO);
                let off = (drawn - expected).abs().max_element();
                assert!(off <= 2e-5 * drawn.max_element().max(1.0), "{number}, {index}: {drawn}, not {expected}");
                part += u32::from(seen.w > 0.5);
                nothing += u32::from(seen.w == 0.0);
            });
            assert!(part > 1000 && nothing > 1300, "{number}: {part} rays meet it, {nothing} do not");
        }
        assert!(projected.len() == 3 && rays.len() > 8000, "{} rays", rays.len());
    });
}

#[test]
fn hidden_surfaces_are_seen_as_if_nothing_was_before_them() {
    // The view is from the side: one sphere before the other.
    with_inference("two_spheres", 16, 192, |inference, _| {
        let scene = inference.scene;
        inference.with_observer(0, |observer| {
            let view = picture(inference, observer, 11, 0.0);
            let distance = |object: &u32| scene.objects[*object as usize].bounds.center().distance(view.eye());
            let far = scene.specular_objects().into_iter().max_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap();
            let alone = Tracer::build(scene, |object| object == far);
            let hidden = observer.observe_hidden(&view);
            for observation in &hidden.list {
                let [x, y] = observation.pixel.map(|place| place as f32 + 0.5);
                let ray = view.ray(x, y);
                let hit = alone.first_hit(scene, &ray, 0.0).unwrap();
                let point = alone.point(scene, &ray, &hit);
                let leaving = observer.paths.follow(ray.direction, point, observation.first).leaving.unwrap();
                let off = leaving.direction.distance(observation.ray.direction);
                assert!(off < 1e-4, "{:?}: {off}", observation.pixel);
            }
            assert!(hidden.list.len() > 700, "{}", hidden.list.len());
        });
    });
}

#[test]
fn groups_that_hide_nothing_of_themselves_are_seen_as_ever() {
    with_inference("sphere_room?tess=16", 16, 96, |inference, _| {
        inference.with_observer(0, |observer| {
            let view = picture(inference, observer, 0, 0.0);
            assert!(observer.observe_hidden(&view).list.is_empty());
            assert!(inference.observations(observer, &view).unwrap().list.len() > 500);
        });
    });
}

#[test]
fn what_a_group_hides_of_itself_is_inferred_too() {
    // A mirror pot from its side: spout and handle, one behind the other, hide the body.
    const VIEWPOINT: u32 = 10;
    with_inference("teapot", 64, 192, |inference, projected| {
        let systems = inference.systems(0, projected, VIEWPOINT, &Silent).unwrap();
        inference.with_observer(0, |observer| {
            let at = |offset: f32| {
                inference.observations(observer, &picture(inference, observer, VIEWPOINT, offset)).unwrap()
            };
            let used = [at(0.0), at(-0.5), at(0.5)];
            let hidden = observer.observe_hidden(&picture(inference, observer, VIEWPOINT, 0.0));
            let texels_of = |layer: &Layer, observations: &Observations| -> BTreeSet<u32> {
                let counts = observations.list.iter().filter(|observation| observation.confidence > 0.1);
                counts.filter_map(|observation| layer.texel_at(&observation.ray)).collect()
            };
            let filled_of = |layer: &Layer| -> BTreeSet<u32> {
                let read: BTreeSet<u32> = used.iter().flat_map(|picture| texels_of(layer, picture)).collect();
                texels_of(layer, &hidden).difference(&read).copied().collect()
            };
            // The layer that has most of the hidden parts depends on how clusters come out.
            let number = (0..projected.len()).max_by_key(|number| filled_of(&projected[*number]).len()).unwrap();
            let layer = &projected[number];
            // Pictures beside it, three sizes of each; between them the viewpoint's own, each with the parts that it
            // hides.
            let systems = &systems[number];
            let of = |observations: &Observations, weight: f32| {
                equations(layer, observations, number, |observation| observation.confidence * weight)
            };
            assert!(systems.len() == 12 && systems[3] == of(&used[0], 1.0), "what it shows is as ever");
            assert!(systems[4] == of(&hidden, HIDDEN_WEIGHT), "what it hides comes next");
            let texels = |observations: &Observations| texels_of(layer, observations);
            let filled = filled_of(layer);
            let fitted = |systems: Vec<Equations>| -> Vec<Vec4> {
                let (texture, _) = inference.fitted(layer, Equations::joined(systems));
                texture.texels.iter().map(|texel| texel.value()).collect()
            };
            let shown = systems.iter().enumerate().filter(|(index, _)| ![4, 6, 8].contains(index));
            let without = fitted(shown.map(|(_, system)| system.clone()).collect());
            let with = fitted(systems.clone());
            // The root mean square of a picture's errors.
            let off = |observations: &Observations, texels: &[Vec4]| {
                let mut seen = vec![Vec4::ZERO; observations.list.len()];
                equations(layer, observations, number, |_| 1.0).times(texels, &mut seen);
                let squares = seen.iter().enumerate().map(|(index, seen)| {
                    if observations.list[index].confidence <= 0.1 {
                        return [0.0, 0.0];
                    }
                    [(*seen - observations.seen(index, number)).length_squared(), 1.0]
                });
                let [sum, count] = squares.fold([0.0, 0.0], |sum, next| [sum[0] + next[0], sum[1] + next[1]]);
                (sum / count).sqrt()
            };
            let beside = [1.0, 2.0].map(at);
            let wanted = [0, 1].map(|index| texels(&beside[index]).intersection(&filled).count());
            let errors = [0, 1].map(|index| [&without, &with].map(|texels| off(&beside[index], texels)));
            let own = [&without, &with].map(|texels| off(&used[0], texels));
            let found = format!("{} filled, {wanted:?} of them wanted; {errors:?}, {own:?}", filled.len());
            assert!(wanted[0] > 15 && wanted[1] > 30, "{found}");
            assert!(errors.iter().all(|[without, with]| *with < 0.9 * without), "{found}");
            assert!(own[1] < own[0] + 0.005, "{found}");
        });
    });
}
