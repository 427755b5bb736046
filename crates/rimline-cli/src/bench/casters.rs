//! Scenes of many casters: CPU time of recording a frame, GPU time against the same faces merged into one mesh, memory,
//! and silhouettes that are not those of the merged mesh.

pub(crate) mod field;
pub(crate) mod measure;
pub(crate) mod recorder;
pub(crate) mod results;
mod text;

use std::cell::RefCell;

use rimline::gpu::{Caster, CasterHandle};
use rimline::wgpu;
use rimline_bench::shapes;

use super::measure::{Contender, Rounds, interleave};
use crate::device::Gpu;
use crate::failure::{Failure, NoDevice};
use crate::output::{is_interrupted, note, print};
use crate::progress::Progress;
use field::{CasterMesh, Field, LIGHTS};
use measure::{DrawTimes, StageTimes, Stopwatch, allocated_bytes};
use recorder::{MeshRecorders, Recorder, SceneRecorder, Until};
use results::{BothTimes, CastersResults, CastersRow, Change, Compared, Edges, OneMeshRow};

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

/// The most casters whose volumes are drawn.
const MOST_DRAWN: usize = 1000;
const MOST_FIGURES: usize = 1000;
/// The most casters that have an extractor each.
const MOST_EXTRACTORS: usize = 100;

impl CastersPlan {
    fn scenes(&self) -> impl Iterator<Item = (CasterMesh, usize)> {
        let of = |mesh: CasterMesh, most: usize| {
            self.numbers.iter().filter(move |casters| **casters <= most).map(move |&casters| (mesh, casters))
        };
        of(CasterMesh::Cube, usize::MAX).chain(of(CasterMesh::Figure, MOST_FIGURES))
    }

    pub(crate) fn rows(&self) -> usize {
        if self.numbers.is_empty() { 0 } else { self.scenes().count() + self.one_mesh.len() }
    }

    pub(crate) fn empty_results(&self) -> CastersResults {
        CastersResults { size: self.size, rows: Vec::new(), one_mesh: Vec::new(), planned_rows: self.rows() }
    }
}

/// The devices on which frames run.
struct Devices<'a> {
    /// Nothing is drawn on it.
    stages: Stopwatch<'a>,
    draws: Stopwatch<'a>,
    depth: wgpu::TextureView,
}

