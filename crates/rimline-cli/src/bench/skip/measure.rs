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

/// A variant whose stages are timed, on a device on which nothing is drawn.
struct Timing<'a> {
    recorder: SkipRecorder<'a>,
    deforming: &'a Deforming<'a>,
}

impl Timing<'_> {
    fn stages(&mut self, stopwatch: &mut Stopwatch<'_>) -> Result<StageRun, Failure> {
        let Self { recorder, deforming } = self;
        let pose = deforming.pose(recorder.frames)?;
        recorder.frames += 1;
        let Timed { clock_ms, times, .. } = stopwatch.timed(|encoder, mut timer, _| {
            let needs = recorder.find_needs(encoder, pose.as_ref(), timer.as_deref_mut())?;
            deforming.encode(encoder, pose.as_ref(), needs, timer.as_deref_mut())?;
            recorder.encode(encoder, None, timer)
        })?;
        // Without timestamps all that is known is their sum.
        let stages = times.map_or_else(|| vec![("all stages", clock_ms)], |(stages, _)| stages);
        Ok(StageRun { stages })
    }
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
            let timed = stopwatch.timed(|encoder, mut timer, _| {
                let needs = recorder.find_needs(encoder, pose.as_ref(), timer.as_deref_mut())?;
                deforming.encode(encoder, pose.as_ref(), needs, timer)
            })?;
            run.add(&timed);
        }
        let mut encoder = stopwatch.encoder();
        receivers.draw(&mut encoder, depth);
        stopwatch.run(encoder.finish())?;
        let seen = depth.texture().create_view(&wgpu::TextureViewDescriptor {
            aspect: wgpu::TextureAspect::DepthOnly,
            ..wgpu::TextureViewDescriptor::default()
        });
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
            recorder.encode(encoder, Some(&seen), timer.as_deref_mut())?;
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

/// Results of a variant.
pub(super) struct Measured {
    /// Both of the same rounds.
    pub(super) runs: Vec<(StageRun, FrameRun)>,
    pub(super) counted: Counted,
    pub(super) fragments: Option<u64>,
}

/// Times of each variant, what its stages counted, and the fragments of its volumes. Stages and whole frames take turns, so
/// that a drift of the machine's speed hits both alike. `None` where Ctrl-C came first.
pub(super) fn measure(
    rounds: Rounds,
    [stages, draws]: &mut [Stopwatch<'_>; 2],
    setting: &Setting,
    variants: &[Variant],
    size: u32,
) -> Result<Option<Vec<Measured>>, Failure> {
    let gpu = draws.gpu;
    let [deforming_stages, deforming] = [Deforming::new(stages.gpu, setting)?, Deforming::new(gpu, setting)?];
    let receivers = &Receivers::new(gpu, setting, deforming.positions());
    let depth = &draws.depth(size);
    let counter = FragmentCounter::new(draws, size, setting.lights.len())?;
    let (mut pairs, mut found) = (Vec::new(), Vec::new());
    for &variant in variants {
        let recorder = SkipRecorder::new(gpu, setting, &deforming, variant)?;
        let mut drawn = Drawn { recorder, depth, receivers, deforming: &deforming };
        for _ in 0..=SETTLED {
            if is_interrupted() {
                return Ok(None);
            }
            drawn.frame(draws)?;
        }
        let counted = drawn.recorder.counted(gpu).map_err(|error| error.on(gpu))?;
        let draw = |pass: &mut wgpu::RenderPass<'_>, light| drawn.recorder.draw(pass, &draws.pipelines, light);
        let fragments = counter.as_ref().map(|counter| counter.count(draws, &draw)).transpose()?;
        found.push(Measured { runs: Vec::new(), counted, fragments });
        let recorder = SkipRecorder::new(stages.gpu, setting, &deforming_stages, variant)?;
        let mut timing = Timing { recorder, deforming: &deforming_stages };
        for _ in 0..=SETTLED {
            timing.stages(stages)?;
        }
        pairs.push((timing, drawn));
    }
    let (stages, draws) = (RefCell::new(stages), RefCell::new(draws));
    let contenders = pairs.iter_mut().map(|(timing, drawn)| -> Contender<'_, (StageRun, FrameRun)> {
        let (stages, draws) = (&stages, &draws);
        Box::new(move || {
            let of_stages = timing.stages(&mut stages.borrow_mut())?;
            Ok((of_stages, drawn.frame(&mut draws.borrow_mut())?))
        })
    });
    let Some(rounds) = interleave(rounds, contenders.collect(), is_interrupted)? else { return Ok(None) };
    for (found, runs) in found.iter_mut().zip(rounds) {
        found.runs = runs;
    }
    Ok(Some(found))
}
