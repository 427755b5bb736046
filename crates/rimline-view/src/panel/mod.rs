//! The user interface around the picture, by egui: it makes events of what egui hears, and shows the state.

mod help;
mod lights;
mod models;
mod picture;
mod shown;
mod statistics;
mod style;
mod switches;
mod time;

use std::collections::VecDeque;
use std::time::Duration;

use egui_wgpu::ScreenDescriptor;
use shown::Shown;

use crate::renderer::{Gpu, Renderer};
use crate::state::event::Event;
use crate::state::keys::{self, Action};
use crate::state::viewer::{Message, Tone, Viewer};

/// Frame times that the plot shows.
const HISTORY: usize = 120;

/// How many seconds nothing must change before the picture is drawn once more with all samples, on software devices.
const REFINE_AFTER: f64 = 0.35;

/// The panel, the time line and the picture between them.
pub struct Panel {
    context: egui::Context,
    painter: egui_wgpu::Renderer,
    shown: Shown,
    history: VecDeque<f32>,
    last: Option<f64>,
    /// Whether the last run asked to be run again at once, so that the time since then is a frame's.
    was_busy: bool,
    /// When a picture of few samples is drawn once more. Infinite: it was tried.
    refine_at: Option<f64>,
    /// Keys that are down, by where they are if the shell knows.
    held: Vec<egui::Key>,
    /// The widget that had the keyboard in the last run.
    focused: Option<egui::Id>,
    deltas: egui::TexturesDelta,
}

/// Results of a run, to paint and to act on.
pub struct PanelOutput {
    /// Requests of egui to the shell: the cursor and the like.
    pub platform: egui::PlatformOutput,
    /// When to run again, if nothing happens before. [`Duration::MAX`]: never.
    pub repaint_after: Duration,
    primitives: Vec<egui::ClippedPrimitive>,
    pixels_per_point: f32,
}

impl Panel {
    /// A panel that is painted onto targets of this format, which is not sRGB.
    pub fn new(gpu: &Gpu, format: wgpu::TextureFormat) -> Self {
        let context = egui::Context::default();
        context.options_mut(|options| options.max_passes = std::num::NonZeroUsize::MIN);
        style::set(&context);
        let options = egui_wgpu::RendererOptions { dithering: false, ..Default::default() };
        Self {
            context,
            painter: egui_wgpu::Renderer::new(&gpu.device, format, options),
            shown: Shown::new(gpu, format),
            history: VecDeque::with_capacity(HISTORY),
            last: None,
            was_busy: false,
            refine_at: None,
            held: Vec::new(),
            focused: None,
            deltas: egui::TexturesDelta::default(),
        }
    }

    /// egui's context.
    pub fn context(&self) -> &egui::Context {
        &self.context
    }

    /// Takes what egui heard, lets the time pass, and draws the picture if it is to be another one.
    pub fn run(&mut self, mut input: egui::RawInput, viewer: &mut Viewer, renderer: &mut Renderer) -> PanelOutput {
        let time = input.time;
        if let Some(time) = time {
            let passed = self.last.replace(time).map_or(0.0, |last| (time - last) as f32);
            if self.was_busy {
                note(&mut self.history, passed);
            }
            viewer.handle(Event::Passed(passed.clamp(0.0, 0.25)));
        }
        // Open menus close with Escape, too.
        let is_for_egui = self.context.egui_wants_keyboard_input() || egui::Popup::is_any_open(&self.context);
        input.events.retain(|event| {
            let is_repeated = self.is_repeated(event);
            is_for_egui || !take_key(event, is_repeated, viewer)
        });
        let has_news = renderer.poll();
        let full = self.context.clone().run_ui(input, |ui| {
            if viewer.shows_panel {
                side_panel(ui, viewer, renderer, &self.history, &mut self.focused);
            }
            if viewer.duration() > 0.0 {
                egui::Panel::bottom("time").frame(style::strip()).show(ui, |ui| time::show(ui, viewer));
            }
            egui::CentralPanel::default().frame(egui::Frame::NONE).show(ui, |ui| picture::show(ui, viewer));
            if !viewer.shows_panel {
                error(ui.ctx(), viewer);
            }
            help::show(ui.ctx(), viewer);
        });
        let is_drawn = renderer.show(viewer);
        let refine_after = time.map_or(Duration::MAX, |time| self.refine(time, is_drawn, viewer, renderer));
        self.shown.take(renderer);
        let is_busy = viewer.is_animated() || viewer.is_dragging();
        let delay = full.viewport_output.get(&egui::ViewportId::ROOT).map_or(Duration::MAX, |v| v.repaint_delay);
        let mut repaint_after = delay.min(refine_after);
        if is_busy || has_news {
            repaint_after = Duration::ZERO;
        } else if renderer.is_waiting() {
            repaint_after = repaint_after.min(Duration::from_millis(30));
        } else if is_drawn && viewer.shows_panel {
            repaint_after = repaint_after.min(Duration::from_millis(60));
        }
        self.was_busy = is_busy;
        self.deltas.append(full.textures_delta);
        PanelOutput {
            platform: full.platform_output,
            repaint_after,
            primitives: self.context.tessellate(full.shapes, full.pixels_per_point),
            pixels_per_point: full.pixels_per_point,
        }
    }

