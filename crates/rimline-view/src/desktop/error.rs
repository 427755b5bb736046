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
