//! The CPU references of the stages `polygon_facing`, `polygon_turns`, `polygon_pairs` and `polygon_masks`: how a light sees
//! a polygon (`Orientation`: front-facing, back-facing, in a plane with the light, or twisted). `polygon_facing` runs them
//! all. The stages that cut twisted polygons have no reference. Claims: docs/numerics/polygons.md.

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