    /// Draws a picture of few samples once more with all of them, when it has stayed for a while. Returns how long that still
    /// is.
    fn refine(&mut self, time: f64, is_drawn: bool, viewer: &Viewer, renderer: &mut Renderer) -> Duration {
        let is_coarse = renderer.is_coarse(viewer) && !viewer.is_animated();
        if is_drawn || !is_coarse {
            self.refine_at = None;
        }
        if !is_coarse {
            return Duration::MAX;
        }
        let at = *self.refine_at.get_or_insert(time + REFINE_AFTER);
        if at <= time {
            self.refine_at = Some(f64::INFINITY);
            // A picture that cannot be drawn better stays.
            let _ = renderer.refine(viewer);
            return Duration::MAX;
        }
        Duration::try_from_secs_f64(at - time).unwrap_or(Duration::MAX)
    }

    /// Notes keys that go down and up. Returns whether this is one that was down already: not every window says so.
    fn is_repeated(&mut self, event: &egui::Event) -> bool {
        match event {
            egui::Event::Key { key, physical_key, pressed, repeat, .. } => {
                let key = physical_key.unwrap_or(*key);
                let at = self.held.iter().position(|&held| held == key);
                match (at, *pressed) {
                    (None, true) => self.held.push(key),
                    (Some(at), false) => _ = self.held.swap_remove(at),
                    // It may have gone down by another name, with Shift or without.
                    (None, false) if physical_key.is_none() => self.held.clear(),
                    (None, false) | (Some(_), true) => {}
                }
                *pressed && (*repeat || at.is_some())
            }
            egui::Event::WindowFocused(_) => {
                self.held.clear();
                false
            }
            _ => false,
        }
    }

    /// Paints onto a target of this size in pixels, and submits, unless the device is lost.
    pub fn paint(&mut self, gpu: &Gpu, target: &wgpu::TextureView, size: [u32; 2], output: &PanelOutput) {
        if gpu.is_lost() {
            // egui panics where it gets no memory for copies.
            return;
        }
        let screen = ScreenDescriptor { size_in_pixels: size, pixels_per_point: output.pixels_per_point };
        for (id, deltas) in &self.deltas.set {
            for delta in deltas {
                self.painter.update_texture(&gpu.device, &gpu.queue, *id, delta);
            }
        }
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("panel") });
        let mut buffers =
            self.painter.update_buffers(&gpu.device, &gpu.queue, &mut encoder, &output.primitives, &screen);
        let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("panel"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: target,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
            })],
            depth_stencil_attachment: None,
            timestamp_writes: None,
            occlusion_query_set: None,
            multiview_mask: None,
        });
        let mut pass = pass.forget_lifetime();
        self.shown.draw(&mut pass);
        self.painter.render(&mut pass, &output.primitives, &screen);
        drop(pass);
        buffers.push(encoder.finish());
        gpu.queue.submit(buffers);
        for id in &self.deltas.free {
            self.painter.free_texture(id);
        }
        self.deltas.clear();
    }
}

