//! The bytes of a file's buffers, and the files beside a glTF: which it names, which may be read, and reading them
//! within the budget.

use std::borrow::Cow;
use std::fs::File;
use std::io::{Error, ErrorKind, Read};
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use percent_encoding::percent_decode_str;
use serde_json::Value;

use super::budget::Budget;
use super::container;
use super::document::{Buffer, Part, checked};
use super::error::GltfError;
use super::json::shorten;
use super::warning::Warnings;

/// Gives the content of the file with a path relative to the glTF, or `None` if there is none. Paths are those of
/// [`relative`]: unchecked.
pub(super) type Given<'a> = &'a dyn Fn(&str) -> Option<Vec<u8>>;

/// Where the files are that a glTF names.
#[derive(Clone, Copy)]
pub(super) enum Beside<'a> {
    Given(Given<'a>),
    Folder(Folder<'a>),
}

impl<'a> Beside<'a> {
    /// The folder, if there is one.
    pub(super) fn folder(&self) -> Option<&'a Path> {
        if let Self::Folder(folder) = self { folder.path } else { None }
    }

    /// At most `most` bytes of the file that a relative URI names.
    fn read(
        &self,
        uri: &str,
        json_path: &dyn Fn() -> String,
        most: u64,
        budget: &Budget,
    ) -> Result<Vec<u8>, GltfError> {
        match self {
            Self::Folder(folder) => read(&folder.find(uri, json_path)?, most, budget),
            Self::Given(given) => {
                let refuse = |problem| bad_uri(uri, json_path, problem);
                let path = relative(uri).map_err(refuse)?;
                let literal = || uri.contains('%').then(|| given(uri)).flatten();
                let content = path.to_str().and_then(given).or_else(literal);
                let content = content.ok_or_else(|| refuse("names a file, but the glTF was given without it"))?;
                budget.charge_file(content.capacity() as u64, json_path)?;
                Ok(content)
            }
        }
    }
}

/// The folder of a glTF.
#[derive(Clone, Copy)]
pub(super) struct Folder<'a> {
    /// Its path. `None`: no file is read.
    pub(super) path: Option<&'a Path>,
    /// Whether files outside the folder are read, too.
    pub(super) allow_outside: bool,
}

impl Folder<'_> {
    /// The file that a relative URI names: with percent signs decoded, or as it is where only that is there. A symbolic link
    /// in the folder may lead out of it, so the path returned is the one that the system resolved.
    pub(super) fn find(&self, uri: &str, json_path: &dyn Fn() -> String) -> Result<PathBuf, GltfError> {
        let refuse = |problem| bad_uri(uri, json_path, problem);
        let outside = |path| Err(GltfError::Outside { json_path: json_path(), uri: shorten(uri), path });
        let relative = relative(uri).map_err(refuse)?;
        if !self.allow_outside && leaves(&relative) {
            return outside(relative);
        }
        let folder =
            self.path.ok_or_else(|| refuse("names a file, but the glTF was given without a folder to look in"))?;
        // The folder of `model.gltf` is the empty path.
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let named = folder.join(relative);
        // Some exporters write names as they are, with percent signs.
        let literal = Path::new(uri);
        let is_literal = !named.exists() && !leaves(literal) && folder.join(literal).exists();
        let named = if is_literal { folder.join(literal) } else { named };
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

/// The path that a URI names, relative to the folder of the glTF. It may be absolute or lead outside: see [`leaves`].
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

/// The JSON of a GLB file, and the file's length. `None` for any other file, and for a GLB that is damaged there: reading
/// the whole file gives the error.
pub(super) fn glb_json(path: &Path, budget: &Budget) -> Result<Option<(Vec<u8>, u64)>, GltfError> {
    let mut start = [0; container::START_BYTES];
    let opened = open(path).and_then(|(mut file, length)| file.read_exact(&mut start).map(|()| (file, length)));
    let Ok((file, length)) = opened else { return Ok(None) };
    let Some(bytes) = container::json_bytes(&start).filter(|&bytes| bytes <= length) else { return Ok(None) };
    budget.charge_file(bytes, &|| path.display().to_string())?;
    let json = take(file, bytes).ok().filter(|json| json.len() as u64 == bytes);
    Ok(json.map(|json| (json, length)))
}

/// Reads at most `most` bytes of a regular file.
pub(super) fn read(path: &Path, most: u64, budget: &Budget) -> Result<Vec<u8>, GltfError> {
    let failed = |source| GltfError::Read { path: path.to_owned(), source: Arc::new(source) };
    let (file, length) = open(path).map_err(failed)?;
    // A file that grows meanwhile is cut to the length that was charged.
    budget.charge_file(length.min(most), &|| path.display().to_string())?;
    take(file, length.min(most)).map_err(failed)
}

/// A regular file and its length. A device or a pipe, which may have no end, is never opened.
fn open(path: &Path) -> Result<(File, u64), Error> {
    let metadata = std::fs::metadata(path)?;
    if metadata.is_file() {
        return Ok((File::open(path)?, metadata.len()));
    }
    Err(Error::other("it is not a regular file"))
}

fn take(file: File, bytes: u64) -> Result<Vec<u8>, Error> {
    let mut content = Vec::new();
    content.try_reserve_exact(bytes as usize).map_err(|_| Error::from(ErrorKind::OutOfMemory))?;
    file.take(bytes).read_to_end(&mut content)?;
    Ok(content)
}

/// Some exporters omit the padding.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// The bytes of a buffer. One without data is `None`, which is an error only if something uses it.
pub(super) type Bytes<'a> = Option<Cow<'a, [u8]>>;

/// Loads all buffers. One that cannot be read is an error only if something uses it, too.
pub(super) fn buffers<'a>(
    buffers: &[Part<Buffer>],
    binary: Option<&'a [u8]>,
    beside: Beside<'_>,
    budget: &Budget,
    warnings: &Warnings<'_>,
) -> Result<Vec<Part<Bytes<'a>>>, GltfError> {
    let load = |(index, buffer): (usize, &Part<Buffer>)| {
        let read = checked(buffer).and_then(|buffer| bytes(buffer, index, binary, beside, budget));
        warnings.keep(read)
    };
    buffers.iter().enumerate().map(load).collect()
}

