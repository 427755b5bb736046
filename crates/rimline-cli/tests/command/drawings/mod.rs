//! Hidden-line drawings as other programs read them.

pub(crate) mod files;
pub(crate) mod raster;
mod scene;
