//! The picture: what the pointer does there, and handles of lights over it.

use egui::{Color32, Pos2, Rect, Stroke};
use glam::{Vec2, Vec3};

use super::style;
use crate::state::camera::Camera;
use crate::state::event::{Button, Event, Modifiers};
use crate::state::handle::Handle;
use crate::state::keys::{Action, key_of};
use crate::state::lamp::{Lamp, LampKind};
use crate::state::viewer::Viewer;
use rimline_picture::Bounds;

pub(super) fn show(ui: &mut egui::Ui, viewer: &mut Viewer) {
    let rect = ui.max_rect();
    let scale = ui.ctx().pixels_per_point();
    let pixels = |length: f32| ((length * scale).round() as u32).max(1);
    viewer.handle_radius = 16.0 * scale;
    let size = [pixels(rect.width()), pixels(rect.height())];
    if size != viewer.size() {
        viewer.handle(Event::Resized(size));
    }
    // Tab passes the picture by, which listens while no widget has the keyboard.
    let response = ui.interact(rect, ui.scope_id().with("picture"), egui::Sense::DRAG);
    listen(ui, viewer, &response, scale);
    let painter = ui.painter_at(rect);
    let over = Over { painter, rect, scale, camera: viewer.camera(), bounds: viewer.bounds(), ground: viewer.ground() };
    if viewer.options.overlays.boxes {
        viewer.bodies.iter().for_each(|body| over.draw_box(&body.bounds()));
    }
    for (number, lamp) in viewer.lamps.iter().enumerate() {
        over.lamp(lamp, viewer.selected == Some(number), viewer.hovered == Some(Handle::Lamp(number)));
    }
    if let Some((number, lamp)) = viewer.selected.and_then(|number| Some((number, viewer.lamps.get(number)?))) {
        over.target(lamp, viewer.hovered == Some(Handle::Target(number)));
    }
    if viewer.hovered.is_some() {
        ui.ctx().set_cursor_icon(egui::CursorIcon::Grab);
    }
    if ui.input(egui::InputState::has_touch_screen) {
        panel_button(ui.ctx(), viewer, rect);
    }
}

/// A button in the corner of the picture that shows and hides the panel, where there may be no keyboard.
fn panel_button(context: &egui::Context, viewer: &mut Viewer, rect: Rect) {
    let at = rect.right_top() + egui::vec2(-8.0, 8.0);
    let area = egui::Area::new(egui::Id::unique("panel button")).fixed_pos(at).pivot(egui::Align2::RIGHT_TOP);
    area.show(context, |ui| {
        if ui.button("Panel").on_hover_text(key_of(Action::Panel)).clicked() {
            viewer.handle(Event::Acted(Action::Panel));
        }
    });
}

/// Makes events of what fingers, the pointer and held keys do.
fn listen(ui: &egui::Ui, viewer: &mut Viewer, response: &egui::Response, scale: f32) {
    if let Some(fingers) = ui.input(egui::InputState::multi_touch) {
        // The first finger is a pointer, too. Beside a second one it drags nothing.
        viewer.handle(Event::Released);
        if is_on(response, fingers.center_pos) {
            viewer.handle(Event::Panned((fingers.translation_delta * scale).into()));
            viewer.handle(Event::Pinched(fingers.zoom_delta));
        }
    } else {
        point(ui, viewer, response, scale);
        scroll(ui, viewer, response, scale);
    }
    fly(ui, viewer);
}

/// Whether a point is on the picture, and nothing of egui's lies over it there.
fn is_on(response: &egui::Response, at: Pos2) -> bool {
    response.rect.contains(at) && response.ctx.layer_id_at(at).is_none_or(|layer| layer == response.layer_id)
}

/// Keys that are held with the pointer.
fn held(modifiers: egui::Modifiers) -> Modifiers {
    Modifiers { shift: modifiers.shift, control: modifiers.command }
}

