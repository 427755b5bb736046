//! The list of models.

use super::style;
use crate::state::body::{Body, Report};
use crate::state::event::Event;
use crate::state::keys::Action;
use crate::state::viewer::Viewer;

pub(super) fn show(ui: &mut egui::Ui, viewer: &mut Viewer) {
    style::heading(ui, "Models");
    let (mut choice, mut removed) = (None, None);
    for (number, body) in viewer.bodies.iter().enumerate() {
        let report = body.report();
        ui.horizontal(|ui| {
            if name(ui, &body.name, report.faces) {
                removed = Some(number);
            }
        });
        open_edges(ui, &report);
        if body.animations().len() > 1 {
            let mut animation = body.animation;
            animations(ui, number, body, &mut animation);
            if animation != body.animation {
                choice = Some((number, animation));
            }
        }
    }
    if let Some((number, animation)) = choice {
        viewer.play(number, animation);
    }
    if let Some(number) = removed {
        viewer.remove_body(number);
    }
    ui.horizontal(|ui| scene_and_camera(ui, viewer));
}

/// A model's name, its faces, and a button. Returns whether that removes it.
fn name(ui: &mut egui::Ui, name: &str, faces: usize) -> bool {
    // A long name leaves room for the rest.
    ui.scope(|ui| {
        ui.set_max_width(ui.available_width() - 120.0);
        ui.add(egui::Label::new(name).truncate());
    });
    let what = if faces == 1 { "face" } else { "faces" };
    ui.colored_label(style::DIM, format!("{} {what}", grouped(faces)));
    let layout = egui::Layout::right_to_left(egui::Align::Center);
    ui.with_layout(layout, |ui| ui.small_button("×").on_hover_text("remove this model").clicked()).inner
}

/// How many edges have other than two faces that agree, with advice, if some have.
fn open_edges(ui: &mut egui::Ui, report: &Report) {
    let Some(advice) = report.advice() else { return };
    let kinds =
        [(report.boundary, "boundary"), (report.non_manifold, "non-manifold"), (report.inconsistent, "inconsistent")];
    let found = kinds.iter().filter(|(count, _)| *count > 0);
    let facts: Vec<String> = found.map(|(count, what)| format!("{} {what}", grouped(*count))).collect();
    ui.colored_label(style::DIM, format!("{} edges", facts.join(", ")));
    ui.add(egui::Label::new(egui::RichText::new(advice).small().color(style::DIM)).wrap());
}

/// A choice of the animation that plays. `number`: the model's.
fn animations(ui: &mut egui::Ui, number: usize, body: &Body, animation: &mut Option<usize>) {
    let current = animation.and_then(|index| body.animations().get(index));
    let text = current.map_or("at rest", |(name, _)| name.as_str());
    egui::ComboBox::from_id_salt(("animation", number)).selected_text(text).width(180.0).show_ui(ui, |ui| {
        for (index, (name, seconds)) in body.animations().iter().enumerate() {
            ui.selectable_value(animation, Some(index), format!("{name}  {seconds:.1} s"));
        }
        ui.selectable_value(animation, None, "at rest");
    });
}

/// The buttons below the list, and a choice of the files' cameras.
fn scene_and_camera(ui: &mut egui::Ui, viewer: &mut Viewer) {
    if ui.small_button("Next scene").on_hover_text("built-in scenes and your files in turn (N)").clicked() {
        viewer.handle(Event::Acted(Action::NextScene));
    }
    if ui.small_button("Show all").on_hover_text("reset the camera (R)").clicked() {
        viewer.handle(Event::Acted(Action::ResetCamera));
    }
    let cameras = viewer.cameras();
    if cameras.is_empty() {
        return;
    }
    let current = cameras.iter().find(|(_, orbit)| *orbit == viewer.orbit);
    let text = current.map_or("camera", |(name, _)| name.as_str());
    egui::ComboBox::from_id_salt("camera").selected_text(text).width(110.0).show_ui(ui, |ui| {
        for (name, orbit) in &cameras {
            ui.selectable_value(&mut viewer.orbit, *orbit, name);
        }
    });
}

/// A number with its thousands apart.
pub(super) fn grouped(number: usize) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    #[test]
    fn thousands_are_apart() {
        assert_eq!([1, 999, 1000, 1_234_567].map(super::grouped), ["1", "999", "1,000", "1,234,567"]);
    }
}
