//! How much work each level of skipping leaves out of a frame: its stages, its stencil passes, its volumes' fragments.

mod city;
mod crowd;
mod house;
mod levels;
pub(crate) mod scenes;
mod walk;

use std::cell::RefCell;

use crate::casters::Devices;
use crate::engine::{Contender, Metric, Rounds, Sample, times};
use crate::gpu::{Stopwatch, beside_draws};
use crate::record::{Counted, DEPTH, Drawn, FragmentCounter, STENCIL, SceneRecorder, Surfaces, Until};
use crate::row::{Row, Section, Variant, compare};
use crate::{Error, Host};
use scenes::SkipScene;
use serde_json::json;

/// Frames before one is counted, so that what does not change was computed before.
const SETTLED: usize = 2;
/// The stage that deforms, as the timer has it.
const DEFORM: &str = "deform";

/// A counter of the stages, by its name in the data.
type Counter = (&'static str, fn(&Counted) -> u32);

const COUNTERS: [Counter; 14] = [
    ("pairs", |counted| counted.scene.pairs),
    ("unreached-pairs", |counted| counted.scene.pairs_culled_by_range),
    ("occluded-pairs", |counted| counted.scene.pairs_culled_by_occluders),
    ("kept-pairs", |counted| counted.scene.cached_pairs),
    ("faces", |counted| counted.scene.faces),
    ("edges", |counted| counted.scene.edges),
    ("spared-faces", |counted| counted.scene.untested_faces),
    ("spared-edges", |counted| counted.scene.untested_edges),
    ("unneeded-figures", |counted| counted.scene.culled_casters),
    ("skipped-volumes", |counted| counted.shadows.skipped),
    ("unreached-volumes", |counted| counted.shadows.culled_by_range),
    ("hidden-volumes", |counted| counted.shadows.culled_by_receivers),
    ("kept-lists", |counted| counted.shadows.cached_lists),
    ("capped-volumes", |counted| counted.shadows.near_capped),
];

/// Measures a scene with each choice of levels. Stages and whole frames take turns, so that a drift of the machine's speed
/// hits both.
pub(crate) fn measure(
    rounds: Rounds,
    devices: &mut Devices<'_>,
    (scene, casters): (SkipScene, usize),
    size: u32,
    host: &dyn Host,
) -> Result<Row, Error> {
    let setting = scene.setting(casters)?;
    // Frames of many volumes take seconds.
    let rounds = Rounds { least: rounds.least.min(3), ..rounds };
    let Devices { stages, draws, pipelines } = devices;
    let gpu = draws.gpu;
    let depth = gpu.texture([size; 2], DEPTH);
    let receivers = depth.texture().create_view(&wgpu::TextureViewDescriptor {
        aspect: wgpu::TextureAspect::DepthOnly,
        ..wgpu::TextureViewDescriptor::default()
    });
    let counter = FragmentCounter::new(gpu, size, setting.lights.len())?;
    let (mut recorders, mut counts) = (Vec::new(), Vec::new());
    for choice in scene.choices() {
        let options = choice.options(setting.lights.len());
        let drawn = SceneRecorder::new(gpu, &setting, Some(pipelines), options)?;
        let surfaces = Some(Surfaces::of(gpu, DEPTH, &setting, drawn.positions()?));
        let (depth, receivers) = (depth.clone(), Some(receivers.clone()));
        let mut drawn = Drawn { scene: drawn, surfaces, depth, receivers };
        let mut timed = SceneRecorder::new(stages.gpu, &setting, None, options)?;
        for _ in 0..=SETTLED {
            if host.is_stopped() {
                return Err(Error::Stopped);
            }
            frame(&mut drawn, draws)?;
            stages_alone(&mut timed, stages)?;
        }
        let counter = counter.as_ref().map(|counter| counter.count(gpu, |pass, light| drawn.scene.draw(pass, light)));
        counts.push((drawn.scene.counted(gpu)?, counter.transpose()?));
        recorders.push((choice, timed, drawn));
    }
    let (stages, draws) = (RefCell::new(stages), RefCell::new(draws));
    let contenders = recorders.iter_mut().map(|(choice, timed, drawn)| -> (Variant, Contender<'_>) {
        let (stages, draws) = (&stages, &draws);
        let run = move || {
            let mut sample = stages_alone(timed, &mut stages.borrow_mut())?;
            sample.extend(frame(drawn, &mut draws.borrow_mut())?);
            Ok(sample)
        };
        (Variant::new(&choice.id, &choice.name, 4, 0), Box::new(run))
    });
    let entries = compare(rounds, contenders.collect(), host)?.into_iter().zip(&counts).map(|(entry, counted)| {
        let (counted, fragments) = counted;
        let entry = COUNTERS.iter().fold(entry, |entry, (name, of)| entry.with_count(name, of(counted) as usize));
        fragments.iter().fold(entry, |entry, &found| entry.with_count("fragments", found as usize))
    });
    let entries = entries.collect();
    Ok(Row {
        section: Section::Skipping,
        scene: scene.name.to_owned(),
        title: scene.title(casters),
        group: scene.name.to_owned(),
        facts: vec![
            ("view", json!(scene.view)),
            ("casters", json!(setting.casters.count())),
            ("faces", json!(setting.casters.faces())),
            ("lights", json!(setting.lights.len())),
            ("pairs_in_range", json!(setting.pairs_in_range)),
            ("size", json!(size)),
        ],
        entries,
    })
}

/// Times the stages, on a device on which nothing is drawn.
fn stages_alone(recorder: &mut SceneRecorder<'_>, stopwatch: &mut Stopwatch<'_>) -> Result<Sample, Error> {
    recorder.begin()?;
    let timed = stopwatch.timed(|encoder, mut timer| {
        recorder.deform(encoder, timer.as_deref_mut())?;
        recorder.encode(encoder, Until::Volumes(None), timer)
    })?;
    // Without timestamps all that is known is their sum.
    if !timed.has_stamps {
        let mut sample = times([("deform", 0.0), ("compute", timed.clock_ms)]);
        sample.push((Metric::Stage("all stages"), timed.clock_ms));
        return Ok(sample);
    }
    let [deform, compute] = [true, false].map(|deforms| timed.of(|name| (name == DEFORM) == deforms));
    let mut sample = timed.stages();
    sample.extend(times([("deform", deform), ("compute", compute)]));
    Ok(sample)
}

/// Runs a frame: deforms, draws depths, then runs stages and stencil passes. Depths are the caller's in any case, so
/// they are not timed.
fn frame(drawn: &mut Drawn<'_>, stopwatch: &mut Stopwatch<'_>) -> Result<Sample, Error> {
    let [mut recording_ms, mut frame_ms] = [0.0; 2];
    if drawn.scene.begin()? {
        let deformed = stopwatch.timed(|encoder, timer| drawn.scene.deform(encoder, beside_draws(timer)))?;
        (recording_ms, frame_ms) = (deformed.recording_ms, deformed.clock_ms);
    }
    stopwatch.by_clock(|encoder| drawn.record(encoder, "depth", None))?;
    let rest = stopwatch.frame(&["stages", STENCIL], |encoder, part, timer| drawn.record(encoder, part, timer))?;
    let (stencil, frame_ms) = (rest.of(|name| name == STENCIL), frame_ms + rest.clock_ms);
    Ok(times([("stencil", stencil), ("frame", frame_ms), ("recording", recording_ms + rest.recording_ms)]))
}
