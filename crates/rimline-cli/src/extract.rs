//! `rimline extract`: facing, silhouette and winding bits for lights, as NumPy arrays.

use std::borrow::Cow;
use std::io::{self, Seek, Write};
use std::time::Instant;

use rimline::cpu::{EdgeMasks, Extraction, FacingStatistics, Threads};
use rimline::gpu::{ExtractionStatistics, Extractor, ExtractorOptions, StageTimer};
use rimline::internals::{Method, cpu};
use rimline::mesh::{EdgeCounts, EdgeKind, Polygons};
use rimline::{Displacement, Light, Mesh, Origin, Predicate, wgpu};
use rimline_bench::error_metrics::light_counts;
use rimline_files::npz::{ElementType, NpzWriter, write_origin};
use serde_json::json;

use crate::args::{ExtractArgs, MethodArg, PredicateArg};
use crate::device::{Device, Gpu, GpuError, On as _};
use crate::failure::Failure;
use crate::files::{Inputs, check_ending};
use crate::input::{Done, PosedInput, Positions, Scene};
use crate::output::{Line, Output, Progress, print, say};
use crate::report::{self, Lines, Times, per_light};
use crate::shadow::args::value_name;

/// Results of either device. Masks lie in ⌈N/32⌉ planes, item after item.
pub(crate) struct Found<'a> {
    positions: Cow<'a, [[f32; 3]]>,
    facing: Vec<u32>,
    /// Twisted polygons; empty unless faces are polygons.
    twisted: Vec<u32>,
    masks: Vec<EdgeMasks>,
    statistics: FacingStatistics,
}

pub(crate) fn extract_exactly<'s>(device: &Device, scene: &Scene<'s>, lights: &[Light]) -> Result<Found<'s>, Failure> {
    let (method, predicate) = (Method::FaceMask, Predicate::Exact);
    let job = Job { scene, lights, method, predicate, displacement: None, time_s: 0.0 };
    job.find(device, &mut Times::default(), false)
}

pub(crate) fn run(args: &ExtractArgs) -> Result<(), Failure> {
    let Way { method, predicate, named } = way(args)?;
    check_ending(&args.out, "npz")?;
    let progress = Progress::start();
    let mut times = Times::default();
    progress.step("reading the model");
    let posed = times.measure("load", || PosedInput::read(&args.posed, &args.model))?;
    let lights = posed.input.lights(&args.lights, posed.time_s())?;
    progress.step("building edge records");
    let scene = times.measure("topology", || posed.scene())?;
    if scene.mesh.polygons().is_some() && method == Method::FaceMask && predicate != Predicate::Exact {
        let named = value_name(&named);
        return Err(Failure::usage(format!("polygons are always decided exactly; leave out `--predicate {named}`")));
    }
    Inputs::new(posed.files()).spare(&args.out)?;
    let output = Output::create(&args.out)?;

    let job = Job {
        scene: &scene,
        lights: &lights,
        method,
        predicate,
        displacement: posed.displacement.as_ref(),
        time_s: posed.time_s(),
    };
    let work = |device: &Device, times: &mut Times| job.find(device, times, args.json);
    let Done { device: adapter, result: found, mut times } = posed.work((&progress, "extracting"), &times, work)?;
    let (mesh, origin) = (&scene.mesh, posed.input.origin());
    times.measure("write", || output.finish(|file| write_arrays(file, mesh, &lights, &found, origin)))?;
    drop(progress);
    report(args, [adapter, value_name(&args.method), value_name(&named)], (mesh, &found), lights.len(), origin, &times)
}

