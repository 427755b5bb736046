//! How much work each level of skipping leaves out of a frame: its stages, its stencil passes, its volumes' fragments.

mod city;
mod crowd;
mod house;
pub(crate) mod levels;
pub(crate) mod scenes;
mod walk;

use std::cell::RefCell;

use serde_json::json;
use wgpu::LoadOp;

use crate::casters::Devices;
use crate::engine::{Contender, Metric, Rounds, Sample, times};
use crate::gpu::{Stopwatch, beside_draws};
use crate::record::{Counted, DEPTH, FragmentCounter, Pass, STENCIL, SceneRecorder, Surfaces, Target};
use crate::row::{Row, Section, Variant, compare};
use crate::{Error, Host};
use scenes::SkipScene;

/// Frames before one is counted, so that what does not change was computed before.
const SETTLED: usize = 2;
/// The stage that deforms, as the timer has it.
const DEFORM: &str = "deform";
/// The parts of a frame: deforming and compute stages by timestamps, the stencil passes of all lights, the whole frame
/// by the clock, and time of the CPU for recording.
pub(crate) const PARTS: [&str; 5] = ["deform", "compute", "stencil", "frame", "recording"];

/// A counter of the stages, by its name in the data.
type Counter = (&'static str, fn(&Counted) -> u32);

pub(crate) const COUNTERS: [Counter; 14] = [
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
    let counter = FragmentCounter::new(gpu, size, setting.lights.len())?;
    let (mut recorders, mut counts) = (Vec::new(), Vec::new());
    for choice in scene.choices() {
        let options = choice.options(setting.lights.len());
        let mut drawn = SceneRecorder::new(gpu, &setting, Some(pipelines), options)?;
        let surfaces = Surfaces::of(gpu, &setting, drawn.positions()?);
        let mut timed = SceneRecorder::new(stages.gpu, &setting, None, options)?;
        for _ in 0..=SETTLED {
            if host.is_stopped() {
                return Err(Error::Stopped);
            }
            frame(&mut drawn, &surfaces, &depth, draws)?;
            stages_alone(&mut timed, stages)?;
        }
        let counter = counter.as_ref().map(|counter| counter.count(gpu, |pass, light| drawn.draw(pass, light)));
        counts.push((drawn.counted(gpu)?, counter.transpose()?));
        recorders.push((choice, timed, drawn, surfaces));
    }
    let (stages, draws) = (RefCell::new(stages), RefCell::new(draws));
    let contenders = recorders.iter_mut().map(|(choice, timed, drawn, surfaces)| -> (Variant, Contender<'_>) {
        let (stages, draws, depth) = (&stages, &draws, &depth);
        let run = move || {
            let mut sample = stages_alone(timed, &mut stages.borrow_mut())?;
            sample.extend(frame(drawn, surfaces, depth, &mut draws.borrow_mut())?);
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
        recorder.encode_seen(encoder, None, timer)
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
fn frame(
    recorder: &mut SceneRecorder<'_>,
    surfaces: &Surfaces,
    depth: &wgpu::TextureView,
    stopwatch: &mut Stopwatch<'_>,
) -> Result<Sample, Error> {
    let [mut recording_ms, mut frame_ms] = [0.0; 2];
    if recorder.begin()? {
        let deformed = stopwatch.timed(|encoder, timer| recorder.deform(encoder, beside_draws(timer)))?;
        (recording_ms, frame_ms) = (deformed.recording_ms, deformed.clock_ms);
    }
    stopwatch.by_clock(|encoder| {
        surfaces.pass(encoder, depth, Pass::Depth, None);
        Ok(())
    })?;
    let depths = depth.texture().create_view(&wgpu::TextureViewDescriptor {
        aspect: wgpu::TextureAspect::DepthOnly,
        ..wgpu::TextureViewDescriptor::default()
    });
    let rest = stopwatch.frame(&["stages", STENCIL], |encoder, part, mut timer| {
        if part == "stages" {
            return recorder.encode_seen(encoder, Some(&depths), beside_draws(timer));
        }
        (0..recorder.lights.len()).try_for_each(|light| {
            let target = Target::counting(depth, LoadOp::Load);
            recorder.draw(&mut target.begin_timed(encoder, STENCIL, timer.as_deref_mut(), None), light)
        })
    })?;
    let (stencil, frame_ms) = (rest.of(|name| name == STENCIL), frame_ms + rest.clock_ms);
    Ok(times([("stencil", stencil), ("frame", frame_ms), ("recording", recording_ms + rest.recording_ms)]))
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::shapes::Shape;

    /// Positive where faces are counter-clockwise seen from outside.
    pub(super) fn volume(shape: &Shape) -> f64 {
        let corner = |vertex: u32| DVec3::from(shape.positions[vertex as usize].map(f64::from));
        let signed = |face: &[u32; 3]| {
            let [a, b, c] = face.map(corner);
            a.dot(b.cross(c)) / 6.0
        };
        shape.faces.iter().map(signed).sum()
    }

    #[test]
    fn counters_have_distinct_names() {
        let mut ids: Vec<&str> = COUNTERS.iter().map(|counter| counter.0).collect();
        ids.sort_unstable();
        ids.dedup();
        assert_eq!(ids.len(), COUNTERS.len());
    }
}
