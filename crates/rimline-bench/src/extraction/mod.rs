//! Silhouettes from new positions: every method by turns, for a mesh and some lights.

pub(crate) mod method;
mod on_cpu;
pub(crate) mod subject;

use std::time::Instant;

use rimline::Predicate;
use rimline::gpu::ExtractorOptions;
use rimline::internals::Method;
use rimline::internals::cpu;
use rimline::internals::layout::ExtractionStatistics;
use rimline::mesh::Mesh;
use serde_json::json;

use crate::engine::{Contender, Metric, Rounds, Sample, interleave};
use crate::error_metrics::{Candidate, Score};
use crate::gpu::{Gpu, Stopwatch};
use crate::record::{Meshes, Recorder as _, Until};
use crate::row::{Entry, Row, Section};
use crate::{Error, Host};
use method::{CONTESTANTS, Contestant, Runs, checked, timed};
use subject::{Case, Made, Subject};

/// A subject with all that its numbers of lights share.
pub(crate) struct Prepared {
    made: Made,
    topology_ms: f64,
    topology_bytes: usize,
}

impl Prepared {
    pub(crate) fn new(subject: &Subject) -> Result<Self, Error> {
        let made = subject.make()?;
        let faces = made.mesh.faces().to_vec();
        let begin = Instant::now();
        let again = Mesh::from_faces(made.positions.len(), faces)?;
        let topology_ms = begin.elapsed().as_secs_f64() * 1e3;
        Ok(Self { made, topology_ms, topology_bytes: again.edge_record_bytes() })
    }

    /// A row of times and errors of every method.
    pub(crate) fn measure(
        &self,
        count: usize,
        gpu: Option<&Gpu>,
        rounds: Rounds,
        host: &dyn Host,
    ) -> Result<Row, Error> {
        let Self { made: Made { name, class, mesh, positions, .. }, topology_ms, topology_bytes } = self;
        let lights = self.made.lights(count);
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
                ("topology_bytes", json!(topology_bytes)),
                ("lights", json!(lights.len())),
                ("silhouette_bits", json!(mesh.edges().len() * lights.len())),
            ],
            entries,
        })
    }
}

fn entries(
    case: &Case<'_>,
    gpu: Option<&Gpu>,
    exact: &cpu::Extraction,
    rounds: Rounds,
    host: &dyn Host,
) -> Result<Vec<Entry>, Error> {
    let takes_part = |contestant: &&Contestant| contestant.takes(case) && (gpu.is_some() || !contestant.is_gpu());
    let contestants: Vec<&'static Contestant> = CONTESTANTS.iter().filter(takes_part).collect();
    let (mut found, mut contenders) = (Vec::new(), Vec::new());
    for contestant in &contestants {
        if host.is_stopped() {
            return Err(Error::Stopped);
        }
        let (extraction, contender) = match (contestant.runs, gpu) {
            (Runs::Gpu(method, predicate), Some(gpu)) => {
                (extraction(gpu, case, method, predicate)?, contender(gpu, case, method, predicate)?)
            }
            (Runs::Gpu(..), None) => continue,
            (Runs::Cpu(on_cpu, share), _) => (on_cpu::extraction(case, on_cpu), on_cpu::contender(case, on_cpu, share)),
        };
        let facing = (!extraction.facing.is_empty()).then_some(extraction.facing.as_slice());
        let candidate = Candidate { facing, masks: &extraction.masks };
        let score = Score::of(case.mesh, case.lights.len(), exact, candidate).expect("masks of this mesh and lights");
        found.push((score, extraction.statistics.undecided_pairs));
        contenders.push(contender);
    }
    let samples = interleave(rounds, contenders, host)?;
    let entries = contestants.into_iter().zip(samples).zip(found);
    let entry = |((contestant, samples), (score, undecided)): ((&Contestant, Vec<Sample>), (Score, u32))| {
        Entry::new(contestant.variant(), &samples)
            .with_count("wrong_facing_bits", score.wrong_facing_bits)
            .with_count("wrong_silhouette_bits", score.wrong_silhouette_bits)
            .with_count("unclosed_vertices", score.unclosed_vertices)
            .with_count("undecided_pairs", undecided as usize)
    };
    Ok(entries.map(entry).collect())
}

/// The mesh on the GPU.
fn recorder(gpu: &Gpu, case: &Case<'_>, options: ExtractorOptions) -> Result<Meshes<'static>, Error> {
    let mut meshes = Meshes::new(None, case.lights, None);
    meshes.push(gpu, options, case.mesh, case.positions)?;
    Ok(meshes)
}

/// Runs a method again and again.
fn contender<'a>(gpu: &'a Gpu, case: &Case<'_>, method: Method, predicate: Predicate) -> Result<Contender<'a>, Error> {
    let mut recorder = recorder(gpu, case, timed(method, predicate, case.lights.len()))?;
    let mut stopwatch = Stopwatch::new(gpu);
    Ok(Box::new(move || {
        let timed = stopwatch.timed(|encoder, timer| recorder.encode(encoder, Until::Extraction, timer))?;
        let (wall, gpu) = (timed.recording_ms + timed.clock_ms, timed.passes.as_ref().map(|(_, span)| *span));
        let mut sample = vec![(Metric::Time("time"), gpu.unwrap_or(wall)), (Metric::Time("wall"), wall)];
        sample.extend(gpu.map(|ms| (Metric::Time("gpu"), ms)));
        sample.extend(timed.stages());
        Ok(sample)
    }))
}

/// A method's bits; facing masks only where it has them.
fn extraction(gpu: &Gpu, case: &Case<'_>, method: Method, predicate: Predicate) -> Result<cpu::Extraction, Error> {
    let mut recorder = recorder(gpu, case, checked(method, predicate, case.lights.len()))?;
    Stopwatch::new(gpu).by_clock(|encoder| recorder.encode(encoder, Until::Extraction, None))?;
    let Some(extractor) = recorder.extractor() else { return Ok(cpu::Extraction::default()) };
    let results = extractor.results();
    let facing = match method {
        Method::FaceMask => gpu.read_planes(results.facing, case.mesh.faces().len())?,
        Method::PerEdge => Vec::new(),
    };
    let masks = gpu.read_planes(results.masks, case.mesh.edges().len())?;
    let statistics: Vec<ExtractionStatistics> = gpu.read(results.statistics)?;
    let statistics = statistics.first().map(|statistics| cpu::FacingStatistics {
        non_finite_faces: statistics.non_finite_faces,
        undecided_pairs: statistics.undecided_pairs,
        exact_zeros: statistics.exact_zeros,
    });
    gpu.check()?;
    Ok(cpu::Extraction { facing, masks, statistics: statistics.unwrap_or_default(), ..Default::default() })
}
