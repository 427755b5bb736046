//! The reference of the deform stage.

pub(crate) mod deform;