impl Drop for Panel {
    fn drop(&mut self) {
        // egui panics where textures that were never painted are dropped.
        self.deltas.clear();
    }
}

/// Adds the time of a frame in seconds to the milliseconds of those before. A window that was hidden meanwhile, or a page in
/// the background, drew none.
fn note(history: &mut VecDeque<f32>, passed: f32) {
    const LONGEST: f32 = 5.0;
    if passed < LONGEST {
        history.truncate(HISTORY - 1);
        history.push_front(passed * 1e3);
    }
}

/// Lets a key do what it is for. Returns whether it is for anything.
fn take_key(event: &egui::Event, is_repeated: bool, viewer: &mut Viewer) -> bool {
    let egui::Event::Key { key, pressed: true, modifiers, .. } = event else { return false };
    let is_plain = !modifiers.ctrl && !modifiers.alt && !modifiers.mac_cmd;
    let Some(action) = keys::action(*key, modifiers.shift).filter(|_| is_plain) else { return false };
    if !is_repeated || action.is_gradual() {
        viewer.handle(Event::Acted(action));
    }
    true
}

fn side_panel(
    ui: &mut egui::Ui,
    viewer: &mut Viewer,
    renderer: &Renderer,
    history: &VecDeque<f32>,
    focused: &mut Option<egui::Id>,
) {
    egui::Panel::right("panel").exact_size(302.0).resizable(false).frame(style::panel()).show(ui, |ui| {
        egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            title(ui, viewer);
            models::show(ui, viewer);
            lights::show(ui, viewer);
            switches::show(ui, viewer);
            statistics::show(ui, viewer, renderer, history);
            follow(ui, focused);
        });
    });
}

/// Scrolls to the widget that the keyboard went to.
fn follow(ui: &egui::Ui, focused: &mut Option<egui::Id>) {
    let now = ui.ctx().memory(egui::Memory::focused);
    if std::mem::replace(focused, now) == now {
        return;
    }
    let widget = now.and_then(|id| ui.ctx().read_response(id)).filter(|widget| widget.layer_id == ui.layer_id());
    if let Some(widget) = widget {
        ui.scroll_to_rect_animation(widget.rect, None, egui::style::ScrollAnimation::none());
    }
}

fn title(ui: &mut egui::Ui, viewer: &mut Viewer) {
    ui.horizontal(|ui| {
        ui.label(egui::RichText::new("Rimline").size(18.0).strong());
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            for (text, action) in [
                ("?", Action::Help),
                ("Picture", Action::Screenshot),
                ("Copy", Action::CopyCommand),
                ("Open…", Action::OpenFile),
            ] {
                if ui.button(text).on_hover_text(keys::hint(action)).clicked() {
                    viewer.handle(Event::Acted(action));
                }
            }
        });
    });
    message(ui, viewer);
}

/// Shows an error over the picture, where there is no panel for it.
fn error(context: &egui::Context, viewer: &mut Viewer) {
    if viewer.message.as_ref().is_none_or(|message| message.tone != Tone::Error) {
        return;
    }
    let area = egui::Area::new(egui::Id::unique("error")).fixed_pos(egui::pos2(8.0, 8.0));
    area.show(context, |ui| {
        style::panel().show(ui, |ui| {
            ui.set_max_width(300.0);
            message(ui, viewer);
        });
    });
}

fn message(ui: &mut egui::Ui, viewer: &mut Viewer) {
    if let Some(Message { tone, text, details }) = viewer.message.clone() {
        let color = if tone == Tone::Error { style::ERROR } else { style::DIM };
        ui.horizontal_wrapped(|ui| {
            let label = ui.colored_label(color, text);
            if !details.is_empty() {
                label.on_hover_text(details);
            }
            if ui.small_button("×").clicked() {
                viewer.message = None;
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_out_of_sight_leaves_no_frame_time() {
        let mut history = VecDeque::new();
        for passed in [0.25, 3600.0, 0.5] {
            note(&mut history, passed);
        }
        assert_eq!(history, [500.0, 250.0]);
        (0..2 * HISTORY).for_each(|_| note(&mut history, 0.0));
        assert_eq!(history.len(), HISTORY);
    }
}
