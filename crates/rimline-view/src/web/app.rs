//! The viewer on its canvas.

use std::cell::RefCell;
use std::rc::Rc;

use web_sys::{DragEvent, EventTarget, HtmlCanvasElement, HtmlElement, HtmlInputElement};

use super::page::{Page, listen, words};
use super::{WATCH, files, input};
use crate::panel::{Panel, PanelOutput};
use crate::renderer::Renderer;
use crate::scenes;
use crate::state::event::Event;
use crate::state::viewer::{Request, Viewer};

/// Seconds after which files may be asked for again in any case. A dialog that is open hears the keys itself.
const ASK_AGAIN: f64 = 5.0;

struct App {
    page: Page,
    canvas: HtmlCanvasElement,
    viewer: Viewer,
    renderer: Renderer,
    panel: Panel,
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    raw: egui::RawInput,
    screenshots: u32,
    /// How often files were asked for.
    dialogs: u32,
    /// Whether the browser is to call back for a frame.
    is_frame_coming: bool,
    /// The message that the page's own text repeats for screen readers.
    said: String,
}

type Shared = Rc<RefCell<App>>;

pub(super) async fn run(page: &Page) -> Result<(), String> {
    let canvas: HtmlCanvasElement = page.element("view")?;
    let instance = super::instance();
    let surface = instance.create_surface(wgpu::SurfaceTarget::Canvas(canvas.clone())).map_err(text)?;
    let (adapter, gpu) = super::open(page, &instance, Some(&surface)).await?;
    let mut config = surface.get_default_config(&adapter, 1, 1).ok_or("The browser's GPU cannot draw on a page")?;
    // egui encodes colours itself.
    config.format = config.format.remove_srgb_suffix();
    let app = App {
        viewer: Viewer::new(scenes::walking_figure().map_err(text)?),
        panel: Panel::new(&gpu, config.format),
        renderer: Renderer::new(gpu).map_err(text)?,
        page: page.clone(),
        canvas,
        surface,
        config,
        raw: egui::RawInput { focused: true, ..egui::RawInput::default() },
        screenshots: 0,
        dialogs: 0,
        is_frame_coming: false,
        said: String::new(),
    };
    listen_to_page(&Rc::new(RefCell::new(app)))
}

#[expect(clippy::needless_pass_by_value, reason = "it is for `map_err`")]
fn text(error: impl ToString) -> String {
    error.to_string()
}

fn listen_to_page(app: &Shared) -> Result<(), String> {
    let (page, canvas) = (app.borrow().page.clone(), app.borrow().canvas.clone());
    let heard = Rc::clone(app);
    input::listen_on(
        &canvas,
        Rc::new(move |events| {
            heard.borrow_mut().raw.events.extend_from_slice(events);
            ask_for_frame(&heard);
        }),
    );
    let (body, resized) = (EventTarget::from(page.window.clone()), Rc::clone(app));
    listen(&body, "resize", move |_: web_sys::Event| ask_for_frame(&resized));
    listen(&body, "dragover", |event: DragEvent| event.prevent_default());
    let dropped = Rc::clone(app);
    listen(&body, "drop", move |event: DragEvent| {
        event.prevent_default();
        open(&dropped, event.data_transfer().and_then(|data| data.files()).as_ref());
    });
    let chooser = page.element::<HtmlInputElement>("files")?;
    let (chosen, cancelled) = (Rc::clone(app), Rc::clone(app));
    listen(&chooser, "cancel", move |_: web_sys::Event| cancelled.borrow_mut().viewer.handle(Event::Answered));
    listen(&chooser.clone(), "change", move |_: web_sys::Event| {
        chosen.borrow_mut().viewer.handle(Event::Answered);
        open(&chosen, chooser.files().as_ref());
        // The same file may be chosen again.
        chooser.set_value("");
    });
    watch_pixels(Rc::clone(app));
    // Keys go to the viewer at once.
    let _ = canvas.focus();
    page.tell("said", "Ready. F1 lists the keys.");
    ask_for_frame(app);
    Ok(())
}

/// Opens files, or lets the viewer say why they cannot be opened.
fn open(app: &Shared, list: Option<&web_sys::FileList>) {
    let Some(list) = list else { return };
    app.borrow_mut().viewer.handle(Event::Opening);
    let app = Rc::clone(app);
    files::read_each(list, move |name, file| {
        app.borrow_mut().viewer.open(name, name.to_owned(), file);
        ask_for_frame(&app);
    });
}

/// Paints anew when a screen with other pixels shows the page, of which no event tells.
fn watch_pixels(app: Shared) {
    let page = app.borrow().page.clone();
    page.after(WATCH, move || {
        let (size, painted) = (app.borrow().pixels().0, [app.borrow().config.width, app.borrow().config.height]);
        if size != painted {
            ask_for_frame(&app);
        }
        watch_pixels(app);
    });
}

/// Lets the browser call back once for the next frame, however often this is called.
fn ask_for_frame(app: &Shared) {
    let mut this = app.borrow_mut();
    if !std::mem::replace(&mut this.is_frame_coming, true) {
        let app = Rc::clone(app);
        this.page.at_next_frame(move || {
            app.borrow_mut().is_frame_coming = false;
            let (wake, requests) = app.borrow_mut().paint();
            requests.into_iter().for_each(|request| fulfil(&app, request));
            wake_after(&app, wake);
        });
    }
}

/// Paints again after some seconds. `None`: only when something happens.
fn wake_after(app: &Shared, seconds: Option<f64>) {
    match seconds {
        None => {}
        Some(0.0) => ask_for_frame(app),
        Some(seconds) => {
            let (page, app) = (app.borrow().page.clone(), Rc::clone(app));
            page.after(seconds, move || ask_for_frame(&app));
        }
    }
}

