//! Twins of the stages and vertex shaders of volumes from depth maps.

pub(crate) mod contour;
pub(crate) mod contour_flaps;
pub(crate) mod contour_marks;
pub(crate) mod contour_places;
pub(crate) mod contour_rim;
pub(crate) mod contour_side;
pub(crate) mod contour_tiles;
pub(crate) mod contour_walls;
pub(crate) mod depth_cells;
pub(crate) mod depth_cube;
pub(crate) mod depth_edges;
pub(crate) mod depth_merge;
pub(crate) mod depth_metric;
pub(crate) mod depth_near;
pub(crate) mod depth_near_walls;
pub(crate) mod depth_surface;
pub(crate) mod depth_walls;
pub(crate) mod edge_code;
pub(crate) mod edge_marks;
pub(crate) mod edge_rule;
pub(crate) mod mesh_depth;
pub(crate) mod samples;
