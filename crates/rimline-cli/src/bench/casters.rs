//! Scenes of many casters: CPU time of recording a frame, GPU time against the same faces merged into one mesh, memory,
//! and silhouettes that are not those of the merged mesh.

pub(crate) mod field;
mod measure;
mod recorder;
pub(crate) mod results;
mod text;

use std::cell::RefCell;

use rimline_measure::shapes;

use super::measure::{Contender, Rounds, interleave};
use crate::device::Gpu;
use crate::failure::{Failure, NoDevice};
use crate::output::{is_interrupted, note, print};
use crate::progress::Progress;
use field::{CasterMesh, Field};
use measure::{FrameTimes, Stopwatch, allocated_bytes};
use recorder::{MeshRecorders, Recorder, SceneRecorder, Until};
use results::{CastersResults, CastersRow, Change, Compared, OneMeshRow};

/// What is measured.
#[derive(Clone, Debug)]
pub(crate) struct CastersPlan {
    /// Numbers of casters. Empty: nothing is measured.
    pub(crate) numbers: Vec<usize>,
    /// Approximate face counts of the single casters that are held against an extractor.
    pub(crate) one_mesh: Vec<usize>,
    /// Pixels across and down.
    pub(crate) size: u32,
    pub(crate) rounds: Rounds,
}

/// The most casters that are also drawn and timed on the GPU, and the most figures.
const MOST_ON_GPU: usize = 1000;
/// The most casters that have an extractor each.
const MOST_EXTRACTORS: usize = 100;

impl CastersPlan {
    fn scenes(&self) -> impl Iterator<Item = (CasterMesh, usize)> {
        let of = |mesh: CasterMesh, most: usize| {
            self.numbers.iter().filter(move |casters| **casters <= most).map(move |&casters| (mesh, casters))
        };
        of(CasterMesh::Cube, usize::MAX).chain(of(CasterMesh::Figure, MOST_ON_GPU))
    }

    pub(crate) fn rows(&self) -> usize {
        if self.numbers.is_empty() { 0 } else { self.scenes().count() + self.one_mesh.len() }
    }

    pub(crate) fn empty_results(&self) -> CastersResults {
        CastersResults { size: self.size, rows: Vec::new(), one_mesh: Vec::new(), planned_rows: self.rows() }
    }
}

/// Measures row after row until Ctrl-C.
pub(super) fn measure_all(
    plan: &CastersPlan,
    gpu: &Gpu,
    progress: &Progress,
    results: &mut CastersResults,
) -> Result<(), Failure> {
    if plan.rows() == 0 {
        return Ok(());
    }
    let mut stopwatch = Stopwatch::new(gpu, plan.size)?;
    for (mesh, casters) in plan.scenes() {
        let title = format!("scene of {}", mesh.counted(casters));
        progress.step(title.clone());
        match measure_scene(plan, gpu, &mut stopwatch, mesh, casters) {
            Ok(None) => return Ok(()),
            Ok(Some(row)) => {
                progress.aside(|| print(&text::row(&row)))?;
                results.rows.push(row);
            }
            Err(Failure::NoDevice(reason @ NoDevice::TooSmall { .. })) => {
                note(&format!("without the {title}: {reason}"));
                results.planned_rows -= 1;
            }
            Err(failure) => return Err(failure),
        }
        progress.advance(&title);
    }
    for &faces in &plan.one_mesh {
        let title = format!("scene of one mesh of {} faces", super::grouped::grouped(faces));
        progress.step(title.clone());
        let Some(row) = measure_one_mesh(plan, gpu, &mut stopwatch, faces)? else { return Ok(()) };
        progress.aside(|| print(&text::one_mesh_row(&row)))?;
        results.one_mesh.push(row);
        progress.advance(&title);
    }
    Ok(())
}

