//! Why buffers cannot be read back.

/// Why a buffer cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The buffer was made without usage `COPY_SRC`.
    #[error("the buffer to read lacks usage COPY_SRC")]
    NotCopySource,
    /// The device was lost, or it refused the copy or the mapping. For example it lacks the memory, or the buffer
    /// belongs to another device or was destroyed.
    #[error("the device did not hand back {bytes} bytes: {message}")]
    Device {
        /// Bytes that were asked for.
        bytes: u64,
        /// The message of the device.
        message: String,
    },
    /// The platform is a browser, where no thread may wait for the device.
    #[error("this platform does not wait for the device; await `read_back_async` or `StageTimer::read_async` instead")]
    CannotWait,
}
