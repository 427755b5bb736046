//! Times and counts of a setting with each choice of levels.

use std::cell::RefCell;

use rimline::gpu::StageTimer;
use rimline::wgpu;
use wgpu::LoadOp;

use super::super::casters::measure::{STENCIL, Stopwatch, Timed, stencil_pass};
use super::super::casters::recorder::DrawPipelines;
use super::super::measure::{Contender, Rounds, interleave};
use super::fragments::FragmentCounter;
use super::levels::Variant;
use super::receivers::Receivers;
use super::recorder::{Deforming, SkipRecorder};
use super::results::{Counted, FrameRun, StageRun};
use super::setting::Setting;
use crate::failure::Failure;
use crate::output::is_interrupted;

/// Frames before one is counted, so that what does not change was computed before.
const SETTLED: usize = 2;

/// The stages' times of each variant. Nothing is drawn. `None` where Ctrl-C came first.
pub(super) fn stages(
    rounds: Rounds,
    stopwatch: &mut Stopwatch<'_>,
    setting: &Setting,
) -> Result<Option<Vec<Vec<StageRun>>>, Failure> {
    let deforming = Deforming::new(stopwatch.gpu, setting)?;
    let stopwatch = RefCell::new(stopwatch);
    let contender = |variant| -> Result<Contender<'_, StageRun>, Failure> {
        let mut recorder = SkipRecorder::new(stopwatch.borrow().gpu, setting, &deforming, variant)?;
        let (deforming, stopwatch) = (&deforming, &stopwatch);
        Ok(Box::new(move || {
            let pose = deforming.pose(recorder.frames)?;
            recorder.frames += 1;
            let Timed { clock_ms, times, .. } = stopwatch.borrow_mut().timed(|encoder, mut timer, _| {
                deforming.encode(encoder, pose.as_ref(), timer.as_deref_mut())?;
                recorder.encode(encoder, timer)
            })?;
            // Without timestamps all that is known is their sum.
            let stages = times.map_or_else(|| vec![("all stages", clock_ms)], |(stages, _)| stages);
            Ok(StageRun { stages })
        }))
    };
    let contenders = Variant::all().map(contender).collect::<Result<Vec<_>, _>>()?;
    interleave(rounds, contenders, is_interrupted)
}

/// A variant in frames that are drawn.
struct Drawn<'a> {
    recorder: SkipRecorder<'a>,
    depth: &'a wgpu::TextureView,
    receivers: &'a Receivers,
    deforming: &'a Deforming<'a>,
}

impl Drawn<'_> {
    /// Runs a frame: deforms, draws depths, then runs stages and stencil passes. Depths are the caller's in any case, so
    /// they are not timed.
    fn frame(&mut self, stopwatch: &mut Stopwatch<'_>) -> Result<FrameRun, Failure> {
        let Self { recorder, depth, receivers, deforming } = self;
        let pose = deforming.pose(recorder.frames)?;
        recorder.frames += 1;
        let mut run = FrameRun::default();
        if pose.is_some() {
            let timed = stopwatch.timed(|encoder, timer, _| deforming.encode(encoder, pose.as_ref(), timer))?;
            run.add(&timed);
        }
        let mut encoder = stopwatch.encoder();
        receivers.draw(&mut encoder, depth);
        stopwatch.run(encoder.finish())?;
        let passes = |encoder: &mut wgpu::CommandEncoder,
                      recorder: &SkipRecorder<'_>,
                      mut timer: Option<&mut StageTimer>,
                      pipelines: &DrawPipelines| {
            for light in 0..recorder.lights() {
                let mut pass = stencil_pass(encoder, depth, LoadOp::Load, timer.as_deref_mut(), None);
                recorder.draw(&mut pass, pipelines, light)?;
            }
            Ok(())
        };
        // Without timestamps the clock tells the passes from the stages, if they are submitted apart.
        let is_apart = !stopwatch.has_timer();
        let all = stopwatch.timed(|encoder, mut timer, pipelines| {
            recorder.encode(encoder, timer.as_deref_mut())?;
            if is_apart { Ok(()) } else { passes(encoder, recorder, timer, pipelines) }
        })?;
        run.add(&all);
        let stages = all.times.iter().flat_map(|(stages, _)| stages);
        run.stencil_ms = stages.filter(|(name, _)| *name == STENCIL).map(|(_, ms)| ms).sum();
        if is_apart {
            let drawn = stopwatch.timed(|encoder, timer, pipelines| passes(encoder, recorder, timer, pipelines))?;
            run.add(&drawn);
            run.stencil_ms = drawn.clock_ms;
        }
        Ok(run)
    }
}

impl FrameRun {
    fn add(&mut self, timed: &Timed) {
        self.frame_ms += timed.clock_ms;
        self.recording_ms += timed.recording_ms;
    }
}

/// What frames with draws showed of a variant.
pub(super) struct Frames {
    pub(super) runs: Vec<FrameRun>,
    pub(super) counted: Counted,
    pub(super) fragments: Option<u64>,
}

/// Times of whole frames of each variant, what they counted, and the fragments of their volumes. `None` where Ctrl-C came
/// first.
pub(super) fn frames(
    rounds: Rounds,
    stopwatch: &mut Stopwatch<'_>,
    setting: &Setting,
    size: u32,
) -> Result<Option<Vec<Frames>>, Failure> {
    let gpu = stopwatch.gpu;
    let deforming = &Deforming::new(gpu, setting)?;
    let receivers = &Receivers::new(gpu, setting, deforming.positions());
    let depth = &stopwatch.depth(size);
    let counter = FragmentCounter::new(stopwatch, size, setting.lights.len())?;
    let (mut drawn, mut found) = (Vec::new(), Vec::new());
    for variant in Variant::all() {
        let recorder = SkipRecorder::new(gpu, setting, deforming, variant)?;
        let mut one = Drawn { recorder, depth, receivers, deforming };
        for _ in 0..=SETTLED {
            if is_interrupted() {
                return Ok(None);
            }
            one.frame(stopwatch)?;
        }
        let counted = one.recorder.counted(gpu).map_err(|error| error.on(gpu))?;
        let draw = |pass: &mut wgpu::RenderPass<'_>, light| one.recorder.draw(pass, &stopwatch.pipelines, light);
        let fragments = counter.as_ref().map(|counter| counter.count(stopwatch, &draw)).transpose()?;
        found.push(Frames { runs: Vec::new(), counted, fragments });
        drawn.push(one);
    }
    let stopwatch = RefCell::new(stopwatch);
    let contenders = drawn.iter_mut().map(|one| -> Contender<'_, FrameRun> {
        let stopwatch = &stopwatch;
        Box::new(move || one.frame(&mut stopwatch.borrow_mut()))
    });
    let Some(rounds) = interleave(rounds, contenders.collect(), is_interrupted)? else { return Ok(None) };
    for (found, runs) in found.iter_mut().zip(rounds) {
        found.runs = runs;
    }
    Ok(Some(found))
}
