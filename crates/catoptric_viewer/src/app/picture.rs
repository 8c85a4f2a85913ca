//! The picture, and what the hand does on it.

use super::marks;
use super::state::Viewer;
use super::state::grip::Tool;
use super::state::shown::ShownPicture;
use super::words::{caption, cut_middle, width_of};
use eframe::egui::{
    Align2, Color32, Context, CursorIcon, Key, PointerButton, Pos2, Rect, Response, Sense, Stroke, StrokeKind,
    TextureId, Ui, pos2, vec2,
};
use glam::{Vec2, Vec3};

/// The half width of the zone in which the divider is taken, in points.
const DIVIDER_REACH: f32 = 6.0;

/// Seconds for which it is said what was done.
const NOTED_SECONDS: f64 = 4.0;

/// Sizes of the scene that a key flies in a second.
const FLIGHT_A_SECOND: f32 = 0.35;

/// The whole texture.
const ALL: Rect = Rect { min: Pos2::ZERO, max: pos2(1.0, 1.0) };

/// Shows the picture in all of the space that is left.
pub(super) fn show(viewer: &mut Viewer, ui: &mut Ui) {
    let scale = ui.ctx().pixels_per_point();
    let space = ui.available_rect_before_wrap();
    // Whole pixels, so that the picture's are the screen's.
    let snapped = |point: f32| (point * scale).round() / scale;
    let rect = Rect::from_min_max(
        pos2(snapped(space.min.x), snapped(space.min.y)),
        pos2(snapped(space.max.x), snapped(space.max.y)),
    );
    viewer.size = [rect.width(), rect.height()].map(|points| (points * scale).round().clamp(0.0, 8192.0) as u32);
    viewer.rect = rect;
    let response = ui.interact(rect, ui.scope_id().with("picture"), Sense::click_and_drag());
    let divider = viewer.divider.map(|share| rect.left() + rect.width() * share);
    let drags_divider = divider.is_some_and(|x| drag_divider(viewer, ui, rect, x));
    if !drags_divider {
        steer(viewer, ui, &response, rect);
    }
    paint(viewer, ui, rect, divider);
    say(viewer, ui, rect);
}

/// Words over the picture: what was done a moment ago, what is in the hand, and what is wrong where no panel
/// says it.
fn say(viewer: &Viewer, ui: &Ui, rect: Rect) {
    let now = ui.input(|input| input.time);
    let noted = viewer.shown.noted.as_ref().filter(|(_, at)| now - at < NOTED_SECONDS);
    let held = viewer.held().map(|(name, by)| format!("`{name}` moved by {:.3}, {:.3}, {:.3}", by.x, by.y, by.z));
    let loading = || viewer.asked.values().next_back().map(|(source, _)| format!("opening {}", source.short_name()));
    let has_panel = viewer.shows_panels && (!viewer.is_narrow || viewer.is_unfolded);
    if let Some((text, at)) = noted {
        let text = cut_middle(text, (rect.width() / 8.0).max(12.0) as usize);
        caption(ui, rect.center_bottom() + vec2(0.0, -12.0), Align2::CENTER_BOTTOM, &text);
        ui.ctx().request_repaint_after_secs((at + NOTED_SECONDS - now).max(0.0) as f32);
    } else if let Some(text) = held {
        caption(ui, rect.center_bottom() + vec2(0.0, -12.0), Align2::CENTER_BOTTOM, &text);
    } else if let Some(text) = loading().filter(|_| viewer.shown.pictures[0].is_none()) {
        caption(ui, rect.center(), Align2::CENTER_CENTER, &text);
    } else if let Some(message) = viewer.shown.messages.back().filter(|_| !has_panel && viewer.failed.is_none()) {
        caption(ui, rect.left_bottom() + vec2(8.0, -8.0), Align2::LEFT_BOTTOM, &message.text);
    }
}

/// Moves the divider. Returns true while the hand is on it.
fn drag_divider(viewer: &mut Viewer, ui: &mut Ui, rect: Rect, x: f32) -> bool {
    let zone = Rect::from_x_y_ranges(x - DIVIDER_REACH..=x + DIVIDER_REACH, rect.y_range());
    let response = ui.interact(zone, ui.scope_id().with("divider"), Sense::drag());
    if response.hovered() || response.dragged() {
        ui.ctx().set_cursor_icon(CursorIcon::ResizeHorizontal);
    }
    if let Some(at) = response.interact_pointer_pos().filter(|_| response.dragged()) {
        viewer.divider = Some(((at.x - rect.left()) / rect.width().max(1.0)).clamp(0.02, 0.98));
    }
    response.dragged()
}

