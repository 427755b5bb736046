//! `rimline query`: how many faces lie between points and lights, as NumPy arrays.

pub(crate) mod args;
mod asked;
mod on_gpu;
mod report;

use std::io::{self, Seek, Write};
use std::path::Path;
use std::time::Instant;

use rimline::MAX_LIGHTS;
use rimline::reference::cpu::{self, Threads};
use rimline::reference::light::check_shadow_lights;
use rimline::{Light, Origin};

use crate::begins;
use crate::device::Device;
use crate::ending::{self, Written};
use crate::extract::arrays::write_lights;
use crate::failure::{Failure, InputError, UsageError};
use crate::input::{Scene, Shape};
use crate::npz::{self, ElementType, NpzWriter, write_origin};
use crate::output::{Output, print};
use crate::posed_input::PosedInput;
use crate::progress::Progress;
use crate::source;
use crate::target::Inputs;
use crate::times::Times;
use args::QueryArgs;
use asked::Asked;
use report::Report;

pub(crate) fn run(args: &QueryArgs) -> Result<(), Failure> {
    ending::check(&args.out, Written::Npz)?;
    let progress = Progress::start();
    let mut times = Times::default();
    progress.step("reading the model");
    let posed = times.measure("load", || PosedInput::read(&args.posed, &args.model))?;
    let lights = posed.lights(&args.lights)?;
    check_shadow_lights(&lights, MAX_LIGHTS).map_err(UsageError::Lights)?;
    progress.step("reading the points");
    let (limit, origin) = (args.model.options().memory_limit, posed.input.origin);
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
    progress.step("opening the device");
    let begin = Instant::now();
    let (device, mut times) = posed.work(|device| {
        progress.step("counting");
        let mut times = times.clone();
        times.add("device", begin.elapsed().as_secs_f64() * 1e3);
        depths.clear();
        match device {
            Device::Cpu => on_cpu(&scene, asked, &mut depths, &mut times)?,
            Device::Gpu(gpu) => {
                let job = on_gpu::Job {
                    scene: &scene,
                    asked,
                    displacement: posed.displacement.as_ref(),
                    time_s: posed.time_s(),
                };
                // Times are for those who ask for them; all others would wait for the work twice.
                if args.json {
                    job.run_warm(gpu, &mut depths, &mut times)?;
                } else {
                    job.run(gpu, &mut depths, &mut times)?;
                }
            }
        }
        Ok(times)
    })?;
    progress.step("writing");
    times.measure("write", || output.finish(|file| write(file, (&points, &lights), &depths, origin)))?;
    let report = Report::new(&scene.mesh, &asked, &depths, origin, device.name(), times);
    drop(progress);
    print(&if args.json { report.json() } else { report.text(&args.out) })
}

fn read_points(file: &Path, memory_limit: u64) -> Result<npz::PointArrays, Failure> {
    let read =
        || -> Result<_, InputError> { Ok(npz::read_points(begins::archive(source::open(file)?)?, memory_limit)?) };
    read().map_err(Failure::input(file))
}

fn on_cpu(scene: &Scene<'_>, asked: Asked<'_>, depths: &mut Vec<i32>, times: &mut Times) -> Result<(), Failure> {
    let threads = Threads::all();
    let deformed;
    let positions: &[[f32; 3]] = match &scene.shape {
        Shape::World(positions) => positions,
        Shape::Posed { model, pose } => {
            deformed = times.measure("deform", || cpu::deform(model, pose, 0.0, None, threads))?;
            &deformed
        }
    };
    times.measure("shadow_depth", || {
        asked.each_slice(asked.slice(&scene.mesh), depths, |Asked { points, on_face, lights, .. }| {
            let found = cpu::shadow_depth_on_faces(positions, &scene.mesh, points, on_face, lights, threads);
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
