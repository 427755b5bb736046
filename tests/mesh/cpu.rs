//! Meshes: welding and edge records.

mod topology;
