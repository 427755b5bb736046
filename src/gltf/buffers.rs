//! The bytes of a file's buffers: binary chunk, data URIs, files beside the glTF.

use std::borrow::Cow;
use std::fs::File;
use std::io::Read;
use std::path::{Component, Path, PathBuf};

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use percent_encoding::percent_decode_str;

use super::GltfError;
use super::document::{Buffer, Document};
use super::json::shorten;

/// Some exporters leave the padding out.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// Loads all buffers; `None` for one without data, which matters only where something uses it. Then checks that every
/// buffer view lies within its buffer's stated length.
pub(super) fn load<'a>(
    document: &Document,
    binary: Option<&'a [u8]>,
    base: Option<&Path>,
) -> Result<Vec<Option<Cow<'a, [u8]>>>, GltfError> {
    let buffers = document
        .buffers
        .iter()
        .enumerate()
        .map(|(index, buffer)| match (&buffer.uri, binary) {
            (Some(uri), _) => resolve(uri, index, buffer, base).map(|bytes| Some(Cow::Owned(bytes))),
            (None, Some(binary)) if index == 0 => Ok(Some(Cow::Borrowed(binary))),
            _ => Ok(None),
        })
        .collect::<Result<Vec<_>, _>>()?;
    for (index, (buffer, bytes)) in document.buffers.iter().zip(&buffers).enumerate() {
        if let Some(bytes) = bytes
            && (bytes.len() as u64) < buffer.bytes
        {
            return Err(GltfError::TooShort {
                place: format!("buffers[{index}].byteLength"),
                needed: buffer.bytes,
                available: bytes.len() as u64,
            });
        }
    }
    for (index, view) in document.views.iter().enumerate() {
        let available = document.buffers[view.buffer].bytes;
        let needed = view.offset.saturating_add(view.bytes);
        if needed > available {
            return Err(GltfError::TooShort {
                place: format!("bufferViews[{index}] (byteOffset and byteLength)"),
                needed,
                available,
            });
        }
    }
    Ok(buffers)
}

fn resolve(uri: &str, index: usize, buffer: &Buffer, base: Option<&Path>) -> Result<Vec<u8>, GltfError> {
    let refuse = |problem| GltfError::Uri { place: format!("buffers[{index}].uri"), uri: shorten(uri), problem };
    if uri.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case("data:")) {
        return data_uri(&uri[5..]).map_err(refuse);
    }
    let path = relative(uri).map_err(refuse)?;
    let base = base.ok_or_else(|| refuse("names a file, but the glTF was given without a folder to look in"))?;
    read(&base.join(path), buffer.bytes)
}

fn data_uri(rest: &str) -> Result<Vec<u8>, &'static str> {
    let (kind, data) = rest.split_once(',').ok_or("is a data URI without a comma before the data")?;
    let data: Vec<u8> = percent_decode_str(data).collect();
    if kind.to_ascii_lowercase().ends_with(";base64") {
        BASE64.decode(data).map_err(|_| "is a data URI whose base64 is damaged")
    } else {
        Ok(data)
    }
}

/// The path of a file in the glTF's folder or below.
fn relative(uri: &str) -> Result<PathBuf, &'static str> {
    let scheme = uri.split(['/', '?', '#', '%']).next().unwrap_or_default();
    if scheme.contains(':') || uri.starts_with("//") {
        return Err("is an absolute URI, and only files beside the glTF are read; put the file there");
    }
    let decoded = percent_decode_str(uri).decode_utf8().map_err(|_| "is no UTF-8 once decoded")?;
    let path = PathBuf::from(&*decoded);
    let mut named = false;
    for component in path.components() {
        match component {
            Component::Normal(_) => named = true,
            Component::CurDir => {}
            _ => return Err("leaves the glTF's folder, which is not allowed; put the file there"),
        }
    }
    if named { Ok(path) } else { Err("names no file") }
}

/// Reads at most `bytes` of a regular file: never a device or a pipe, which may have no end.
fn read(path: &Path, bytes: u64) -> Result<Vec<u8>, GltfError> {
    let failed = |source| GltfError::Read { path: path.to_owned(), source };
    if !std::fs::metadata(path).map_err(failed)?.is_file() {
        return Err(failed(std::io::Error::other("it is not a regular file")));
    }
    let mut content = Vec::new();
    let file = File::open(path).map_err(failed)?;
    file.take(bytes).read_to_end(&mut content).map_err(failed)?;
    Ok(content)
}

/// Reads a whole regular file.
pub(super) fn read_file(path: &Path) -> Result<Vec<u8>, GltfError> {
    read(path, u64::MAX)
}
