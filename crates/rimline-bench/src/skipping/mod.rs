//! How much work each level of skipping leaves out of a frame: its stages, its stencil passes, its volumes' fragments.

pub(crate) mod scenes;
mod walk;

use std::cell::RefCell;

use rimline::gpu::{Measuring, SceneOptions};
use serde_json::{Value, json};

use crate::casters::Devices;
use crate::engine::{Contender, Metric, Rounds, Sample, times};
use crate::gpu::{Stopwatch, beside_draws};
use crate::record::{Counted, DEPTH, Drawn, FragmentCounter, STENCIL, SceneRecorder, Setting, Surfaces, Until};
use crate::row::{Row, Section, Variant, compare};
use crate::{Error, Host};
use scenes::SkipScene;

/// Frames before one is counted, so that what does not change was computed before.
const SETTLED: usize = 2;

const DEFORM: Metric = Metric::Time("deform");

/// Levels of skipping: names in the data and for people, and the work that is done without them. Clusters have an option
/// of their own. Occluded faces are no level here: no scene has any excluded.
const LEVELS: [(&str, &str, &[Measuring]); 7] = [
    ("light-reach", "light reach", &[Measuring::CULLED_BY_RANGE]),
    ("shadow-reach", "shadow reach", &[Measuring::CULLED_BY_VIEW]),
    ("nothing-moved", "nothing moved", &[Measuring::CACHED_BITS, Measuring::CACHED_LISTS]),
    ("clusters", "clusters", &[]),
    ("hidden-receivers", "hidden receivers", &[Measuring::CULLED_BY_RECEIVERS]),
    ("unneeded-figures", "unneeded figures", &[Measuring::CULLED_CASTERS]),
    ("occluders", "occluders", &[Measuring::CULLED_BY_OCCLUDERS]),
];

type Counter = (&'static str, fn(&Counted) -> u32);

/// Counters of the stages, by their names in the data.
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

/// All levels off, all on, and each off alone, with options for so many lights. Occluders are off alone where there are some,
/// and of a scene of one mesh only clusters are.
fn choices(scene: &SkipScene, max_lights: usize) -> Vec<(Variant, SceneOptions)> {
    let choice = |id: &str, name: &str, is_on: &dyn Fn(usize) -> bool| {
        let mut options = SceneOptions { max_lights, ..SceneOptions::default() };
        for (_, (id, _, bits)) in LEVELS.iter().enumerate().filter(|(level, _)| !is_on(*level)) {
            bits.iter().for_each(|bit| options.measuring.set(*bit, true));
            options.clusters_from = options.clusters_from.filter(|_| *id != "clusters");
        }
        (Variant::new(id, name, 4, 0), options)
    };
    let mut all = vec![choice("all-off", "all levels off", &|_| false), choice("all-on", "all levels on", &|_| true)];
    for (number, (id, name, _)) in LEVELS.iter().enumerate() {
        // Meshes of many faces take long to prepare.
        let matters = match *id {
            "occluders" => scene.name == "house",
            "clusters" => true,
            _ => !scene.is_one_mesh(),
        };
        if matters {
            all.push(choice(&format!("without-{id}"), &format!("all but: {name}"), &|level| level != number));
        }
    }
    all
}

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
    for (variant, options) in choices(&scene, setting.lights.len()) {
        let recorder = SceneRecorder::new(gpu, &setting, Some(pipelines), options)?;
        let surfaces = Some(Surfaces::of(gpu, DEPTH, &setting, recorder.positions()?));
        let (depth, receivers) = (depth.clone(), Some(receivers.clone()));
        let mut drawn = Drawn { scene: recorder, surfaces, depth, receivers };
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
        recorders.push((variant, timed, drawn));
    }
    let (stages, draws) = (RefCell::new(stages), RefCell::new(draws));
    let contenders = recorders.iter_mut().map(|(variant, timed, drawn)| -> (Variant, Contender<'_>) {
        let (stages, draws) = (&stages, &draws);
        let run = move || {
            let mut sample = stages_alone(timed, &mut stages.borrow_mut())?;
            sample.extend(frame(drawn, &mut draws.borrow_mut())?);
            Ok(sample)
        };
        (variant.clone(), Box::new(run))
    });
    let entries = compare(rounds, contenders.collect(), host)?.into_iter().zip(&counts).map(|(entry, counted)| {
        let (counted, fragments) = counted;
        // Not known where all stages have one time.
        let entry = if entry.values(DEFORM).is_empty() { entry.with(DEFORM, []) } else { entry };
        let entry = COUNTERS.iter().fold(entry, |entry, (name, of)| entry.with_count(name, of(counted) as usize));
        fragments.iter().fold(entry, |entry, &found| entry.with_count("fragments", found as usize))
    });
    let entries = entries.collect();
    Ok(Row {
        section: Section::Skipping,
        scene: scene.name.to_owned(),
        title: scene.title(casters),
        group: scene.name.to_owned(),
        facts: facts(&scene, &setting, size),
        entries,
    })
}

fn facts(scene: &SkipScene, setting: &Setting, size: u32) -> Vec<(&'static str, Value)> {
    vec![
        ("view", json!(scene.view)),
        ("casters", json!(setting.casters.count())),
        ("faces", json!(setting.casters.faces())),
        ("lights", json!(setting.lights.len())),
        ("pairs_in_range", json!(setting.pairs_in_range)),
        ("size", json!(size)),
    ]
}

/// Times the stages of the next frame without receivers, on a device on which nothing is drawn. Posing is not timed.
fn stages_alone(recorder: &mut SceneRecorder<'_>, stopwatch: &mut Stopwatch<'_>) -> Result<Sample, Error> {
    recorder.begin()?;
    let timed = stopwatch.timed(|encoder, mut timer| {
        recorder.deform(encoder, timer.as_deref_mut())?;
        recorder.encode(encoder, Until::Volumes(None), timer)
    })?;
    if !timed.has_stamps {
        // All that is known is their sum.
        let mut sample = times([("compute", timed.clock_ms)]);
        sample.push((Metric::Stage("all stages"), timed.clock_ms));
        return Ok(sample);
    }
    let [deform, compute] = [true, false].map(|deforms| timed.of(|name| (name == "deform") == deforms));
    let mut sample = times([("deform", deform), ("compute", compute)]);
    sample.extend(timed.stages());
    Ok(sample)
}

/// Runs the next frame: poses and deforms casters that walk, draws depths, then runs stages and stencil passes. Poses and depths
/// are the caller's in any case, so they are not timed. The whole frame is timed by the clock.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_level_is_off_alone_once() {
        let house = SkipScene::named("house", true).remove(0);
        let all: Vec<String> = choices(&house, 5).iter().map(|(_, options)| format!("{options:?}")).collect();
        assert_eq!(all.len(), LEVELS.len() + 2);
        // A switch that changes nothing is none.
        assert!((1..all.len()).all(|at| !all[..at].contains(&all[at])), "{all:?}");
        let defaults = SceneOptions { max_lights: 5, ..SceneOptions::default() };
        assert_eq!(all[1], format!("{defaults:?}"));
    }

    #[test]
    fn counters_have_distinct_names() {
        for (at, (name, _)) in COUNTERS.iter().enumerate() {
            assert!(COUNTERS[..at].iter().all(|(other, _)| other != name), "{name}");
        }
    }
}
