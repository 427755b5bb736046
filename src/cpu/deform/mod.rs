//! The twin of the deform stage.

pub(crate) mod deform;
