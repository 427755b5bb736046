//! Reading buffers back, for headless tools and tests; no stage does.

/// Why a buffer cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The buffer was made without `COPY_SRC`.
    #[error("the buffer to read lacks usage COPY_SRC")]
    NotCopySource,
    /// The device was lost or refused the mapping.
    #[error("the device did not hand back {bytes} bytes: {message}")]
    Device {
        /// Bytes asked for.
        bytes: u64,
        /// What the device said.
        message: String,
    },
}

/// Copies `buffer` to the CPU in pieces and hands each to `take`, in order. Waits for the device.
///
/// # Errors
/// [`ReadError`] when the buffer may not be copied or the device is lost.
pub fn read_back(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    buffer: &wgpu::Buffer,
    mut take: impl FnMut(&[u8]),
) -> Result<(), ReadError> {
    const PIECE: u64 = 16 << 20;
    if !buffer.usage().contains(wgpu::BufferUsages::COPY_SRC) {
        return Err(ReadError::NotCopySource);
    }
    let staging = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("read_back"),
        size: buffer.size().min(PIECE),
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut begin = 0;
    while begin < buffer.size() {
        let bytes = (buffer.size() - begin).min(PIECE);
        let failed = |message: String| ReadError::Device { bytes, message };
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("read_back") });
        encoder.copy_buffer_to_buffer(buffer, begin, &staging, 0, bytes);
        queue.submit([encoder.finish()]);
        let (sender, receiver) = std::sync::mpsc::channel();
        staging.slice(..bytes).map_async(wgpu::MapMode::Read, move |result| {
            // The receiver is there until the answer came.
            let _ = sender.send(result);
        });
        device.poll(wgpu::PollType::wait_indefinitely()).map_err(|error| failed(error.to_string()))?;
        let mapped = receiver.recv().map_err(|error| failed(error.to_string()))?;
        mapped.map_err(|error| failed(error.to_string()))?;
        take(&staging.slice(..bytes).get_mapped_range().map_err(|error| failed(error.to_string()))?);
        staging.unmap();
        begin += bytes;
    }
    Ok(())
}

/// A whole buffer as items; a remainder shorter than an item is left out.
///
/// # Errors
/// As [`read_back`].
pub fn read_back_vec<T: bytemuck::Pod>(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    buffer: &wgpu::Buffer,
) -> Result<Vec<T>, ReadError> {
    let mut items: Vec<T> = Vec::with_capacity(buffer.size() as usize / size_of::<T>());
    let mut rest: Vec<u8> = Vec::new();
    read_back(device, queue, buffer, |bytes| {
        let begin = if rest.is_empty() { 0 } else { (size_of::<T>() - rest.len()).min(bytes.len()) };
        rest.extend_from_slice(&bytes[..begin]);
        if rest.len() == size_of::<T>() {
            items.push(bytemuck::pod_read_unaligned(&rest));
            rest.clear();
        }
        let whole = bytes[begin..].chunks_exact(size_of::<T>());
        rest.extend_from_slice(whole.remainder());
        items.extend(whole.map(bytemuck::pod_read_unaligned::<T>));
    })?;
    Ok(items)
}
