//! Scenes of many casters: CPU time of recording a frame, GPU time against the same faces merged into one mesh, memory,
//! and silhouettes that are not those of the merged mesh.
//!
//! Casters of one mesh stand at integer positions in a cube, with lights and a camera outside it. Positions of vertices and
//! casters have so few digits that their sums are exact. So a caster in the scene has exactly the silhouettes that its
//! part of the merged mesh has.

use std::cell::RefCell;

use glam::Vec3;
use rimline::gpu::{Caster, ExtractorOptions, Measuring, SceneOptions, ShadowFormat, ShadowPipelines, StageTimer};
use rimline::{Counting, Light, Matrix3x4, Mesh};
use serde_json::{Value, json};
use wgpu::CommandEncoder;

use crate::engine::{Contender, Rounds, times};
use crate::extraction::subject;
use crate::gpu::{Gpu, Stopwatch};
use crate::random::Random;
use crate::record::{Camera, DEPTH, Drawn, ExtractorRecorder, STENCIL, SceneRecorder, Setting, Until, made_anew};
use crate::row::{Entry, Row, Section, Variant, compare};
use crate::shapes::{self, Shape};
use crate::text::grouped;
use crate::{Error, Host};

const LIGHTS: usize = 5;
/// The most casters whose volumes are drawn.
const MOST_DRAWN: usize = 1000;
/// The most casters that have a scene each.
const MOST_SCENES: usize = 100;
/// Half the width of the cube that casters stand in.
const HALF_WIDTH: i16 = 50;
/// Positions are multiples of its reciprocal.
const GRID: f32 = 4096.0;
/// The stages that extract, of a scene and of a single mesh.
pub(crate) const EXTRACTION: [&str; 7] =
    ["cull_lights", "clusters", "chunks", "facing", "exact_facing", "edges", "arguments"];

/// The mesh that all casters of a scene have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CasterMesh {
    Cube,
    /// A torus of 4,000 faces, about what a skinned character has.
    Character,
}

impl CasterMesh {
    fn id(self) -> &'static str {
        match self {
            Self::Cube => "box",
            Self::Character => "figure",
        }
    }

    /// `1 box`, `200 figures`.
    pub(crate) fn counted(self, casters: usize) -> String {
        let many = if self == Self::Cube { "boxes" } else { "figures" };
        format!("{} {}", grouped(casters), if casters == 1 { self.id() } else { many })
    }

    pub(crate) fn shape(self) -> Shape {
        let shape = match self {
            Self::Cube => shapes::cube(),
            Self::Character => shapes::torus(50, 40, 1.0, 0.4),
        };
        shape.placed(|position| position.map(|c| (c * GRID).round() / GRID))
    }
}

/// Casters of a shape in a cube. The same each time.
pub(crate) fn field(shape: Shape, casters: usize) -> Setting {
    let mut random = Random::new(1);
    let mut whole = |from: i16, to: i16| f32::from(from) + random.below((to - from) as usize + 1) as f32;
    let light = |_| {
        let at = [whole(-HALF_WIDTH, HALF_WIDTH), whole(70, 90), whole(-HALF_WIDTH, HALF_WIDTH)];
        Light::point(at)
    };
    let lights: Vec<Light> = (0..LIGHTS).map(light).collect();
    // A single caster is seen.
    let position = |index| if index == 0 { [0.0; 3] } else { [(); 3].map(|()| whole(-HALF_WIDTH, HALF_WIDTH)) };
    let placed =
        (0..casters).map(position).map(|[x, y, z]| (0, [[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, y], [0.0, 0.0, 1.0, z]]));
    // It sees about half of the cube.
    let eye = Vec3::new(0.0, 0.0, f32::from(HALF_WIDTH) + 4.0);
    Setting::rigid(vec![shape], placed.collect(), lights, &Camera::level(eye, Vec3::NEG_Z, 1.5, 0.1))
}

/// Where casters may move to, turned: one more than there are casters, so that a single one moves, too. A scene takes a
/// caster that gets the transform that it has as not moved.
fn turned(setting: &Setting) -> Vec<Matrix3x4> {
    let mut random = Random::new(2);
    let shapes = setting.casters.world_shapes();
    let at = shapes.iter().rev().chain(shapes.first()).map(|shape| shape.positions[0]);
    let turn = |[x, y, z]: [f32; 3]| {
        let (s, c) = random.between(-3.0, 3.0).sin_cos();
        [[c, 0.0, s, x], [0.0, 1.0, 0.0, y], [-s, 0.0, c, z]]
    };
    at.map(turn).collect()
}