fn bytes<'a>(
    buffer: &Buffer,
    index: usize,
    binary: Option<&'a [u8]>,
    beside: Beside<'_>,
    budget: &Budget,
) -> Result<Bytes<'a>, GltfError> {
    let json_path = || format!("buffers[{index}].uri");
    let bytes = match &buffer.uri {
        Some(uri) if is_data(uri) => {
            // The URI with percent signs decoded, in a list that doubles, and the bytes.
            let mark = budget.mark();
            budget.charge(uri.len() as u64, 4, &json_path)?;
            let bytes = data_uri(uri).map_err(|problem| bad_uri(uri, &json_path, problem))?;
            budget.settle(mark, 0);
            budget.charge_file(bytes.capacity() as u64, &json_path)?;
            Cow::Owned(bytes)
        }
        Some(uri) => {
            budget.charge(path_bytes(uri), 1, &json_path)?;
            Cow::Owned(beside.read(uri, &json_path, buffer.bytes, budget)?)
        }
        None => match binary.filter(|_| index == 0) {
            Some(binary) => Cow::Borrowed(binary),
            None => return Ok(None),
        },
    };
    let available = bytes.len() as u64;
    if available < buffer.bytes {
        return Err(GltfError::too_short(format!("buffers[{index}].byteLength"), buffer.bytes, available));
    }
    Ok(Some(bytes))
}

/// Bytes for the path that a URI names, if it has no data: decoded in a list that doubles, and quoted by an error.
pub(super) fn path_bytes(uri: &str) -> u64 {
    if is_data(uri) { 0 } else { 4 * uri.len() as u64 }
}

fn is_data(uri: &str) -> bool {
    uri.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case("data:"))
}

/// A URI that is not read. It is quoted, shortened.
fn bad_uri(uri: &str, json_path: &dyn Fn() -> String, problem: &str) -> GltfError {
    GltfError::invalid(json_path(), format!(": {:?} {problem}", shorten(uri)))
}

fn data_uri(uri: &str) -> Result<Vec<u8>, &'static str> {
    let (kind, data) = uri.split_once(',').ok_or("is a data URI without a comma before the data")?;
    let data: Cow<'_, [u8]> = percent_decode_str(data).into();
    if kind.to_ascii_lowercase().ends_with(";base64") {
        BASE64.decode(data).map_err(|_| "is a data URI whose base64 is damaged")
    } else {
        Ok(data.into_owned())
    }
}

/// All files that a glTF names, in no order: buffers, images, and what extensions name by a `uri`. They need not exist.
/// Absolute URIs count as names.
pub(super) fn named(json: &Value, base: Option<&Path>, budget: &Budget) -> Result<Vec<PathBuf>, GltfError> {
    let Some(base) = base else { return Ok(Vec::new()) };
    let (mut files, mut rest) = (Vec::new(), vec![json]);
    while let Some(value) = rest.pop() {
        match value {
            Value::Array(values) => rest.extend(values),
            Value::Object(object) => {
                rest.extend(object.values());
                if let Some(Value::String(uri)) = object.get("uri") {
                    add(&mut files, uri, base, budget)?;
                }
            }
            _ => {}
        }
    }
    Ok(files)
}

fn add(files: &mut Vec<PathBuf>, uri: &str, base: &Path, budget: &Budget) -> Result<(), GltfError> {
    if is_data(uri) {
        return Ok(());
    }
    // Two paths and the decoded URI, in lists that double.
    let longest = base.as_os_str().len() + uri.len();
    budget.charge(longest as u64, 8, &|| "the files that the JSON names".to_owned())?;
    let decoded = percent_decode_str(uri).decode_utf8_lossy();
    // Some exporters write names as they are, with percent signs.
    if decoded != uri {
        files.push(base.join(uri));
    }
    files.push(base.join(&*decoded));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn buffers_pictures_and_extensions() {
        let json: Value = serde_json::from_str(
            r#"{"buffers": [{"uri": "a.bin"}, {"uri": "data:;base64,AA"}, {}], "images": [{"uri": "b%20c.png"}],
                "extensions": {"X": {"sounds": [{"uri": "../d.mp3"}]}}, "extras": {"uri": 5}}"#,
        )
        .expect("it is JSON");
        let budget = Budget::new(u64::MAX);
        let mut files = named(&json, Some(Path::new("m")), &budget).expect("no limit");
        files.sort();
        assert_eq!(files, ["m/../d.mp3", "m/a.bin", "m/b c.png", "m/b%20c.png"].map(PathBuf::from));
        assert!(named(&json, None, &budget).expect("no limit").is_empty());
    }
}
