//! Objects under the hand: picked, and dragged through the scene.

use super::state::Viewer;
use super::state::grip::Grip;
use super::state::shown::Picked;
use crate::studio::order::Order;
use catoptric::scene::{Camera, View};
use eframe::egui::{Pos2, Rect, Response};
use glam::{Vec2, Vec3};

impl Viewer {
    /// Asks what is seen at a place of the window.
    pub(super) fn pick(&mut self, at: Pos2, rect: Rect, scale: f32) -> u64 {
        let position_px = [(at.x - rect.left()) * scale, (at.y - rect.top()) * scale];
        self.picks += 1;
        self.shown.picked = Some(Picked { number: self.picks, position_px, path: Vec::new(), places: None });
        self.link.send(Order::Pick { number: self.picks, position_px });
        self.picks
    }

    /// Has the view turn about what is seen at a place of the window, once that is told.
    pub(super) fn focus_at(&mut self, at: Pos2, rect: Rect, scale: f32) {
        self.focus = Some(self.pick(at, rect, scale));
    }

    /// Turns about what was picked, if the view was to.
    pub(super) fn turn_about_picked(&mut self, number: u64) {
        let Some(picked) = self.shown.picked.as_ref().filter(|_| self.focus == Some(number)) else { return };
        self.focus = None;
        let Some(first) = picked.path.first() else {
            return self.note("nothing is there that the view could turn about");
        };
        let (point, object) = (first.position, first.object as usize);
        let name = self.scene.as_ref().and_then(|scene| scene.objects.get(object)).map(|object| object.name.clone());
        if let Some(navigator) = &mut self.navigator {
            navigator.focus(point);
        }
        match name.filter(|name| !name.is_empty()) {
            Some(name) => self.note(format!("dragging turns about this point of `{name}` now")),
            None => self.note("dragging turns about this point now"),
        }
    }

    /// The object in the hand and how far it was moved.
    pub(super) fn held(&self) -> Option<(&str, Vec3)> {
        let (name, ..) = self.grip.as_ref()?.held.as_ref()?;
        Some((name, self.changes.moves.get(name).copied().unwrap_or_default()))
    }

    /// Moves the object that was under the pointer when dragging began, across the view: its point under the pointer
    /// stays there.
    pub(super) fn drag_object(&mut self, response: &Response, rect: Rect, scale: f32) {
        let Some(at) = response.interact_pointer_pos() else { return };
        if response.drag_started() {
            let from = response.ctx.input(|input| input.pointer.press_origin()).unwrap_or(at);
            let number = self.pick(from, rect, scale);
            self.grip = Some(Grip { number, held: None });
        }
        self.take_hold();
        let (Some(Grip { held: Some((name, point, before)), .. }), Some(navigator)) = (&self.grip, &self.navigator)
        else {
            return;
        };
        let [width, height] = self.size;
        let view = View::new(navigator.camera(), width, height, 0.0);
        let px = Vec2::new(at.x - rect.left(), at.y - rect.top()) * scale;
        if let Some(target) = at_depth_of(&view, navigator.camera(), px, *point) {
            self.changes.moves.insert(name.clone(), *before + (target - *point));
        }
    }

    /// Learns what is in the hand, once that is told.
    fn take_hold(&mut self) {
        let Some(grip) = self.grip.as_mut().filter(|grip| grip.held.is_none()) else { return };
        let Some(picked) = self.shown.picked.as_ref().filter(|picked| picked.number == grip.number) else { return };
        let Some(first) = picked.path.first() else { return };
        let object = self.scene.as_ref().and_then(|scene| scene.objects.get(first.object as usize));
        if let Some(name) = object.map(|object| object.name.clone()).filter(|name| !name.is_empty()) {
            let before = self.changes.moves.get(&name).copied().unwrap_or_default();
            grip.held = Some((name, first.position, before));
        }
    }
}

/// The point that is seen at a place of the picture, as deep as another one.
fn at_depth_of(view: &View, camera: &Camera, px: Vec2, point: Vec3) -> Option<Vec3> {
    let axis = -Vec3::from(camera.world_from_camera.matrix3.z_axis);
    let ray = view.ray(px.x, px.y);
    let distance = (point - ray.origin).dot(axis) / ray.direction.dot(axis);
    let target = ray.origin + ray.direction * distance;
    (distance > 0.0 && target.is_finite()).then_some(target)
}
