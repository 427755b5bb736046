//! How much work each level of skipping leaves out of a frame: its stages, its stencil passes, its volumes' fragments.

mod big;
mod city;
mod crowd;
mod fragments;
pub(crate) mod levels;
mod measure;
mod moving;
mod receivers;
mod recorder;
pub(crate) mod results;
pub(crate) mod scenes;
mod setting;
mod still;
mod text;
mod walk;

use super::casters::measure::Stopwatch;
use super::measure::Rounds;
use crate::device::Gpu;
use crate::failure::{Failure, NoDevice};
use crate::output::{note, print};
use crate::progress::Progress;
use measure::Measured;
use results::{SkipEntry, SkipResults, SkipRow};
use scenes::SkipScene;

#[derive(Clone, Debug)]
pub(crate) struct SkipPlan {
    /// Scenes with their numbers of casters.
    pub(crate) scenes: Vec<(SkipScene, usize)>,
    /// Pixels across and down.
    pub(crate) size: u32,
    pub(crate) rounds: Rounds,
}

impl SkipPlan {
    pub(crate) fn rows(&self) -> usize {
        self.scenes.len()
    }

    pub(crate) fn empty_results(&self) -> SkipResults {
        SkipResults { size: self.size, rows: Vec::new(), planned_rows: self.rows() }
    }
}

/// Measures row after row until Ctrl-C. `another` is a second device on the same adapter, on which nothing was drawn.
pub(super) fn measure_all(
    plan: &SkipPlan,
    gpu: &Gpu,
    another: &Gpu,
    progress: &Progress,
    results: &mut SkipResults,
) -> Result<(), Failure> {
    if plan.rows() == 0 {
        return Ok(());
    }
    let mut devices = [Stopwatch::new(another)?, Stopwatch::new(gpu)?];
    for &(scene, casters) in &plan.scenes {
        let title = scene.title(casters);
        progress.step(title.clone());
        match measure_row(plan, &mut devices, scene, casters) {
            Ok(None) => return Ok(()),
            Ok(Some(row)) => {
                progress.aside(|| print(&text::row(&row)))?;
                results.rows.push(row);
            }
            Err(Failure::NoDevice(reason @ NoDevice::TooSmall { .. })) => {
                note(&format!("without the scene {title}: {reason}"));
                results.planned_rows -= 1;
            }
            Err(failure) => return Err(failure),
        }
        progress.advance(&title);
    }
    Ok(())
}

/// `None` where Ctrl-C came first.
fn measure_row(
    plan: &SkipPlan,
    devices: &mut [Stopwatch<'_>; 2],
    scene: SkipScene,
    casters: usize,
) -> Result<Option<SkipRow>, Failure> {
    let setting = scene.setting(casters).map_err(recorder::model_failure)?;
    // Frames of many volumes take seconds.
    let rounds = Rounds { least: plan.rounds.least.min(3), ..plan.rounds };
    let variants = scene.variants();
    let Some(measured) = measure::measure(rounds, devices, &setting, &variants, plan.size)? else { return Ok(None) };
    let entries = variants.into_iter().zip(measured).map(|(variant, Measured { runs, counted, fragments })| {
        let (stages, frames) = runs.into_iter().unzip();
        SkipEntry { variant, stages, frames, counted, fragments }
    });
    Ok(Some(SkipRow {
        scene,
        casters: setting.casters.count(),
        faces: setting.casters.faces(),
        lights: setting.lights.len(),
        pairs_in_range: setting.pairs_in_range,
        entries: entries.collect(),
    }))
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use rimline_bench::shapes::Shape;

    /// Positive where faces are counter-clockwise seen from outside.
    pub(super) fn volume(shape: &Shape) -> f64 {
        let corner = |vertex: u32| DVec3::from(shape.positions[vertex as usize].map(f64::from));
        let signed = |face: &[u32; 3]| {
            let [a, b, c] = face.map(corner);
            a.dot(b.cross(c)) / 6.0
        };
        shape.faces.iter().map(signed).sum()
    }
}
