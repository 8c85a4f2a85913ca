//! The picture, and what the hand does on it.

use super::Viewer;
use super::hand::Tool;
use super::marks;
use super::shown::ShownPicture;
use eframe::egui::{
    Align2, Color32, Context, CursorIcon, FontId, Key, PointerButton, Pos2, Rect, Response, Sense, Stroke, StrokeKind,
    TextureId, Ui, pos2, vec2,
};
use glam::{Vec2, Vec3};

/// The half width of the zone in which the divider is taken, in points.
const DIVIDER_REACH: f32 = 6.0;

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
    // Where no panel says it.
    if let Some(message) = viewer.shown.messages.back().filter(|_| !viewer.shows_panels) {
        caption(ui, rect.left_bottom() + vec2(8.0, -8.0), Align2::LEFT_BOTTOM, message);
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
        viewer.pick(at, rect, scale);
    }
}

/// Flies as long as keys are held: W, A, S, D, and Q and E for down and up; faster with shift.
fn fly(viewer: &mut Viewer, ctx: &Context) {
    if ctx.egui_wants_keyboard_input() {
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
        return label(ui, rect, Align2::LEFT_TOP, left.as_ref(), &viewer.choices[0].method);
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
    }
    path_lines(viewer, ui, rect);
    marks::paint(viewer, ui, rect);
    painter.vline(x, rect.y_range(), Stroke::new(2.0, Color32::WHITE));
    let grip = Rect::from_center_size(pos2(x, rect.center().y), vec2(10.0, 36.0));
    painter.rect(grip, 4.0, Color32::WHITE, Stroke::new(1.0, Color32::BLACK), StrokeKind::Inside);
    label(ui, rect, Align2::LEFT_TOP, left.as_ref(), &viewer.choices[0].method);
    label(ui, rect, Align2::RIGHT_TOP, right.as_ref(), &viewer.choices[1].method);
}

/// The method's name in a corner, with what the picture is like.
fn label(ui: &Ui, rect: Rect, corner: Align2, picture: Option<&ShownPicture>, method: &str) {
    let text = match picture {
        Some(picture) if picture.is_whole => method.to_owned(),
        Some(picture) => {
            let [width, height] = picture.size;
            format!("{method}, {width}x{height}, {} samples", picture.samples)
        }
        None => format!("{method} ..."),
    };
    let at = corner.pos_in_rect(&rect.shrink(8.0));
    caption(ui, at, corner, &text);
}

/// Text that can be read on any picture.
pub(super) fn caption(ui: &Ui, at: Pos2, align: Align2, text: &str) {
    let galley = ui.painter().layout_no_wrap(text.into(), FontId::proportional(14.0), Color32::WHITE);
    let place = align.anchor_size(at, galley.size());
    ui.painter().rect_filled(place.expand(3.0), 3.0, Color32::from_black_alpha(150));
    ui.painter().galley(place.min, galley, Color32::WHITE);
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
