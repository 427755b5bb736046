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
use crate::engine::{Contender, Metric, Rounds, Sample, interleave};
use crate::gpu::{Stopwatch, Timed, beside_draws};
use crate::record::{
    Counted, DEPTH, FragmentCounter, Pass, Recorder as _, STENCIL, SceneRecorder, Surfaces, stencil_pass,
};
use crate::row::{Entry, Row, Section, Variant as Named};
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
    let Devices { stages, draws, scene: pipelines, .. } = devices;
    let gpu = draws.gpu;
    let depth = gpu.texture(size, DEPTH).create_view(&wgpu::TextureViewDescriptor::default());
    let counter = FragmentCounter::new(gpu, size, setting.lights.len())?;
    let variants = scene.variants();
    let (mut pairs, mut counts) = (Vec::new(), Vec::new());
    for variant in &variants {
        let options = variant.options(setting.lights.len());
        let mut drawn = SceneRecorder::new(gpu, &setting, Some(pipelines), options)?;
        let seen = Seen { surfaces: Surfaces::of(gpu, &setting, drawn.positions()?), depth: depth.clone() };
        let mut timed = SceneRecorder::new(stages.gpu, &setting, None, options)?;
        for _ in 0..=SETTLED {
            if host.is_stopped() {
                return Err(Error::Stopped);
            }
            frame(&mut drawn, &seen, draws)?;
            stages_alone(&mut timed, stages)?;
        }
        let counter = counter.as_ref().map(|counter| counter.count(gpu, |pass, light| drawn.draw(pass, light)));
        counts.push((drawn.counted(gpu)?, counter.transpose()?));
        pairs.push((timed, drawn, seen));
    }
    let (stages, draws) = (RefCell::new(stages), RefCell::new(draws));
    let contenders = pairs.iter_mut().map(|(timed, drawn, seen)| -> Contender<'_> {
        let (stages, draws, seen) = (&stages, &draws, &*seen);
        Box::new(move || {
            let mut sample = stages_alone(timed, &mut stages.borrow_mut())?;
            sample.extend(frame(drawn, seen, &mut draws.borrow_mut())?);
            Ok(sample)
        })
    });
    let samples = interleave(rounds, contenders.collect(), host)?;
    let mut entries = Vec::new();
    for ((variant, samples), (counted, fragments)) in variants.iter().zip(samples).zip(&counts) {
        let mut entry = Entry::new(Named::new(&variant.id(), &variant.name(), 4, 0), &samples);
        for (name, of) in COUNTERS {
            entry = entry.with_count(name, of(counted) as usize);
        }
        entries.push(fragments.iter().fold(entry, |entry, &found| entry.with_count("fragments", found as usize)));
    }
    Ok(Row {
        section: Section::Skipping,
        scene: scene.name().to_owned(),
        title: scene.title(casters),
        group: scene.name().to_owned(),
        facts: vec![
            ("view", json!(scene.view())),
            ("casters", json!(setting.casters.count())),
            ("faces", json!(setting.casters.faces())),
            ("lights", json!(setting.lights.len())),
            ("pairs_in_range", json!(setting.pairs_in_range)),
            ("size", json!(size)),
        ],
        entries,
    })
}

/// Visible surfaces: depths that volumes are tested against.
struct Seen {
    surfaces: Surfaces,
    depth: wgpu::TextureView,
}

/// Times the stages, on a device on which nothing is drawn.
fn stages_alone(recorder: &mut SceneRecorder<'_>, stopwatch: &mut Stopwatch<'_>) -> Result<Sample, Error> {
    recorder.begin()?;
    let timed = stopwatch.timed(|encoder, mut timer| {
        recorder.deform(encoder, timer.as_deref_mut())?;
        recorder.encode_seen(encoder, None, timer)
    })?;
    let mut sample = timed.stages();
    let deform = timed.of(|name| name == DEFORM);
    // Without timestamps all that is known is their sum.
    let compute = if timed.passes.is_some() { timed.of(|name| name != DEFORM) } else { timed.clock_ms };
    if timed.passes.is_none() {
        sample.push((Metric::Stage("all stages"), timed.clock_ms));
    }
    sample.extend([(Metric::Time("deform"), deform), (Metric::Time("compute"), compute)]);
    Ok(sample)
}

/// Runs a frame: deforms, draws depths, then runs stages and stencil passes. Depths are the caller's in any case, so
/// they are not timed.
fn frame(recorder: &mut SceneRecorder<'_>, seen: &Seen, stopwatch: &mut Stopwatch<'_>) -> Result<Sample, Error> {
    let (gpu, depth) = (stopwatch.gpu, &seen.depth);
    let (mut frame_ms, mut recording_ms) = (0.0, 0.0);
    let mut add = |timed: &Timed| {
        frame_ms += timed.clock_ms;
        recording_ms += timed.recording_ms;
    };
    if recorder.begin()? {
        add(&stopwatch.timed(|encoder, mut timer| recorder.deform(encoder, beside_draws(&mut timer)))?);
    }
    let mut encoder = gpu.encoder();
    seen.surfaces.pass(&mut encoder, depth, Pass::Depth, None);
    gpu.queue.submit([encoder.finish()]);
    gpu.wait()?;
    let depths = depth.texture().create_view(&wgpu::TextureViewDescriptor {
        aspect: wgpu::TextureAspect::DepthOnly,
        ..wgpu::TextureViewDescriptor::default()
    });
    let passes = |encoder: &mut wgpu::CommandEncoder, recorder: &SceneRecorder<'_>, mut timer: Option<&mut _>| {
        (0..recorder.lights.len()).try_for_each(|light| {
            let mut pass = stencil_pass(encoder, depth, LoadOp::Load, timer.as_deref_mut(), None);
            recorder.draw(&mut pass, light)
        })
    };
    // Without timestamps the clock tells the passes from the stages, if they are submitted apart.
    let is_apart = !stopwatch.has_timer();
    let all = stopwatch.timed(|encoder, mut timer| {
        recorder.encode_seen(encoder, Some(&depths), beside_draws(&mut timer))?;
        if is_apart { Ok(()) } else { passes(encoder, recorder, timer) }
    })?;
    add(&all);
    let mut stencil = all.of(|name| name == STENCIL);
    if is_apart {
        let drawn = stopwatch.timed(|encoder, timer| passes(encoder, recorder, timer))?;
        add(&drawn);
        stencil = drawn.clock_ms;
    }
    Ok([("stencil", stencil), ("frame", frame_ms), ("recording", recording_ms)]
        .map(|(name, ms)| (Metric::Time(name), ms))
        .into())
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
