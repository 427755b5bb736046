//! Times, counters, memory.

use std::collections::VecDeque;

use super::models::grouped;
use super::{HISTORY, style};
use crate::renderer::Renderer;
use crate::state::viewer::Viewer;

pub(super) fn show(ui: &mut egui::Ui, viewer: &mut Viewer, renderer: &Renderer, history: &VecDeque<f32>) {
    style::heading(ui, "Figures");
    plot(ui, history);
    let counters = renderer.counters();
    let line = |ui: &mut egui::Ui, what: &str, text: String| {
        ui.horizontal(|ui| {
            ui.colored_label(style::DIM, what);
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| ui.monospace(text));
        });
    };
    if let Some(scene) = &counters.scene {
        let count = |number: u32| grouped(number as usize);
        line(ui, "faces tested, untested", format!("{}, {}", count(scene.faces), count(scene.untested_faces)));
        line(ui, "edges tested, untested", format!("{}, {}", count(scene.edges), count(scene.untested_edges)));
        line(ui, "pairs, cached", format!("{}, {}", count(scene.pairs), count(scene.cached_pairs)));
        line(ui, "pairs out of range", count(scene.pairs_culled_by_range));
        line(ui, "models not needed", count(scene.culled_casters));
    }
    if let Some(shadow) = &counters.shadow {
        let pairs = counters.scene.as_ref().map_or(0, |scene| scene.pairs);
        let [drawn, skipped] =
            [pairs.saturating_sub(shadow.skipped), shadow.skipped].map(|count| grouped(count as usize));
        line(ui, "shadows drawn, skipped", format!("{drawn}, {skipped}"));
        let [culled, ended] = [shadow.culled_by_receivers, shadow.ended].map(|count| grouped(count as usize));
        line(ui, "without a receiver, ended", format!("{culled}, {ended}"));
        line(ui, "with near caps", grouped(shadow.near_capped as usize));
        line(ui, "lists cached", grouped(shadow.cached_lists as usize));
    }
    let mebibytes = |bytes: u64| format!("{:.1} MiB", bytes as f64 / f64::from(1 << 20));
    line(ui, "textures and models", mebibytes(counters.bytes));
    if let Some(bytes) = counters.device_bytes {
        line(ui, "all on the device", mebibytes(bytes));
    }
    if renderer.has_timer() {
        ui.checkbox(&mut viewer.options.timing, "time the stages on the device");
    } else {
        ui.colored_label(style::DIM, "This device measures no times.");
    }
    match &counters.stages {
        Some(Ok(times)) => {
            line(ui, "all stages", format!("{:.2} ms", times.span_ms));
            for (stage, ms) in &times.stages {
                line(ui, stage, format!("{ms:.2} ms"));
            }
        }
        Some(Err(why)) => _ = ui.colored_label(style::DIM, format!("No times: {why}")),
        None => {}
    }
    ui.add_space(6.0);
    let gpu = renderer.gpu();
    let software = if gpu.is_software { ", software" } else { "" };
    ui.colored_label(style::DIM, format!("{}{software}", gpu.name));
}

/// Frame times, the newest at the right, with lines at 16.7 and 100 ms.
fn plot(ui: &mut egui::Ui, history: &VecDeque<f32>) {
    let (rect, _) = ui.allocate_exact_size(egui::vec2(ui.available_width(), 54.0), egui::Sense::hover());
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 4.0, ui.visuals().extreme_bg_color);
    let most = history.iter().copied().fold(20.0, f32::max) * 1.15;
    let height = |ms: f32| rect.bottom() - ms / most * rect.height();
    for ms in [16.7, 100.0] {
        if ms < most {
            let stroke = egui::Stroke::new(1.0, egui::Color32::from_gray(60));
            painter.hline(rect.x_range(), height(ms), stroke);
        }
    }
    let step = rect.width() / (HISTORY - 1) as f32;
    let point = |(number, &ms): (usize, &f32)| egui::pos2(rect.right() - number as f32 * step, height(ms));
    let points: Vec<_> = history.iter().enumerate().map(point).collect();
    painter.line(points, egui::Stroke::new(1.5, style::ACCENT));
    let mut recent: Vec<f32> = history.iter().take(20).copied().collect();
    recent.sort_by(f32::total_cmp);
    // The median: the first frames of a view make pipelines.
    let text = match recent.get(recent.len() / 2) {
        Some(ms) => format!("{ms:.1} ms, {:.1} frames a second", 1e3 / ms),
        None => "frame times appear while something moves".to_owned(),
    };
    let font = egui::FontId::proportional(11.0);
    painter.text(rect.left_top() + egui::vec2(6.0, 4.0), egui::Align2::LEFT_TOP, text, font, style::DIM);
}
