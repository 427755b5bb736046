//! Counting methods against each other over paths of cameras: time of the stencil pass and of the whole frame, and wrong
//! pixels.

pub(crate) mod method;
mod renderer;
pub(crate) mod results;
pub(crate) mod scene;
mod text;
mod truth;

use super::measure::{Contender, Rounds, interleave};
use crate::device::Gpu;
use crate::failure::Failure;
use crate::output::{is_interrupted, print};
use crate::progress::Progress;
use method::METHODS;
use renderer::{FrameTime, ShadowBenchRenderer, Stage};
use results::{ShadowEntry, ShadowResults, ShadowRow, WrongPixels};
use scene::{MODELS, PATHS, Path};
use truth::Truth;

#[derive(Clone, Copy, Debug)]
pub(crate) struct ShadowPlan {
    /// How many of the models, from the first on.
    pub(crate) models: usize,
    /// Frames of each path; 0 leaves all out.
    pub(crate) frames: usize,
    /// Pixels across and down.
    pub(crate) size: u32,
    pub(crate) rounds: Rounds,
}

impl ShadowPlan {
    pub(crate) fn rows(&self) -> usize {
        if self.frames == 0 { 0 } else { self.models.min(MODELS.len()) * PATHS.len() }
    }

    pub(crate) fn empty_results(&self) -> ShadowResults {
        ShadowResults { size: self.size, frames: self.frames, rows: Vec::new(), planned_rows: self.rows() }
    }

    /// Frames that are held against rays: about four of each path.
    fn checked(&self) -> impl Iterator<Item = usize> {
        (0..self.frames).step_by(self.frames.div_ceil(4).max(1))
    }

    fn camera(&self, path: Path, frame: usize) -> crate::render::camera::Camera {
        path.camera(frame as f32 / self.frames.saturating_sub(1).max(1) as f32)
    }
}

/// Measures row after row until Ctrl-C.
pub(super) fn measure_all(
    plan: &ShadowPlan,
    gpu: &Gpu,
    progress: &Progress,
    results: &mut ShadowResults,
) -> Result<(), Failure> {
    if plan.rows() == 0 {
        return Ok(());
    }
    let room = scene::room();
    for model in MODELS.into_iter().take(plan.models) {
        let caster = model.make();
        let failed = |source: rimline::MeshError| Failure::Input { file: model.name.into(), source: source.into() };
        let mesh = caster.mesh().map_err(failed)?;
        let stage = Stage { mesh: &mesh, caster: &caster, room: &room, size: plan.size };
        for path in PATHS {
            let title = format!("shadows of a {}: {}", model.name, path.name());
            progress.step(title.clone());
            let Some(entries) = measure(plan, gpu, &stage, path)? else { return Ok(()) };
            let row = ShadowRow { model: model.name, faces: mesh.faces().len(), path, entries };
            progress.aside(|| print(&text::row(&row)))?;
            results.rows.push(row);
            progress.advance(&title);
        }
    }
    Ok(())
}

/// Times and wrong pixels of every method; `None` where Ctrl-C came first.
fn measure(plan: &ShadowPlan, gpu: &Gpu, stage: &Stage<'_>, path: Path) -> Result<Option<Vec<ShadowEntry>>, Failure> {
    let light = path.light();
    let mut theatres = Vec::new();
    for method in &METHODS {
        theatres.push(ShadowBenchRenderer::new(gpu, stage, method).map_err(|error| error.on(gpu))?);
    }
    let mut wrong = vec![Vec::new(); METHODS.len()];
    let truth = Truth::new(stage, light);
    for frame in plan.checked() {
        if is_interrupted() {
            return Ok(None);
        }
        let camera = plan.camera(path, frame);
        let seen = truth.seen(&camera);
        for (renderer, wrong) in theatres.iter_mut().zip(&mut wrong) {
            wrong.push(WrongPixels { frame, pixels: seen.wrong(&renderer.counts(&camera, light)?) });
        }
    }
    let contenders = theatres.iter_mut().map(|renderer| -> Contender<'_, Vec<FrameTime>> {
        Box::new(move || (0..plan.frames).map(|frame| renderer.draw(&plan.camera(path, frame), light)).collect())
    });
    let Some(rounds) = interleave(plan.rounds, contenders.collect(), is_interrupted)? else { return Ok(None) };
    let entries = METHODS.iter().zip(rounds).zip(wrong);
    Ok(Some(entries.map(|((method, rounds), wrong_pixels)| ShadowEntry { method, rounds, wrong_pixels }).collect()))
}