/// Prints counts and times. Lists have an entry a light, in the order given.
fn report(
    args: &ExtractArgs,
    [adapter, method, predicate]: [String; 3],
    (mesh, found): (&Mesh, &Found<'_>),
    lights: usize,
    origin: Origin,
    times: &Times,
) -> Result<(), Failure> {
    let EdgeCounts { consistent, inconsistent, boundary } = mesh.edges().counts();
    let FacingStatistics { non_finite_faces, undecided_pairs, exact_zeros } = found.statistics;
    let counts = light_counts(mesh, &found.masks, &found.twisted, lights).into_iter();
    let (silhouette_edges, unclosed_vertices): (Vec<_>, Vec<_>) =
        counts.map(|light| (light.silhouette_edges, light.unclosed_vertices)).unzip();
    let twisted = mesh.polygons().map(|polygons| {
        let plane = |light: usize| found.twisted.iter().skip(light / 32 * polygons.len()).take(polygons.len());
        let of_light = |light| plane(light).filter(|&&mask| mask >> (light % 32) & 1 != 0).count();
        (0..lights).map(of_light).collect::<Vec<usize>>()
    });
    if args.json {
        let report = json!({
            "adapter": adapter,
            "method": method,
            "predicate": predicate,
            "vertices": found.positions.len(),
            "faces": mesh.face_count(),
            "degenerate_faces": mesh.degenerate_faces(),
            "non_finite_faces": non_finite_faces,
            "undecided_pairs": undecided_pairs,
            "exact_zeros": exact_zeros,
            "edges": { "consistent": consistent, "inconsistent": inconsistent, "boundary": boundary },
            "lights": lights,
            "silhouette_edges": silhouette_edges,
            "unclosed_vertices": unclosed_vertices,
            "twisted_polygons": twisted,
        });
        return print(&report::json(report, origin, times));
    }
    let mut lines = Lines::default();
    lines.line("device", adapter);
    lines.line("vertices", found.positions.len());
    lines.line("faces", mesh.face_count());
    lines.origin(origin);
    if non_finite_faces > 0 {
        lines.line("", format!("{non_finite_faces} with a position that is not finite: they face no light"));
    }
    if undecided_pairs > 0 {
        let decided = format!("{undecided_pairs} pairs of face and light, {exact_zeros} of them in one plane");
        lines.line("decided exactly", decided);
    }
    if let Some(twisted) = twisted {
        lines.line("twisted polygons", per_light(&twisted));
    }
    let edges = format!("{consistent} consistent, {inconsistent} inconsistent, {boundary} boundary");
    lines.line("edge records", edges);
    lines.line("silhouette edges", per_light(&silhouette_edges));
    lines.line("unclosed vertices", per_light(&unclosed_vertices));
    lines.times(times);
    say(&format!("{}wrote {}\n", lines.0, Line(args.out.display())))
}

/// Method and predicate, which must go together.
struct Way {
    method: Method,
    predicate: Predicate,
    /// The option that means the predicate.
    named: PredicateArg,
}

fn way(args: &ExtractArgs) -> Result<Way, Failure> {
    let (method, usual) = match args.method {
        MethodArg::FaceMask => (Method::FaceMask, PredicateArg::Exact),
        MethodArg::PerEdge => (Method::PerEdge, PredicateArg::Plane),
    };
    let named = args.predicate.unwrap_or(usual);
    let predicate = match named {
        PredicateArg::Exact if method == Method::PerEdge => {
            return Err(Failure::usage(
                "the per-edge method has no exact form; leave out `--predicate exact`, or `--method per-edge`",
            ));
        }
        PredicateArg::Exact => Predicate::Exact,
        PredicateArg::Fast => Predicate::Fast,
        PredicateArg::Plane => Predicate::Plane,
    };
    Ok(Way { method, predicate, named })
}

/// An extraction, and how it is computed.
#[derive(Clone, Copy)]
struct Job<'a, 's> {
    scene: &'a Scene<'s>,
    lights: &'a [Light],
    method: Method,
    predicate: Predicate,
    displacement: Option<&'a Displacement>,
    time_s: f32,
}

impl<'s> Job<'_, 's> {
    /// `is_warm` compiles shaders before the stages run: times are for those who ask for them, and all others would
    /// wait for the work twice.
    fn find(&self, device: &Device, times: &mut Times, is_warm: bool) -> Result<Found<'s>, Failure> {
        match device {
            Device::Cpu => self.on_cpu(times),
            Device::Gpu(gpu) => self.on_gpu(gpu, times, is_warm),
        }
    }

    /// The CPU references, stage by stage.
    fn on_cpu(&self, times: &mut Times) -> Result<Found<'s>, Failure> {
        let Self { scene: Scene { mesh, shape }, lights, method, predicate, .. } = *self;
        let (positions, threads) = (shape.on_cpu(times)?, Threads::all());
        if let Some(polygons) = mesh.polygons() {
            let extract = |method| {
                let found = cpu::extract_by(&positions, mesh, lights, method, predicate, threads);
                found.map_err(|error| Failure::usage(error.to_string()))
            };
            let Extraction { facing, twisted, mut masks, statistics } =
                times.measure("facing", || extract(Method::FaceMask))?;
            if method == Method::PerEdge {
                masks = times.measure("per_edge", || extract(method))?.masks;
            }
            let rows = |planes: &[u32]| rows_of_polygons(polygons, planes, mesh.faces().len(), lights.len());
            return Ok(Found { positions, facing: rows(&facing), twisted: rows(&twisted), masks, statistics });
        }
        let faces = mesh.faces();
        let mut facing = Vec::new();
        // The per-edge method has no face bits, so the file gets the exact ones.
        let of_faces = if method == Method::PerEdge { Predicate::Exact } else { predicate };
        let statistics =
            times.measure("facing", || cpu::facing_into(&mut facing, &positions, faces, lights, of_faces, threads));
        let masks = match method {
            Method::FaceMask => {
                times.measure("edges", || cpu::edges(mesh.edges(), &facing, faces.len(), lights.len(), threads))
            }
            Method::PerEdge => {
                times.measure("per_edge", || cpu::per_edge(&positions, mesh, lights, predicate, threads))
            }
        };
        Ok(Found { positions, facing, twisted: Vec::new(), masks, statistics })
    }

    fn on_gpu(&self, gpu: &Gpu, times: &mut Times, is_warm: bool) -> Result<Found<'s>, Failure> {
        let Gpu { device, queue, .. } = gpu;
        let (placed, mut extractors) = times.measure("prepare", || self.prepare(gpu)).on(gpu)?;
        gpu.check()?;
        if is_warm {
            let run = |scene: &Scene<'_>| Job { scene, ..*self }.on_gpu(gpu, &mut Times::default(), false).map(drop);
            self.scene.warm_up(times, run)?;
        }

        let mut timer = StageTimer::new(device, queue);
        let mut encoder = gpu.encoder("extract");
        placed.encode(&mut encoder, &self.scene.shape, self.time_s, timer.as_mut()).on(gpu)?;
        for extractor in &mut extractors {
            extractor.encode_timed(&mut encoder, placed.buffer(), self.lights, timer.as_mut()).on(gpu)?;
        }
        if let Some(timer) = &timer {
            timer.resolve(&mut encoder);
        }
        let commands = encoder.finish();
        let begin = Instant::now();
        queue.submit([commands]);
        gpu.wait()?;
        times.add_stages(gpu, timer.as_ref(), begin.elapsed().as_secs_f64() * 1e3).on(gpu)?;
        let found = times.measure("read", || self.read(gpu, &placed, &extractors)).on(gpu)?;
        gpu.check()?;
        Ok(found)
    }

    fn prepare(&self, gpu: &Gpu) -> Result<(Positions, Vec<Extractor>), GpuError> {
        let placed = Positions::new(gpu, &self.scene.shape, self.displacement)?;
        // The per-edge method has no face bits, so the file gets the exact ones, from a face pass of their own.
        let methods = match self.method {
            Method::FaceMask => vec![(Method::FaceMask, self.predicate, true)],
            Method::PerEdge => {
                vec![(Method::FaceMask, Predicate::Exact, false), (Method::PerEdge, self.predicate, true)]
            }
        };
        let mut extractors = Vec::new();
        for (method, predicate, masks) in methods {
            let (max_lights, lists) = (self.lights.len(), None);
            let options =
                ExtractorOptions { max_lights, method, predicate, masks, lists, ..ExtractorOptions::default() };
            extractors.push(Extractor::new(&gpu.pipelines, &self.scene.mesh, options)?);
        }
        Ok((placed, extractors))
    }

    fn read(&self, gpu: &Gpu, placed: &Positions, extractors: &[Extractor]) -> Result<Found<'s>, GpuError> {
        let mesh = &self.scene.mesh;
        let (first, last) = (&extractors[0], &extractors[extractors.len() - 1]);
        let ExtractionStatistics { non_finite_faces, undecided_pairs, exact_zeros, .. } =
            gpu.read_first(first.results().statistics)?;
        let triangles = mesh.faces().len();
        let (facing, twisted) = match mesh.polygons() {
            None => (read_planes(gpu, first.results().facing, triangles)?, Vec::new()),
            Some(polygons) => {
                let planes: Vec<u32> = read_planes(gpu, first.results().facing, 2 * triangles)?;
                let rows = |planes: &[u32]| rows_of_polygons(polygons, planes, 2 * triangles, self.lights.len());
                (rows(&planes), rows(planes.get(triangles..).unwrap_or_default()))
            }
        };
        Ok(Found {
            positions: placed.read(gpu, &self.scene.shape)?,
            facing,
            twisted,
            masks: read_planes(gpu, last.results().masks, mesh.edges().len())?,
            statistics: FacingStatistics { non_finite_faces, undecided_pairs, exact_zeros },
        })
    }
}

