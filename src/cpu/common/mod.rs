//! The parts that the CPU references share: threads, positions, the determinant, its filter, its sign in `f64` and in
//! integers.

pub(crate) mod determinant;
pub(crate) mod double_sign;
pub(crate) mod exact_sign;
pub(crate) mod filter;
pub(crate) mod fixed_sign;
pub(crate) mod parallel;
pub(crate) mod positions;
