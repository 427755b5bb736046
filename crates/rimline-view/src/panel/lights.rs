//! The list of lights, and the selected one.

use std::ops::RangeInclusive;

use glam::Vec3;

use super::style;
use crate::state::event::Event;
use crate::state::keys::{Action, key_of};
use crate::state::lamp::{Lamp, LampKind};
use crate::state::viewer::Viewer;
use rimline_picture::Bounds;

pub(super) fn show(ui: &mut egui::Ui, viewer: &mut Viewer) {
    style::heading(ui, "Lights");
    let mut selected = viewer.selected;
    for (number, lamp) in viewer.lamps.iter_mut().enumerate() {
        ui.horizontal(|ui| {
            ui.checkbox(&mut lamp.is_on, "").on_hover_text("on or off (T)");
            // egui rounds a colour each time that it is shown, and what the user did not change stays.
            let mut color = lamp.color;
            if ui.color_edit_button_rgb(&mut color).changed() {
                lamp.color = color;
            }
            let kind = if matches!(lamp.kind, LampKind::Point(_)) { "point" } else { "direction" };
            if ui.selectable_label(selected == Some(number), format!("{}  {kind}", number + 1)).clicked() {
                selected = Some(number);
            }
            ui.add(egui::Slider::new(&mut lamp.intensity, 0.0..=2.0).show_value(false)).on_hover_text("intensity");
        });
    }
    viewer.selected = selected;
    ui.horizontal(|ui| {
        for (text, action) in [
            ("Add", Action::AddLight),
            ("Remove", Action::RemoveLight),
            ("Point or direction", Action::ChangeLightKind),
        ] {
            if ui.small_button(text).on_hover_text(key_of(action)).clicked() {
                viewer.handle(Event::Acted(action));
            }
        }
    });
    let bounds = viewer.bounds();
    if let Some(lamp) = viewer.selected.and_then(|number| viewer.lamps.get_mut(number)) {
        edit(ui, lamp, &bounds);
    }
    ui.colored_label(style::DIM, "Drag its handle. Shift: up and down. Ctrl: level.");
}

fn edit(ui: &mut egui::Ui, lamp: &mut Lamp, bounds: &Bounds) {
    let extent = bounds.extent();
    match &mut lamp.kind {
        LampKind::Point(at) => numbers(ui, "at", at, 0.01 * extent),
        LampKind::Sun(towards) => direction(ui, "from", towards),
    }
    ui.horizontal_wrapped(|ui| {
        if let LampKind::Sun(_) = lamp.kind {
            length(ui, "radius", &mut lamp.radius, 0.05, 1e-3..=1.0);
            return;
        }
        length(ui, "range", &mut lamp.range, 4.0 * extent, 0.05 * extent..=20.0 * extent);
        length(ui, "radius", &mut lamp.radius, 0.1 * extent, 1e-3 * extent..=extent);
        let mut is_spot = lamp.cone.is_some();
        if ui.checkbox(&mut is_spot, "spot").on_hover_text("drag the ring to aim it").changed() {
            lamp.set_spot(is_spot, bounds);
        }
        if let Some((_, angle)) = &mut lamp.cone {
            let mut degrees = angle.to_degrees();
            let value = egui::DragValue::new(&mut degrees).range(1.0..=89.0).speed(0.25).suffix("°");
            if ui.add(value.clamp_existing_to_range(false)).changed() {
                *angle = degrees.clamp(1.0, 89.0).to_radians();
            }
        }
    });
    // Last: a row above the box "spot" would take the keyboard from it as it comes.
    if let (LampKind::Point(_), Some((axis, _))) = (&lamp.kind, &mut lamp.cone) {
        direction(ui, "aim", axis);
    }
}

/// A length that there may be, `usual` at first.
fn length(ui: &mut egui::Ui, name: &str, value: &mut Option<f32>, usual: f32, range: RangeInclusive<f32>) {
    let mut is_given = value.is_some();
    if ui.checkbox(&mut is_given, name).changed() {
        *value = is_given.then_some(usual);
    }
    if let Some(value) = value {
        let shown = egui::DragValue::new(value).range(range.clone()).clamp_existing_to_range(false);
        if ui.add(shown.speed(0.01 * usual)).changed() {
            // Arrow keys go on past the range.
            *value = value.clamp(*range.start(), *range.end());
        }
    }
}

/// A direction of length 1.
fn direction(ui: &mut egui::Ui, name: &str, towards: &mut Vec3) {
    let mut given = *towards;
    numbers(ui, name, &mut given, 0.01);
    if given != *towards {
        *towards = given.normalize_or(*towards);
    }
}

/// Three numbers, which stay finite after any input. Small steps have more digits.
fn numbers(ui: &mut egui::Ui, name: &str, Vec3 { x, y, z }: &mut Vec3, speed: f32) {
    let decimals = (-speed.log10()).round().clamp(2.0, 15.0) as usize;
    ui.horizontal(|ui| {
        ui.colored_label(style::DIM, name);
        for value in [x, y, z] {
            let value = egui::DragValue::new(value).range(-1e30..=1e30).clamp_existing_to_range(false);
            ui.add(value.speed(speed).max_decimals(decimals));
        }
    });
}
