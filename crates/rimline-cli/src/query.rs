//! `rimline query`: how many faces lie between points and lights, as NumPy arrays.

use std::io::{self, Seek, Write};
use std::slice;

use rimline::cpu::{self, Threads};
use rimline::gpu::{PositionBuffer, QueryPoints, ShadowQuery, ShadowQueryOptions};
use rimline::mesh::NO_FACE;
use rimline::{Displacement, Light, MAX_LIGHTS, Mesh, Origin, check_shadow_lights, wgpu};
use rimline_files::FileError;
use rimline_files::npz::{self, ElementType, NpzWriter, write_origin};
use serde_json::json;

use crate::args::QueryArgs;
use crate::device::{Device, Gpu, GpuError, On as _};
use crate::extract::write_lights;
use crate::failure::{Cause, Failure};
use crate::files::{self, Inputs, check_ending};
use crate::input::{Done, PosedInput, Positions, Scene};
use crate::output::{Line, Output, Progress, note, print, say};
use crate::report::{self, Lines, Times, first_lights, per_light};

pub(crate) fn run(args: &QueryArgs) -> Result<(), Failure> {
    check_ending(&args.out, "npz")?;
    let progress = Progress::start();
    let mut times = Times::default();
    progress.step("reading the model");
    let posed = times.measure("load", || PosedInput::read(&args.posed, &args.model))?;
    let lights = posed.input.lights(&args.lights, posed.time_s())?;
    check_shadow_lights(&lights, MAX_LIGHTS).map_err(|error| Failure::usage(error.to_string()))?;
    progress.step("reading the points");
    let (limit, origin) = (args.model.read.load.memory_limit, posed.input.origin());
    let refused = |error: Cause| Failure::input(&args.points, error);
    let read = || -> Result<_, Cause> { Ok(npz::read_points(files::archive(&args.points, limit)?, limit)?) };
    let given = times.measure("points", read).map_err(refused)?;
    let scene = times.measure("topology", || posed.scene())?;
    given.check_faces(scene.mesh.faces().len()).map_err(|error| refused(error.into()))?;
    let npz::PointArrays { points, on_face } = given;
    let points = points.relative_to(origin);
    let asked = Asked { points: &points, on_face: on_face.as_deref(), lights: &lights, lift: args.lift };
    Inputs::new(posed.files().chain([&*args.points])).spare(&args.out)?;
    let output = Output::create(&args.out)?;
    // Asked for before any long work.
    let mut depths: Vec<i32> = Vec::new();
    let count = points.len() * lights.len();
    let needed = count as u64 * size_of::<i32>() as u64;
    if needed > limit {
        return Err(refused(FileError::TooLarge { what: "the depths".into(), needed, limit }.into()));
    }
    if depths.try_reserve_exact(count).is_err() {
        let (points, lights) = (points.len(), lights.len());
        let why = "do not fit into memory; give fewer points or lights";
        return Err(refused(format!("the depths of {points} points for {lights} lights {why}").into()));
    }

    asked.note_swallowed();
    let job = Job { scene: &scene, asked, displacement: posed.displacement.as_ref(), time_s: posed.time_s() };
    let Done { device: adapter, mut times, .. } = posed.work((&progress, "counting"), &times, |device, times| {
        depths.clear();
        match device {
            Device::Cpu => on_cpu(&scene, asked, &mut depths, times),
            // Times are for those who ask for them; all others would wait for the work twice.
            Device::Gpu(gpu) => job.run(gpu, &mut depths, times, args.json),
        }
    })?;
    times.measure("write", || output.finish(|file| write(file, (&points, &lights), &depths, origin)))?;
    drop(progress);
    report(args, &adapter, &scene.mesh, (asked, &depths), origin, &times)
}

