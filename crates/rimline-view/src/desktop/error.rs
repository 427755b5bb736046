//! Why there is no window.

use crate::renderer::RenderError;
use crate::state::body::BodyError;

/// Why the window cannot be shown, or did not stay.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DesktopError {
    /// There is no display.
    #[error("there is no display to open a window on ({0}); `rimline shadow` draws the same without one, to a file")]
    NoDisplay(String),
    /// The window cannot be made.
    #[error("the window cannot be opened: {0}; `rimline shadow` draws the same without one, to a file")]
    Window(String),
    /// None of the files can be shown. What is wrong with each was printed.
    #[error("no file can be shown, so no window was opened")]
    NoFile,
    /// The folder for screenshots is no folder.
    #[error("{}: there is no such folder for screenshots; make it, or name another", .0.display())]
    NoFolder(std::path::PathBuf),
    /// There are no adapters at all.
    #[error("no GPU was found; on Linux install a Vulkan driver, such as mesa-vulkan-drivers")]
    NoGpu,
    /// No adapter has this name.
    #[error("no device has `{name}` in its name or backend; the devices are {}", .found.join(", "))]
    NotNamed {
        /// The device that was asked for.
        name: String,
        /// Adapters that were found.
        found: Vec<String>,
    },
    /// No adapter can draw onto the window.
    #[error(
        "no GPU can draw onto this display (found: {found}); on Linux install a Vulkan driver, such as mesa-vulkan-drivers; \
         `rimline shadow` draws to a file on any of them"
    )]
    NoAdapter {
        /// Adapters that were found.
        found: String,
    },
    /// The picture cannot be drawn.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// A built-in scene cannot be made.
    #[error(transparent)]
    Body(#[from] BodyError),
}
