//! Budgets of time: frames that are not done are drawn by `auto`, and say so.

use catoptric::framebuffer::Framebuffer;
use catoptric::methods::budget::Budgeted;
use catoptric::methods::{self, Method, Quality, Report};
use catoptric::progress::{Cancelled, Progress, Silent};
use catoptric::scene::{Scene, View};
use catoptric_testkit::drawing::{picture, scene};
use std::sync::Arc;

const QUALITY: Quality = Quality { samples: 1, order: 2 };

fn drawn(method: &dyn Method, scene: &Scene, view: &View) -> (Framebuffer, Report) {
    let valid = "the scene can be drawn";
    let mut prepared = method.prepare(&Arc::new(scene.clone()), QUALITY, None, &Silent).expect(valid);
    let mut target = Framebuffer::new(view.width, view.height);
    let frame = prepared.frame(view, &Silent).expect(valid);
    let report = frame.draw(&mut target, &Silent).expect(valid);
    (target, report)
}

#[test]
fn frames_end_with_their_budget() {
    let scene = scene("vase?tess=8");
    let view = scene.default_view(64, 48);
    let exact = picture("auto", "", &scene, &view, QUALITY);
    for info in methods::all() {
        let method = methods::create(info.id, &toml::Table::new()).expect("defaults are valid");
        let (found, report) = drawn(&Budgeted::new(&*method, 0.0), &scene, &view);
        let leaves_it = ["auto", "multiperspective"].contains(&info.id);
        assert_eq!(report.fallbacks.get("frames_over_budget"), (!leaves_it).then_some(&1), "{}", info.id);
        if !leaves_it {
            assert_eq!(found.pixels, exact.pixels, "{}", info.id);
            assert!(report.warnings.iter().any(|warning| warning.contains("within 0 ms")), "{}", info.id);
        }
    }
}

#[test]
fn an_hour_is_enough_and_changes_nothing() {
    let scene = scene("vase?tess=8");
    let view = scene.default_view(64, 48);
    let method = methods::create("reflector_search", &toml::Table::new()).expect("defaults are valid");
    let (found, report) = drawn(&Budgeted::new(&*method, 3.6e6), &scene, &view);
    assert_eq!(found.pixels, picture("reflector_search", "", &scene, &view, QUALITY).pixels);
    assert!(!report.fallbacks.contains_key("frames_over_budget"));
}

#[test]
fn who_cancels_gets_no_other_picture() {
    struct Cancelling;
    impl Progress for Cancelling {
        fn at(&self, _: &str, _: u64, _: u64) -> Result<(), Cancelled> {
            Err(Cancelled)
        }
    }
    let scene = Arc::new(scene("vase?tess=8"));
    let view = scene.default_view(64, 48);
    let method = methods::create("reference", &toml::Table::new()).expect("defaults are valid");
    let mut prepared = Budgeted::new(&*method, 1e9).prepare(&scene, QUALITY, None, &Silent).expect("it can be drawn");
    let frame = prepared.frame(&view, &Silent).expect("it can be drawn");
    assert!(frame.draw(&mut Framebuffer::new(64, 48), &Cancelling).is_err());
}