fn on_cpu(scene: &Scene<'_>, asked: Asked<'_>, depths: &mut Vec<i32>, times: &mut Times) -> Result<(), Failure> {
    let positions = scene.shape.on_cpu(times)?;
    times.measure("shadow_depth", || {
        asked.each_slice(asked.slice(&scene.mesh), depths, |Asked { points, on_face, lights, .. }| {
            let found = cpu::shadow_depth_on_faces(&positions, &scene.mesh, points, on_face, lights, Threads::all());
            found.map_err(|error| Failure::usage(error.to_string()))
        })
    })
}

/// The output contract: which arrays, in which order and shape. Points and lights are relative to the origin.
fn write(
    file: impl Write + Seek,
    (points, lights): (&[[f32; 3]], &[Light]),
    depths: &[i32],
    origin: Origin,
) -> io::Result<()> {
    let mut npz = NpzWriter::new(file);
    npz.slice("points", ElementType::F32, &[points.len(), 3], points)?;
    write_lights(&mut npz, lights)?;
    npz.slice("depth", ElementType::I32, &[points.len(), lights.len()], depths)?;
    write_origin(&mut npz, origin)?;
    npz.finish()
}

/// Prints counts and times. Lists have an entry a light, in the order given.
fn report(
    args: &QueryArgs,
    adapter: &str,
    mesh: &Mesh,
    (asked, depths): (Asked<'_>, &[i32]),
    origin: Origin,
    times: &Times,
) -> Result<(), Failure> {
    let lights = asked.lights.len();
    let each = |count: &dyn Fn(&mut dyn Iterator<Item = i32>) -> usize| -> Vec<usize> {
        (0..lights).map(|light| count(&mut depths.iter().skip(light).step_by(lights).copied())).collect()
    };
    let points_on_faces = asked.on_face.unwrap_or_default().iter().filter(|&&face| face != NO_FACE).count();
    let non_finite_points = depths.iter().step_by(lights).filter(|&&depth| depth < 0).count();
    let points_in_shadow = each(&|depths| depths.filter(|&depth| depth > 0).count());
    let deepest = each(&|depths| depths.max().unwrap_or(0).max(0) as usize);
    if args.json {
        let report = json!({
            "adapter": adapter,
            "vertices": mesh.vertex_count(),
            "faces": mesh.faces().len(),
            "points": asked.points.len(),
            "points_on_faces": points_on_faces,
            "non_finite_points": non_finite_points,
            "lights": lights,
            "points_in_shadow": points_in_shadow,
            "deepest": deepest,
        });
        return print(&report::json(report, origin, times));
    }
    let mut lines = Lines::default();
    lines.line("device", adapter);
    lines.line("vertices", mesh.vertex_count());
    lines.line("faces", mesh.faces().len());
    lines.origin(origin);
    lines.line("points", asked.points.len());
    if points_on_faces > 0 {
        lines.line("", format!("{points_on_faces} name their face"));
    }
    if non_finite_points > 0 {
        lines.line("", format!("{non_finite_points} not finite: their depth is -1"));
    }
    lines.line("points in shadow", per_light(&points_in_shadow));
    let (deepest, more) = first_lights(&deepest);
    lines.line("deepest", deepest + if more { ", …" } else { "" });
    lines.times(times);
    say(&format!("{}wrote {}\n", lines.0, Line(args.out.display())))
}

/// Points and lights, in the space of the positions.
#[derive(Clone, Copy)]
struct Asked<'a> {
    points: &'a [[f32; 3]],
    on_face: Option<&'a [u32]>,
    lights: &'a [Light],
    /// How far points are moved towards each light before they are asked about.
    lift: Option<f64>,
}