/// Makes events of what the pointer does.
fn point(ui: &egui::Ui, viewer: &mut Viewer, response: &egui::Response, scale: f32) {
    let pixel = |at: Pos2| ((at - response.rect.min) * scale).into();
    // A slow frame may hold a press, moves, a release and more moves: their order decides what a move drags.
    for event in ui.input(|input| input.events.clone()) {
        match event {
            egui::Event::PointerMoved(at) if viewer.is_dragging() || response.hovered() => {
                viewer.handle(Event::Moved(pixel(at)));
            }
            egui::Event::PointerButton { pos, button, pressed: true, modifiers } if is_on(response, pos) => {
                let button = match button {
                    egui::PointerButton::Primary => Button::Primary,
                    egui::PointerButton::Secondary => Button::Secondary,
                    egui::PointerButton::Middle => Button::Middle,
                    _ => continue,
                };
                if !viewer.is_dragging() {
                    viewer.handle(Event::Moved(pixel(pos)));
                    viewer.handle(Event::Pressed(button, held(modifiers)));
                }
            }
            egui::Event::PointerButton { pos, pressed: false, .. } if viewer.is_dragging() => {
                viewer.handle(Event::Moved(pixel(pos)));
                viewer.handle(Event::Released);
            }
            // The system took the finger for a gesture of its own, or shows another window. No release may follow.
            egui::Event::Touch { phase: egui::TouchPhase::Cancel, .. } | egui::Event::WindowFocused(false) => {
                viewer.handle(Event::Released);
            }
            _ => {}
        }
    }
    // A window that lost the pointer hears of no release.
    if viewer.is_dragging() && !ui.input(|input| input.pointer.any_down()) {
        viewer.handle(Event::Released);
    }
    let at = if viewer.is_dragging() { response.interact_pointer_pos() } else { response.hover_pos() };
    match at {
        Some(at) => viewer.handle(Event::Moved(pixel(at))),
        None if viewer.is_dragging() => {}
        None => viewer.hovered = None,
    }
}

/// Makes events of a wheel or of fingers beside the screen.
fn scroll(ui: &egui::Ui, viewer: &mut Viewer, response: &egui::Response, scale: f32) {
    if !response.hovered() {
        return;
    }
    let (modifiers, scrolled, pinched) =
        ui.input(|input| (input.modifiers, input.smooth_scroll_delta(), input.zoom_delta()));
    if scrolled != egui::Vec2::ZERO && modifiers.shift {
        viewer.handle(Event::Panned((scrolled * scale).into()));
    } else if scrolled != egui::Vec2::ZERO {
        viewer.handle(Event::Scrolled([scrolled.x / 40.0, scrolled.y / 40.0], held(modifiers)));
    }
    if pinched != 1.0 {
        viewer.handle(Event::Pinched(pinched));
    }
}

/// Moves with the keys that are held.
fn fly(ui: &egui::Ui, viewer: &mut Viewer) {
    if ui.ctx().egui_wants_keyboard_input() || ui.input(|input| input.modifiers.any()) {
        return;
    }
    let axis = |less: egui::Key, more: egui::Key| {
        ui.input(|input| f32::from(i8::from(input.key_down(more)) - i8::from(input.key_down(less))))
    };
    let by = [axis(egui::Key::A, egui::Key::D), axis(egui::Key::Q, egui::Key::E), axis(egui::Key::S, egui::Key::W)];
    if by != [0.0; 3] {
        viewer.handle(Event::Flown(by, ui.input(|input| input.stable_dt).min(0.1)));
        ui.ctx().request_repaint();
    }
}

/// Draws over the picture.
struct Over {
    painter: egui::Painter,
    rect: Rect,
    scale: f32,
    camera: Camera,
    bounds: Bounds,
    ground: f32,
}

impl Over {
    fn at(&self, point: Vec3) -> Option<Pos2> {
        let Vec2 { x, y } = self.camera.project(point)? / self.scale;
        Some(self.rect.min + egui::vec2(x, y))
    }