/// A stride that comes to each of so many casters before it comes to one again: a prime that does not divide their number.
fn stride(casters: usize) -> usize {
    [97, 101, 103].into_iter().find(|prime| !casters.is_multiple_of(*prime)).unwrap_or(1)
}

/// The devices on which frames run, and what draws.
pub(crate) struct Devices<'a> {
    /// Nothing is drawn on it.
    pub(crate) stages: Stopwatch<'a>,
    pub(crate) draws: Stopwatch<'a>,
    pub(crate) pipelines: ShadowPipelines,
}

impl<'a> Devices<'a> {
    pub(crate) fn new(stages: &'a Gpu, draws: &'a Gpu) -> Result<Self, Error> {
        let format = ShadowFormat { depth_stencil: DEPTH, ..ShadowFormat::default() };
        let pipelines = ShadowPipelines::new(&draws.pipelines, &format, Counting::Auto)?;
        Ok(Self { pipelines, stages: Stopwatch::new(stages), draws: Stopwatch::new(draws) })
    }
}

/// Options of a scene that computes all bits and lists in each frame, or what changed only. It culls either way.
fn options(keep_bits: bool) -> SceneOptions {
    let mut options = SceneOptions::default();
    options.measuring.set(Measuring::CACHED_BITS, !keep_bits);
    options
}

/// The variants, as figures and data have them.
fn variant(id: &str) -> Variant {
    let (name, colour, shape) = match id {
        "scene" => ("scene", 4, 0),
        "merged" => ("merged mesh", 6, 1),
        "extractor" => ("extractor", 6, 1),
        "scene-still" => ("scene, nothing moved", 3, 3),
        "scene-1-percent-moved" => ("scene, 1 % moved", 4, 0),
        "scene-all-moved" => ("scene, all moved", 6, 1),
        "scene-light-moved" => ("scene, a light moved", 1, 4),
        "scene-new-caster" => ("scene, a new caster", 2, 4),
        _ => ("a scene a caster", 0, 2),
    };
    Variant::new(id, name, colour, shape)
}

const VOLUMES: Until<'static> = Until::Volumes(None);

