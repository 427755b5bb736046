//! Files: what is opened, and where screenshots go.

use std::path::{Path, PathBuf};

use rimline::Origin;
use rimline::gltf::{Asset, LoadOptions};

use crate::state::body::{Body, BodyError};

/// A model of a file, and the origin that it is relative to.
pub type Loaded = (Body, Origin);

/// Reads a file. With models that are shown already, their origin is given.
pub type Loader = fn(&Path, Option<Origin>) -> Result<Loaded, BodyError>;

/// Reads glTF.
///
/// # Errors
/// [`BodyError`] if the file cannot be read or shown.
pub fn load_gltf(path: &Path, origin: Option<Origin>) -> Result<Loaded, BodyError> {
    let mut asset = Asset::open(path, LoadOptions::default())?;
    let origin = match origin {
        Some(origin) => origin,
        None => asset.suggested_origin(None, 0.0)?,
    };
    asset.set_origin(origin);
    Ok((Body::new(&name(path), Some(path.display().to_string()), asset)?, origin))
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
