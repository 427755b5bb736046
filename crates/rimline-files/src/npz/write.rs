//! Writing archives that are the same bytes for the same arrays.

use std::io::{self, Seek, SeekFrom, Write};

use rimline::Origin;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, System, ZipWriter};

use super::header::{ElementType, Header};

/// An archive in the making: entries are stored, not compressed, in the order given, all dated 1980-01-01.
pub struct NpzWriter<W: Write + Seek> {
    zip: ZipWriter<Abandoned<W>>,
}

impl<W: Write + Seek> NpzWriter<W> {
    pub fn new(writer: W) -> Self {
        Self { zip: ZipWriter::new(Abandoned { inner: writer, is_failed: false, end: 0 }) }
    }

    /// Adds an array in C order; `write` streams exactly as many bytes as the shape has.
    pub fn array(
        &mut self,
        name: &str,
        element: ElementType,
        shape: &[usize],
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> io::Result<()> {
        let header = Header::bytes(element, shape);
        let length = header.len() + shape.iter().product::<usize>() * element.size;
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .last_modified_time(DateTime::default())
            .unix_permissions(0o644)
            .system(System::Unix)
            .large_file(u32::try_from(length).is_err());
        self.zip.start_file(format!("{name}.npy"), options)?;
        self.zip.write_all(&header)?;
        write(&mut self.zip)
    }

    /// Adds an array whose elements are there.
    pub fn slice<T: bytemuck::NoUninit>(
        &mut self,
        name: &str,
        element: ElementType,
        shape: &[usize],
        items: &[T],
    ) -> io::Result<()> {
        self.array(name, element, shape, |to| to.write_all(bytemuck::cast_slice(items)))
    }

    pub fn finish(self) -> io::Result<()> {
        self.zip.finish()?.inner.flush()
    }
}

/// Writes the array `origin`, unless the origin is zero. It is the last of an archive.
pub fn write_origin(npz: &mut NpzWriter<impl Write + Seek>, origin: Origin) -> io::Result<()> {
    if origin.is_zero() {
        return Ok(());
    }
    npz.slice("origin", ElementType::F64, &[3], &origin.to_array())
}

/// A writer that is left alone once it has failed: `ZipWriter` goes on writing when it is dropped, and prints what comes of
/// it. From then on it is at its farthest position, and takes everything.
struct Abandoned<W> {
    inner: W,
    is_failed: bool,
    end: u64,
}

impl<W: Write> Write for Abandoned<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = if self.is_failed { Ok(bytes.len()) } else { self.inner.write(bytes) };
        self.is_failed |= written.is_err();
        written
    }

    fn flush(&mut self) -> io::Result<()> {
        if self.is_failed { Ok(()) } else { self.inner.flush() }
    }
}

impl<W: Seek> Seek for Abandoned<W> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let at = if self.is_failed { Ok(self.end) } else { self.inner.seek(to) };
        self.is_failed |= at.is_err();
        self.end = at.as_ref().map_or(self.end, |&at| at.max(self.end));
        at
    }
}
