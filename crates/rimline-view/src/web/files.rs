//! Files that are dropped on the page or chosen. They never leave the machine.

use std::collections::BTreeMap;
use std::io;
use std::path::Path;

use rimline_files::{File, FileError, ReadOptions, read_slices};
use wasm_bindgen_futures::{JsFuture, spawn_local};
use web_sys::FileList;

use super::page::words;

/// The most bytes that a file may have, and that reading it may take: a page has 4 GiB in all.
const MOST: u32 = 1 << 30;

/// Endings of files that lie beside a glTF and are no models: buffers, and textures, which are not needed.
const BESIDE: [&str; 7] = ["bin", "glbin", "png", "jpg", "jpeg", "webp", "ktx2"];

/// Reads files one after the other, and gives each to `take`. Those that lie beside a glTF are its buffers.
pub(super) fn read_each(list: &FileList, take: impl Fn(&str, Result<File, FileError>) + 'static) {
    // The browser empties the list when its event is over.
    let files: Vec<web_sys::File> = (0..list.length()).filter_map(|index| list.get(index)).collect();
    let has_gltf = files.iter().any(|file| ending(&file.name()) == "gltf");
    let (beside, models): (Vec<_>, Vec<_>) =
        files.into_iter().partition(|file| has_gltf && BESIDE.contains(&&*ending(&file.name())));
    spawn_local(async move {
        // All buffers together are bounded, too.
        let (mut buffers, mut left) = (BTreeMap::new(), f64::from(MOST));
        for file in beside.iter().filter(|file| ending(&file.name()).ends_with("bin")) {
            match content(file, left).await {
                Ok(bytes) => {
                    left -= bytes.len() as f64;
                    buffers.insert(file.name(), bytes);
                }
                Err(error) => take(&file.name(), Err(error)),
            }
        }
        for file in &models {
            let name = file.name();
            take(&name, read(file, &name, &buffers).await);
        }
    });
}

fn ending(name: &str) -> String {
    name.rsplit_once('.').map_or_else(String::new, |(_, ending)| ending.to_ascii_lowercase())
}

async fn read(file: &web_sys::File, name: &str, buffers: &BTreeMap<String, Vec<u8>>) -> Result<File, FileError> {
    let bytes = content(file, f64::from(MOST)).await?;
    let options = ReadOptions { memory_limit: u64::from(MOST), ..ReadOptions::default() };
    // The page knows names, not folders.
    let find = |path: &str| buffers.get(path.rsplit('/').next().unwrap_or(path)).cloned();
    read_slices(&bytes, Some(Path::new(name)), &find, &options)
}

async fn content(file: &web_sys::File, most: f64) -> Result<Vec<u8>, FileError> {
    if file.size() > most {
        let who = if most < f64::from(MOST) { "it and the buffers before it have" } else { "it has" };
        let reason = format!("{who} more than 1 GiB, which is too much for a page; `rimline view` opens it");
        return Err(io::Error::other(reason).into());
    }
    let content = JsFuture::from(file.array_buffer()).await.map_err(|error| io::Error::other(words(&error)))?;
    Ok(js_sys::Uint8Array::new(&content).to_vec())
}
