//! The window's events.

use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::{StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop, EventLoopProxy};
use winit::window::{Window, WindowId};

use super::files::{name, save};
use super::surface::{Next, Screen};
use super::{DesktopError, DesktopOptions};
use crate::panel::Panel;
use crate::renderer::Renderer;
use crate::state::event::Event;
use crate::state::viewer::{Request, Viewer};

/// A dialog that ends sooner was never shown.
const LEAST_DIALOG: Duration = Duration::from_millis(300);
/// A new device that is lost sooner cannot do what it is asked for, and the next one could not.
const LEAST_DEVICE: Duration = Duration::from_secs(10);

pub(super) fn run(options: DesktopOptions, mut viewer: Viewer) -> Result<(), DesktopError> {
    if !options.pictures.is_dir() {
        return Err(DesktopError::NoFolder(options.pictures));
    }
    let is_read = |file: &PathBuf| open(&mut viewer, file);
    let are_read: Vec<bool> = options.files.iter().map(is_read).collect();
    if !are_read.is_empty() && !are_read.contains(&true) {
        return Err(DesktopError::NoFile);
    }
    let events = EventLoop::<Chosen>::with_user_event();
    let events = { events }.build().map_err(|error| DesktopError::NoDisplay(reason(&error.to_string())))?;
    let proxy = events.create_proxy();
    let mut app = App {
        options,
        viewer,
        proxy,
        shown: None,
        clipboard: None,
        error: None,
        wake_at: None,
        renewed_at: None,
        is_dropping: false,
    };
    events.run_app(&mut app).map_err(|error| DesktopError::Window(error.to_string()))?;
    app.error.map_or(Ok(()), Err)
}

/// Opens a file, or prints why it cannot be opened; the viewer says so, too.
fn open(viewer: &mut Viewer, path: &Path) -> bool {
    let file = rimline_files::read(path, &viewer.read);
    let error = viewer.open(&name(path), path.display().to_string(), file);
    if let Some(error) = &error {
        // Names may have characters that steer a terminal. Nobody may be there to read.
        let _ = writeln!(io::stderr(), "rimline: {}", error.replace(char::is_control, "\u{fffd}"));
    }
    error.is_none()
}

/// The message of winit, without the line of its source.
fn reason(error: &str) -> String {
    let said = error.strip_prefix("os error at ").and_then(|rest| rest.split_once(".rs:")?.1.split_once(": "));
    said.map_or(error, |(_, said)| said).trim_end_matches('.').to_owned()
}

/// Files that a dialog was closed with. `None`: there was no dialog.
type Chosen = Option<Vec<PathBuf>>;

/// The files that were chosen. `None`: there is no dialog.
fn chosen(files: Option<Vec<PathBuf>>, took: Duration) -> Chosen {
    // The library tells a dialog that nobody can show as one that was closed; nobody closes one so fast.
    files.or_else(|| (took >= LEAST_DIALOG).then(Vec::new))
}

struct App {
    options: DesktopOptions,
    viewer: Viewer,
    proxy: EventLoopProxy<Chosen>,
    shown: Option<Shown>,
    /// On X11 the text is gone with whoever put it there.
    clipboard: Option<arboard::Clipboard>,
    error: Option<DesktopError>,
    /// When the panel wants to be run again.
    wake_at: Option<Instant>,
    /// When the last new device was made, after another was lost.
    renewed_at: Option<Instant>,
    /// Whether files were dropped since the last frame.
    is_dropping: bool,
}

/// A window that is open. Fields are dropped in this order.
struct Shown {
    renderer: Renderer,
    panel: Panel,
    input: egui_winit::State,
    screen: Screen,
    titled: String,
}

/// The title of the window.
fn title(viewer: &Viewer) -> String {
    match viewer.bodies.as_slice() {
        [body] => format!("{} – Rimline", body.name),
        [body, rest @ ..] if !viewer.is_built_in() => format!("{} and {} more – Rimline", body.name, rest.len()),
        _ => "Rimline".to_owned(),
    }
}

impl Shown {
    fn new(events: &ActiveEventLoop, options: &DesktopOptions) -> Result<Self, DesktopError> {
        let [width, height] = options.size;
        let attributes = Window::default_attributes()
            .with_title("Rimline")
            .with_inner_size(PhysicalSize::new(width, height))
            .with_min_inner_size(PhysicalSize::new(480, 320));
        let window = events.create_window(attributes).map_err(|error| DesktopError::Window(error.to_string()))?;
        Self::on(&Arc::new(window), options)
    }

