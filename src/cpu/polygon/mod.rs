//! Polygons as a light sees them: facing, averted, in a plane with the light, or L-twisted; docs/numerics/polygons.md.

pub(crate) mod edge_pair;
pub(crate) mod half_space;
pub(crate) mod many_edges;
pub(crate) mod outline;
pub(crate) mod polygon_facing;
pub(crate) mod polygon_masks;
pub(crate) mod polygon_turns;
pub(crate) mod seen;
pub(crate) mod turn;
pub(crate) mod turns_batch;
