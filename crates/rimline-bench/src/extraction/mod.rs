//! Times and errors of extraction: all methods in turn, for a mesh and some lights.

mod on_cpu;
pub(crate) mod subject;

use rimline::Predicate;
use rimline::gpu::ExtractorOptions;
use rimline::internals::Method;
use rimline::internals::cpu;
use rimline::internals::layout::ExtractionStatistics;
use serde_json::json;

use crate::engine::{Contender, Rounds, times};
use crate::error_metrics::Score;
use crate::gpu::{Gpu, Stopwatch};
use crate::record::ExtractorRecorder;
use crate::row::{Entry, Mark, Row, Section, Variant, compare};
use crate::{Error, Host};
use Runs::{OnCpu, OnGpu};
use on_cpu::Algorithm::{self, Double, Plain, Reference};
pub(crate) use on_cpu::share;
use subject::{Case, Made};
pub(crate) use subject::{OF_USER, ORDINARY};

/// Where and how a method runs; the flag of `OnCpu` is true for all threads, false for one. Each run computes facing and
/// edges anew, as after a change of positions.
#[derive(Clone, Copy)]
enum Runs {
    OnGpu(Method, Predicate),
    OnCpu(Algorithm, bool),
}

pub(crate) const PER_EDGE: &str = "gpu-per-edge-plane";
pub(crate) const GPU_FAST: &str = "gpu-mask-local";
pub(crate) const GPU_EXACT: &str = "gpu-mask-exact";
pub(crate) const CPU_FAST: &str = "cpu-f32-all";
pub(crate) const CPU_EXACT: &str = "cpu-exact-all";

/// All methods, in the order in which they are shown: the name in the data, the name for people, where and how it runs, and
/// colour and shape of its mark. CPU references have the marks of the GPU's face masks with the same arithmetic.
const CONTESTANTS: [(&str, &str, Runs, usize, usize); 13] = [
    (PER_EDGE, "GPU per edge, f32 plane form (2003)", OnGpu(Method::PerEdge, Predicate::Plane), 0, 2),
    ("gpu-per-edge-local", "GPU per edge, f32 local form", OnGpu(Method::PerEdge, Predicate::Fast), 1, 4),
    ("gpu-mask-plane", "GPU face masks, f32 plane form", OnGpu(Method::FaceMask, Predicate::Plane), 2, 1),
    (GPU_FAST, "GPU face masks, f32 local form", OnGpu(Method::FaceMask, Predicate::Fast), 3, 3),
    (GPU_EXACT, "GPU face masks, exact", OnGpu(Method::FaceMask, Predicate::Exact), 4, 0),
    ("cpu-plain-one", "CPU plain loop, f32, 1 thread", OnCpu(Plain, false), 6, 2),
    ("cpu-f32-one", "CPU f32, 1 thread", OnCpu(Reference(Predicate::Fast), false), 3, 3),
    ("cpu-f64-one", "CPU f64, 1 thread", OnCpu(Double, false), 5, 1),
    ("cpu-exact-one", "CPU exact, 1 thread", OnCpu(Reference(Predicate::Exact), false), 4, 0),
    ("cpu-plain-all", "CPU plain loop, f32, all threads", OnCpu(Plain, true), 6, 2),
    (CPU_FAST, "CPU f32, all threads", OnCpu(Reference(Predicate::Fast), true), 3, 3),
    ("cpu-f64-all", "CPU f64, all threads", OnCpu(Double, true), 5, 1),
    (CPU_EXACT, "CPU exact, all threads", OnCpu(Reference(Predicate::Exact), true), 4, 0),
];

/// A row of times and errors of every method.
pub(crate) fn measure(
    made: &Made,
    count: usize,
    gpu: Option<&Gpu>,
    rounds: Rounds,
    host: &dyn Host,
) -> Result<Row, Error> {
    let Made { name, class, mesh, positions, topology_ms, .. } = made;
    let lights = made.lights(count);
    let case = Case { positions, mesh, lights: &lights };
    let exact = on_cpu::reference(&case);
    let entries = match entries(&case, gpu, &exact, rounds, host) {
        // A mesh that does not fit the GPU still fits the CPU.
        Err(error) if error.is_too_large() => {
            host.note(&format!("without the GPU: {error}"));
            entries(&case, None, &exact, rounds, host)?
        }
        other => other?,
    };
    Ok(Row {
        section: Section::Extraction,
        scene: name.clone(),
        title: name.clone(),
        group: (*class).to_owned(),
        facts: vec![
            ("vertices", json!(positions.len())),
            ("faces", json!(mesh.faces().len())),
            ("edges", json!(mesh.edges().len())),
            ("closed", json!(mesh.is_closed())),
            ("topology_ms", json!(topology_ms)),
            ("topology_bytes", json!(mesh.edge_record_bytes())),
            ("lights", json!(lights.len())),
            ("silhouette_bits", json!(mesh.edges().len() * lights.len())),
        ],
        entries,
    })
}

