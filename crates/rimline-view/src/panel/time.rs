//! The time line of animations.

use crate::state::event::Event;
use crate::state::keys::Action;
use crate::state::viewer::Viewer;

pub(super) fn show(ui: &mut egui::Ui, viewer: &mut Viewer) {
    ui.horizontal(|ui| {
        let text = if viewer.clock.is_running { "Stop" } else { "Play" };
        if ui.add_sized([46.0, 20.0], egui::Button::new(text)).on_hover_text("play or stop (Space)").clicked() {
            viewer.handle(Event::Acted(Action::Play));
        }
        let duration = viewer.duration();
        ui.spacing_mut().slider_width = (ui.available_width() - 182.0).max(60.0);
        let slider = egui::Slider::new(&mut viewer.clock.seconds, 0.0..=duration).show_value(false);
        if ui.add(slider).dragged() {
            viewer.clock.is_running = false;
        }
        ui.monospace(format!("{:>5.2} / {duration:.2} s", viewer.clock.seconds));
        let speed = egui::DragValue::new(&mut viewer.clock.speed).range(-8.0..=8.0).speed(0.05).suffix("×");
        ui.add(speed.max_decimals(2)).on_hover_text("speed ([ and ])");
    });
}
