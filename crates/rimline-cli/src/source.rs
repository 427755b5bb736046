//! Input files. They are regular files, or standard input as `-`: a pipe or device given by name may never end.

use std::fs::{File, Metadata};
use std::io::{self, BufReader, Cursor, Read, Seek};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use rimline_files::open_regular;

const MAX_STDIN_BYTES: u64 = 1 << 32;

/// A seekable reader, which archives need.
pub(crate) trait ReadSeek: Read + Seek {}

impl<T: Read + Seek> ReadSeek for T {}

pub(crate) fn is_stdin(file: &Path) -> bool {
    file.as_os_str() == "-"
}

pub(crate) fn open(file: &Path) -> io::Result<Box<dyn ReadSeek>> {
    if is_stdin(file) {
        return Ok(Box::new(Cursor::new(stdin()?)));
    }
    Ok(Box::new(BufReader::with_capacity(1 << 18, open_regular(file)?)))
}

pub(crate) fn read(file: &Path) -> io::Result<Vec<u8>> {
    if is_stdin(file) {
        return stdin();
    }
    let mut bytes = Vec::new();
    open_regular(file)?.read_to_end(&mut bytes)?;
    Ok(bytes)
}

pub(crate) fn read_text(file: &Path) -> io::Result<String> {
    String::from_utf8(read(file)?).map_err(|_| io::Error::other("it is not UTF-8 text"))
}

/// The input's metadata. For `-` it is the metadata of standard input: a file, a pipe or a terminal.
pub(crate) fn metadata(file: &Path) -> io::Result<Metadata> {
    #[cfg(unix)]
    if is_stdin(file) {
        use std::os::fd::AsFd;
        return File::from(io::stdin().as_fd().try_clone_to_owned()?).metadata();
    }
    std::fs::metadata(file)
}

fn stdin() -> io::Result<Vec<u8>> {
    static IS_TAKEN: AtomicBool = AtomicBool::new(false);
    if IS_TAKEN.swap(true, Ordering::SeqCst) {
        return Err(io::Error::other("standard input is already another input; `-` can be given once"));
    }
    let mut bytes = Vec::new();
    io::stdin().lock().take(MAX_STDIN_BYTES + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > MAX_STDIN_BYTES {
        return Err(io::Error::other("standard input holds more than 4 GiB; write it to a file"));
    }
    if bytes.is_empty() {
        return Err(io::Error::other("it is empty"));
    }
    Ok(bytes)
}
