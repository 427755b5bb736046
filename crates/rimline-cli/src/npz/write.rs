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
        Self { zip: ZipWriter::new(Abandoned { inner: writer, is_failed: false, at: 0, end: 0 }) }
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
        let mut counted = Counted { inner: &mut self.zip, written: header.len() };
        write(&mut counted)?;
        if counted.written == length {
            Ok(())
        } else {
            Err(io::Error::other(format!("array `{name}` came to {} bytes instead of {length}", counted.written)))
        }
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

/// A writer that is left alone once it has failed: `ZipWriter` goes on writing when it is dropped, and prints what comes of
/// it. From then on only positions are kept, as if all were well.
struct Abandoned<W> {
    inner: W,
    is_failed: bool,
    at: u64,
    end: u64,
}

impl<W> Abandoned<W> {
    fn unless_failed<T>(&mut self, run: impl FnOnce(&mut W) -> io::Result<T>) -> io::Result<Option<T>> {
        if self.is_failed {
            return Ok(None);
        }
        let done = run(&mut self.inner);
        self.is_failed = done.is_err();
        done.map(Some)
    }
}

impl<W: Write> Write for Abandoned<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.unless_failed(|inner| inner.write(bytes))?.unwrap_or(bytes.len());
        self.at += written as u64;
        self.end = self.end.max(self.at);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.unless_failed(W::flush).map(Option::unwrap_or_default)
    }
}

impl<W: Seek> Seek for Abandoned<W> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let kept = match to {
            SeekFrom::Start(at) => Some(at),
            SeekFrom::Current(by) => self.at.checked_add_signed(by),
            SeekFrom::End(by) => self.end.checked_add_signed(by),
        };
        let at = self.unless_failed(|inner| inner.seek(to))?.or(kept);
        self.at = at.ok_or(io::ErrorKind::InvalidInput)?;
        Ok(self.at)
    }
}
