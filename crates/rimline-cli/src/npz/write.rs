//! Writing archives that are the same bytes for the same arrays.

use std::io::{self, Seek, Write};

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, System, ZipWriter};

use super::header::{ElementType, Header};

/// An archive in the making: entries are stored, not compressed, in the order given, all dated 1980-01-01.
pub(crate) struct NpzWriter<W: Write + Seek> {
    zip: ZipWriter<W>,
}

impl<W: Write + Seek> NpzWriter<W> {
    pub(crate) fn new(writer: W) -> Self {
        Self { zip: ZipWriter::new(writer) }
    }

    /// Adds an array in C order; `write` streams exactly as many bytes as the shape has.
    pub(crate) fn array(
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
        let mut counted = Counted { inner: &mut self.zip, written: header.len() };
        write(&mut counted)?;
        if counted.written == length {
            Ok(())
        } else {
            Err(io::Error::other(format!("array `{name}` came to {} bytes instead of {length}", counted.written)))
        }
    }

    pub(crate) fn finish(self) -> io::Result<()> {
        self.zip.finish()?.flush()
    }
}

struct Counted<'a, W: Write> {
    inner: &'a mut W,
    written: usize,
}

impl<W: Write> Write for Counted<'_, W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.inner.write(bytes)?;
        self.written += written;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}
