//! Overlays and marks over the picture.

use crate::session::{SCENE, Session, expected, open, scene, settle};
use crate::trial;
use catoptric::methods::overlay::{Overlay, OverlayKind};
use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;
use libtest_mimic::Trial;

pub(crate) fn trials() -> Vec<Trial> {
    vec![trial("an overlay is chosen, shown with its legend, and hidden in motion", chosen_and_hidden)]
}

/// The trials that look at the screen.
pub(crate) fn screens() -> Vec<Trial> {
    vec![
        trial("an overlay covers the pixels that it is of", covers),
        trial("a picked point is marked where methods show it", marks),
    ]
}

/// Opens the panel of overlays and ticks one.
fn tick(session: &mut Session, kind: OverlayKind) -> Overlay {
    if session.query_by_role_and_label(Role::CheckBox, kind.name()).is_none() {
        session.get_by_label("Overlays").click();
        (0..40).for_each(|_| session.step());
    }
    // Times have names, too.
    session.get_by_role_and_label(Role::CheckBox, kind.name()).click();
    settle(session, |viewer| viewer.overlay(kind).is_some() && viewer.is_sharp());
    session.state().overlay(kind).unwrap().clone()
}

fn chosen_and_hidden() {
    let mut session = open(&format!("builtin:{SCENE}"), "multiperspective", None);
    let tiles = tick(&mut session, OverlayKind::Tiles);
    assert!(tiles.size == session.state().wish().unwrap().size && !tiles.segments.is_empty());
    session.step();
    session.get_by_label("one bundle of rays");
    // Overlays that the method does not have are not offered.
    assert!(session.query_by_role_and_label(Role::CheckBox, OverlayKind::Layers.name()).is_none());
    // The picture below it is the same.
    let wish = session.state().wish().unwrap().clone();
    assert_eq!(session.state().picture(0).unwrap(), &expected(&scene(SCENE), &wish, 0));
    // From another place it is another one.
    session.key_down(egui::Key::D);
    (0..5).for_each(|_| session.step());
    session.key_up(egui::Key::D);
    assert!(session.state().overlay(OverlayKind::Tiles).is_none());
    settle(&mut session, |viewer| viewer.overlay(OverlayKind::Tiles).is_some() && viewer.is_sharp());
    assert_ne!(session.state().overlay(OverlayKind::Tiles), Some(&tiles));
    session.get_by_role_and_label(Role::CheckBox, OverlayKind::Tiles.name()).click();
    settle(&mut session, |viewer| viewer.wish().is_some_and(|wish| wish.overlays.is_empty()));
    assert!(session.state().overlay(OverlayKind::Tiles).is_none());
}

/// The pixels of the picture on the screen.
fn screen(session: &mut Session, name: &str) -> Vec<[u8; 4]> {
    session.remove_cursor();
    session.step();
    let rect = session.state().picture_rect();
    let screen = session.render().unwrap();
    if let Some(folder) = std::env::var_os("CATOPTRIC_SCREENSHOTS") {
        screen.save(std::path::Path::new(&folder).join(format!("overlay {name}.png"))).unwrap();
    }
    let [width, height] = session.state().wish().unwrap().size;
    let at = |x: u32, y: u32| screen.get_pixel(rect.left() as u32 + x, rect.top() as u32 + y).0;
    (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| at(x, y)).collect()
}

fn marks() {
    let mut session = open(&format!("builtin:{SCENE}"), "environment_map", None);
    let bare = screen(&mut session, "marks, bare");
    let at = session.state().picture_rect().center() + egui::vec2(40.0, 60.0);
    for pressed in [true, false] {
        let (pos, button, modifiers) = (at, egui::PointerButton::Primary, egui::Modifiers::NONE);
        session.event(egui::Event::PointerMoved(at));
        session.event(egui::Event::PointerButton { pos, button, pressed, modifiers });
        session.step();
    }
    settle(&mut session, |viewer| viewer.places().is_some_and(|places| places.is_done));
    (0..40).for_each(|_| session.step());
    session.get_by_label("By other methods");
    session.get_by_label("truth");
    let marked = screen(&mut session, "marks");
    let places = session.state().places().unwrap();
    assert!(places.list.len() >= 4, "{places:?}");
    let width = session.state().wish().unwrap().size[0] as i32;
    for place in &places.list {
        let [x, y] = place.position_px.map(|place| place as i32);
        // The middle of a cross has its colour or, below another, that one's.
        let pixel = (y * width + x) as usize;
        assert!(bare[pixel] != marked[pixel], "{place:?}");
    }
    // In another picture nothing is said.
    session.key_down(egui::Key::D);
    (0..5).for_each(|_| session.step());
    session.key_up(egui::Key::D);
    assert!(session.state().places().is_none());
}

fn covers() {
    for (method, spec, kind) in [
        ("multiperspective", SCENE, OverlayKind::Tiles),
        ("multiperspective", SCENE, OverlayKind::Paths),
        ("path_perturbation", SCENE, OverlayKind::VirtualTriangles),
        ("auto", "planar_mirror?mirrors=2", OverlayKind::VirtualTriangles),
        ("layered_environment_map", SCENE, OverlayKind::Layers),
        ("auto", "glass_sphere", OverlayKind::Paths),
        ("reference", "glass_sphere", OverlayKind::Paths),
        ("sample_based_camera", SCENE, OverlayKind::Leaves),
    ] {
        let mut session = open(&format!("builtin:{spec}"), method, None);
        let name = format!("{method} {}", kind.name());
        let bare = screen(&mut session, &format!("{name}, bare"));
        let overlay = tick(&mut session, kind);
        let covered = screen(&mut session, &name);
        let width = overlay.size[0] as usize;
        let mut wanted: Vec<bool> = overlay.pixels.iter().map(|group| *group != 0).collect();
        wanted.resize(bare.len(), false);
        for segment in &overlay.segments {
            let [a, b] = segment.ends;
            let steps = (a.distance(b) * 4.0).ceil().max(1.0);
            for step in 0..=steps as u32 {
                let at = a.lerp(b, step as f32 / steps);
                for (x, y) in [(-1, -1), (0, -1), (1, -1), (-1, 0), (0, 0), (1, 0), (-1, 1), (0, 1), (1, 1)] {
                    let [x, y] = [at.x.floor() as i32 + x, at.y.floor() as i32 + y];
                    if x >= 0 && y >= 0 && x < width as i32 && y < overlay.size[1] as i32 {
                        wanted[y as usize * width + x as usize] = true;
                    }
                }
            }
        }
        let differs = |pixel: usize| bare[pixel].iter().zip(covered[pixel]).any(|(a, b)| a.abs_diff(b) > 6);
        let changed: Vec<bool> = (0..bare.len()).map(differs).collect();
        let count = |is_counted: &dyn Fn(usize) -> bool| (0..bare.len()).filter(|pixel| is_counted(*pixel)).count();
        let (beside, all) = (count(&|pixel| changed[pixel] && !wanted[pixel]), count(&|pixel| changed[pixel]));
        assert!(all > 300 && beside == 0, "{name}: {beside} of {all} beside");
        if !overlay.pixels.is_empty() {
            let missed = count(&|pixel| !changed[pixel] && overlay.pixels[pixel] != 0);
            assert!(missed * 20 < all, "{name}: {missed} beside {all}");
        }
    }
}
