//! The extraction without a device: the CPU references against brute force.

mod brute_force;
mod chains;
mod mesh_space_lights;
mod predicates;
