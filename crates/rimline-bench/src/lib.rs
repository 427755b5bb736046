//! What `rimline bench` measures with. There is no promise of stability: anything may change in any release.
//!
//! * [`shapes`], [`stress`]: meshes made by code, smooth ones and those that are hard on floating-point arithmetic;
//! * [`error_metrics`]: how wrong a method is on them;
//! * [`slivers`]: whether a driver rasterises triangles that leave the picture rightly;
//! * [`pipelines`]: short ways to pipelines; [`random`]: seeded numbers;
//! * with the feature `rays`, `rays`: triangles and rays in `f64`.
#![allow(
    clippy::missing_errors_doc,
    clippy::missing_panics_doc,
    reason = "the crate is for programs of its repository"
)]
#![allow(missing_docs, reason = "fields of fixtures say by their names what they are")]

pub mod error_metrics;
pub mod pipelines;
pub mod random;
#[cfg(feature = "rays")]
pub mod rays;
pub mod shapes;
pub mod slivers;
pub mod stress;
