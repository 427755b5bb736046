//! The planner of buffers.

use super::device_error::DeviceError;
use super::memory::{Allocation, buffer, check_bindings, filled, padded};
use super::uniforms::UniformTable;

/// A buffer to make, with all its properties. A subject lists its buffers once, in a function
/// that runs twice, first to sum them in an [`Account`], then to make them.
#[derive(Clone, Copy)]
pub(crate) struct Wanted<'a> {
    pub(crate) label: &'static str,
    pub(crate) bytes: u64,
    usage: wgpu::BufferUsages,
    /// The contents, unless the buffer begins with zeros.
    contents: Option<&'a [u8]>,
    /// It is bound as a whole.
    is_whole: bool,
    /// It is too small to count, so no sum or limit has it.
    is_free: bool,
}

impl<'a> Wanted<'a> {
    /// A storage buffer that stages write.
    pub(crate) fn new(label: &'static str, bytes: u64) -> Self {
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
        Self { label, bytes, usage, contents: None, is_whole: false, is_free: false }
    }

    /// A storage buffer with contents.
    pub(crate) fn filled(label: &'static str, contents: &'a [u8]) -> Self {
        Self { contents: Some(contents), ..Self::new(label, contents.len() as u64) }
    }

    /// A table of uniforms.
    pub(crate) fn uniforms(label: &'static str, table: &'a UniformTable) -> Self {
        let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        Self { usage, ..Self::filled(label, table.bytes()) }
    }

    /// One uniform, which is written later.
    pub(crate) fn uniform(label: &'static str, bytes: usize) -> Self {
        let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        Self { usage, ..Self::new(label, bytes as u64) }
    }

    /// The same with another size. A buffer with contents keeps the size of these.
    pub(crate) fn sized(self, bytes: u64) -> Self {
        Self { bytes, ..self }
    }

    /// It has indirect draws or dispatches, too.
    pub(crate) fn indirect(self) -> Self {
        Self { usage: self.usage | wgpu::BufferUsages::INDIRECT, ..self }
    }

    /// It has vertices, too.
    pub(crate) fn vertices(self) -> Self {
        Self { usage: self.usage | wgpu::BufferUsages::VERTEX, ..self }
    }

    /// It is bound as a whole, if so.
    pub(crate) fn whole_if(self, is_whole: bool) -> Self {
        Self { is_whole, ..self }
    }

    /// It is too small to count: no sum and no limit has it.
    pub(crate) fn free(self) -> Self {
        Self { is_free: true, ..self }
    }

    pub(crate) fn make(&self, device: &wgpu::Device) -> wgpu::Buffer {
        match self.contents {
            Some(contents) => filled(device, self.label, contents, self.usage),
            None => buffer(device, self.label, self.bytes, self.usage),
        }
    }
}

/// The buffers that a subject wants, before any is made.
#[derive(Debug, Default)]
pub(crate) struct Account {
    pub(crate) all: Vec<Allocation>,
    /// The buffers that are bound as a whole, with the bytes that are bound.
    whole: Vec<Allocation>,
}

impl Account {
    pub(crate) fn note(&mut self, wanted: &Wanted<'_>) {
        let &Wanted { label, bytes, is_whole, is_free, .. } = wanted;
        self.whole.extend(is_whole.then_some(Allocation { label, bytes }));
        self.all.extend((!is_free).then_some(Allocation { label, bytes: padded(bytes) }));
    }

    /// Checks the arrays that are bound as a whole.
    pub(crate) fn check_whole(&self, limit: u64) -> Result<(), DeviceError> {
        check_bindings(&self.whole, limit)
    }
}
