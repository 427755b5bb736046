//! Files beside a glTF: which may be read, and reading them within the budget.

use std::fs::File;
use std::io::{Error, ErrorKind, Read};
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use percent_encoding::percent_decode_str;

use super::budget::Budget;
use super::container;
use super::error::GltfError;
use super::json::shorten;

/// Where to look for the files that a glTF names.
#[derive(Clone, Copy)]
pub(super) struct Folder<'a> {
    /// The folder. `None`: no file is read.
    pub(super) path: Option<&'a Path>,
    /// Whether files outside the folder are read, too.
    pub(super) allow_outside: bool,
}

impl Folder<'_> {
    /// The file that a relative URI names. A symbolic link in the folder may lead out of it, so the path returned is
    /// the one that the system resolved.
    pub(super) fn find(&self, uri: &str, place: &dyn Fn() -> String) -> Result<PathBuf, GltfError> {
        let refuse = |problem| GltfError::Uri { place: place(), uri: shorten(uri), problem };
        let outside = |path| Err(GltfError::Outside { place: place(), uri: shorten(uri), path });
        let relative = relative(uri).map_err(refuse)?;
        let leaves = leaves(&relative);
        if leaves && !self.allow_outside {
            return outside(relative);
        }
        let folder =
            self.path.ok_or_else(|| refuse("names a file, but the glTF was given without a folder to look in"))?;
        // The folder of `model.gltf` is the empty path.
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let named = folder.join(relative);
        if self.allow_outside {
            return Ok(named);
        }
        let resolve = |path: &Path| {
            path.canonicalize().map_err(|source| GltfError::Read { path: path.to_owned(), source: Arc::new(source) })
        };
        let resolved = resolve(&named)?;
        if resolved.starts_with(resolve(folder)?) { Ok(resolved) } else { outside(resolved) }
    }
}

/// The path that a URI names, relative to the folder of the glTF.
fn relative(uri: &str) -> Result<PathBuf, &'static str> {
    let scheme = uri.split(['/', '?', '#', '%']).next().unwrap_or_default();
    if scheme.contains(':') || uri.starts_with("//") {
        return Err("is an absolute URI, and only files are read; put the file beside the glTF");
    }
    let decoded = percent_decode_str(uri).decode_utf8().map_err(|_| "is no UTF-8 once decoded")?;
    let path = PathBuf::from(&*decoded);
    let named = path.components().any(|component| matches!(component, Component::Normal(_)));
    if named { Ok(path) } else { Err("names no file") }
}

/// Whether a path leaves the folder where it starts, judged by its names alone.
fn leaves(path: &Path) -> bool {
    let mut depth = 0_usize;
    for component in path.components() {
        match component {
            Component::Normal(_) => depth += 1,
            Component::CurDir => {}
            Component::ParentDir if depth > 0 => depth -= 1,
            Component::ParentDir | Component::RootDir | Component::Prefix(_) => return true,
        }
    }
    false
}

/// The JSON of a GLB file, and the file's length. `None` for any other file, and for a GLB that is damaged there: whoever
/// reads the whole file says what is wrong with it.
pub(super) fn glb_json(path: &Path, budget: &Budget) -> Result<Option<(Vec<u8>, u64)>, GltfError> {
    let Ok(metadata) = std::fs::metadata(path) else { return Ok(None) };
    if !metadata.is_file() {
        return Ok(None);
    }
    let Ok(mut file) = File::open(path) else { return Ok(None) };
    let mut start = [0; container::START_BYTES];
    if file.read_exact(&mut start).is_err() {
        return Ok(None);
    }
    let json_bytes = container::json_bytes(&start).filter(|&bytes| bytes <= metadata.len());
    let Some(json_bytes) = json_bytes else { return Ok(None) };
    budget.charge_file(json_bytes, &|| path.display().to_string())?;
    let mut json = Vec::new();
    let is_read =
        json.try_reserve_exact(json_bytes as usize).is_ok() && file.take(json_bytes).read_to_end(&mut json).is_ok();
    Ok((is_read && json.len() as u64 == json_bytes).then_some((json, metadata.len())))
}

/// Reads at most `most` bytes of a regular file. It never reads a device or a pipe, which may have no end.
pub(super) fn read(path: &Path, most: u64, budget: &Budget) -> Result<Vec<u8>, GltfError> {
    let failed = |source| GltfError::Read { path: path.to_owned(), source: Arc::new(source) };
    let metadata = std::fs::metadata(path).map_err(failed)?;
    if !metadata.is_file() {
        return Err(failed(Error::other("it is not a regular file")));
    }
    // A file that grows meanwhile is cut to the length that was charged.
    let length = metadata.len().min(most);
    budget.charge_file(length, &|| path.display().to_string())?;
    let mut content = Vec::new();
    content.try_reserve_exact(length as usize).map_err(|_| failed(ErrorKind::OutOfMemory.into()))?;
    let file = File::open(path).map_err(failed)?;
    file.take(length).read_to_end(&mut content).map_err(failed)?;
    Ok(content)
}
