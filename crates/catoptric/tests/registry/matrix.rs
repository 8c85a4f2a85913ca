//! Every method on every built-in scene against the reference, within the limits that are kept beside the method.

use catoptric::framebuffer::Framebuffer;
use catoptric::light::path_tracer::specular_mask;
use catoptric::methods::limits::ErrorLimit;
use catoptric::methods::{self, Family, MethodInfo, Quality};
use catoptric::parallel;
use catoptric::scene::{Scene, View};
use catoptric_scenes::builtin;
use catoptric_testkit::drawing::{picture, reflector_error, scene};
use catoptric_testkit::scenes::sphere_in_room;

/// Coarse enough for a picture of 48 x 36.
fn specification(name: &str) -> String {
    let more = if name == "large_room" { "&triangles=10000" } else { "" };
    format!("{name}?tess=8{more}")
}

/// Scenes that search methods take ten times as long to draw as others.
const BUSY: [&str; 6] = ["car", "colonnade", "teapot", "torus", "vase", "workshop"];

/// The methods that look for reflection points one by one.
const SEARCHING: [&str; 4] = ["explosion_map", "path_perturbation", "reflector_search", "sample_based_camera"];

#[test]
fn every_method_keeps_its_limits_on_every_built_in_scene() {
    assert_limits(|scene, info| !(BUSY.contains(&scene) && SEARCHING.contains(&info.id)));
}

#[test]
#[ignore = "slow: cargo xtask check-all --only slow"]
fn searching_methods_keep_their_limits_on_busy_scenes() {
    assert_limits(|scene, info| BUSY.contains(&scene) && SEARCHING.contains(&info.id));
}

/// Every method within its limits on the scenes on which it `is_asked`.
fn assert_limits(is_asked: impl Fn(&str, &MethodInfo) -> bool + Sync) {
    let all = builtin::all();
    // Small pictures leave cores idle: scenes are drawn side by side.
    let faults = parallel::map_collect(all.len(), |index| {
        let name = all[index].name;
        let is_asked = |info: &&MethodInfo| info.family != Family::Reference && is_asked(name, info);
        faults_on(name, &methods::all().iter().copied().filter(is_asked).collect::<Vec<_>>())
    });
    let faults = faults.concat();
    assert!(faults.is_empty(), "what is reached instead, as it would stand there:\n{}", faults.join("\n"));
}

/// The limits that methods would just keep on a scene, where they do not keep their own.
fn faults_on(name: &str, asked: &[&MethodInfo]) -> Vec<String> {
    if asked.is_empty() {
        return Vec::new();
    }
    let scene = scene(&specification(name));
    let view = scene.default_view(48, 36);
    let mut faults = Vec::new();
    for order in [1, 2] {
        let truth = picture("reference", "", &scene, &view, Quality { samples: 4, order });
        for info in asked {
            let limits = info.limits.scenes.iter().find(|limits| limits.scene == name);
            let limit = limits.map(|limits| limits.orders[order as usize - 1]);
            let (reached, holds) = measure(info, limit, &scene, &view, order, &truth);
            if !holds {
                faults.push(format!("{}/limits.rs: scene \"{name}\", order {order}: {reached}", info.id));
            }
        }
    }
    faults
}

/// The limit that would be just kept, as it is written, and whether the method's own is kept.
fn measure(
    info: &MethodInfo,
    limit: Option<ErrorLimit>,
    scene: &Scene,
    view: &View,
    order: u32,
    truth: &Framebuffer,
) -> (String, bool) {
    let found = picture(info.id, info.limits.settings, scene, view, Quality { samples: 4, order });
    let error = reflector_error(&found, truth, scene, view);
    let holds = limit.is_some_and(|limit| error.over_0_1 <= limit.over_0_1 && error.flip_mean <= limit.flip);
    // A tenth more than is reached, and a pixel or two.
    let above = |reached: f64| ((1100.0 * reached).ceil() / 1000.0 + 0.003).min(1.0);
    (format!("below({:.3}, {:.3})", above(error.over_0_1), above(error.flip_mean)), holds)
}

#[test]
fn limits_are_of_scenes_that_exist() {
    for info in methods::all() {
        for limits in info.limits.scenes {
            assert!(builtin::all().iter().any(|scene| scene.name == limits.scene), "{}: {}", info.id, limits.scene);
        }
    }
}

#[test]
fn order_zero_draws_reflectors_black_in_every_method() {
    let scene = sphere_in_room(true);
    let view = scene.default_view(40, 30);
    let mask = specular_mask(&scene, &view);
    for info in methods::all() {
        let drawn = picture(info.id, "", &scene, &view, Quality { samples: 1, order: 0 });
        for (pixel, reflector) in drawn.pixels.iter().zip(&mask) {
            assert_eq!(pixel[..3] == [0.0; 3], *reflector, "{}", info.id);
        }
    }
}
