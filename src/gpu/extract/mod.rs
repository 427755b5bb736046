//! The extraction of one mesh: facing, exact facing, edges, lists, draw arguments.

mod bind_groups;
pub(crate) mod buffers;
pub(crate) mod errors;
pub(crate) mod extraction;
pub(crate) mod extractor;
pub(crate) mod include;
pub(crate) mod options;
pub(crate) mod polygon_buffers;
mod polygon_passes;
pub(crate) mod programs;
mod read_edges;
pub(crate) mod results;
