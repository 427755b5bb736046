//! Buffers. All sizes are summed and checked before the first buffer is made.

use std::future::Future;
use std::pin::pin;
use std::task::{Context, Poll, Waker};

pub use super::device_error::Allocation;
use super::device_error::DeviceError;

/// Checks the sizes of buffers before any is made. Returns their sum.
pub(crate) fn check(
    allocations: &[Allocation],
    buffer_limit: u64,
    memory_limit: Option<u64>,
) -> Result<u64, DeviceError> {
    if let Some(&Allocation { label, bytes }) = allocations.iter().find(|allocation| allocation.bytes > buffer_limit) {
        return Err(DeviceError::BufferTooLarge { label, bytes, limit: buffer_limit });
    }
    let bytes = allocations.iter().map(|allocation| allocation.bytes).sum();
    if let (Some(limit), Some(&largest)) = (memory_limit, allocations.iter().max_by_key(|allocation| allocation.bytes))
        && bytes > limit
    {
        return Err(DeviceError::MemoryLimit { bytes, limit, largest });
    }
    Ok(bytes)
}

/// Checks the sizes of arrays that are bound as a whole.
pub(crate) fn check_bindings<'a>(
    allocations: impl IntoIterator<Item = &'a Allocation>,
    limit: u64,
) -> Result<(), DeviceError> {
    match allocations.into_iter().find(|allocation| allocation.bytes > limit) {
        Some(&Allocation { label, bytes }) => Err(DeviceError::BindingTooLarge { what: label, bytes, limit }),
        None => Ok(()),
    }
}

/// Runs `make`, which makes buffers of `bytes` in all. Running out of memory is an error.
pub(crate) fn guarded<T>(device: &wgpu::Device, bytes: u64, make: impl FnOnce() -> T) -> Result<T, DeviceError> {
    scoped(device, wgpu::ErrorFilter::OutOfMemory, make).map_err(|message| DeviceError::OutOfMemory { bytes, message })
}

/// Runs `make` and returns the device's errors of one kind, in the device's words. A browser answers later than a
/// function that does not wait can return. There the error goes to the device's own handler.
pub(crate) fn scoped<T>(
    device: &wgpu::Device,
    filter: wgpu::ErrorFilter,
    make: impl FnOnce() -> T,
) -> Result<T, String> {
    // Nobody waits for the answer of this scope, so the scope would swallow the error.
    if cfg!(target_family = "wasm") {
        return Ok(make());
    }
    let scope = device.push_error_scope(filter);
    let made = make();
    // The answer is ready at once on native backends.
    match pin!(scope.pop()).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(Some(error)) => Err(error.to_string()),
        _ => Ok(made),
    }
}

/// Runs `make` and returns the device's errors of any kind. Browsers behave as for [`scoped`].
pub(crate) fn any_error<T>(device: &wgpu::Device, make: impl FnOnce() -> T) -> Result<T, String> {
    use wgpu::ErrorFilter::{Internal, OutOfMemory, Validation};
    let made = scoped(device, Internal, || scoped(device, OutOfMemory, || scoped(device, Validation, make)));
    made.and_then(|made| made).and_then(|made| made)
}

/// A buffer of [`padded`] bytes.
pub(crate) fn buffer(
    device: &wgpu::Device,
    label: &'static str,
    bytes: u64,
    usage: wgpu::BufferUsages,
) -> wgpu::Buffer {
    let (label, size) = (Some(label), padded(bytes));
    device.create_buffer(&wgpu::BufferDescriptor { label, size, usage, mapped_at_creation: false })
}

/// A buffer that begins with `contents`, which are whole words.
pub(crate) fn filled(
    device: &wgpu::Device,
    label: &'static str,
    contents: &[u8],
    usage: wgpu::BufferUsages,
) -> wgpu::Buffer {
    let buffer = mapped(device, label, contents.len() as u64, usage);
    // This fails only if the buffer could not be made. The error scope around it reports that, and the next encode
    // reports that the device is lost.
    write_mapped(&buffer, &[contents]);
    buffer
}

/// A buffer of [`padded`] bytes, for [`write_mapped`].
pub(crate) fn mapped(
    device: &wgpu::Device,
    label: &'static str,
    bytes: u64,
    usage: wgpu::BufferUsages,
) -> wgpu::Buffer {
    let (label, size) = (Some(label), padded(bytes));
    device.create_buffer(&wgpu::BufferDescriptor { label, size, usage, mapped_at_creation: true })
}

/// The usage of a buffer that is written once, to copy from. Without `MAP_WRITE` wgpu maps another buffer, which it copies
/// to this one at the next submission.
pub(crate) const STAGING: wgpu::BufferUsages = wgpu::BufferUsages::COPY_SRC.union(wgpu::BufferUsages::MAP_WRITE);

/// Writes `contents`, one after the other, to the beginning of a mapped buffer, and unmaps it. Each is of whole words.
/// Returns whether the buffer was mapped; no buffer of a lost device is.
pub(crate) fn write_mapped(buffer: &wgpu::Buffer, contents: &[&[u8]]) -> bool {
    let bytes: usize = contents.iter().map(|part| part.len()).sum();
    match buffer.slice(..bytes as u64).get_mapped_range_mut() {
        Ok(mut view) => {
            let mut at = 0;
            for part in contents {
                view.slice(at..at + part.len()).copy_from_slice(part);
                at += part.len();
            }
        }
        Err(_) => return false,
    }
    buffer.unmap();
    true
}

/// The size that a buffer of `bytes` takes: whole words, at least four.
pub(crate) fn padded(bytes: u64) -> u64 {
    bytes.next_multiple_of(4).max(16)
}