/// Moves the camera as the hand does.
fn steer(viewer: &mut Viewer, ui: &Ui, response: &Response, rect: Rect) {
    let scale = ui.ctx().pixels_per_point();
    let moves_object = viewer.tool == Tool::Move && !ui.input(|input| input.modifiers.shift);
    if moves_object && response.dragged_by(PointerButton::Primary) {
        return viewer.drag_object(response, rect, scale);
    }
    if response.drag_stopped() {
        viewer.grip = None;
    }
    let Some(navigator) = &mut viewer.navigator else { return };
    let height = rect.height().max(1.0);
    let moved = response.drag_delta() / height;
    let moved = Vec2::new(moved.x, moved.y);
    let (shift, touches) = ui.input(|input| (input.modifiers.shift, input.multi_touch()));
    let before = navigator.camera().clone();
    if let Some(touch) = touches {
        navigator.zoom(touch.zoom_delta);
        let moved = touch.translation_delta / height;
        navigator.pan(Vec2::new(moved.x, moved.y));
    } else if moved != Vec2::ZERO {
        if response.dragged_by(PointerButton::Middle) || (response.dragged_by(PointerButton::Primary) && shift) {
            navigator.pan(moved);
        } else if response.dragged_by(PointerButton::Secondary) {
            navigator.look(moved);
        } else {
            navigator.orbit(moved);
        }
    }
    if response.hovered() {
        let (scroll, pinch) = ui.input(|input| (input.smooth_scroll_delta().y, input.zoom_delta()));
        navigator.zoom((scroll * 0.004).exp() * pinch);
    }
    fly(viewer, ui.ctx());
    let has_moved = viewer.navigator.as_ref().is_some_and(|navigator| *navigator.camera() != before);
    if has_moved {
        viewer.camera = None;
    }
    if let Some(at) = response.interact_pointer_pos().filter(|_| response.clicked()) {
        match response.double_clicked() {
            true => viewer.focus_at(at, rect, scale),
            false => drop(viewer.pick(at, rect, scale)),
        }
    }
}

/// Flies as long as keys are held: W, A, S, D, and Q and E for down and up; faster with shift.
fn fly(viewer: &mut Viewer, ctx: &Context) {
    if ctx.egui_wants_keyboard_input() {
        return;
    }
    // Ctrl+S saves, and does not fly.
    if ctx.input(|input| input.modifiers.command) {
        return;
    }
    let Some(navigator) = &mut viewer.navigator else { return };
    let (step, held) = ctx.input(|input| {
        let along = |more: Key, less: Key| {
            f32::from(u8::from(input.key_down(more))) - f32::from(u8::from(input.key_down(less)))
        };
        let direction = Vec3::new(along(Key::D, Key::A), along(Key::E, Key::Q), along(Key::S, Key::W));
        let speed = FLIGHT_A_SECOND * if input.modifiers.shift { 4.0 } else { 1.0 };
        (direction * speed * input.stable_dt.min(0.1), direction != Vec3::ZERO)
    });
    if held {
        navigator.fly(step);
        ctx.request_repaint();
    }
}

