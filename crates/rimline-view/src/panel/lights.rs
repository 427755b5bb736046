//! The list of lights, and the selected one.

use super::style;
use crate::state::event::Event;
use crate::state::keys::{Action, key_of};
use crate::state::lamp::{Lamp, LampKind};
use crate::state::viewer::Viewer;

pub(super) fn show(ui: &mut egui::Ui, viewer: &mut Viewer) {
    style::heading(ui, "Lights");
    let mut selected = viewer.selected;
    for (number, lamp) in viewer.lamps.iter_mut().enumerate() {
        ui.horizontal(|ui| {
            ui.checkbox(&mut lamp.is_on, "").on_hover_text("on or off (T)");
            ui.color_edit_button_rgb(&mut lamp.color);
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
    let extent = viewer.bounds().extent();
    if let Some(lamp) = viewer.selected.and_then(|number| viewer.lamps.get_mut(number)) {
        edit(ui, lamp, extent);
    }
    ui.colored_label(style::DIM, "Drag its handle. Shift: up and down. Ctrl: level.");
}

fn edit(ui: &mut egui::Ui, lamp: &mut Lamp, extent: f32) {
    match &mut lamp.kind {
        LampKind::Point(at) => {
            numbers(ui, "at", &mut at.x, &mut at.y, &mut at.z, 0.01 * extent);
            let mut has_range = lamp.range.is_some();
            ui.horizontal(|ui| {
                if ui.checkbox(&mut has_range, "range").changed() {
                    lamp.range = has_range.then_some(4.0 * extent);
                }
                if let Some(range) = &mut lamp.range {
                    let slider = egui::Slider::new(range, 0.05 * extent..=20.0 * extent).logarithmic(true);
                    ui.add(slider.max_decimals(2));
                }
            });
        }
        LampKind::Sun(towards) => {
            let mut given = *towards;
            numbers(ui, "from", &mut given.x, &mut given.y, &mut given.z, 0.01);
            if given != *towards {
                *towards = given.normalize_or(*towards);
            }
        }
    }
}

fn numbers(ui: &mut egui::Ui, name: &str, x: &mut f32, y: &mut f32, z: &mut f32, speed: f32) {
    ui.horizontal(|ui| {
        ui.colored_label(style::DIM, name);
        for value in [x, y, z] {
            ui.add(egui::DragValue::new(value).speed(speed).max_decimals(2));
        }
    });
}
