//! `rimline extract`: facing, silhouette and winding bits for lights, as NumPy arrays.

pub(crate) mod arrays;
mod on_gpu;

use std::borrow::Cow;
use std::path::Path;

use rimline::internals::Method;
use rimline::internals::cpu::{self, Extraction, FacingStatistics, Threads};
use rimline::internals::layout::EdgeMasks;
use rimline::mesh::{EdgeCounts, Polygons};
use rimline::{Displacement, Light, Mesh, Origin, Predicate};
use rimline_bench::error_metrics::light_counts;
use serde_json::json;

use crate::args::{ExtractArgs, MethodArg, PredicateArg};
use crate::device::Device;
use crate::failure::{Failure, UsageError};
use crate::input::Scene;
use crate::output::{Output, print, say};
use crate::posed_input::PosedInput;
use crate::progress::Progress;
use crate::report::{self, Lines, Times, per_light};
use crate::shadow::args::value_name;
use crate::shown::Line;
use crate::target::{Inputs, check_ending};

/// Results of either device. Masks lie in ⌈N/32⌉ planes, item after item.
pub(crate) struct Found<'a> {
    positions: Cow<'a, [[f32; 3]]>,
    facing: Vec<u32>,
    /// Twisted polygons; empty unless faces are polygons.
    twisted: Vec<u32>,
    masks: Vec<EdgeMasks>,
    statistics: FacingStatistics,
}

/// Finds everything exactly on a device.
pub(crate) fn extract_exactly<'s>(device: &Device, scene: &Scene<'s>, lights: &[Light]) -> Result<Found<'s>, Failure> {
    let (method, predicate) = (Method::FaceMask, Predicate::Exact);
    let job = Job { scene, lights, method, predicate, displacement: None, time_s: 0.0 };
    job.find(device, &mut Times::default(), false)
}

pub(crate) fn run(args: &ExtractArgs) -> Result<(), Failure> {
    let (method, predicate, named) = way(args)?;
    check_ending(&args.out, "npz")?;
    let progress = Progress::start();
    let mut times = Times::default();
    progress.step("reading the model");
    let posed = times.measure("load", || PosedInput::read(&args.posed, &args.model))?;
    let lights = posed.lights(&args.lights)?;
    progress.step("building edge records");
    let scene = times.measure("topology", || posed.scene())?;
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
    let (adapter, found, mut times) = posed.work((&progress, "extracting"), &times, work)?;
    let (mesh, origin) = (&scene.mesh, posed.input.origin());
    times.measure("write", || output.finish(|file| arrays::write(file, mesh, &lights, &found, origin)))?;
    let names = [adapter, value_name(&args.method), value_name(&named)];
    let report = Report { mesh, lights: lights.len(), found: &found, names, origin, times };
    drop(progress);
    if args.json { print(&report.json()) } else { say(&report.text(&args.out)) }
}

/// Method and predicate, which must go together.
fn way(args: &ExtractArgs) -> Result<(Method, Predicate, PredicateArg), UsageError> {
    let (method, usual) = match args.method {
        MethodArg::FaceMask => (Method::FaceMask, PredicateArg::Exact),
        MethodArg::PerEdge => (Method::PerEdge, PredicateArg::Plane),
    };
    let named = args.predicate.unwrap_or(usual);
    let predicate = match named {
        PredicateArg::Exact if method == Method::PerEdge => return Err(UsageError::ExactPerEdge),
        PredicateArg::Exact => Predicate::Exact,
        PredicateArg::Fast => Predicate::Fast,
        PredicateArg::Plane => Predicate::Plane,
    };
    Ok((method, predicate, named))
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
                found.map_err(|error| Failure::from(UsageError::Arguments(error)))
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
}