pub(crate) fn measure(
    rounds: Rounds,
    devices: &mut Devices<'_>,
    (mesh, casters): (CasterMesh, usize),
    size: u32,
    host: &dyn Host,
) -> Result<Row, Error> {
    let setting = field(mesh.shape(), casters);
    let merged = setting.in_buffers(vec![setting.casters.merged()]);
    let anew = made_anew(LIGHTS, Counting::Auto);
    let mut other = SceneRecorder::new(devices.stages.gpu, &merged, None, anew)?;
    let stages_of = |encoder: &mut _, until: Until<'_>, timer: Option<&mut _>| other.encode(encoder, until, timer);
    let Devices { stages: watch, draws: stopwatch, pipelines } = devices;
    let (mut gpu_times, scene_edges) = stages(rounds, watch, &setting, VOLUMES, ("merged", stages_of), host)?;
    watch.by_clock(|encoder| other.encode(encoder, Until::Extraction, None))?;
    let edges = [scene_edges, other.silhouette_edges(watch.gpu)?];
    let gpu = stopwatch.gpu;
    let taken = |before: Option<u64>| {
        Ok::<_, Error>(gpu.allocated_bytes()?.zip(before).map(|(now, then)| now.saturating_sub(then)))
    };
    let before = gpu.allocated_bytes()?;
    let mut recorder = SceneRecorder::new(gpu, &setting, Some(pipelines), options(false))?;
    stopwatch.by_clock(|encoder| recorder.encode(encoder, VOLUMES, None))?;
    let (scene_device_bytes, scene_bytes) = (taken(before)?, recorder.bytes()?);
    let depth = gpu.texture([size; 2], DEPTH);
    let drawn = |scene| Drawn { scene, surfaces: None, depth: depth.clone(), receivers: None };
    let mut recorder = drawn(recorder);
    if casters <= MOST_DRAWN {
        let mut merged = drawn(SceneRecorder::new(gpu, &merged, Some(pipelines), anew)?);
        let watch = RefCell::new(&mut *stopwatch);
        let draws = |drawn: &mut Drawn<'_>| {
            let parts = ["stages", STENCIL];
            let timed = watch.borrow_mut().frame(&parts, |encoder, part, timer| drawn.record(encoder, part, timer))?;
            Ok(times([("stencil", timed.of(|name| name == STENCIL)), ("frame", timed.whole_ms)]))
        };
        let contenders: Vec<(&str, Contender<'_>)> =
            vec![("scene", Box::new(|| draws(&mut recorder))), ("merged", Box::new(|| draws(&mut merged)))];
        let drawn = compare(rounds, contenders, host)?;
        for (entry, drawn) in [0, 2].into_iter().zip(drawn) {
            gpu_times[entry] = gpu_times[entry].clone().and(&drawn);
        }
    }
    let alone = if casters <= MOST_SCENES { setting.casters.world_shapes() } else { Vec::new() };
    let alone: Vec<Setting> = alone.into_iter().map(|shape| setting.in_buffers(vec![shape])).collect();
    let before = gpu.allocated_bytes()?;
    let scenes = alone.iter().map(|setting| SceneRecorder::new(gpu, setting, Some(pipelines), anew));
    let mut scenes = scenes.collect::<Result<Vec<_>, _>>()?;
    stopwatch.by_clock(|encoder| encode_all(&mut scenes, encoder))?;
    let of_scenes = taken(before)?;
    // This scene caches nothing on the GPU. The CPU records as for one that does.
    let mut entries = record(rounds, stopwatch, &setting, recorder.scene, scenes, host)?;
    // GPU times of the still scene stand beside its CPU times.
    entries[0] = entries[0].clone().and(&gpu_times.remove(1)).with_count("bytes", scene_bytes as usize);
    for (entry, bytes) in [(0, scene_device_bytes), (5, of_scenes)] {
        if let (Some(entry), Some(bytes)) = (entries.get_mut(entry), bytes) {
            *entry = entry.clone().with_count("device_bytes", bytes as usize);
        }
    }
    entries.extend(gpu_times);
    let facts = facts(&setting, mesh.shape().faces.len(), size, &edges);
    let (scene, group) = (mesh.id().to_owned(), mesh.id().to_owned());
    Ok(Row { section: Section::Casters, scene, title: mesh.counted(casters), group, facts, entries })
}

/// Measures a scene of one caster of about so many faces against an extractor that finds the same, faces with a light in their
/// plane included. A scene has clusters of large meshes; an extractor has none.
pub(crate) fn measure_one_mesh(
    rounds: Rounds,
    devices: &mut Devices<'_>,
    faces: usize,
    size: u32,
    host: &dyn Host,
) -> Result<Row, Error> {
    let setting = field(subject::torus(faces), 1);
    let gpu = devices.stages.gpu;
    let Shape { positions, faces } = setting.casters.merged();
    let (mesh, faces) = (Mesh::from_faces(positions.len(), faces)?, setting.casters.faces());
    let options = ExtractorOptions { max_lights: LIGHTS, for_volumes: true, ..ExtractorOptions::default() };
    let mut other = ExtractorRecorder::new(gpu, options, &mesh, &positions, &setting.lights)?;
    let stages_of = |encoder: &mut _, _: Until<'_>, timer: Option<&mut _>| other.encode(encoder, timer);
    let (mut entries, scene_edges) =
        stages(rounds, &mut devices.stages, &setting, Until::Extraction, ("extractor", stages_of), host)?;
    entries.retain(|entry| entry.variant.id != "scene-still");
    let facts = facts(&setting, faces, size, &[scene_edges, other.silhouette_edges(gpu)?]);
    let (title, name) = (format!("{} faces", grouped(faces)), "one-mesh".to_owned());
    Ok(Row { section: Section::OneMesh, scene: name.clone(), title, group: name, facts, entries })
}

/// Facts of a scene. The last are silhouette edges of each light: in the scene, and in what it is held against.
fn facts(setting: &Setting, faces: usize, size: u32, [scene, other]: &[Vec<u64>; 2]) -> Vec<(&'static str, Value)> {
    vec![
        ("faces", json!(faces)),
        ("casters", json!(setting.casters.count())),
        ("lights", json!(setting.lights.len())),
        ("silhouette_edges", json!(scene)),
        ("wrong_lights", json!(wrong_lights(scene, other))),
        ("size", json!(size)),
    ]
}

