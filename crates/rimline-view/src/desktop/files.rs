//! Files: what is opened, and where screenshots go.

use std::path::{Path, PathBuf};

use rimline::Origin;
use rimline_files::{ReadOptions, read, settle};

use crate::state::body::{Body, BodyError};

/// Reads a file, relative to the origin of models that are shown already, or else to one that it needs. Returns the origin, too.
pub(super) fn load(path: &Path, origin: Option<Origin>) -> Result<(Body, Origin), BodyError> {
    let mut file = read(path, &ReadOptions::default())?;
    match origin {
        Some(origin) => file.move_to(origin)?,
        None => _ = settle(&mut [(&mut file, &[])], 0.0).map_err(|(_, error)| error)?,
    }
    let origin = file.origin();
    Ok((Body::new(&name(path), Some(path.display().to_string()), file)?, origin))
}

/// The name of a file without its folders.
pub(super) fn name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// A name in a folder that no file has yet.
pub(super) fn free_name(folder: &Path) -> PathBuf {
    let names = (1..).map(|number| folder.join(format!("rimline-{number}.png")));
    names.into_iter().find(|path| !path.exists()).unwrap_or_else(|| folder.join("rimline.png"))
}
