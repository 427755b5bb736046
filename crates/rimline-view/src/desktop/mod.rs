//! The viewer in a window of the desktop.

mod app;
mod error;
mod files;
mod surface;

use std::path::PathBuf;

pub use error::DesktopError;
use rimline_files::ReadOptions;

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
    /// Where screenshots go.
    pub pictures: PathBuf,
    /// How files are read, also those that are opened later. Polygons are drawn as triangles in any case.
    pub read: ReadOptions,
}

impl Default for DesktopOptions {
    /// A built-in scene at 1280 × 800 on any device. Screenshots go to the current folder.
    fn default() -> Self {
        let read = ReadOptions::default();
        Self { files: Vec::new(), size: [1280, 800], device: None, pictures: PathBuf::from("."), read }
    }
}

/// Runs the viewer until its window closes.
///
/// # Errors
/// [`DesktopError`] if there is no display, or nothing that can draw onto it.
pub fn run(options: DesktopOptions) -> Result<(), DesktopError> {
    let mut viewer = Viewer::new(crate::scenes::walking_figure()?);
    viewer.read = options.read;
    app::run(options, viewer)
}