/// A row a polygon, as the file has them, of a plane for each 32 lights with a row a triangle. Planes begin every
/// `stride` words.
fn rows_of_polygons(polygons: &Polygons, planes: &[u32], stride: usize, lights: usize) -> Vec<u32> {
    // Without a triangle in the mesh, planes are empty, and no polygon has bits.
    let plane = |batch: usize| planes.get(stride * batch..).unwrap_or_default();
    (0..lights.div_ceil(32)).flat_map(|batch| polygons.masks_of(plane(batch))).collect()
}

fn read_planes<T: bytemuck::Pod>(gpu: &Gpu, buffers: &[wgpu::Buffer], items: usize) -> Result<Vec<T>, GpuError> {
    let mut all: Vec<T> = Vec::new();
    for buffer in buffers {
        let mut plane = gpu.read(buffer)?;
        // A buffer may be longer than what it holds.
        plane.truncate(items);
        // Most have one plane, which is not copied.
        if all.is_empty() {
            all = plane;
        } else {
            all.append(&mut plane);
        }
    }
    Ok(all)
}

pub(crate) fn write_lights(npz: &mut NpzWriter<impl Write + Seek>, lights: &[Light]) -> io::Result<()> {
    let components: Vec<[f32; 4]> = lights.iter().map(|light| light.to_array()).collect();
    npz.slice("lights", ElementType::F32, &[lights.len(), 4], &components)
}

