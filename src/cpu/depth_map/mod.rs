//! Twins of the stages and vertex shaders of volumes from depth maps.

pub(crate) mod depth_cells;
pub(crate) mod depth_surface;
pub(crate) mod edge_code;
pub(crate) mod samples;