impl App {
    /// The size that the page gives the canvas in pixels of the screen, and how many of them a point has.
    fn pixels(&self) -> ([u32; 2], f64) {
        let scale = self.page.window.device_pixel_ratio();
        let limit = f64::from(self.renderer.gpu().device.limits().max_texture_dimension_2d);
        let pixels = |side: i32| (f64::from(side) * scale).round().clamp(1.0, limit) as u32;
        ([pixels(self.canvas.client_width()), pixels(self.canvas.client_height())], scale)
    }

    /// Gives that size to canvas and surface, and returns the pixels of a point.
    fn fit(&mut self) -> f32 {
        let (size, scale) = self.pixels();
        if [self.config.width, self.config.height] != size || self.canvas.width() != size[0] {
            [self.config.width, self.config.height] = size;
            self.canvas.set_width(size[0]);
            self.canvas.set_height(size[1]);
            self.surface.configure(&self.renderer.gpu().device, &self.config);
        }
        scale as f32
    }

    /// Paints a frame, unless the device is lost. Returns the seconds after which to paint again, and the viewer's requests.
    fn paint(&mut self) -> (Option<f64>, Vec<Request>) {
        if self.renderer.gpu().is_lost() {
            return (None, Vec::new());
        }
        let scale = self.fit();
        for event in &self.raw.events {
            if let egui::Event::WindowFocused(is_focused) = event {
                self.raw.focused = *is_focused;
            }
        }
        let mut raw = self.raw.take();
        let size = egui::vec2(self.config.width as f32, self.config.height as f32) / scale;
        raw.screen_rect = Some(egui::Rect::from_min_size(egui::Pos2::ZERO, size));
        raw.time = Some(self.page.now());
        raw.max_texture_side = Some(self.renderer.gpu().device.limits().max_texture_dimension_2d as usize);
        raw.viewports.entry(egui::ViewportId::ROOT).or_default().native_pixels_per_point = Some(scale);
        let output = self.panel.run(raw, &mut self.viewer, &mut self.renderer);
        self.present(&output);
        self.speak();
        let cursor = cursor(output.platform.cursor_icon);
        let _ = HtmlElement::from(self.canvas.clone()).style().set_property("cursor", cursor);
        let is_soon = output.repaint_after < std::time::Duration::from_secs(3600);
        (is_soon.then_some(output.repaint_after.as_secs_f64()), std::mem::take(&mut self.viewer.requests))
    }

    fn present(&mut self, output: &PanelOutput) {
        use wgpu::CurrentSurfaceTexture as Current;
        // A canvas gives a texture unless its device is lost, which is noticed elsewhere.
        let (Current::Success(texture) | Current::Suboptimal(texture)) = self.surface.get_current_texture() else {
            return;
        };
        let view = texture.texture.create_view(&wgpu::TextureViewDescriptor::default());
        self.panel.paint(self.renderer.gpu(), &view, [self.config.width, self.config.height], output);
        self.renderer.gpu().queue.present(texture);
    }

    /// Writes the viewer's message into the page, for screen readers.
    fn speak(&mut self) {
        let said = self.viewer.message.as_ref().map_or_else(String::new, |message| {
            if message.details.is_empty() {
                message.text.clone()
            } else {
                format!("{}: {}", message.text, message.details)
            }
        });
        if said != self.said {
            self.page.tell("said", &said);
            self.said = said;
        }
    }
}

/// Does what the viewer asked for.
fn fulfil(app: &Shared, request: Request) {
    let page = app.borrow().page.clone();
    let event_app = Rc::clone(app);
    let tell = move |event| {
        event_app.borrow_mut().viewer.handle(event);
        ask_for_frame(&event_app);
    };
    match request {
        // The browser closes pages.
        Request::Close => {}
        Request::OpenFiles => {
            if let Ok(chooser) = page.element::<HtmlInputElement>("files") {
                chooser.click();
            }
            app.borrow_mut().dialogs += 1;
            let (asked, dialog) = (Rc::clone(app), app.borrow().dialogs);
            // A browser that shows no dialog does not say so. By then there may be a later one.
            page.after(ASK_AGAIN, move || {
                let mut app = asked.borrow_mut();
                if app.dialogs == dialog {
                    app.viewer.handle(Event::Answered);
                }
            });
        }
        Request::Copy(line) => wasm_bindgen_futures::spawn_local(async move {
            let how = if page.copy(&line).await { "copied" } else { "no clipboard; the line is here" };
            tell(Event::Copied(how.into(), line));
        }),
        Request::Screenshot { scale } => {
            let picture = {
                let App { viewer, renderer, screenshots, .. } = &mut *app.borrow_mut();
                *screenshots += 1;
                renderer.screenshot(viewer, scale).map(|picture| (format!("rimline-{screenshots}.png"), picture))
            };
            wasm_bindgen_futures::spawn_local(async move {
                let saved = async {
                    let (name, picture) = picture.map_err(text)?;
                    let bytes = picture.await.and_then(|picture| picture.png()).map_err(text)?;
                    page.download(&name, &bytes).map_err(|error| words(&error))?;
                    Ok::<_, String>(name)
                };
                tell(match saved.await {
                    Ok(name) => Event::Message(format!("saved {name}")),
                    Err(reason) => Event::Opened(Err(("the screenshot".into(), reason))),
                });
            });
        }
    }
    ask_for_frame(app);
}

/// The name that style sheets have for a cursor.
fn cursor(icon: egui::CursorIcon) -> &'static str {
    use egui::CursorIcon as Icon;
    match icon {
        Icon::PointingHand => "pointer",
        Icon::Grab => "grab",
        Icon::Grabbing => "grabbing",
        Icon::Text => "text",
        Icon::ResizeHorizontal => "ew-resize",
        _ => "default",
    }
}
