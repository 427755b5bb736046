//! The measurements of `rimline bench`. There is no promise of stability: anything may change in any release.
//!
//! * [`shapes`], [`stress`]: meshes made by code, smooth ones and those that are hard on floating-point arithmetic;
//! * [`error_metrics`]: how wrong a method is on them;
//! * [`slivers`]: whether a driver rasterises triangles that leave the picture rightly;
//! * [`pipelines`]: short ways to pipelines; [`random`]: seeded numbers;
//! * with the feature `rays`, `rays`: triangles and rays in `f64`;
//! * with the feature `measure`, what benches share: `engine` runs contenders in turn, `row` has the results, `gpu` times
//!   frames, `record` records scenes, meshes and what receives;
//! * with the feature `report`, all of `rimline bench`: a `Plan` of `Options`, and `Results`, as JSON, as a report with
//!   charts, and as a few lines.
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

#[cfg(feature = "measure")]
pub mod arguments;
#[cfg(feature = "measure")]
pub mod depth_maps;
#[cfg(feature = "measure")]
pub mod engine;
#[cfg(feature = "measure")]
mod error;
#[cfg(feature = "measure")]
pub mod gpu;
#[cfg(feature = "measure")]
pub mod record;
#[cfg(feature = "measure")]
pub mod row;

#[cfg(feature = "report")]
mod casters;
#[cfg(feature = "report")]
mod chart;
#[cfg(feature = "report")]
mod extraction;
#[cfg(feature = "report")]
mod figures;
#[cfg(feature = "report")]
mod machine;
#[cfg(feature = "report")]
mod page;
#[cfg(feature = "report")]
mod plan;
#[cfg(feature = "report")]
mod results;
#[cfg(feature = "report")]
mod run;
#[cfg(feature = "report")]
mod shadows;
#[cfg(feature = "report")]
mod skipping;
#[cfg(feature = "report")]
mod summary;
#[cfg(feature = "report")]
mod text;

#[cfg(feature = "measure")]
pub use error::{Error, Host};

#[cfg(feature = "report")]
pub use {
    extraction::subject::Model,
    figures::CHARTS,
    machine::Adapter,
    plan::{Options, Plan, PlanError},
    results::{Results, TITLE},
    run::Opened,
};

/// The description of the data, for programs and people.
#[cfg(feature = "report")]
pub const SCHEMA: &str = include_str!("../bench.schema.json");