    /// Makes everything that depends on the device.
    fn on(window: &Arc<Window>, options: &DesktopOptions) -> Result<Self, DesktopError> {
        let screen = Screen::open(Arc::clone(window), options.device.as_deref())?;
        let panel = Panel::new(&screen.gpu, screen.format());
        let renderer = Renderer::new(screen.gpu.clone())?;
        let most = screen.gpu.device.limits().max_texture_dimension_2d as usize;
        let scale = Some(window.scale_factor() as f32);
        let context = panel.context().clone();
        let input = egui_winit::State::new(context, egui::ViewportId::ROOT, &**window, scale, None, Some(most));
        Ok(Self { renderer, panel, input, screen, titled: String::new() })
    }
}

impl App {
    fn copy(&mut self, line: &str) -> Result<(), arboard::Error> {
        if self.clipboard.is_none() {
            self.clipboard = Some(arboard::Clipboard::new()?);
        }
        self.clipboard.as_mut().map_or(Ok(()), |clipboard| clipboard.set_text(line))
    }

    fn redraw(&self) {
        if let Some(shown) = &self.shown {
            shown.screen.window.request_redraw();
        }
    }

    /// Ends with an error.
    fn fail(&mut self, events: &ActiveEventLoop, error: DesktopError) {
        self.error = Some(error);
        events.exit();
    }

    fn paint(&mut self) -> Result<(), DesktopError> {
        let Self { viewer, shown: Some(shown), options, .. } = self else { return Ok(()) };
        if shown.screen.gpu.is_lost() {
            if self.renewed_at.is_some_and(|at| at.elapsed() < LEAST_DEVICE) {
                return Err(DesktopError::LostAgain);
            }
            // Another device, or the same one again; the state stays.
            let window = Arc::clone(&shown.screen.window);
            self.shown = None;
            let shown = Shown::on(&window, options)?;
            viewer.handle(Event::Message("the device was lost; everything was made anew".into()));
            (self.shown, self.renewed_at) = (Some(shown), Some(Instant::now()));
            self.redraw();
            return Ok(());
        }
        // wgpu panics where a surface that it refused is asked for a texture.
        shown.screen.gpu.check()?;
        let Shown { renderer, panel, input, screen, titled } = shown;
        let texture = match screen.next()? {
            Next::Texture(texture) => texture,
            Next::Occluded => return Ok(()),
            Next::Again => {
                screen.window.request_redraw();
                return Ok(());
            }
        };
        let window = Arc::clone(&screen.window);
        let title = title(viewer);
        if *titled != title {
            window.set_title(&title);
            *titled = title;
        }
        let raw = input.take_egui_input(&window);
        let output = panel.run(raw, viewer, renderer);
        input.handle_platform_output(&window, output.platform.clone());
        let view = texture.texture.create_view(&wgpu::TextureViewDescriptor::default());
        panel.paint(&screen.gpu, &view, screen.size(), &output);
        window.pre_present_notify();
        screen.gpu.queue.present(texture);
        screen.gpu.check()?;
        if output.repaint_after.is_zero() || screen.gpu.is_lost() {
            window.request_redraw();
        } else {
            self.wake_at = Instant::now().checked_add(output.repaint_after);
        }
        Ok(())
    }

    /// Does what the viewer asked for.
    fn fulfil(&mut self, events: &ActiveEventLoop) {
        for request in std::mem::take(&mut self.viewer.requests) {
            match request {
                Request::Close => events.exit(),
                Request::Copy(line) => {
                    let how = if self.copy(&line).is_ok() { "copied" } else { "no clipboard; printed" };
                    // Nobody may be there to read.
                    let _ = writeln!(io::stdout(), "{line}");
                    self.viewer.handle(Event::Copied(how.into(), line));
                }
                Request::Screenshot { scale } => {
                    let said = self.screenshot(scale);
                    self.viewer.handle(match said {
                        Ok(path) => Event::Message(format!("wrote {}", path.display())),
                        Err(why) => Event::Opened(Err(("the screenshot".into(), why))),
                    });
                }
                Request::OpenFiles => self.ask_for_files(),
            }
            self.redraw();
        }
    }

