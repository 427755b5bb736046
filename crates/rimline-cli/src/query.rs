//! `rimline query`: how many faces lie between points and lights, as NumPy arrays.

pub(crate) mod args;
mod on_gpu;

use std::io::{self, Seek, Write};
use std::path::Path;
use std::slice;

use args::QueryArgs;
use rimline::internals::cpu::{self, Threads};
use rimline::internals::light::check_shadow_lights;
use rimline::mesh::NO_FACE;
use rimline::{Light, MAX_LIGHTS, Mesh, Origin};
use serde_json::json;

use crate::device::Device;
use crate::extract::arrays::write_lights;
use crate::failure::{Failure, InputError, UsageError};
use crate::input::Scene;
use crate::output::{Output, note, print, say};
use crate::posed_input::PosedInput;
use crate::progress::Progress;
use crate::report::{self, Lines, Times, first_lights, per_light};
use crate::shown::Line;
use crate::source;
use crate::target::{Inputs, check_ending};
use rimline_files::npz::{self, ElementType, NpzWriter, write_origin};

pub(crate) fn run(args: &QueryArgs) -> Result<(), Failure> {
    check_ending(&args.out, "npz")?;
    let progress = Progress::start();
    let mut times = Times::default();
    progress.step("reading the model");
    let posed = times.measure("load", || PosedInput::read(&args.posed, &args.model))?;
    let lights = posed.lights(&args.lights)?;
    check_shadow_lights(&lights, MAX_LIGHTS).map_err(UsageError::Lights)?;
    progress.step("reading the points");
    let (limit, origin) = (args.model.options().memory_limit, posed.input.origin());
    let given = times.measure("points", || read_points(&args.points, limit))?;
    let scene = times.measure("topology", || posed.scene())?;
    given.check_faces(scene.mesh.faces().len()).map_err(|error| Failure::input(&args.points)(error.into()))?;
    let npz::PointArrays { points, on_face } = given;
    let points = points.relative_to(origin);
    let asked = Asked { points: &points, on_face: on_face.as_deref(), lights: &lights, lift: args.lift };
    Inputs::new(posed.files().chain([&*args.points])).spare(&args.out)?;
    let output = Output::create(&args.out)?;
    // Asked for before any long work.
    let mut depths: Vec<i32> = Vec::new();
    let count = points.len() * lights.len();
    let (needed, limit) = (count as u64 * size_of::<i32>() as u64, args.model.options().memory_limit);
    if needed > limit {
        return Err(Failure::input(&args.points)(InputError::TooLarge { what: "the depths".into(), needed, limit }));
    }
    let too_many = |_| InputError::Depths { points: points.len(), lights: lights.len() };
    depths.try_reserve_exact(count).map_err(too_many).map_err(Failure::input(&args.points))?;

    asked.note_swallowed();
    let job = on_gpu::Job { scene: &scene, asked, displacement: posed.displacement.as_ref(), time_s: posed.time_s() };
    let (adapter, (), mut times) = posed.work((&progress, "counting"), &times, |device, times| {
        depths.clear();
        match device {
            Device::Cpu => on_cpu(&scene, asked, &mut depths, times),
            // Times are for those who ask for them; all others would wait for the work twice.
            Device::Gpu(gpu) => job.run(gpu, &mut depths, times, args.json),
        }
    })?;
    times.measure("write", || output.finish(|file| write(file, (&points, &lights), &depths, origin)))?;
    let report = Report { mesh: &scene.mesh, asked, depths: &depths, origin, adapter, times };
    drop(progress);
    if args.json { print(&report.json()) } else { say(&report.text(&args.out)) }
}

fn read_points(file: &Path, memory_limit: u64) -> Result<npz::PointArrays, Failure> {
    let read = || -> Result<_, InputError> {
        Ok(npz::read_points(rimline_files::archive(source::open(file)?)?, memory_limit)?)
    };
    read().map_err(Failure::input(file))
}

