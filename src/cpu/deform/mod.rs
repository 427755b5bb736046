//! The CPU reference of the stage `deform`. Its positions may differ from those of the GPU by the bound in
//! docs/numerics/deform.md.

pub(crate) mod deform;
