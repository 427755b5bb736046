//! Meshes: welding and edge records.

mod topology;
mod weld;