fn on_cpu(scene: &Scene<'_>, asked: Asked<'_>, depths: &mut Vec<i32>, times: &mut Times) -> Result<(), Failure> {
    let positions = scene.shape.on_cpu(times)?;
    times.measure("shadow_depth", || {
        asked.each_slice(asked.slice(&scene.mesh), depths, |Asked { points, on_face, lights, .. }| {
            let found = cpu::shadow_depth_on_faces(&positions, &scene.mesh, points, on_face, lights, Threads::all());
            Ok(found.map_err(UsageError::Arguments)?)
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

struct Report<'a> {
    mesh: &'a Mesh,
    asked: Asked<'a>,
    depths: &'a [i32],
    origin: Origin,
    adapter: String,
    times: Times,
}

struct Counts {
    points_on_faces: usize,
    non_finite_points: usize,
    /// One a light.
    points_in_shadow: Vec<usize>,
    deepest: Vec<usize>,
}

impl Report<'_> {
    fn counts(&self) -> Counts {
        let (faces, lights) = (self.asked.on_face.unwrap_or_default(), self.asked.lights.len());
        let each = |count: &dyn Fn(&mut dyn Iterator<Item = i32>) -> usize| -> Vec<usize> {
            let of_light = |light| count(&mut self.depths.iter().skip(light).step_by(lights).copied());
            (0..lights).map(of_light).collect()
        };
        Counts {
            points_on_faces: faces.iter().filter(|&&face| face != NO_FACE).count(),
            non_finite_points: self.depths.iter().step_by(lights).filter(|&&depth| depth < 0).count(),
            points_in_shadow: each(&|depths| depths.filter(|&depth| depth > 0).count()),
            deepest: each(&|depths| depths.max().unwrap_or(0).max(0) as usize),
        }
    }

    /// Lists have an entry a light, in the order given.
    fn json(&self) -> String {
        let Counts { points_on_faces, non_finite_points, points_in_shadow, deepest } = self.counts();
        let report = json!({
            "adapter": self.adapter,
            "vertices": self.mesh.vertex_count(),
            "faces": self.mesh.faces().len(),
            "points": self.asked.points.len(),
            "points_on_faces": points_on_faces,
            "non_finite_points": non_finite_points,
            "lights": deepest.len(),
            "points_in_shadow": points_in_shadow,
            "deepest": deepest,
        });
        report::json(report, self.origin, &self.times)
    }

    fn text(&self, out: &Path) -> String {
        let Counts { points_on_faces, non_finite_points, points_in_shadow, deepest } = self.counts();
        let mut lines = Lines::default();
        lines.line("device", &self.adapter);
        lines.line("vertices", self.mesh.vertex_count());
        lines.line("faces", self.mesh.faces().len());
        lines.origin(self.origin);
        lines.line("points", self.asked.points.len());
        if points_on_faces > 0 {
            lines.line("", format!("{points_on_faces} name their face"));
        }
        if non_finite_points > 0 {
            lines.line("", format!("{non_finite_points} not finite: their depth is -1"));
        }
        lines.line("points in shadow", per_light(&points_in_shadow));
        let (deepest, more) = first_lights(&deepest);
        lines.line("deepest", deepest + if more { ", …" } else { "" });
        lines.times(&self.times);
        format!("{}wrote {}\n", lines.0, Line(out.display()))
    }
}

/// Points and lights, in the space of the positions.
#[derive(Clone, Copy)]
pub(super) struct Asked<'a> {
    pub(super) points: &'a [[f32; 3]],
    /// One for each point.
    pub(super) on_face: Option<&'a [u32]>,
    pub(super) lights: &'a [Light],
    /// How far points are moved towards each light before they are asked about.
    pub(super) lift: Option<f64>,
}

impl Asked<'_> {
    /// The number of lights that a count takes: a lifted point is another one for each light.
    pub(super) fn lights_at_once(&self) -> usize {
        if self.lift.is_some() { 1 } else { self.lights.len() }
    }

    /// Points of one call or submission: few enough that no GPU is kept busy for long and no result takes much memory.
    pub(super) fn slice(&self, mesh: &Mesh) -> usize {
        let pairs = ((1 << 36) / mesh.faces().len().max(1)).clamp(1 << 12, 1 << 22);
        (pairs / self.lights.len().max(1)).max(64)
    }

    /// Adds the depths of all points, a slice at a time. `count` counts for points as they are.
    pub(super) fn each_slice<E>(
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

    /// The depths of the points, each lifted towards each light.
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
    pub(super) fn note_swallowed(&self) {
        let Some(lift) = self.lift else { return };
        let pairs = self.points.iter().flat_map(|&point| self.lights.iter().map(move |&light| (point, light)));
        let swallowed = pairs.filter(|&(point, light)| is_swallowed(point, light, lift)).count();
        if swallowed > 0 {
            note(&format!(
                "warning: --lift {lift:e} is lost, or more than half of it, in the 32-bit floats of {swallowed} of the {} pairs of point \
                 and light; lift by more, or name the faces that points are on (`on_face`)",
                self.points.len() * self.lights.len()
            ));
        }
    }
}

/// Whether rounding takes more than half of the way that a point is lifted.
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