/// Measures row after row until Ctrl-C. `another` is a second device on the same adapter, on which nothing was drawn.
pub(super) fn measure_all(
    plan: &CastersPlan,
    gpu: &Gpu,
    another: &Gpu,
    progress: &Progress,
    results: &mut CastersResults,
) -> Result<(), Failure> {
    if plan.rows() == 0 {
        return Ok(());
    }
    let (stages, draws) = (Stopwatch::new(another)?, Stopwatch::new(gpu)?);
    let depth = draws.depth(plan.size);
    let mut devices = Devices { stages, draws, depth };
    for (mesh, casters) in plan.scenes() {
        let title = format!("scene of {}", mesh.counted(casters));
        progress.step(title.clone());
        match measure_scene(plan.rounds, &mut devices, mesh, casters) {
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
        let Some(row) = measure_one_mesh(plan.rounds, &mut devices.stages, faces)? else { return Ok(()) };
        progress.aside(|| print(&text::one_mesh_row(&row)))?;
        results.one_mesh.push(row);
        progress.advance(&title);
    }
    Ok(())
}

/// `None` where Ctrl-C came first.
fn measure_scene(
    rounds: Rounds,
    devices: &mut Devices<'_>,
    mesh: CasterMesh,
    casters: usize,
) -> Result<Option<CastersRow>, Failure> {
    let field = Field::new(mesh.shape(), casters);
    let stages = compare_stages(rounds, &mut devices.stages, &field, Until::Volumes)?;
    let Some((mut compared, edges)) = stages else { return Ok(None) };

    let Devices { draws: stopwatch, depth, .. } = devices;
    let gpu = stopwatch.gpu;
    let before = allocated_bytes(gpu)?;
    let (mut scene, handles) = SceneRecorder::new(gpu, &field, false)?;
    stopwatch.stages_by_clock(&mut scene, Until::Volumes)?;
    let scene_device_bytes = taken(before, allocated_bytes(gpu)?);
    let scene_bytes = scene.bytes().map_err(|error| error.on(gpu))?;
    if casters <= MOST_DRAWN {
        let Some(draws) = compare_draws(rounds, stopwatch, depth, &field, &mut scene)? else { return Ok(None) };
        compared.draws = draws;
    }

    let mut extractors = None;
    let mut extractors_device_bytes = None;
    if casters <= MOST_EXTRACTORS {
        let before = allocated_bytes(gpu)?;
        let mut all = MeshRecorders::new(gpu, &stopwatch.pipelines, &field, field.placed())?;
        stopwatch.stages_by_clock(&mut all, Until::Volumes)?;
        extractors_device_bytes = taken(before, allocated_bytes(gpu)?);
        extractors = Some(all);
    }
    let recording = record(rounds, stopwatch, &field, &handles, scene, extractors)?;
    Ok(recording.map(|recording| CastersRow {
        mesh,
        faces: field.shape.faces.len(),
        casters,
        recording,
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

/// Recording times of each change in ms.
type Recorded = Vec<(Change, Vec<f64>)>;

/// CPU times of recording. `None` where Ctrl-C came first.
fn record(
    rounds: Rounds,
    stopwatch: &Stopwatch<'_>,
    field: &Field,
    handles: &[CasterHandle],
    scene: SceneRecorder,
    extractors: Option<MeshRecorders>,
) -> Result<Option<Recorded>, Failure> {
    let (lights, mesh) = (scene.lights().to_vec(), scene.mesh());
    let scene = RefCell::new(scene);
    let casters = handles.len();
    // Casters of each round's change follow those of the round before, so that memory is read where it was not read last.
    let moving = |count: usize| -> Contender<'_, f64> {
        let scene = &scene;
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
    let (mut round, mut last) = (0, None);
    let light = || {
        round += 1;
        stopwatch.recording(&mut *scene.borrow_mut(), |recorder| {
            Ok(recorder.scene().set_light(lights[0], field.lights[round % LIGHTS])?)
        })
    };
    let new_caster = || {
        stopwatch.recording(&mut *scene.borrow_mut(), |recorder| {
            if let Some(last) = last.take() {
                recorder.scene().remove(last)?;
            }
            last = Some(recorder.scene().insert(Caster::rigid(mesh, field.turned[0]))?);
            Ok(())
        })
    };
    let mut contenders = vec![moving(0), moving(casters.div_ceil(100)), moving(casters)];
    let changing: [Contender<'_, f64>; 2] = [Box::new(light), Box::new(new_caster)];
    contenders.extend(changing);
    let mut changes = vec![Change::Still, Change::OneInHundred, Change::All, Change::Light, Change::NewCaster];
    if let Some(mut extractors) = extractors {
        changes.push(Change::Extractors);
        contenders.push(Box::new(move || stopwatch.recording(&mut extractors, |_| Ok(()))));
    }
    let samples = interleave(rounds, contenders, is_interrupted)?;
    Ok(samples.map(|samples| changes.into_iter().zip(samples).collect()))
}

/// GPU times of the stages of a scene and of its faces as one mesh, in turn, and the silhouette edges of both. `None` where
/// Ctrl-C came first.
fn compare_stages(
    rounds: Rounds,
    stopwatch: &mut Stopwatch<'_>,
    field: &Field,
    until: Until,
) -> Result<Option<(Compared, Edges)>, Failure> {
    let gpu = stopwatch.gpu;
    let (mut scene, _) = SceneRecorder::new(gpu, field, false)?;
    let (mut still, _) = SceneRecorder::new(gpu, field, true)?;
    let mut merged = MeshRecorders::new(gpu, &stopwatch.pipelines, field, [field.merged()])?;
    let edges = |recorder: &mut dyn Recorder| {
        stopwatch.stages_by_clock(recorder, Until::Extraction)?;
        recorder.silhouette_edges(gpu).map_err(|error| error.on(gpu))
    };
    let edges = [edges(&mut scene)?, edges(&mut merged)?];
    let stopwatch = RefCell::new(stopwatch);
    let contenders: Vec<Contender<'_, StageTimes>> = vec![
        Box::new(|| stopwatch.borrow_mut().stages(&mut scene, until)),
        Box::new(|| stopwatch.borrow_mut().stages(&mut still, until)),
        Box::new(|| stopwatch.borrow_mut().stages(&mut merged, until)),
    ];
    let Some(samples) = interleave(rounds, contenders, is_interrupted)? else { return Ok(None) };
    let mut samples = samples.into_iter();
    let [scene, still, other] = std::array::from_fn(|_| samples.next().unwrap_or_default());
    let still = BothTimes { scene: still, other: other.clone() };
    Ok(Some((Compared { stages: BothTimes { scene, other }, still, ..Compared::default() }, edges)))
}

/// GPU times of whole frames, likewise.
fn compare_draws(
    rounds: Rounds,
    stopwatch: &mut Stopwatch<'_>,
    depth: &wgpu::TextureView,
    field: &Field,
    scene: &mut SceneRecorder,
) -> Result<Option<BothTimes<DrawTimes>>, Failure> {
    let mut merged = MeshRecorders::new(stopwatch.gpu, &stopwatch.pipelines, field, [field.merged()])?;
    let stopwatch = RefCell::new(stopwatch);
    in_turn(rounds, || stopwatch.borrow_mut().draws(scene, depth), || stopwatch.borrow_mut().draws(&mut merged, depth))
}

/// Times of a scene and of what it is held against, in turn. `None` where Ctrl-C came first.
fn in_turn<T>(
    rounds: Rounds,
    scene: impl FnMut() -> Result<T, Failure>,
    other: impl FnMut() -> Result<T, Failure>,
) -> Result<Option<BothTimes<T>>, Failure> {
    let contenders: Vec<Contender<'_, T>> = vec![Box::new(scene), Box::new(other)];
    let Some(samples) = interleave(rounds, contenders, is_interrupted)? else { return Ok(None) };
    let mut samples = samples.into_iter();
    let mut next = || samples.next().unwrap_or_default();
    Ok(Some(BothTimes { scene: next(), other: next() }))
}

/// `None` where Ctrl-C came first.
fn measure_one_mesh(
    rounds: Rounds,
    stopwatch: &mut Stopwatch<'_>,
    faces: usize,
) -> Result<Option<OneMeshRow>, Failure> {
    // Twice as many rings as segments, two faces each.
    let segments = ((faces as f64 / 4.0).sqrt().round() as u32).max(3);
    let field = Field::new(shapes::torus(2 * segments, segments, 1.0, 0.4), 1);
    let compared = compare_stages(rounds, stopwatch, &field, Until::Extraction)?;
    Ok(compared.map(|(compared, edges)| OneMeshRow { faces: field.shape.faces.len(), compared, edges }))
}
