//! The methods that are compared.

use rimline::Predicate;
use rimline::internals::Method;

use super::subject::Case;
use crate::row::{Mark, Variant};
use OnCpu::{Double, Plain, Reference};
use Runs::{Cpu, Gpu};
use Share::{AllThreads, OneThread};

/// A way to silhouettes. Its times are those of positions that just changed: facing and edges, nothing kept.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Contestant {
    /// Name in the data.
    id: &'static str,
    name: &'static str,
    pub(crate) runs: Runs,
    /// Colour by arithmetic, shape by method, hollow on the CPU.
    mark: Mark,
}

/// Where and how it runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Runs {
    Gpu(Method, Predicate),
    Cpu(OnCpu, Share),
}

/// Algorithms on the CPU.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum OnCpu {
    /// The library's CPU references.
    Reference(Predicate),
    /// A plain loop over facing in `f64`, and the CPU reference of the edge stage.
    Double,
    /// The naive loop for one light and a closed mesh: a byte a face in `f32`, then a byte an edge.
    Plain,
}

/// How much of the CPU.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Share {
    OneThread,
    AllThreads,
}

pub(crate) const PER_EDGE: &str = "gpu-per-edge-plane";
pub(crate) const GPU_FAST: &str = "gpu-mask-local";
pub(crate) const GPU_EXACT: &str = "gpu-mask-exact";
pub(crate) const CPU_FAST: &str = "cpu-f32-all";
pub(crate) const CPU_EXACT: &str = "cpu-exact-all";

/// All of them, in the order in which they are shown.
pub(crate) const CONTESTANTS: [Contestant; 13] = [
    contestant(PER_EDGE, "GPU per edge, f32 plane form (2003)", Gpu(Method::PerEdge, Predicate::Plane), 0, 2),
    contestant("gpu-per-edge-local", "GPU per edge, f32 local form", Gpu(Method::PerEdge, Predicate::Fast), 1, 4),
    contestant("gpu-mask-plane", "GPU face masks, f32 plane form", Gpu(Method::FaceMask, Predicate::Plane), 2, 1),
    contestant(GPU_FAST, "GPU face masks, f32 local form", Gpu(Method::FaceMask, Predicate::Fast), 3, 3),
    contestant(GPU_EXACT, "GPU face masks, exact", Gpu(Method::FaceMask, Predicate::Exact), 4, 0),
    contestant("cpu-plain-one", "CPU plain loop, f32, 1 thread", Cpu(Plain, OneThread), 6, 2),
    contestant("cpu-f32-one", "CPU f32, 1 thread", Cpu(Reference(Predicate::Fast), OneThread), 3, 3),
    contestant("cpu-f64-one", "CPU f64, 1 thread", Cpu(Double, OneThread), 5, 1),
    contestant("cpu-exact-one", "CPU exact, 1 thread", Cpu(Reference(Predicate::Exact), OneThread), 4, 0),
    contestant("cpu-plain-all", "CPU plain loop, f32, all threads", Cpu(Plain, AllThreads), 6, 2),
    contestant(CPU_FAST, "CPU f32, all threads", Cpu(Reference(Predicate::Fast), AllThreads), 3, 3),
    contestant("cpu-f64-all", "CPU f64, all threads", Cpu(Double, AllThreads), 5, 1),
    contestant(CPU_EXACT, "CPU exact, all threads", Cpu(Reference(Predicate::Exact), AllThreads), 4, 0),
];

const fn contestant(id: &'static str, name: &'static str, runs: Runs, colour: usize, shape: usize) -> Contestant {
    Contestant { id, name, runs, mark: Mark { colour, shape, hollow: matches!(runs, Cpu(..)) } }
}

impl Contestant {
    pub(crate) fn variant(&self) -> Variant {
        Variant { id: self.id.to_owned(), name: self.name.to_owned(), mark: self.mark }
    }

    /// Whether it can do this: the plain loop is for closed meshes and one light.
    pub(crate) fn takes(&self, case: &Case<'_>) -> bool {
        !matches!(self.runs, Cpu(Plain, _)) || case.lights.len() == 1 && case.mesh.is_closed()
    }
}