    fn screenshot(&mut self, scale: u32) -> Result<PathBuf, String> {
        let shown = self.shown.as_mut().ok_or("no window is open")?;
        let picture = shown.renderer.screenshot(&self.viewer, scale).map_err(|error| error.to_string())?;
        // The copy ends only while somebody polls the device.
        let polled = shown.screen.gpu.device.poll(wgpu::PollType::wait_indefinitely());
        polled.map_err(|error| error.to_string())?;
        let picture = pollster::block_on(picture).map_err(|error| error.to_string())?;
        save(&self.options.pictures, &picture.png().map_err(|error| error.to_string())?)
    }

    /// Shows the dialog of the system on a thread of its own, where the system allows that: the window goes on.
    fn ask_for_files(&self) {
        let proxy = self.proxy.clone();
        let ask = move || {
            let begin = Instant::now();
            let files = rfd::FileDialog::new().set_title("Open models").pick_files();
            // The window may be closed by now.
            let _ = proxy.send_event(chosen(files, begin.elapsed()));
        };
        if cfg!(target_os = "macos") {
            ask();
        } else {
            let begun = std::thread::Builder::new().name("dialog".into()).spawn(ask);
            if begun.is_err() {
                let _ = self.proxy.send_event(None);
            }
        }
    }
}

impl ApplicationHandler<Chosen> for App {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.shown.is_some() {
            return;
        }
        match Shown::new(events, &self.options) {
            Ok(shown) => self.shown = Some(shown),
            Err(error) => return self.fail(events, error),
        }
        self.redraw();
    }

    fn user_event(&mut self, _: &ActiveEventLoop, files: Chosen) {
        self.viewer.handle(Event::Answered);
        if let Some(files) = files {
            if !files.is_empty() {
                self.viewer.handle(Event::Opening);
            }
            for file in &files {
                _ = open(&mut self.viewer, file);
            }
        } else {
            let instead = "no file dialog here; drop files on the window, or under Wayland name them in the command";
            self.viewer.handle(Event::Message(instead.into()));
        }
        self.redraw();
    }

    fn new_events(&mut self, _: &ActiveEventLoop, _: StartCause) {
        if self.wake_at.take_if(|at| *at <= Instant::now()).is_some() {
            self.redraw();
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(shown) = &mut self.shown else { return };
        match &event {
            WindowEvent::CloseRequested => return events.exit(),
            WindowEvent::Resized(size) => {
                shown.screen.resize(size.width, size.height);
                shown.screen.window.request_redraw();
            }
            // egui hears of it, too, or it would wait for the file that it saw coming, and ask for frames meanwhile.
            // winit tells of dropped files under X11, on Windows and macOS, not under Wayland.
            WindowEvent::DroppedFile(path) => {
                // Files that are dropped together come one by one, with no frame between them.
                if !std::mem::replace(&mut self.is_dropping, true) {
                    self.viewer.handle(Event::Opening);
                }
                open(&mut self.viewer, path);
            }
            WindowEvent::RedrawRequested => {
                self.is_dropping = false;
                if let Err(error) = self.paint() {
                    return self.fail(events, error);
                }
                return self.fulfil(events);
            }
            _ => {}
        }
        if shown.input.on_window_event(&shown.screen.window, &event).repaint {
            shown.screen.window.request_redraw();
        }
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        events.set_control_flow(self.wake_at.map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
    }

    fn exiting(&mut self, _: &ActiveEventLoop) {
        // The device goes before the display does.
        self.shown = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dialog_that_ends_at_once_was_never_shown() {
        let files = Some(vec![PathBuf::from("a.obj")]);
        assert_eq!(chosen(None, Duration::from_millis(40)), None);
        assert_eq!(chosen(None, Duration::from_secs(2)), Some(Vec::new()));
        assert_eq!(chosen(files.clone(), Duration::ZERO), files);
    }

    #[test]
    fn no_path_of_a_source_is_said() {
        let said = "os error at winit/src/linux/mod.rs:765: neither WAYLAND_DISPLAY nor DISPLAY is set.";
        assert_eq!(reason(said), "neither WAYLAND_DISPLAY nor DISPLAY is set");
        assert_eq!(reason("the event loop cannot be made again"), "the event loop cannot be made again");
    }
}