fn paint(viewer: &Viewer, ui: &Ui, rect: Rect, divider: Option<f32>) {
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 0.0, Color32::BLACK);
    let image = |texture: TextureId, clip: Rect| {
        painter.with_clip_rect(clip.intersect(painter.clip_rect())).image(texture, rect, ALL, Color32::WHITE);
    };
    let [left, right] = &viewer.shown.pictures;
    if let Some(picture) = left {
        image(picture.image.id(), rect);
    }
    for shown in &viewer.shown.overlays {
        if let (Some(texture), Some(_)) = (&shown.texture, viewer.overlay(shown.overlay.kind)) {
            image(texture.id(), rect);
        }
    }
    let Some(x) = divider else {
        path_lines(viewer, ui, rect);
        marks::paint(viewer, ui, rect);
        let text = label(left.as_ref(), &viewer.choices[0].method);
        caption(ui, rect.left_top() + vec2(8.0, 8.0), Align2::LEFT_TOP, &text);
        return;
    };
    let right_part = Rect::from_min_max(pos2(x, rect.top()), rect.max);
    painter.rect_filled(right_part, 0.0, Color32::BLACK);
    if let Some(picture) = right {
        image(picture.image.id(), right_part);
    }
    let compared = viewer.shown.compared.as_ref().filter(|compared| viewer.shows_same(&compared.wish));
    if let Some(compared) = compared.filter(|_| viewer.shows_heat) {
        image(compared.texture.id(), right_part);
        let text = format!("FLIP {:.4}   off by > 0.1: {:.3} %", compared.flip_mean, compared.over_0_1 * 100.0);
        caption(ui, pos2(rect.right() - 8.0, rect.bottom() - 8.0), Align2::RIGHT_BOTTOM, &text);
    } else if viewer.shows_heat {
        let text = heat_in_the_making(viewer, right.as_ref());
        caption(ui, right_part.center_bottom() - vec2(0.0, 36.0), Align2::CENTER_BOTTOM, &text);
    }
    path_lines(viewer, ui, rect);
    marks::paint(viewer, ui, rect);
    painter.vline(x, rect.y_range(), Stroke::new(2.0, Color32::WHITE));
    let grip = Rect::from_center_size(pos2(x, rect.center().y), vec2(10.0, 36.0));
    painter.rect(grip, 4.0, Color32::WHITE, Stroke::new(1.0, Color32::BLACK), StrokeKind::Inside);
    let texts = [left, right].into_iter().zip(&viewer.choices);
    let [left, right] = [0, 1].map(|side| {
        texts.clone().nth(side).map(|(picture, choice)| label(picture.as_ref(), &choice.method)).unwrap_or_default()
    });
    let placed = caption(ui, rect.left_top() + vec2(8.0, 8.0), Align2::LEFT_TOP, &left);
    // Side by side where there is room, else one below the other.
    let lower = if placed.width() + width_of(ui, &right) + 32.0 > rect.width() { placed.height() + 4.0 } else { 0.0 };
    caption(ui, rect.right_top() + vec2(-8.0, 8.0 + lower), Align2::RIGHT_TOP, &right);
}

/// The work that the heat map waits for.
fn heat_in_the_making(viewer: &Viewer, right: Option<&ShownPicture>) -> String {
    let stage = viewer.shown.busy.as_ref().map(|(stage, share)| match share {
        Some(share) => format!("{stage}, {:.0} %", share * 100.0),
        None => stage.clone(),
    });
    match (stage, right) {
        (Some(stage), _) => format!("heat map: {stage}"),
        (None, Some(picture)) if !picture.is_whole => {
            format!("heat map: once both sides are sharp; the right one has {} samples", picture.samples)
        }
        _ if viewer.is_sharp() => "heat map: comparing both sides".into(),
        _ => "heat map: once both sides are sharp".into(),
    }
}

/// The method's name, with what the picture is like.
fn label(picture: Option<&ShownPicture>, method: &str) -> String {
    match picture {
        Some(picture) if picture.is_whole => method.to_owned(),
        Some(picture) => {
            let [width, height] = picture.size;
            format!("{method}, {width}x{height}, {} samples", picture.samples)
        }
        None => format!("{method} ..."),
    }
}

/// The path that was picked, as it stands in space, seen by the camera.
fn path_lines(viewer: &Viewer, ui: &Ui, rect: Rect) {
    let (Some(picked), Some(navigator), Some(scene)) = (&viewer.shown.picked, &viewer.navigator, &viewer.scene) else {
        return;
    };
    let [width, height] = viewer.size;
    let view = catoptric::scene::View::new(navigator.camera(), width, height, scene.bounds.diagonal() * 1e-8);
    let scale = ui.ctx().pixels_per_point();
    let painter = ui.painter_at(rect);
    let seen = |point: Vec3| view.pixel_of(point).map(|px| rect.min + vec2(px.x, px.y) / scale);
    let mut before: Option<Pos2> = None;
    for (index, bounce) in picked.path.iter().enumerate() {
        let at = seen(bounce.position);
        if let (Some(from), Some(to)) = (before, at) {
            painter.line_segment([from, to], Stroke::new(4.0, Color32::BLACK));
            painter.line_segment([from, to], Stroke::new(2.0, Color32::YELLOW));
        }
        if let Some(at) = at {
            let color = if index + 1 == picked.path.len() { Color32::LIGHT_GREEN } else { Color32::YELLOW };
            painter.circle(at, 4.5, color, Stroke::new(1.5, Color32::BLACK));
        }
        before = at;
    }
}
