//! Files that are dropped on the page or chosen. They never leave the machine.

use std::io;
use std::path::Path;

use rimline_files::{File, FileError, ReadOptions, read_bytes};
use wasm_bindgen_futures::{JsFuture, spawn_local};
use web_sys::FileList;

use super::page::words;

/// The most bytes that a file may have, and that reading it may take: a page has 4 GiB in all.
const MOST: u32 = 1 << 30;

/// Reads files one after the other, and gives each to `take`.
pub(super) fn read_each(list: &FileList, take: impl Fn(&str, Result<File, FileError>) + 'static) {
    // The browser empties the list when its event is over.
    let files: Vec<web_sys::File> = (0..list.length()).filter_map(|index| list.get(index)).collect();
    spawn_local(async move {
        for file in files {
            let name = file.name();
            take(&name, read(&file, &name).await);
        }
    });
}

async fn read(file: &web_sys::File, name: &str) -> Result<File, FileError> {
    if file.size() > f64::from(MOST) {
        let reason = "it has more than 1 GiB, which is too much for a page; `rimline view` opens it";
        return Err(io::Error::other(reason).into());
    }
    let content = JsFuture::from(file.array_buffer()).await.map_err(|error| io::Error::other(words(&error)))?;
    let bytes = js_sys::Uint8Array::new(&content).to_vec();
    let options = ReadOptions { memory_limit: u64::from(MOST), ..ReadOptions::default() };
    read_bytes(&bytes, Some(Path::new(name)), &options)
}
