//! The list of keys.

use super::style;
use crate::state::keys::KEYS;
use crate::state::viewer::Viewer;

pub(super) fn show(context: &egui::Context, viewer: &mut Viewer) {
    let mut is_open = viewer.shows_help;
    let window = egui::Window::new("Keys and pointer").open(&mut is_open).collapsible(false).resizable(false);
    window.anchor(egui::Align2::CENTER_CENTER, [0.0, 0.0]).show(context, |ui| {
        let rows = KEYS.len().div_ceil(2);
        egui::Grid::new("keys").num_columns(4).spacing([14.0, 3.0]).show(ui, |ui| {
            for row in 0..rows {
                for binding in [KEYS.get(row), KEYS.get(row + rows)].into_iter().flatten() {
                    ui.colored_label(style::ACCENT, binding.name());
                    ui.label(binding.what);
                }
                ui.end_row();
            }
        });
        ui.separator();
        for text in [
            "Drag a light by its handle; with Shift up and down, with Ctrl at its height.",
            "Drag elsewhere to turn; with Shift, the right or the middle button to move sideways.",
            "Scroll or pinch for nearer and farther. Two fingers on a screen move sideways, too.",
            "W, A, S, D, Q and E fly.",
            "Tab goes through the panel: Space, arrows and numbers change what is there. Escape comes back.",
            "Drop files on the window to open them: several at once, too. Under Wayland press O instead.",
        ] {
            ui.colored_label(style::DIM, text);
        }
    });
    viewer.shows_help = is_open;
}
