//! The viewer in a window of the desktop.

mod app;
mod error;
mod files;
mod surface;

use std::path::PathBuf;

pub use error::DesktopError;
pub use files::{Loaded, Loader, load_gltf};

use crate::state::viewer::Viewer;

/// How the window begins.
#[derive(Debug)]
pub struct DesktopOptions {
    /// Files to open. None: a built-in scene is shown.
    pub files: Vec<PathBuf>,
    /// Width and height of the window in pixels.
    pub size: [u32; 2],
    /// A part of the adapter's name, or nothing for any.
    pub device: Option<String>,
    /// Reads files.
    pub loader: Loader,
    /// Where screenshots go.
    pub pictures: PathBuf,
}

impl Default for DesktopOptions {
    /// A built-in scene at 1280 × 800 on any device. Reads glTF. Screenshots go to the current folder.
    fn default() -> Self {
        Self { files: Vec::new(), size: [1280, 800], device: None, loader: load_gltf, pictures: PathBuf::from(".") }
    }
}

/// Runs the viewer until its window closes.
///
/// # Errors
/// [`DesktopError`] if there is no display, or nothing that can draw onto it.
pub fn run(options: DesktopOptions) -> Result<(), DesktopError> {
    let viewer = Viewer::new(crate::scenes::walking_figure()?);
    app::run(options, viewer)
}
