//! Meshes: welding, edge records and clusters.

mod cluster_meshes;
mod clusters;
mod topology;
mod weld;