/// Writes all arrays; positions and lights are relative to the origin. Nothing is copied whole: what needs another form
/// is converted piece by piece.
pub(crate) fn write_arrays(
    file: impl Write + Seek,
    mesh: &Mesh,
    lights: &[Light],
    found: &Found<'_>,
    origin: Origin,
) -> io::Result<()> {
    let (faces, edges, words) = (mesh.face_count(), mesh.edges().len(), lights.len().div_ceil(32));
    let mut npz = NpzWriter::new(file);
    npz.slice("positions", ElementType::F32, &[found.positions.len(), 3], &found.positions)?;
    npz.slice("faces", ElementType::U32, &[mesh.faces().len(), 3], mesh.faces())?;
    if let Some(polygons) = mesh.polygons() {
        let of_triangles = polygons.triangle_polygons();
        npz.slice("triangle_polygons", ElementType::U32, &[of_triangles.len()], &of_triangles)?;
        let loops = |polygon| polygons.loops(polygon);
        let all_loops = || (0..polygons.len()).flat_map(loops);
        npz.array("polygon_loops", ElementType::U32, &[polygons.len()], |to| {
            pieces(to, 0..polygons.len(), |polygon| loops(polygon).len() as u32)
        })?;
        npz.array("loop_sizes", ElementType::U32, &[all_loops().count()], |to| {
            pieces(to, all_loops(), |corners| corners.len() as u32)
        })?;
        let corners = all_loops().map(<[u32]>::len).sum();
        npz.array("loop_corners", ElementType::U32, &[corners], |to| {
            pieces(to, all_loops().flatten(), |&corner| corner)
        })?;
    }
    write_lights(&mut npz, lights)?;
    npz.slice("edges", ElementType::U32, &[edges, 2], mesh.edges().vertices())?;
    npz.array("edge_faces", ElementType::U32, &[edges, 2], |to| {
        // No face 1 is `0xFFFFFFFF` here as in memory; `face_0` has its flag taken off.
        pieces(to, mesh.edges().iter(), |edge| [edge.face_0, edge.face_1.unwrap_or(u32::MAX)])
    })?;
    npz.array("edge_kind", ElementType::U8, &[edges], |to| {
        pieces(to, mesh.edges().iter(), |edge| match edge.kind {
            EdgeKind::Consistent => 0_u8,
            EdgeKind::Inconsistent => 1,
            EdgeKind::Boundary => 2,
        })
    })?;
    npz.array("facing", ElementType::U32, &[faces, words], planes(&found.facing, faces, words, |&mask| mask))?;
    if mesh.polygons().is_some() {
        npz.array("twisted", ElementType::U32, &[faces, words], planes(&found.twisted, faces, words, |&mask| mask))?;
    }
    let silhouette = |masks: &EdgeMasks| masks.silhouette;
    npz.array("silhouette", ElementType::U32, &[edges, words], planes(&found.masks, edges, words, silhouette))?;
    let winding = |masks: &EdgeMasks| masks.winding;
    npz.array("winding", ElementType::U32, &[edges, words], planes(&found.masks, edges, words, winding))?;
    write_origin(&mut npz, origin)?;
    npz.finish()
}

/// Items converted and written a few thousand at a time.
fn pieces<T, U: bytemuck::NoUninit>(
    to: &mut dyn Write,
    items: impl Iterator<Item = T>,
    convert: impl Fn(T) -> U,
) -> io::Result<()> {
    const PIECE: usize = 1 << 14;
    let mut piece = Vec::with_capacity(PIECE);
    for item in items {
        piece.push(convert(item));
        if piece.len() == PIECE {
            to.write_all(bytemuck::cast_slice(&piece))?;
            piece.clear();
        }
    }
    to.write_all(bytemuck::cast_slice(&piece))
}

/// From a plane a word to the words of each item side by side.
fn planes<'a, T>(
    planes: &'a [T],
    items: usize,
    words: usize,
    word: impl Fn(&T) -> u32 + 'a,
) -> impl FnOnce(&mut dyn Write) -> io::Result<()> + 'a {
    move |to| {
        let all = (0..items).flat_map(|item| (0..words).map(move |plane| plane * items + item));
        pieces(to, all, |at| word(&planes[at]))
    }
}
