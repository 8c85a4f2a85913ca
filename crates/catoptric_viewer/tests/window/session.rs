//! A window under test.

use crate::painted::Painted;
use catoptric::framebuffer::Framebuffer;
use catoptric::light::visibility::{DIFFUSE_BOUNCES, cast_shadows, shadow_sky};
use catoptric::methods;
use catoptric::progress::Silent;
use catoptric::scene::{PoseOptions, Scene};
use catoptric_scenes::builtin;
pub(crate) use catoptric_viewer::app::Start;
use catoptric_viewer::app::{StudioThread, Viewer};
use catoptric_viewer::studio::Gpu;
use catoptric_viewer::studio::order::{Source, Wish};
use eframe::egui_wgpu::RenderState;
use egui::{Event, Modifiers, PointerButton, Pos2};
use egui_kittest::kittest::Queryable;
use egui_kittest::wgpu::WgpuTestRenderer;
use egui_kittest::{Harness, TestRenderer};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// The scene of most tests.
pub(crate) const SCENE: &str = "sphere_room?tess=16";

/// A test that waits longer gives up: far longer than anything takes on a machine at work.
const PATIENCE: Duration = Duration::from_secs(300);

pub(crate) type Session = Harness<'static, Viewer>;

/// A window with a scene, once everything is sharp.
pub(crate) fn open(scene: &str, method: &str, against: Option<&str>) -> Session {
    open_on(None, scene, method, against)
}

/// The same, drawn by the window's device.
pub(crate) fn open_on(device: Option<RenderState>, scene: &str, method: &str, against: Option<&str>) -> Session {
    open_as(device, start(scene, method, against))
}

/// The scene, methods and quality that a window begins with.
pub(crate) fn start(scene: &str, method: &str, against: Option<&str>) -> Start {
    Start {
        source: Source::of_word(scene),
        method: method.into(),
        settings: toml::Table::new(),
        against: against.map(str::to_owned),
        samples: 4,
        order: Some(2),
        opening: Default::default(),
        view: Default::default(),
        panels: true,
        bakes: Vec::new(),
        program: crate::errands::PROGRAM.as_ref().ok().cloned(),
    }
}

/// A window that begins with something, once everything is sharp.
pub(crate) fn open_as(device: Option<RenderState>, start: Start) -> Session {
    match device.clone() {
        Some(window) => open_with(WgpuTestRenderer::from_render_state(window), device, start),
        None => open_with(Painted::default(), None, start),
    }
}

/// The same, with what draws the window; `device` is what draws the scene.
pub(crate) fn open_with(renderer: impl TestRenderer + 'static, device: Option<RenderState>, start: Start) -> Session {
    open_woken(renderer, device, start, Box::new(|| ()))
}

/// The same; `wake_up` is called within the studio's work whenever it has news.
pub(crate) fn open_woken(
    renderer: impl TestRenderer + 'static,
    device: Option<RenderState>,
    start: Start,
    wake_up: Box<dyn Fn() + Send + Sync>,
) -> Session {
    let gpu = device.as_ref().map(|RenderState { adapter, device, queue, .. }| {
        Gpu::of_window(adapter, device.clone(), queue.clone()).unwrap()
    });
    let studio = StudioThread::start(gpu, wake_up);
    let viewer = Viewer::new(Box::new(studio), device, start);
    // Files may have names of any letters.
    let builder = Harness::builder().allow_missing_glyphs().with_size([620.0, 1000.0]).with_step_dt(1.0 / 60.0);
    let builder = builder.renderer(renderer);
    let mut session = builder.build_ui_state(|ui, viewer: &mut Viewer| viewer.show(ui), viewer);
    settle(&mut session, Viewer::is_sharp);
    session
}

/// Lets some frames go by: panels open slowly.
pub(crate) fn steps(session: &mut Session, count: usize) {
    (0..count).for_each(|_| session.step());
}

/// Clicks into the window.
pub(crate) fn click(session: &mut Session, pos: Pos2) {
    session.event(Event::PointerMoved(pos));
    for pressed in [true, false] {
        let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
        session.event(Event::PointerButton { pos, button, pressed, modifiers });
        session.step();
    }
}

/// Lets time go on until something is so.
pub(crate) fn settle(session: &mut Session, is_so: impl Fn(&Viewer) -> bool) {
    let start = Instant::now();
    while start.elapsed() < PATIENCE {
        session.step();
        if is_so(session.state()) {
            return;
        }
        std::thread::sleep(Duration::from_millis(3));
    }
    let viewer = session.state();
    let messages: Vec<&str> = viewer.messages().collect();
    panic!("it never came to be; sharp: {}, messages: {messages:?}, wish: {:?}", viewer.is_sharp(), viewer.wish());
}

/// A built-in scene as the studio poses it.
pub(crate) fn scene(spec: &str) -> Arc<Scene> {
    let mut scene = builtin::parse(spec).unwrap().pose(&PoseOptions::default()).unwrap();
    cast_shadows(&mut scene);
    shadow_sky(&mut scene, DIFFUSE_BOUNCES, &Silent).unwrap();
    Arc::new(scene)
}

/// The library's own picture for a side of a wish.
pub(crate) fn expected(scene: &Arc<Scene>, wish: &Wish, side: usize) -> Framebuffer {
    let drawn = &wish.sides[side];
    let method = methods::create(&drawn.method, &drawn.settings).unwrap();
    let mut prepared = method.prepare(scene, drawn.quality, None, &Silent).unwrap();
    let mut picture = Framebuffer::new(wish.size[0], wish.size[1]);
    let view = scene.view(&wish.camera, wish.size[0], wish.size[1]);
    prepared.frame(&view, &Silent).unwrap().draw(&mut picture, &Silent).unwrap();
    picture
}

/// The share of pixels with a channel of their sRGB values off by more than 0.1.
pub(crate) fn share_off(one: &[u8], other: &[u8], channels: usize) -> f64 {
    assert_eq!(one.len(), other.len());
    let is_off = |(a, b): &(&[u8], &[u8])| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 25);
    let off = one.chunks(channels).zip(other.chunks(channels)).filter(is_off).count();
    off as f64 / (one.len() / channels) as f64
}

/// Chooses the environment map's parallax of a box in the panel, as the hand does.
pub(crate) fn choose_parallax_box(session: &mut Session) {
    session.get_by_label("Settings").click();
    (0..30).for_each(|_| session.step());
    session.get_by_value("none").click();
    (0..3).for_each(|_| session.step());
    session.get_by_label("box").click();
    settle(session, |viewer| {
        viewer.is_sharp() && viewer.wish().is_some_and(|wish| wish.sides[0].settings.contains_key("parallax"))
    });
}
