//! One row: a mesh, some lights, every method by turns.

use rimline::reference::cpu;
use rimline_bench::error_metrics::{Candidate, Score};

use super::bench_mesh::Case;
use super::measure::{Contender, Rounds, interleave};
use super::method::{CONTESTANTS, Contestant, Runs};
use super::on_cpu;
use super::on_gpu::Uploaded;
use super::results::Entry;
use crate::device::Gpu;
use crate::failure::{Failure, NoDevice};
use crate::output::{is_interrupted, note};

/// Times and errors of every method; `None` where Ctrl-C came first.
pub(super) fn measure(case: &Case<'_>, gpu: Option<&Gpu>, rounds: Rounds) -> Result<Option<Vec<Entry>>, Failure> {
    let exact = on_cpu::reference(case);
    let with_gpu = |gpu: Option<&Gpu>| {
        let uploaded = gpu.map(|gpu| Uploaded::new(gpu, case));
        measure_on(case, uploaded.as_ref(), &exact, rounds)
    };
    match with_gpu(gpu) {
        // A mesh that does not fit the GPU still fits the CPU.
        Err(Failure::NoDevice(reason @ NoDevice::TooSmall { .. })) => {
            note(&format!("without the GPU: {reason}"));
            with_gpu(None)
        }
        other => other,
    }
}

fn measure_on(
    case: &Case<'_>,
    uploaded: Option<&Uploaded<'_>>,
    exact: &cpu::Extraction,
    rounds: Rounds,
) -> Result<Option<Vec<Entry>>, Failure> {
    let takes_part = |contestant: &&Contestant| contestant.takes(case) && (uploaded.is_some() || !contestant.is_gpu());
    let contestants: Vec<&'static Contestant> = CONTESTANTS.iter().filter(takes_part).collect();
    let mut scores = Vec::with_capacity(contestants.len());
    for contestant in &contestants {
        if is_interrupted() {
            return Ok(None);
        }
        scores.push(score(case, uploaded, exact, contestant)?);
    }
    let mut contenders: Vec<Contender<'_>> = Vec::with_capacity(contestants.len());
    for contestant in &contestants {
        if is_interrupted() {
            return Ok(None);
        }
        contenders.push(match (contestant.runs, uploaded) {
            (Runs::Gpu(method, predicate), Some(uploaded)) => uploaded.contender(method, predicate)?,
            (Runs::Gpu(..), None) => continue,
            (Runs::Cpu(on_cpu, share), _) => on_cpu::contender(case, on_cpu, share),
        });
    }
    let Some(samples) = interleave(rounds, contenders, is_interrupted)? else { return Ok(None) };
    let entries = contestants.into_iter().zip(samples).zip(scores);
    Ok(Some(
        entries
            .map(|((contestant, samples), (score, undecided_pairs))| Entry {
                contestant,
                samples,
                score,
                undecided_pairs,
            })
            .collect(),
    ))
}

/// A method's errors, and the pairs that it settled in integers.
fn score(
    case: &Case<'_>,
    uploaded: Option<&Uploaded<'_>>,
    exact: &cpu::Extraction,
    contestant: &Contestant,
) -> Result<(Score, u32), Failure> {
    let found = match (contestant.runs, uploaded) {
        (Runs::Gpu(method, predicate), Some(uploaded)) => uploaded.extraction(method, predicate)?,
        (Runs::Gpu(..), None) => cpu::Extraction::default(),
        (Runs::Cpu(on_cpu, _), _) => on_cpu::extraction(case, on_cpu),
    };
    let facing = (!found.facing.is_empty()).then_some(found.facing.as_slice());
    let candidate = Candidate { facing, masks: &found.masks };
    let score = Score::of(case.mesh, case.lights.len(), exact, candidate).expect("masks of the same mesh and lights");
    Ok((score, found.statistics.undecided_pairs))
}
