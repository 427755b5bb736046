//! Overlays, ways to draw and to count, levels of skipping.

use super::style;
use crate::state::keys::key_of;
use crate::state::options::{COUNTINGS, SWITCHES, counting_name};
use crate::state::viewer::Viewer;
use rimline_picture::Mode;

pub(super) fn show(ui: &mut egui::Ui, viewer: &mut Viewer) {
    let options = &mut viewer.options;
    style::heading(ui, "Show");
    egui::Grid::new("show").num_columns(2).min_col_width(128.0).spacing([8.0, 3.0]).show(ui, |ui| {
        for (number, (action, text, switch)) in SWITCHES.into_iter().enumerate() {
            ui.checkbox(switch(options), text).on_hover_text(key_of(action));
            if number % 2 == 1 {
                ui.end_row();
            }
        }
    });
    style::heading(ui, "Shadows");
    ui.horizontal(|ui| {
        ui.colored_label(style::DIM, "drawn");
        egui::ComboBox::from_id_salt("mode").selected_text(options.mode.name()).width(86.0).show_ui(ui, |ui| {
            for (mode, name) in Mode::ALL {
                ui.selectable_value(&mut options.mode, mode, name);
            }
        });
        ui.colored_label(style::DIM, "counted");
        let name = counting_name(options.counting);
        egui::ComboBox::from_id_salt("counting").selected_text(name).width(70.0).show_ui(ui, |ui| {
            for (counting, name) in COUNTINGS {
                ui.selectable_value(&mut options.counting, counting, name);
            }
        });
    });
    egui::CollapsingHeader::new("Skipping").default_open(false).show(ui, |ui| {
        let skipping = &mut options.skipping;
        for (level, text) in [
            (&mut skipping.range, "casters out of a light's range or cone"),
            (&mut skipping.view, "shadows out of sight"),
            (&mut skipping.receivers, "shadows that no receiver is in"),
            (&mut skipping.casters, "deforming casters that are not needed"),
            (&mut skipping.faces, "faces that need not cast"),
            (&mut skipping.bits, "bits of what did not change"),
            (&mut skipping.lists, "lists of what did not change"),
        ] {
            ui.checkbox(level, text);
        }
    });
}
