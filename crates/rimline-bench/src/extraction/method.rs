//! The methods that are compared.

use rimline::Predicate;
use rimline::gpu::ExtractorOptions;
use rimline::internals::Method;

use super::subject::Case;
use crate::row::{Mark, Variant};

/// A way to silhouettes. Its times are those of positions that just changed: facing and edges, nothing kept.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Contestant {
    /// Name in the data.
    pub(crate) id: &'static str,
    pub(crate) name: &'static str,
    pub(crate) runs: Runs,
    /// Colour by arithmetic, shape by method, hollow on the CPU.
    colour: usize,
    shape: usize,
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
    gpu(PER_EDGE, "GPU per edge, f32 plane form (2003)", Method::PerEdge, Predicate::Plane, 0, 2),
    gpu("gpu-per-edge-local", "GPU per edge, f32 local form", Method::PerEdge, Predicate::Fast, 1, 4),
    gpu("gpu-mask-plane", "GPU face masks, f32 plane form", Method::FaceMask, Predicate::Plane, 2, 1),
    gpu(GPU_FAST, "GPU face masks, f32 local form", Method::FaceMask, Predicate::Fast, 3, 3),
    gpu(GPU_EXACT, "GPU face masks, exact", Method::FaceMask, Predicate::Exact, 4, 0),
    one("cpu-plain-one", "CPU plain loop, f32, 1 thread", OnCpu::Plain, 6, 2),
    one("cpu-f32-one", "CPU f32, 1 thread", OnCpu::Reference(Predicate::Fast), 3, 3),
    one("cpu-f64-one", "CPU f64, 1 thread", OnCpu::Double, 5, 1),
    one("cpu-exact-one", "CPU exact, 1 thread", OnCpu::Reference(Predicate::Exact), 4, 0),
    all("cpu-plain-all", "CPU plain loop, f32, all threads", OnCpu::Plain, 6, 2),
    all(CPU_FAST, "CPU f32, all threads", OnCpu::Reference(Predicate::Fast), 3, 3),
    all("cpu-f64-all", "CPU f64, all threads", OnCpu::Double, 5, 1),
    all(CPU_EXACT, "CPU exact, all threads", OnCpu::Reference(Predicate::Exact), 4, 0),
];

const fn gpu(
    id: &'static str,
    name: &'static str,
    method: Method,
    predicate: Predicate,
    colour: usize,
    shape: usize,
) -> Contestant {
    Contestant { id, name, runs: Runs::Gpu(method, predicate), colour, shape }
}

const fn one(id: &'static str, name: &'static str, on_cpu: OnCpu, colour: usize, shape: usize) -> Contestant {
    Contestant { id, name, runs: Runs::Cpu(on_cpu, Share::OneThread), colour, shape }
}

const fn all(id: &'static str, name: &'static str, on_cpu: OnCpu, colour: usize, shape: usize) -> Contestant {
    Contestant { id, name, runs: Runs::Cpu(on_cpu, Share::AllThreads), colour, shape }
}

impl Contestant {
    pub(crate) fn is_gpu(&self) -> bool {
        matches!(self.runs, Runs::Gpu(..))
    }

    pub(crate) fn variant(&self) -> Variant {
        let mark = Mark { colour: self.colour, shape: self.shape, hollow: !self.is_gpu() };
        Variant { id: self.id.to_owned(), name: self.name.to_owned(), mark }
    }

    /// Whether it can do this: the plain loop is for closed meshes and one light.
    pub(crate) fn takes(&self, case: &Case<'_>) -> bool {
        !matches!(self.runs, Runs::Cpu(OnCpu::Plain, _)) || case.lights.len() == 1 && case.mesh.is_closed()
    }
}

/// The options with which a GPU method is timed: unordered lists, no masks.
pub(crate) fn timed(method: Method, predicate: Predicate, max_lights: usize) -> ExtractorOptions {
    ExtractorOptions { max_lights, method, predicate, ..ExtractorOptions::default() }
}

/// The options with which its bits are looked at.
pub(crate) fn checked(method: Method, predicate: Predicate, max_lights: usize) -> ExtractorOptions {
    ExtractorOptions { masks: true, lists: None, ..timed(method, predicate, max_lights) }
}
