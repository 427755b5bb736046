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

use crate::engine::{Contender, Rounds, times};
use crate::error_metrics::{Candidate, Score};
use crate::gpu::{Gpu, Stopwatch};
use crate::record::ExtractorRecorder;
use crate::row::{Entry, Row, Section, Variant, compare};
use crate::{Error, Host};
use method::{CONTESTANTS, Runs};
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
    let (mut found, mut contenders) = (Vec::<(Score, u32)>::new(), Vec::<(Variant, Contender<'_>)>::new());
    for contestant in CONTESTANTS.iter().filter(|contestant| contestant.takes(case)) {
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
        contenders.push((contestant.variant(), contender));
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

/// Runs a method again and again, with unordered lists and without masks.
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

/// A method's bits; facing masks only where it has them.
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
