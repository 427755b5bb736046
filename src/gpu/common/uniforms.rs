//! Uniforms: tables of structs. Dispatches select an entry by a dynamic offset.

use bytemuck::Pod;

use super::device_error::DeviceError;
use super::memory::{STAGING, any_error, filled, mapped, write_mapped};

/// The alignment of dynamic offsets of uniforms. It works on every device.
const ALIGNMENT: usize = 256;

/// A table of equal structs during construction.
#[derive(Debug, Default)]
pub(crate) struct UniformTable {
    bytes: Vec<u8>,
}

impl UniformTable {
    /// Bytes from one entry to the next.
    pub(crate) const fn stride<T>() -> usize {
        size_of::<T>().next_multiple_of(ALIGNMENT)
    }

    /// Adds an entry and returns its dynamic offset.
    pub(crate) fn push<T: Pod>(&mut self, entry: &T) -> u32 {
        let offset = self.bytes.len();
        self.bytes.extend_from_slice(bytemuck::bytes_of(entry));
        self.bytes.resize(offset + Self::stride::<T>(), 0);
        offset as u32
    }

    pub(crate) fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// A uniform buffer with the table.
    pub(crate) fn into_buffer(self, device: &wgpu::Device, label: &'static str) -> wgpu::Buffer {
        filled(device, label, &self.bytes, wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST)
    }
}

/// Records that each target begins with its contents from here on. Commands recorded before still see the old content, so an
/// encoder may hold several uses of a buffer. Records nothing if the device is lost, or without targets. Contents are whole
/// words.
pub(crate) fn upload(
    device: &wgpu::Device,
    encoder: &mut wgpu::CommandEncoder,
    targets: &[(&wgpu::Buffer, &[u8])],
) -> Result<(), DeviceError> {
    if targets.is_empty() {
        return Ok(());
    }
    let contents: Vec<&[u8]> = targets.iter().map(|(_, contents)| *contents).collect();
    let bytes: usize = contents.iter().map(|part| part.len()).sum();
    let make = || mapped(device, "upload", bytes as u64, STAGING);
    let staging = any_error(device, make).map_err(|message| DeviceError::Refused { message })?;
    if !write_mapped(&staging, &contents) {
        return Err(DeviceError::Lost);
    }
    let mut at = 0;
    for (target, contents) in targets {
        let bytes = contents.len() as u64;
        encoder.copy_buffer_to_buffer(&staging, at, target, 0, bytes);
        at += bytes;
    }
    Ok(())
}
