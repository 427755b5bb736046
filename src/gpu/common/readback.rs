//! Reads buffers back, for tools and tests without a window. No stage does.

use std::ops::Range;

use super::device_error::DeviceError;
use super::download::{Download, wait};

/// The largest size of one copy, in bytes.
const PIECE: u64 = 16 << 20;

/// Copies `buffer` to the CPU in pieces and gives each piece to `take`, in order. It waits for the device. In browsers
/// nothing may wait; use [`read_back_async`] there.
///
/// Commands reach whole words of 4 bytes, so nothing is in the one to three bytes behind the last word of a buffer whose
/// size is no multiple of 4. They are left out.
///
/// # Errors
/// [`DeviceError`] when the buffer lacks `COPY_SRC`, the device is lost or refuses the copy, or the platform cannot wait.
pub fn read_back(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    buffer: &wgpu::Buffer,
    mut take: impl FnMut(&[u8]),
) -> Result<(), DeviceError> {
    // The next piece is copied after `take` has this one, so only one piece is in memory twice.
    for range in pieces(buffer, buffer.size(), PIECE)? {
        wait(device, Download::new(device, queue, buffer, range)?)?.hand_to(&mut take)?;
    }
    Ok(())
}

/// Copies `buffer` to the CPU as [`read_back`] does, without waiting. The future is ready when `take` has every piece.
/// The copy is submitted before this function returns, so later submissions may write the buffer. Until the future is
/// ready, the copy takes as much memory as the buffer.
///
/// On native platforms somebody must poll the device meanwhile: call [`wgpu::Device::poll`] with
/// [`wgpu::PollType::Poll`] from any thread, or [`wgpu::Queue::submit`]. Browsers poll by themselves.
///
/// `queue` must be the queue of `device`. wgpu does not tell which device a queue belongs to.
///
/// ```no_run
/// # use rimline::gpu::{DeviceError, read_back_vec_async};
/// # async fn counts(device: &wgpu::Device, queue: &wgpu::Queue, counts: &wgpu::Buffer) -> Result<(), DeviceError> {
/// let counts: Vec<u32> = read_back_vec_async(device, queue, counts).await?;
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// [`DeviceError`] when the buffer lacks `COPY_SRC`, or the device is lost or refuses the copy.
pub fn read_back_async<F: FnMut(&[u8])>(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    buffer: &wgpu::Buffer,
    mut take: F,
) -> impl Future<Output = Result<(), DeviceError>> + use<F> {
    // The copy is submitted here and not at the first poll, so it reads the current content of the buffer.
    let downloads = downloads(device, queue, buffer, PIECE);
    async move {
        for download in downloads? {
            download.await?.hand_to(&mut take)?;
        }
        Ok(())
    }
}

/// Reads the words of a buffer, as [`read_back`] does, as items. A remainder that is shorter than an item is dropped. It
/// waits for the device; [`read_back_vec_async`] does not.
///
/// # Errors
/// The errors of [`read_back`].
pub fn read_back_vec<T: bytemuck::Pod>(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    buffer: &wgpu::Buffer,
) -> Result<Vec<T>, DeviceError> {
    read_back_first(device, queue, buffer, buffer.size())
}

/// Reads the first `end` bytes of a buffer, which are in it, as [`read_back_vec`] does.
pub(crate) fn read_back_first<T: bytemuck::Pod>(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    buffer: &wgpu::Buffer,
    end: u64,
) -> Result<Vec<T>, DeviceError> {
    let mut items = room_for(end);
    // The next piece is copied after this one was read, so only one piece is in memory twice.
    for range in pieces(buffer, end, piece_of::<T>())? {
        wait(device, Download::new(device, queue, buffer, range)?)?.hand_to(&mut |bytes| append(&mut items, bytes))?;
    }
    Ok(items)
}

/// Reads a whole buffer as [`read_back_vec`] does, without waiting. [`read_back_async`] says who polls.
///
/// # Errors
/// The errors of [`read_back_async`].
pub fn read_back_vec_async<T: bytemuck::Pod>(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    buffer: &wgpu::Buffer,
) -> impl Future<Output = Result<Vec<T>, DeviceError>> + use<T> {
    let downloads = downloads(device, queue, buffer, piece_of::<T>());
    let mut items = room_for(buffer.size());
    async move {
        for download in downloads? {
            download.await?.hand_to(&mut |bytes| append(&mut items, bytes))?;
        }
        Ok(items)
    }
}

/// Submits the copies of a whole buffer.
fn downloads(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    buffer: &wgpu::Buffer,
    piece: u64,
) -> Result<Vec<Download>, DeviceError> {
    pieces(buffer, buffer.size(), piece)?.map(|range| Download::new(device, queue, buffer, range)).collect()
}

/// The ranges of bytes that are copied one by one, of the whole words before `end`.
fn pieces(
    buffer: &wgpu::Buffer,
    end: u64,
    piece: u64,
) -> Result<impl Iterator<Item = Range<u64>> + use<>, DeviceError> {
    if !buffer.usage().contains(wgpu::BufferUsages::COPY_SRC) {
        return Err(DeviceError::NotCopySource);
    }
    let end = end / wgpu::COPY_BUFFER_ALIGNMENT * wgpu::COPY_BUFFER_ALIGNMENT;
    Ok((0..end).step_by(piece as usize).map(move |begin| begin..end.min(begin + piece)))
}

/// The largest size of one copy of items: whole items and whole words.
fn piece_of<T>() -> u64 {
    let step = 4 * size_of::<T>() as u64;
    if step == 0 || step > PIECE { PIECE.max(step) } else { PIECE / step * step }
}

/// Room for the items in a buffer of `bytes`.
fn room_for<T>(bytes: u64) -> Vec<T> {
    Vec::with_capacity((bytes as usize).checked_div(size_of::<T>()).unwrap_or(0))
}

/// Appends the items of a piece. There are none of a type without a size.
fn append<T: bytemuck::Pod>(items: &mut Vec<T>, bytes: &[u8]) {
    if size_of::<T>() > 0 {
        items.extend(bytes.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned::<T>));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_hold_whole_items_and_whole_words() {
        assert_eq!([piece_of::<u8>(), piece_of::<u32>(), piece_of::<[u32; 16]>()], [PIECE; 3]);
        assert_eq!([piece_of::<[u8; 3]>(), piece_of::<[u32; 3]>()], [PIECE - 4, PIECE - 16]);
        assert_eq!([piece_of::<[u32; 5 << 20]>(), piece_of::<()>()], [80 << 20, PIECE]);
    }

    #[test]
    fn items_are_appended_without_a_remainder() {
        let mut items = room_for::<[u8; 3]>(8);
        append(&mut items, &[1, 2, 3, 4, 5, 6, 7, 8]);
        assert_eq!(items, [[1, 2, 3], [4, 5, 6]]);
        let mut items = room_for::<()>(8);
        append(&mut items, &[1, 2, 3]);
        assert!(items.is_empty());
    }
}
