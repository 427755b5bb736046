//! The viewer of Rimline: models with exact shadows of lights that are dragged on the picture.
//!
//! [`Viewer`] is the state, plain data that [`Event`]s change. [`Renderer`] draws it into a texture of its own, and [`Panel`]
//! is the user interface around that texture, by egui. None of them knows windows, files, threads or clocks, so all of it runs
//! in tests without a display, and in a browser. `desktop` (a feature, on by default) is the window: `rimline view` runs it.
//! `web` is the page, on wasm32: `cargo xtask web` builds it. Overlays show silhouettes, volumes, caps, edges, clusters,
//! receivers and boxes.
//!
//! ```no_run
//! use rimline_view::{Event, Gpu, Renderer, Viewer};
//!
//! # fn picture(gpu: Gpu) -> Result<(), Box<dyn std::error::Error>> {
//! let mut viewer = Viewer::new(rimline_view::scenes::walking_figure()?);
//! let mut renderer = Renderer::new(gpu)?;
//! viewer.handle(Event::Resized([1280, 800]));
//! renderer.draw(&viewer)?; // into `renderer.texture()`, a pixel of which is `renderer.step()` pixels wide
//! assert!(!renderer.is_stale(&viewer)); // nothing changed, so nothing is to be drawn
//! # Ok(()) }
//! ```

#![forbid(unsafe_code)]

#[cfg(all(feature = "desktop", not(target_arch = "wasm32")))]
pub mod desktop;
mod panel;
#[cfg(any(test, target_arch = "wasm32"))]
mod pointer;
mod renderer;
pub mod scenes;
mod state;
#[cfg(target_arch = "wasm32")]
pub mod web;

pub use panel::{Panel, PanelOutput};
pub use renderer::{Counters, Gpu, Picture, RenderError, Renderer};
pub use rimline_picture::{Bounds, Mode};
pub use state::body::{Body, BodyError, Report, Source};
pub use state::camera::{Camera, Orbit};
pub use state::clock::Clock;
pub use state::event::{Button, Event, Modifiers};
pub use state::handle::Handle;
pub use state::keys::{Action, KEYS, KeyBinding};
pub use state::lamp::{Lamp, LampKind};
pub use state::options::{Counting, Options, Overlays, Skipping};
pub use state::viewer::{Message, Request, Tone, Viewer};
