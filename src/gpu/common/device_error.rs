//! Why a device, or a buffer on it, does not do.

/// A buffer that is to be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Allocation {
    /// The buffer's label.
    pub label: &'static str,
    /// Its size in bytes.
    pub bytes: u64,
}

/// Why a device cannot be used, or buffers cannot be made, bound or read.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages say what fields are")]
pub enum DeviceError {
    /// A limit of the device is too small.
    #[error(
        "{subject} needs `{limit}` of at least {needed}, and the device has {there}; request the device with \
         `required_limits: wgpu::Limits::default()`, or with this limit raised"
    )]
    Limit { subject: &'static str, limit: &'static str, needed: u64, there: u64 },
    /// An alignment of offsets of the device is too coarse.
    #[error(
        "{subject} needs `{limit}` of at most {needed}, and the device has {there}; request the device with \
         `required_limits: wgpu::Limits::default()`, or with this limit lowered"
    )]
    Alignment { subject: &'static str, limit: &'static str, needed: u64, there: u64 },
    /// The adapter lacks a downlevel flag. A device does not list these flags, so each is tried once.
    #[error(
        "{subject} needs `DownlevelFlags::{flag}`, which the adapter lacks; take another adapter or backend: {message}"
    )]
    Downlevel { subject: &'static str, flag: &'static str, message: String },
    /// The device was lost or destroyed.
    #[error("the device is lost; make a new one, and everything on it anew")]
    Lost,
    /// Objects of two devices were used together. This is found only for devices of one [`wgpu::Instance`]. For two
    /// instances wgpu cannot distinguish the objects; it panics or confuses them.
    #[error("{what} is of another device than {with}; make both on one device")]
    OtherDevice { what: &'static str, with: &'static str },
    /// The device refuses an object for no reason that limits, features or flags show.
    #[error("the device refuses what Rimline makes: {message}")]
    Refused { message: String },

    /// One buffer is larger than the `max_buffer_size` of the device.
    #[error("{label} needs {bytes} bytes in one buffer, and the device allows {limit}; split the mesh")]
    BufferTooLarge { label: &'static str, bytes: u64, limit: u64 },
    /// An array that has to be bound at once, such as the share of a single workgroup, does not fit one binding:
    /// `max_storage_buffer_binding_size` of the device.
    #[error("{what} needs {bytes} bytes in one binding, and the device allows {limit}; request a larger limit")]
    BindingTooLarge { what: &'static str, bytes: u64, limit: u64 },
    /// A gathered array needs more bindings than the shaders have.
    #[error("{what} take {bytes} bytes, and four bindings of the device hold {limit}; split the mesh")]
    GatheredTooLarge { what: &'static str, bytes: u64, limit: u64 },
    /// All buffers together exceed the caller's limit.
    #[error(
        "{bytes} bytes needed in all, {limit} allowed (`memory_limit`); the largest is {} with {} bytes",
        .largest.label, .largest.bytes
    )]
    MemoryLimit { bytes: u64, limit: u64, largest: Allocation },
    /// The device ran out of memory. The buffers that had been made are freed.
    #[error("the device has no room for {bytes} bytes: {message}")]
    OutOfMemory { bytes: u64, message: String },

    /// The offset or the stride is not a multiple of 4, or the stride is smaller than 12.
    #[error("positions at offset {offset}, stride {stride}: both must be multiples of 4, and the stride at least 12")]
    PositionLayout { offset: u64, stride: u64 },
    /// The buffer ends before the last vertex.
    #[error("{vertices} vertices at offset {offset}, stride {stride} need {needed} bytes, and the buffer has {bytes}")]
    PositionsTooShort { vertices: u32, offset: u64, stride: u64, needed: u64, bytes: u64 },
    /// The buffer does not have usage `STORAGE`, so no shader can bind it.
    #[error("the position buffer lacks usage STORAGE; add it where the buffer is made")]
    NotStorage,
    /// The device cannot bind the buffer: it belongs to another device or was destroyed.
    #[error(
        "the device does not bind the buffer; give one of the device that the stages are on, not destroyed: {message}"
    )]
    BufferRefused { message: String },

    /// The buffer was made without usage `COPY_SRC`.
    #[error("the buffer to read lacks usage COPY_SRC")]
    NotCopySource,
    /// The device was lost, or it refused the copy or the mapping. For example it lacks the memory, or the buffer
    /// belongs to another device or was destroyed.
    #[error("the device did not hand back {bytes} bytes: {message}")]
    ReadBack { bytes: u64, message: String },
    /// The platform is a browser, where no thread may wait for the device.
    #[error(
        "this platform does not wait for the device; await `read_back_async`, `StageTimer::read_async` or `Extraction::read_edges_async` instead"
    )]
    CannotWait,

    /// The queue has no length of a tick: [`wgpu::Queue::get_timestamp_period`].
    #[error("the queue's timestamp period is {period} ns, so its timestamps are no times; measure by a clock")]
    TimestampPeriod { period: f32 },
    /// All timestamps are equal, so no time was measured.
    #[error(
        "{passes} passes were timed, and all timestamps are equal: the device's clock stands still, or is too coarse; \
         measure by a clock"
    )]
    ClockStill { passes: usize },
    /// Timestamps of compute passes are written too late, as Mesa's llvmpipe does once it has drawn anything.
    #[error(
        "a load of at least {least_ms} ms took {ms} ms by the device's timestamps: they do not belong to their passes; measure by a \
         clock, or on a device that draws nothing"
    )]
    ClockLate { ms: f64, least_ms: f64 },
    /// A pass ended before it began, or before the first pass began.
    #[error("pass {pass} ({name}) ended before it began: the device's clock runs backwards; measure by a clock")]
    ClockBackwards { pass: usize, name: &'static str },
}

/// Contains the errors of one subject in those of another: in a variant, but for those that both have, whoever finds them.
macro_rules! contain {
    ($inner:ident in $outer:ident::$variant:ident but $($same:ident),+) => {
        impl From<$inner> for $outer {
            fn from(error: $inner) -> Self {
                match error {
                    $($inner::$same(error) => Self::$same(error),)+
                    error => Self::$variant(error),
                }
            }
        }
    };
}
pub(crate) use contain;

impl DeviceError {
    /// Whether the device's timestamps are no times. Measure with a clock of the CPU then.
    pub fn is_clock(&self) -> bool {
        use DeviceError::{ClockBackwards, ClockLate, ClockStill, TimestampPeriod};
        matches!(self, TimestampPeriod { .. } | ClockStill { .. } | ClockBackwards { .. } | ClockLate { .. })
    }

    /// Whether something is too large for the device or a memory limit, so that smaller meshes may fit.
    pub fn is_memory(&self) -> bool {
        use DeviceError::{BindingTooLarge, BufferTooLarge, GatheredTooLarge, MemoryLimit, OutOfMemory};
        matches!(
            self,
            BufferTooLarge { .. }
                | BindingTooLarge { .. }
                | GatheredTooLarge { .. }
                | MemoryLimit { .. }
                | OutOfMemory { .. }
        )
    }
}

/// Features by the names of wgpu, for messages.
pub(crate) fn feature_names(features: wgpu::Features) -> String {
    features.iter_names().map(|(name, _)| format!("`Features::{name}`")).collect::<Vec<_>>().join(" and ")
}
