//! Meshes: welding, edge records, polygons and clusters.

mod clusters;
mod near;
mod polygons;
mod topology;
mod weld;
mod zero;
