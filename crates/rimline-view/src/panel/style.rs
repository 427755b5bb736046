//! Colours and spaces.

use egui::{Color32, CornerRadius, Margin, Stroke};

pub(super) const ACCENT: Color32 = Color32::from_rgb(0xe2, 0xa8, 0x5c);
pub(super) const DIM: Color32 = Color32::from_rgb(0x9a, 0xa3, 0xad);
pub(super) const ERROR: Color32 = Color32::from_rgb(0xf0, 0x82, 0x6b);
const PANEL: Color32 = Color32::from_rgb(0x20, 0x24, 0x2a);
const STRIP: Color32 = Color32::from_rgb(0x1b, 0x1f, 0x24);
const TEXT: Color32 = Color32::from_rgb(0xd9, 0xde, 0xe3);

pub(super) fn set(context: &egui::Context) {
    context.set_theme(egui::Theme::Dark);
    context.all_styles_mut(|style| {
        let mut visuals = egui::Visuals::dark();
        visuals.override_text_color = Some(TEXT);
        visuals.panel_fill = PANEL;
        visuals.window_fill = PANEL;
        visuals.extreme_bg_color = Color32::from_rgb(0x15, 0x18, 0x1c);
        visuals.selection.bg_fill = Color32::from_rgb(0x6b, 0x4f, 0x2a);
        visuals.selection.stroke = Stroke::new(1.0, ACCENT);
        visuals.slider_trailing_fill = true;
        for widget in [&mut visuals.widgets.inactive, &mut visuals.widgets.hovered, &mut visuals.widgets.active] {
            widget.corner_radius = CornerRadius::same(4);
        }
        visuals.widgets.inactive.weak_bg_fill = Color32::from_rgb(0x2e, 0x34, 0x3c);
        visuals.widgets.inactive.bg_fill = Color32::from_rgb(0x2e, 0x34, 0x3c);
        visuals.widgets.noninteractive.bg_stroke = Stroke::new(1.0, Color32::from_rgb(0x30, 0x36, 0x3e));
        style.visuals = visuals;
        style.spacing.item_spacing = egui::vec2(6.0, 5.0);
        // The bar, which shows under the pointer, covers no button.
        style.spacing.scroll.floating_allocated_width = 10.0;
        // A still picture is not to be drawn again because something fades.
        style.animation_time = 0.0;
    });
}

/// The frame of the panel at the side.
pub(super) fn panel() -> egui::Frame {
    egui::Frame::NONE.fill(PANEL).inner_margin(Margin::same(12))
}

/// The frame of the time line.
pub(super) fn strip() -> egui::Frame {
    egui::Frame::NONE.fill(STRIP).inner_margin(Margin::symmetric(12, 7))
}

/// The heading of a section.
pub(super) fn heading(ui: &mut egui::Ui, text: &str) {
    ui.add_space(8.0);
    ui.separator();
    ui.label(egui::RichText::new(text).strong().color(ACCENT));
}