/// A row a polygon, as the file has them, of a plane for each 32 lights with a row a triangle. Planes begin every
/// `stride` words.
fn rows_of_polygons(polygons: &Polygons, planes: &[u32], stride: usize, lights: usize) -> Vec<u32> {
    // Without a triangle in the mesh, planes are empty, and no polygon has bits.
    let plane = |batch: usize| planes.get(stride * batch..).unwrap_or_default();
    (0..lights.div_ceil(32)).flat_map(|batch| polygons.masks_of(plane(batch))).collect()
}

struct Report<'a> {
    mesh: &'a Mesh,
    lights: usize,
    found: &'a Found<'a>,
    /// The device, the method and the predicate.
    names: [String; 3],
    origin: Origin,
    times: Times,
}

impl Report<'_> {
    /// For each light, silhouette edges and unclosed vertices.
    fn counts(&self) -> (Vec<usize>, Vec<usize>) {
        let Self { mesh, found, lights, .. } = self;
        let counts = light_counts(mesh, &found.masks, &found.twisted, *lights).into_iter();
        counts.map(|light| (light.silhouette_edges, light.unclosed_vertices)).unzip()
    }

    /// The number of twisted polygons for each light, if the mesh has polygons.
    fn twisted(&self) -> Option<Vec<usize>> {
        let faces = self.mesh.polygons()?.len();
        let plane = |light: usize| self.found.twisted.iter().skip(light / 32 * faces).take(faces);
        let of_light = |light| plane(light).filter(|&&mask| mask >> (light % 32) & 1 != 0).count();
        Some((0..self.lights).map(of_light).collect())
    }

    /// Lists have an entry a light, in the order given.
    fn json(&self) -> String {
        let EdgeCounts { consistent, inconsistent, boundary } = self.mesh.edges().counts();
        let FacingStatistics { non_finite_faces, undecided_pairs, exact_zeros } = self.found.statistics;
        let (silhouette_edges, unclosed_vertices) = self.counts();
        let [adapter, method, predicate] = &self.names;
        let report = json!({
            "adapter": adapter,
            "method": method,
            "predicate": predicate,
            "vertices": self.found.positions.len(),
            "faces": self.mesh.face_count(),
            "degenerate_faces": self.mesh.degenerate_faces(),
            "non_finite_faces": non_finite_faces,
            "undecided_pairs": undecided_pairs,
            "exact_zeros": exact_zeros,
            "edges": { "consistent": consistent, "inconsistent": inconsistent, "boundary": boundary },
            "lights": self.lights,
            "silhouette_edges": silhouette_edges,
            "unclosed_vertices": unclosed_vertices,
            "twisted_polygons": self.twisted(),
        });
        report::json(report, self.origin, &self.times)
    }

    fn text(&self, out: &Path) -> String {
        let EdgeCounts { consistent, inconsistent, boundary } = self.mesh.edges().counts();
        let FacingStatistics { non_finite_faces, undecided_pairs, exact_zeros } = self.found.statistics;
        let (silhouette_edges, unclosed_vertices) = self.counts();
        let mut lines = Lines::default();
        lines.line("device", &self.names[0]);
        lines.line("vertices", self.found.positions.len());
        lines.line("faces", self.mesh.face_count());
        lines.origin(self.origin);
        if non_finite_faces > 0 {
            lines.line("", format!("{non_finite_faces} with a position that is not finite: they face no light"));
        }
        if undecided_pairs > 0 {
            let decided = format!("{undecided_pairs} pairs of face and light, {exact_zeros} of them in one plane");
            lines.line("decided exactly", decided);
        }
        if let Some(twisted) = self.twisted() {
            lines.line("twisted polygons", per_light(&twisted));
        }
        let edges = format!("{consistent} consistent, {inconsistent} inconsistent, {boundary} boundary");
        lines.line("edge records", edges);
        lines.line("silhouette edges", per_light(&silhouette_edges));
        lines.line("unclosed vertices", per_light(&unclosed_vertices));
        lines.times(&self.times);
        format!("{}wrote {}\n", lines.0, Line(out.display()))
    }
}
