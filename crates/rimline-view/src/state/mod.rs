//! The state of the viewer, and the events that change it. Nothing here uses a window or a device.

mod act;
pub(crate) mod body;
pub(crate) mod camera;
pub(crate) mod clock;
pub(crate) mod command;
mod drag;
pub(crate) mod event;
pub(crate) mod handle;
pub(crate) mod keys;
pub(crate) mod lamp;
pub(crate) mod opening;
pub(crate) mod options;
pub(crate) mod viewer;
