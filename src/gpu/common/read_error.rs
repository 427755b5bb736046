//! Why buffers cannot be read back.

/// Why a buffer cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The buffer was made without `COPY_SRC`.
    #[error("the buffer to read lacks usage COPY_SRC")]
    NotCopySource,
    /// The device was lost or refused the copy or the mapping: it lacks the memory, say, or the buffer is of
    /// another device or destroyed.
    #[error("the device did not hand back {bytes} bytes: {message}")]
    Device {
        /// Bytes asked for.
        bytes: u64,
        /// What the device said.
        message: String,
    },
    /// No thread of a browser may wait for the device.
    #[error("this platform does not wait for the device; await `read_back_async` or `StageTimer::read_async` instead")]
    CannotWait,
}
