//! The CPU reference of wgsl/polygon: how a light sees a polygon (`Orientation`: front-facing, back-facing, in a plane with
//! the light, or twisted). It begins at `polygon_facing`. docs/numerics/polygons.md.

pub(crate) mod corner_turn;
pub(crate) mod edge_pair;
pub(crate) mod half_space;
pub(crate) mod many_edges;
pub(crate) mod orientation;
pub(crate) mod polygon_facing;
pub(crate) mod polygon_masks;
pub(crate) mod polygon_pairs;
pub(crate) mod polygon_turns;
pub(crate) mod turns_batch;
