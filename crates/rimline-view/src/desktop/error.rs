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
        "none of these can draw onto this display: {found}; open the window on a display of the GPU's own, or on Linux install \
         a driver that draws onto any, such as mesa-vulkan-drivers; `rimline shadow` draws to a file on all of them"
    )]
    NoAdapter {
        /// Adapters that were found, or those of them that have the name that was asked for.
        found: String,
    },
    /// The device was lost, and the new one soon afterwards.
    #[error("the device was lost twice: what is shown may take it too long; try a smaller model or another device")]
    LostAgain,
    /// The device cannot draw, or refused something.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// A built-in scene cannot be made.
    #[error(transparent)]
    Body(#[from] BodyError),
}

#[cfg(test)]
mod tests {
    use super::DesktopError;

    #[test]
    fn devices_that_cannot_present_are_not_called_missing() {
        let said = DesktopError::NoAdapter { found: "GeForce (Vulkan)".into() }.to_string();
        assert!(said.starts_with("none of these can draw onto this display: GeForce (Vulkan); "), "{said}");
        assert!(!said.contains("no GPU"), "{said}");
    }
}
