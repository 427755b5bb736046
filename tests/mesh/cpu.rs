//! Meshes: welding, edge records, polygons and clusters.

mod cluster_meshes;
mod clusters;
mod polygons;
mod topology;
mod weld;
mod zero;
