//! Shadow volumes: what the GPU chose for lights, and near caps on the CPU.

pub(crate) mod chosen;
pub(crate) mod near_cap;