    fn line(&self, from: Vec3, to: Vec3, stroke: Stroke) {
        if let (Some(from), Some(to)) = (self.at(from), self.at(to)) {
            self.painter.line_segment([from, to], stroke);
        }
    }

    fn draw_box(&self, bounds: &Bounds) {
        let corners = bounds.corners();
        for corner in 0..8_usize {
            for axis in [1, 2, 4] {
                if corner & axis == 0 {
                    self.line(corners[corner], corners[corner | axis], Stroke::new(1.0, style::ACCENT));
                }
            }
        }
    }

    /// The handle of a light: a disc in its colour with a stalk to the ground, or for a light at infinity with rays.
    fn lamp(&self, lamp: &Lamp, is_selected: bool, is_hovered: bool) {
        let handle = lamp.handle(&self.bounds);
        let Some(at) = self.at(handle) else { return };
        let [r, g, b] = lamp.shown_color().map(|c| (c * 255.0) as u8);
        let color = if lamp.is_on { Color32::from_rgb(r, g, b) } else { Color32::from_gray(90) };
        let faint = Stroke::new(1.0, Color32::from_rgba_unmultiplied(20, 22, 26, 120));
        match lamp.kind {
            LampKind::Point(_) => {
                let foot = handle.with_y(self.ground);
                self.line(handle, foot, faint);
                if let Some(foot) = self.at(foot) {
                    self.painter.circle_filled(foot, 2.5, faint.color);
                }
                if let Some(range) = lamp.range.filter(|_| is_selected) {
                    self.circle(handle, Vec3::Y, range, faint);
                }
            }
            LampKind::Sun(_) => {
                self.line(handle, self.bounds.centre() + 0.75 * (handle - self.bounds.centre()), faint);
                for ray in 0..8 {
                    let way = egui::Vec2::angled(std::f32::consts::TAU * ray as f32 / 8.0);
                    self.painter.line_segment([at + 10.0 * way, at + 15.0 * way], Stroke::new(2.0, color));
                }
            }
        }
        let radius = if is_hovered || is_selected { 8.0 } else { 6.5 };
        self.painter.circle_filled(at, radius + 1.5, Color32::from_rgba_unmultiplied(20, 22, 26, 170));
        self.painter.circle_filled(at, radius, color);
        if is_selected {
            self.painter.circle_stroke(at, radius + 3.5, Stroke::new(1.5, style::ACCENT));
        } else if is_hovered {
            self.painter.circle_stroke(at, radius + 3.5, Stroke::new(1.5, Color32::from_gray(230)));
        }
    }

    /// The point that a spot is aimed at: a ring, and the circle that it lights there.
    fn target(&self, lamp: &Lamp, is_hovered: bool) {
        let (LampKind::Point(from), Some((axis, angle))) = (lamp.kind, lamp.cone) else { return };
        let Some(target) = lamp.target(&self.bounds) else { return };
        let faint = Stroke::new(1.0, Color32::from_rgba_unmultiplied(20, 22, 26, 120));
        self.line(from, target, faint);
        self.circle(target, axis, from.distance(target) * angle.tan(), faint);
        if let Some(at) = self.at(target) {
            let color = if is_hovered { Color32::from_gray(230) } else { style::ACCENT };
            self.painter.circle_stroke(at, 6.0, Stroke::new(2.0, color));
        }
    }

    /// A circle around a point, across an axis.
    fn circle(&self, centre: Vec3, axis: Vec3, radius: f32, stroke: Stroke) {
        const SEGMENTS: u32 = 64;
        let (x, z) = axis.any_orthonormal_pair();
        let point = |step: u32| {
            let angle = std::f32::consts::TAU * step as f32 / SEGMENTS as f32;
            centre + radius * (angle.cos() * x + angle.sin() * z)
        };
        (0..SEGMENTS).for_each(|step| self.line(point(step), point(step + 1), stroke));
    }
}