/// `None` where Ctrl-C came first.
fn measure_scene(
    plan: &CastersPlan,
    gpu: &Gpu,
    stopwatch: &mut Stopwatch<'_>,
    mesh: CasterMesh,
    casters: usize,
) -> Result<Option<CastersRow>, Failure> {
    let field = Field::new(mesh.shape(), casters);
    let before = allocated_bytes(gpu)?;
    let (mut scene, handles) = SceneRecorder::new(gpu, &field)?;
    stopwatch.warm_up(&mut scene, Until::Volumes)?;
    let scene_device_bytes = taken(before, allocated_bytes(gpu)?);
    let fail = |error: crate::gpu_error::GpuError| error.on(gpu);
    let scene_bytes = scene.bytes().map_err(fail)?;

    let mut merged = MeshRecorders::new(gpu, &stopwatch.pipelines, &field, [field.merged()])?;
    stopwatch.warm_up(&mut merged, Until::Extraction)?;
    let edges = [scene.silhouette_edges(gpu).map_err(fail)?, merged.silhouette_edges(gpu).map_err(fail)?];
    let compared = if casters <= MOST_ON_GPU {
        let Some(compared) = compare(plan.rounds, stopwatch, Until::Volumes, [&mut scene, &mut merged])? else {
            return Ok(None);
        };
        Some(compared)
    } else {
        None
    };
    drop(merged);

    let before = allocated_bytes(gpu)?;
    let mut extractors = None;
    let mut extractors_device_bytes = None;
    if casters <= MOST_EXTRACTORS {
        let mut all = MeshRecorders::new(gpu, &stopwatch.pipelines, &field, field.placed())?;
        stopwatch.warm_up(&mut all, Until::Volumes)?;
        extractors_device_bytes = taken(before, allocated_bytes(gpu)?);
        extractors = Some(all);
    }
    let scene = RefCell::new(scene);
    let stopwatch = &*stopwatch;
    // Casters of each round's change follow those of the round before, so that memory is read where it was not read last.
    let moving = |count: usize| -> Contender<'_, f64> {
        let (scene, handles, field) = (&scene, &handles, &field);
        let (mut next, mut round) = (0, 0);
        Box::new(move || {
            round += 1;
            stopwatch.recording(&mut *scene.borrow_mut(), |recorder| {
                for _ in 0..count {
                    next = (next + 97) % casters;
                    recorder.scene().set_transform(handles[next], field.turned[(next + round) % casters])?;
                }
                Ok(())
            })
        })
    };
    let mut contenders = vec![moving(0), moving(casters.div_ceil(100)), moving(casters)];
    let mut changes = vec![Change::Still, Change::OneInHundred, Change::All];
    if let Some(extractors) = &mut extractors {
        changes.push(Change::Extractors);
        contenders.push(Box::new(move || stopwatch.recording(extractors, |_| Ok(()))));
    }
    let Some(samples) = interleave(plan.rounds, contenders, is_interrupted)? else { return Ok(None) };
    Ok(Some(CastersRow {
        mesh,
        faces: field.shape.faces.len(),
        casters,
        recording: changes.into_iter().zip(samples).collect(),
        scene_bytes,
        scene_device_bytes,
        extractors_device_bytes,
        compared,
        edges,
    }))
}

/// Bytes allocated meanwhile.
fn taken(before: Option<u64>, after: Option<u64>) -> Option<u64> {
    Some(after?.saturating_sub(before?))
}

/// GPU times of a scene and of what it is held against, in turn. `None` where Ctrl-C came first.
fn compare(
    rounds: Rounds,
    stopwatch: &mut Stopwatch<'_>,
    until: Until,
    [scene, other]: [&mut dyn Recorder; 2],
) -> Result<Option<Compared>, Failure> {
    let stopwatch = RefCell::new(stopwatch);
    let contenders: [Contender<'_, FrameTimes>; 2] = [
        Box::new(|| stopwatch.borrow_mut().frame(scene, until)),
        Box::new(|| stopwatch.borrow_mut().frame(other, until)),
    ];
    let Some(samples) = interleave(rounds, contenders.into(), is_interrupted)? else { return Ok(None) };
    let mut samples = samples.into_iter();
    Ok(Some(Compared { scene: samples.next().unwrap_or_default(), other: samples.next().unwrap_or_default() }))
}

/// `None` where Ctrl-C came first.
fn measure_one_mesh(
    plan: &CastersPlan,
    gpu: &Gpu,
    stopwatch: &mut Stopwatch<'_>,
    faces: usize,
) -> Result<Option<OneMeshRow>, Failure> {
    // Twice as many rings as segments, two faces each.
    let segments = ((faces as f64 / 4.0).sqrt().round() as u32).max(3);
    let field = Field::new(shapes::torus(2 * segments, segments, 1.0, 0.4), 1);
    let (mut scene, _) = SceneRecorder::new(gpu, &field)?;
    let mut extractor = MeshRecorders::new(gpu, &stopwatch.pipelines, &field, [field.merged()])?;
    stopwatch.warm_up(&mut scene, Until::Extraction)?;
    stopwatch.warm_up(&mut extractor, Until::Extraction)?;
    let fail = |error: crate::gpu_error::GpuError| error.on(gpu);
    let edges = [scene.silhouette_edges(gpu).map_err(fail)?, extractor.silhouette_edges(gpu).map_err(fail)?];
    let compared = compare(plan.rounds, stopwatch, Until::Extraction, [&mut scene, &mut extractor])?;
    Ok(compared.map(|compared| OneMeshRow { faces: field.shape.faces.len(), compared, edges }))
}