fn entries(
    case: &Case<'_>,
    gpu: Option<&Gpu>,
    exact: &cpu::Extraction,
    rounds: Rounds,
    host: &dyn Host,
) -> Result<Vec<Entry>, Error> {
    let (mut found, mut contenders) = (Vec::<(Score, u32)>::new(), Vec::<(Variant, Contender<'_>)>::new());
    for (id, name, runs, colour, shape) in CONTESTANTS {
        if host.is_stopped() {
            return Err(Error::Stopped);
        }
        let (extraction, contender) = match (runs, gpu) {
            // The plain loop is for closed meshes and one light.
            (OnCpu(Plain, _), _) if case.lights.len() > 1 || !case.mesh.is_closed() => continue,
            (OnGpu(..), None) => continue,
            (OnGpu(method, predicate), Some(gpu)) => {
                (extraction(gpu, case, method, predicate)?, contender(gpu, case, method, predicate)?)
            }
            (OnCpu(algorithm, is_shared), _) => {
                (on_cpu::extraction(case, algorithm), on_cpu::contender(case, algorithm, is_shared))
            }
        };
        let score = Score::of(case.mesh, case.lights.len(), exact, &extraction).expect("masks of this mesh and lights");
        found.push((score, extraction.statistics.undecided_pairs));
        let mark = Mark { colour, shape, hollow: matches!(runs, OnCpu(..)) };
        contenders.push((Variant { id: id.to_owned(), name: name.to_owned(), mark }, contender));
    }
    let entries = compare(rounds, contenders, host)?.into_iter().zip(found);
    let entry = |(entry, (score, undecided)): (Entry, (Score, u32))| {
        entry
            .with_count("wrong_facing_bits", score.wrong_facing_bits)
            .with_count("wrong_silhouette_bits", score.wrong_silhouette_bits)
            .with_count("unclosed_vertices", score.unclosed_vertices)
            .with_count("undecided_pairs", undecided as usize)
    };
    Ok(entries.map(entry).collect())
}

/// Runs a method on the GPU once a call, with unordered lists and without masks of edges.
fn contender<'a>(gpu: &'a Gpu, case: &Case<'_>, method: Method, predicate: Predicate) -> Result<Contender<'a>, Error> {
    let options = ExtractorOptions { max_lights: case.lights.len(), method, predicate, ..Default::default() };
    let mut recorder = ExtractorRecorder::new(gpu, options, case.mesh, case.positions, case.lights)?;
    let mut stopwatch = Stopwatch::new(gpu);
    Ok(Box::new(move || {
        let timed = stopwatch.timed(|encoder, timer| recorder.encode(encoder, timer))?;
        let wall = timed.recording_ms + timed.clock_ms;
        if !timed.has_stamps {
            return Ok(times([("time", wall), ("wall", wall)]));
        }
        let mut sample = times([("time", timed.whole_ms), ("wall", wall), ("gpu", timed.whole_ms)]);
        sample.extend(timed.stages());
        Ok(sample)
    }))
}

/// Runs a method on the GPU and reads its masks. The per-edge method has no facing masks.
fn extraction(gpu: &Gpu, case: &Case<'_>, method: Method, predicate: Predicate) -> Result<cpu::Extraction, Error> {
    let max_lights = case.lights.len();
    let options =
        ExtractorOptions { max_lights, method, predicate, masks: true, lists: None, ..ExtractorOptions::default() };
    let mut recorder = ExtractorRecorder::new(gpu, options, case.mesh, case.positions, case.lights)?;
    Stopwatch::new(gpu).by_clock(|encoder| recorder.encode(encoder, None))?;
    let results = recorder.extractor.results();
    let facing = match method {
        Method::FaceMask => gpu.read_planes(results.facing, case.mesh.faces().len())?,
        Method::PerEdge => Vec::new(),
    };
    let masks = gpu.read_planes(results.masks, case.mesh.edges().len())?;
    let statistics: Vec<ExtractionStatistics> = gpu.read(results.statistics)?;
    let undecided_pairs = statistics.first().map_or(0, |statistics| statistics.undecided_pairs);
    let statistics = cpu::FacingStatistics { undecided_pairs, ..cpu::FacingStatistics::default() };
    gpu.check()?;
    Ok(cpu::Extraction { facing, masks, statistics, ..Default::default() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn references_have_the_marks_of_face_masks() {
        let all = CONTESTANTS;
        for (id, _, runs, colour, shape) in all {
            let OnCpu(Reference(predicate), _) = runs else { continue };
            let is_same = |runs: Runs| matches!(runs, OnGpu(Method::FaceMask, of) if of == predicate);
            let on_gpu = all.iter().find(|method| is_same(method.2));
            assert_eq!(on_gpu.map(|method| (method.3, method.4)), Some((colour, shape)), "{id}");
        }
    }
}
