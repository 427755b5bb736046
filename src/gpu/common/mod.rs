//! The parts that all subjects share: pipelines, passes, buffers, limits, uniforms, timing, reading back.

pub(crate) mod bindings;
pub(crate) mod cache;
pub(crate) mod clock_check;
pub(crate) mod device_error;
pub(crate) mod dispatch_limits;
pub(crate) mod download;
pub(crate) mod drawing;
pub(crate) mod memory;
pub(crate) mod pass;
pub(crate) mod pipelines;
pub(crate) mod positions;
pub(crate) mod readback;
pub(crate) mod requirements;
pub(crate) mod timer;
pub(crate) mod together;
pub(crate) mod uniforms;
pub(crate) mod wanted;
