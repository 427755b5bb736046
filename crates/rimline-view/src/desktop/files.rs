//! Files: what is opened, and where screenshots go.

use std::path::{Path, PathBuf};

/// The name of a file without its folders.
pub(super) fn name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// A name in a folder that no file has yet.
pub(super) fn free_name(folder: &Path) -> PathBuf {
    let names = (1..).map(|number| folder.join(format!("rimline-{number}.png")));
    names.into_iter().find(|path| !path.exists()).unwrap_or_else(|| folder.join("rimline.png"))
}