impl Asked<'_> {
    /// Points of one call or submission: few enough that no GPU is kept busy for long and no result takes much memory.
    fn slice(&self, mesh: &Mesh) -> usize {
        let pairs = ((1 << 36) / mesh.faces().len().max(1)).clamp(1 << 12, 1 << 22);
        (pairs / self.lights.len().max(1)).max(64)
    }

    /// Adds the depths of all points, a slice at a time. `count` counts for points as they are.
    fn each_slice<E>(
        &self,
        slice: usize,
        depths: &mut Vec<i32>,
        mut count: impl FnMut(Asked<'_>) -> Result<Vec<i32>, E>,
    ) -> Result<(), E> {
        for (at, points) in self.points.chunks(slice).enumerate() {
            let on_face = self.on_face.and_then(|faces| faces.get(at * slice..)?.get(..points.len()));
            let part = Asked { points, on_face, ..*self };
            depths.extend(part.count(&mut count)?);
        }
        Ok(())
    }

    fn count<E>(&self, count: &mut impl FnMut(Asked<'_>) -> Result<Vec<i32>, E>) -> Result<Vec<i32>, E> {
        let Some(lift) = self.lift else { return count(*self) };
        let mut depths = vec![0; self.points.len() * self.lights.len()];
        for (at, light) in self.lights.iter().enumerate() {
            let points: Vec<_> = self.points.iter().map(|&point| light.lift(point, lift)).collect();
            let found = count(Asked { points: &points, lights: slice::from_ref(light), lift: None, ..*self })?;
            for (of_point, depth) in depths.chunks_mut(self.lights.len()).zip(found) {
                of_point[at] = depth;
            }
        }
        Ok(depths)
    }

    /// Warns of pairs of point and light where rounding takes more than half of the lift.
    fn note_swallowed(&self) {
        let Some(lift) = self.lift else { return };
        let pairs = self.points.iter().flat_map(|&point| self.lights.iter().map(move |&light| (point, light)));
        let swallowed = pairs.filter(|&(point, light)| is_swallowed(point, light, lift)).count();
        if swallowed > 0 {
            note(&format!(
                "warning: --lift {lift:e} is lost, or more than half of it, in the 32-bit floats of {swallowed} of the \
                 {} pairs of point and light; lift by more, or name the faces that points are on (`on_face`)",
                self.points.len() * self.lights.len()
            ));
        }
    }
}

fn is_swallowed(point: [f32; 3], light: Light, lift: f64) -> bool {
    if !point.iter().all(|c| c.is_finite()) {
        return false;
    }
    let p = point.map(f64::from);
    let distance = |to: [f64; 3]| (0..3).map(|axis| (to[axis] - p[axis]).powi(2)).sum::<f64>().sqrt();
    let wanted =
        if light.w == 0.0 { lift } else { lift.min(distance(light.xyz.map(|c| f64::from(c) / f64::from(light.w)))) };
    distance(light.lift(point, lift).map(f64::from)) < 0.5 * wanted
}

#[derive(Clone, Copy)]
struct Job<'a, 's> {
    scene: &'a Scene<'s>,
    asked: Asked<'a>,
    displacement: Option<&'a Displacement>,
    time_s: f32,
}

impl Job<'_, '_> {
    fn run(&self, gpu: &Gpu, depths: &mut Vec<i32>, times: &mut Times, is_warm: bool) -> Result<(), Failure> {
        if is_warm {
            let on_face = self.asked.on_face.map(|_| &[NO_FACE][..]);
            let asked = Asked { points: &[[0.0; 3]], on_face, ..self.asked };
            self.scene.warm_up(times, |scene| {
                Job { scene, asked, ..*self }.run(gpu, &mut Vec::new(), &mut Times::default(), false)
            })?;
        }
        let slice = self.asked.slice(&self.scene.mesh).min(self.asked.points.len());
        let (placed, mut query) = times.measure("prepare", || self.prepare(gpu, slice)).on(gpu)?;
        let points = gpu.buffer("points", slice as u64 * POINT, wgpu::BufferUsages::STORAGE);
        gpu.check()?;
        placed.submit(gpu, &self.scene.shape, self.time_s).on(gpu)?;
        times.measure("shadow_depth", || {
            self.asked.each_slice(slice.max(1), depths, |asked| {
                let found = count_on_gpu(gpu, &mut query, &placed, &points, asked).on(gpu)?;
                gpu.check()?;
                Ok(found)
            })
        })
    }

    fn prepare(&self, gpu: &Gpu, slice: usize) -> Result<(Positions, ShadowQuery), GpuError> {
        // A lifted point is another one for each light.
        let max_lights = if self.asked.lift.is_some() { 1 } else { self.asked.lights.len() };
        let max_points = slice as u32;
        let options = ShadowQueryOptions { max_points, max_lights, ..ShadowQueryOptions::default() };
        let placed = Positions::new(gpu, &self.scene.shape, self.displacement)?;
        Ok((placed, ShadowQuery::new(&gpu.pipelines, &self.scene.mesh, options)?))
    }
}

const POINT: u64 = 16;

fn count_on_gpu(
    gpu: &Gpu,
    query: &mut ShadowQuery,
    placed: &Positions,
    buffer: &wgpu::Buffer,
    Asked { points, on_face, lights, .. }: Asked<'_>,
) -> Result<Vec<i32>, GpuError> {
    let face = |at: usize| on_face.and_then(|faces| faces.get(at)).copied().unwrap_or(NO_FACE);
    let words = |(at, point): (usize, &[f32; 3])| {
        let [x, y, z] = point.map(f32::to_bits);
        [x, y, z, face(at)]
    };
    let words: Vec<[u32; 4]> = points.iter().enumerate().map(words).collect();
    gpu.queue.write_buffer(buffer, 0, bytemuck::cast_slice(&words));
    let mut encoder = gpu.encoder("query");
    let points_at = PositionBuffer { buffer, offset: 0, stride: POINT };
    let bound = QueryPoints { points: points_at, on_face: on_face.map(|_| POINT - 4) };
    query.encode_at(&mut encoder, placed.buffer(), bound, points.len() as u32, lights)?;
    gpu.submit(encoder);
    Ok(query.read_occluder_counts(&gpu.queue)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_rounding_takes_is_noticed() {
        let above = Light::point([1e6, 0.0, 8.0]);
        assert!(is_swallowed([1e6, 0.0, 3.0], above, 1e-9));
        assert!(!is_swallowed([1e6, 0.0, 3.0], above, 1e-3), "only z moves");
        assert!(is_swallowed([1e6, 0.0, 3.0], Light::directional([1.0, 0.0, 0.0]), 1e-3));
        assert!(!is_swallowed([1e6, 0.0, 3.0], Light::directional([1.0, 0.0, 0.0]), 1.0));
        assert!(!is_swallowed([1e6, 0.0, 8.0], above, 1.0), "at the light");
        assert!(!is_swallowed([f32::NAN; 3], above, 1.0));
    }

    #[test]
    fn slices_keep_the_order_of_points_lights_and_faces() {
        let points: Vec<[f32; 3]> = (0..7).map(|at| [at as f32, 0.0, 0.0]).collect();
        let lights = [Light::directional([0.0, 1.0, 0.0]), Light::directional([0.0, 0.0, 1.0])];
        let faces: Vec<u32> = (10..17).collect();
        for lift in [None, Some(2.0)] {
            let asked = Asked { points: &points, on_face: Some(&faces), lights: &lights, lift };
            let mut found = Vec::new();
            // A number of point, light and face, and of where the point was moved.
            let count = |asked: Asked<'_>| -> Result<Vec<i32>, ()> {
                let mut all = Vec::new();
                for (point, face) in asked.points.iter().zip(asked.on_face.expect("faces")) {
                    for light in asked.lights {
                        let moved = point[1] + 10.0 * point[2];
                        all.push((point[0] + 100.0 * light.xyz[2] + 1000.0 * moved) as i32 + 100_000 * *face as i32);
                    }
                }
                Ok(all)
            };
            asked.each_slice(3, &mut found, count).expect("no error");
            let moved = if lift.is_some() { [2000, 20_000] } else { [0, 0] };
            let right = (0..7)
                .flat_map(|at| [0, 1].map(|light| 1_000_000 + 100_001 * at + 100 * light + moved[light as usize]));
            assert_eq!(found, right.collect::<Vec<i32>>(), "{lift:?}");
        }
    }
}
