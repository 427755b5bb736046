//! The bytes of a file's buffers: binary chunk, data URIs, files beside the glTF.

use std::borrow::Cow;

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use percent_encoding::percent_decode_str;

use super::budget::Budget;
use super::document::{Buffer, Part};
use super::error::GltfError;
use super::files;
use super::files::Folder;
use super::json::shorten;
use super::warning::Warnings;

/// Some exporters omit the padding.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// The bytes of a buffer. One without data is `None`; it matters only where something uses it.
pub(super) type Bytes<'a> = Option<Cow<'a, [u8]>>;

/// Loads all buffers. One that cannot be read matters only where something uses it, too.
pub(super) fn load<'a>(
    buffers: &[Part<Buffer>],
    binary: Option<&'a [u8]>,
    folder: Folder<'_>,
    budget: &Budget,
    warnings: &Warnings<'_>,
) -> Result<Vec<Part<Bytes<'a>>>, GltfError> {
    let load = |(index, buffer): (usize, &Part<Buffer>)| match buffer {
        Ok(buffer) => warnings.keep(load_one(buffer, index, binary, folder, budget)),
        Err(fault) => Ok(Err(fault.clone())),
    };
    buffers.iter().enumerate().map(load).collect()
}

fn load_one<'a>(
    buffer: &Buffer,
    index: usize,
    binary: Option<&'a [u8]>,
    folder: Folder<'_>,
    budget: &Budget,
) -> Result<Bytes<'a>, GltfError> {
    let bytes = match (&buffer.uri, binary) {
        (Some(uri), _) => Cow::Owned(resolve(uri, index, buffer, folder, budget)?),
        (None, Some(binary)) if index == 0 => Cow::Borrowed(binary),
        _ => return Ok(None),
    };
    if (bytes.len() as u64) < buffer.bytes {
        return Err(GltfError::TooShort {
            place: format!("buffers[{index}].byteLength"),
            needed: buffer.bytes,
            available: bytes.len() as u64,
        });
    }
    Ok(Some(bytes))
}

fn resolve(
    uri: &str,
    index: usize,
    buffer: &Buffer,
    folder: Folder<'_>,
    budget: &Budget,
) -> Result<Vec<u8>, GltfError> {
    let place = || format!("buffers[{index}].uri");
    if uri.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case("data:")) {
        // The URI with percent signs decoded, in a list that doubles, and the bytes.
        let mark = budget.mark();
        budget.charge(uri.len() as u64, 4, &place)?;
        let bytes = data_uri(&uri[5..]);
        let bytes = bytes.map_err(|problem| GltfError::Uri { place: place(), uri: shorten(uri), problem })?;
        budget.settle(mark, 0);
        budget.charge_file(bytes.capacity() as u64, &place)?;
        return Ok(bytes);
    }
    files::read(&folder.find(uri, &place)?, buffer.bytes, budget)
}

fn data_uri(rest: &str) -> Result<Vec<u8>, &'static str> {
    let (kind, data) = rest.split_once(',').ok_or("is a data URI without a comma before the data")?;
    let data: Cow<'_, [u8]> = percent_decode_str(data).into();
    if kind.to_ascii_lowercase().ends_with(";base64") {
        BASE64.decode(data).map_err(|_| "is a data URI whose base64 is damaged")
    } else {
        Ok(data.into_owned())
    }
}
