//! The two forms of a glTF file: JSON text, or a GLB with a JSON chunk and a binary chunk.
//!
//! `Glb` of the `gltf` crate is not used. It subtracts without checking, takes chunks beyond the length that the header
//! states, and refuses chunk types that readers must ignore.

use super::error::GltfError;

const MAGIC: &[u8] = b"glTF";
const HEADER_BYTES: usize = 12;
const CHUNK_HEADER_BYTES: usize = 8;

/// The JSON text, and the binary chunk if there is one.
pub(super) fn split(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), GltfError> {
    if !bytes.starts_with(MAGIC) {
        return Ok((bytes, None));
    }
    let version = word(bytes, 4)?;
    if version != 2 {
        return Err(GltfError::Version { version: version.to_string() });
    }
    let length = word(bytes, 8)? as usize;
    let content = bytes
        .get(..length)
        .ok_or_else(|| damaged(8, &format!("the header states {length} bytes, there are {}", bytes.len())))?;
    let json = chunk(content, HEADER_BYTES)?;
    if &json.kind != b"JSON" {
        return Err(damaged(HEADER_BYTES, "the first chunk is not JSON"));
    }
    let (mut binary, mut offset) = (None, json.end);
    while offset < content.len() {
        let Chunk { kind, data, end } = chunk(content, offset)?;
        if &kind == b"BIN\0" && binary.is_none() {
            binary = Some(data);
        }
        offset = end;
    }
    Ok((json.data, binary))
}

/// The bytes before the JSON of a GLB.
pub(super) const START_BYTES: usize = HEADER_BYTES + CHUNK_HEADER_BYTES;

/// The length of the JSON of a GLB that starts like this. `None` if it is none that [`split`] takes.
pub(super) fn json_bytes(start: &[u8; START_BYTES]) -> Option<u64> {
    let is_known = start.starts_with(MAGIC) && word(start, 4).ok()? == 2 && start.ends_with(b"JSON");
    is_known.then(|| word(start, HEADER_BYTES).ok().map(u64::from)).flatten()
}

/// The text without zero bytes at its end, and their number. Some exporters pad with them instead of spaces.
pub(super) fn unpadded(json: &[u8]) -> (&[u8], usize) {
    let is_space = |byte: &u8| matches!(byte, 0 | b' ' | b'\t' | b'\r' | b'\n');
    let end = json.iter().rposition(|byte| !is_space(byte)).map_or(0, |last| last + 1);
    let (text, padding) = json.split_at(end);
    let zeros = padding.split(|byte| *byte == 0).count() - 1;
    if zeros == 0 { (json, 0) } else { (text, zeros) }
}

/// A chunk of a GLB.
struct Chunk<'a> {
    /// Its type.
    kind: [u8; 4],
    data: &'a [u8],
    /// The offset of the next chunk.
    end: usize,
}

fn chunk(content: &[u8], offset: usize) -> Result<Chunk<'_>, GltfError> {
    let length = word(content, offset)? as usize;
    let kind = word(content, offset + 4)?.to_le_bytes();
    let start = offset + CHUNK_HEADER_BYTES;
    let data = content.get(start..).and_then(|rest| rest.get(..length)).ok_or_else(|| {
        let there = content.len().saturating_sub(start);
        damaged(offset, &format!("the chunk states {length} bytes, there are {there}"))
    })?;
    Ok(Chunk { kind, data, end: start + length })
}

fn word(bytes: &[u8], offset: usize) -> Result<u32, GltfError> {
    bytes
        .get(offset..)
        .and_then(|rest| rest.first_chunk())
        .map(|word| u32::from_le_bytes(*word))
        .ok_or_else(|| damaged(offset, "the GLB ends inside a header"))
}

fn damaged(offset: usize, problem: &str) -> GltfError {
    let problem = format!(": {problem}; the file is cut short or damaged, export it again");
    GltfError::invalid(format!("GLB, byte {offset}"), problem)
}