/// Lights whose silhouette edges are not as many as they should be. A light that either lacks is one.
fn wrong_lights(scene: &[u64], other: &[u64]) -> usize {
    (0..scene.len().max(other.len())).filter(|&light| scene.get(light) != other.get(light)).count()
}

/// Records a frame up to some stage.
type Recorded<'a> = dyn FnMut(&mut CommandEncoder, Until<'_>, Option<&mut StageTimer>) -> Result<(), Error> + 'a;

/// GPU times of the stages of a scene that computes everything, of one in which nothing changed, and of what they are
/// held against, in turn: of extraction, and of all stages if volumes are prepared. Returns the silhouette edges of the
/// scene, too.
fn stages(
    rounds: Rounds,
    stopwatch: &mut Stopwatch<'_>,
    setting: &Setting,
    until: Until<'_>,
    (id, mut other): (&str, impl FnMut(&mut CommandEncoder, Until<'_>, Option<&mut StageTimer>) -> Result<(), Error>),
    host: &dyn Host,
) -> Result<(Vec<Entry>, Vec<u64>), Error> {
    let gpu = stopwatch.gpu;
    let [mut scene, mut still] = [
        SceneRecorder::new(gpu, setting, None, options(false))?,
        SceneRecorder::new(gpu, setting, None, options(true))?,
    ];
    stopwatch.by_clock(|encoder| scene.encode(encoder, Until::Extraction, None))?;
    let edges = scene.silhouette_edges(gpu)?;
    let watch = RefCell::new(stopwatch);
    let timed = |record: &mut Recorded<'_>| {
        let mut stopwatch = watch.borrow_mut();
        let timed = stopwatch.timed(|encoder, timer| record(encoder, until, timer))?;
        let [extraction, all] = if timed.has_stamps {
            [timed.of(|name| EXTRACTION.contains(&name)), timed.of(|_| true)]
        } else {
            [stopwatch.by_clock(|encoder| record(encoder, Until::Extraction, None))?[1], timed.clock_ms]
        };
        let mut sample = times([("extraction", extraction), ("stages", all)]);
        sample.truncate(if let Until::Extraction = until { 1 } else { 2 });
        Ok(sample)
    };
    let contenders: Vec<(Variant, Contender<'_>)> = vec![
        (variant("scene"), Box::new(|| timed(&mut |encoder, until, timer| scene.encode(encoder, until, timer)))),
        (variant("scene-still"), Box::new(|| timed(&mut |encoder, until, timer| still.encode(encoder, until, timer)))),
        (variant(id), Box::new(|| timed(&mut other))),
    ];
    Ok((compare(rounds, contenders, host)?, edges))
}

fn encode_all(scenes: &mut [SceneRecorder<'_>], encoder: &mut CommandEncoder) -> Result<(), Error> {
    scenes.iter_mut().try_for_each(|scene| scene.encode(encoder, VOLUMES, None))
}

/// CPU times of recording a frame after each kind of change, and of the alternative to a scene.
fn record(
    rounds: Rounds,
    stopwatch: &Stopwatch<'_>,
    setting: &Setting,
    scene: SceneRecorder<'_>,
    mut scenes: Vec<SceneRecorder<'_>>,
    host: &dyn Host,
) -> Result<Vec<Entry>, Error> {
    let (lights, mesh, handles) = (scene.lights.clone(), scene.meshes[0], scene.casters.clone());
    let (turned, casters) = (turned(setting), handles.len());
    let stride = stride(casters);
    let scene = RefCell::new(scene);
    let recorded = |change: &mut dyn FnMut(&mut SceneRecorder<'_>) -> Result<(), Error>| {
        let mut scene = scene.borrow_mut();
        let [ms, _] = stopwatch.by_clock(|encoder| {
            change(&mut scene)?;
            scene.encode(encoder, VOLUMES, None)
        })?;
        Ok(times([("recording", ms)]))
    };
    // Casters of each round's change follow those of the round before, so that memory is read where it was not read last.
    let moving = |count: usize| -> Contender<'_> {
        let (recorded, turned, handles) = (&recorded, &turned, &handles);
        let (mut next, mut round) = (0, 0);
        Box::new(move || {
            round += 1;
            recorded(&mut |recorder| {
                for _ in 0..count {
                    next = (next + stride) % casters;
                    recorder.scene.set_transform(handles[next], turned[(next + round) % turned.len()])?;
                }
                Ok(())
            })
        })
    };
    let (mut round, mut last) = (0, None);
    let light = || {
        round += 1;
        recorded(&mut |recorder| Ok(recorder.scene.set_light(lights[0], setting.lights[round % LIGHTS])?))
    };
    let new_caster = || {
        recorded(&mut |recorder| {
            if let Some(last) = last.take() {
                recorder.scene.remove(last)?;
            }
            last = Some(recorder.scene.insert(Caster::rigid(mesh, turned[0]))?);
            Ok(())
        })
    };
    let mut contenders: Vec<(Variant, Contender<'_>)> = vec![
        (variant("scene-still"), moving(0)),
        (variant("scene-1-percent-moved"), moving(casters.div_ceil(100))),
        (variant("scene-all-moved"), moving(casters)),
        (variant("scene-light-moved"), Box::new(light)),
        (variant("scene-new-caster"), Box::new(new_caster)),
    ];
    if !scenes.is_empty() {
        let run = move || {
            let [ms, _] = stopwatch.by_clock(|encoder| encode_all(&mut scenes, encoder))?;
            Ok(times([("recording", ms)]))
        };
        contenders.push((variant("extractors"), Box::new(run)));
    }
    compare(rounds, contenders, host)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn positions_are_exact_and_about_half_of_them_are_seen() {
        let setting = field(CasterMesh::Character.shape(), 1000);
        let shape = CasterMesh::Character.shape();
        let placed = setting.casters.world_shapes();
        for world in placed.iter().step_by(50) {
            let shift: [f64; 3] =
                std::array::from_fn(|axis| f64::from(world.positions[0][axis]) - f64::from(shape.positions[0][axis]));
            for (local, world) in shape.positions.iter().zip(&world.positions) {
                let sum: [f64; 3] = std::array::from_fn(|axis| f64::from(local[axis]) + shift[axis]);
                assert_eq!(world.map(f64::from), sum);
            }
        }
        let (columns, origin) = (setting.camera.view_projection, setting.camera.origin);
        let seen = placed.iter().filter(|shape| {
            let at: [f32; 3] = std::array::from_fn(|axis| shape.positions[0][axis] - origin[axis]);
            let clip = (0..3)
                .fold(columns[3], |clip, axis| std::array::from_fn(|row| clip[row] + columns[axis][row] * at[axis]));
            clip[0].abs() < clip[3] && clip[1].abs() < clip[3]
        });
        let seen = seen.count();
        assert!((400..650).contains(&seen), "{seen}");
    }

    #[test]
    fn all_casters_move_and_none_stays() {
        for casters in [1, 10, 97, 970, 97 * 98, 10_000] {
            let stride = stride(casters);
            let moved: BTreeSet<usize> = (1..=casters).map(|number| number * stride % casters).collect();
            assert_eq!(moved.len(), casters);
        }
        for casters in [1, 2, 30] {
            let to = turned(&field(CasterMesh::Cube.shape(), casters));
            assert_eq!(to.len(), casters + 1);
            assert!((0..to.len()).all(|round| to[round] != to[(round + 1) % to.len()]), "{to:?}");
        }
    }

    #[test]
    fn faces_of_casters_stay_apart_when_merged() {
        let mesh = field(CasterMesh::Cube.shape(), 7).casters.merged().mesh().expect("boxes are a mesh");
        assert_eq!([mesh.faces().len(), mesh.edges().len()], [7 * 12, 7 * 18]);
        assert!(mesh.is_closed());
    }

    #[test]
    fn a_wrong_light_is_counted_and_the_stages_of_extraction_are_stages() {
        assert_eq!((wrong_lights(&[7, 8, 9], &[7, 8, 9]), wrong_lights(&[7, 8, 9], &[7, 9, 9])), (0, 1));
        assert_eq!((wrong_lights(&[7, 8, 9], &[]), wrong_lights(&[7], &[7, 8])), (3, 1));
        for name in EXTRACTION {
            assert!(rimline::internals::stages::STAGES.iter().any(|stage| stage.name == name), "{name}");
        }
    }
}
