//! The extraction of one mesh: facing, exact facing, edges, lists, draw arguments.

pub(crate) mod buffers;
pub(crate) mod errors;
pub(crate) mod extraction;
pub(crate) mod extractor;
pub(crate) mod include;
pub(crate) mod of_scene;
pub(crate) mod options;
pub(crate) mod polygon_buffers;
mod read_edges;
pub(crate) mod stages;
