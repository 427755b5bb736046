//! `rimline extract`: facing, silhouette and winding bits for lights, as NumPy arrays.

pub(crate) mod arrays;
mod on_cpu;
pub(crate) mod on_gpu;
pub(crate) mod report;

use std::time::Instant;

use rimline::reference::Method;
use rimline::reference::cpu::FacingStatistics;
use rimline::reference::layout::EdgeMasks;
use rimline::{Light, Predicate};

use crate::args::{ExtractArgs, MethodArg, PredicateArg};
use crate::device::Device;
use crate::ending::{self, Written};
use crate::failure::{Failure, UsageError};
use crate::input::Scene;
use crate::output::{Output, print};
use crate::posed_input::PosedInput;
use crate::progress::Progress;
use crate::target::Inputs;
use crate::times::Times;
use report::Report;

/// Results of either device. Masks lie in ⌈N/32⌉ planes, item after item.
pub(crate) struct Found<'a> {
    positions: std::borrow::Cow<'a, [[f32; 3]]>,
    facing: Vec<u32>,
    /// Twisted polygons; empty unless faces are polygons.
    twisted: Vec<u32>,
    masks: Vec<EdgeMasks>,
    statistics: FacingStatistics,
}

/// Finds everything exactly on a device.
pub(crate) fn extract_exactly<'s>(device: &Device, scene: &Scene<'s>, lights: &[Light]) -> Result<Found<'s>, Failure> {
    let (method, predicate) = (Method::FaceMask, Predicate::Exact);
    match device {
        Device::Cpu => Ok(on_cpu::extract(scene, lights, method, predicate, &mut Times::default())?),
        Device::Gpu(gpu) => {
            let job = on_gpu::Job { scene, lights, method, predicate, displacement: None, time_s: 0.0 };
            job.run(gpu, &mut Times::default())
        }
    }
}

pub(crate) fn run(args: &ExtractArgs) -> Result<(), Failure> {
    let (method, predicate) = way(args)?;
    ending::check(&args.out, Written::Npz)?;
    let progress = Progress::start();
    let mut times = Times::default();
    progress.step("reading the model");
    let posed = times.measure("load", || PosedInput::read(&args.posed, &args.model))?;
    let lights = posed.lights(&args.lights)?;
    progress.step("building edge records");
    let scene = times.measure("topology", || posed.scene())?;
    Inputs::new(posed.files()).spare(&args.out)?;
    let output = Output::create(&args.out)?;

    progress.step("opening the device");
    let begin = Instant::now();
    let (device, (found, mut times)) = posed.work(|device| {
        progress.step("extracting");
        let mut times = times.clone();
        times.add("device", begin.elapsed().as_secs_f64() * 1e3);
        let found = match device {
            Device::Cpu => on_cpu::extract(&scene, &lights, method, predicate, &mut times)?,
            Device::Gpu(gpu) => {
                let job = on_gpu::Job {
                    scene: &scene,
                    lights: &lights,
                    method,
                    predicate,
                    displacement: posed.displacement.as_ref(),
                    time_s: posed.time_s(),
                };
                // Times are for those who ask for them; all others would wait for the work twice.
                if args.json { job.run_warm(gpu, &mut times)? } else { job.run(gpu, &mut times)? }
            }
        };
        Ok((found, times))
    })?;
    progress.step("writing");
    let (mesh, origin) = (&scene.mesh, posed.input.origin);
    times.measure("write", || output.finish(|file| arrays::write(file, mesh, &lights, &found, origin)))?;
    let report = Report::new(mesh, &lights, &found, (method, predicate), origin, device.name(), times);
    drop(progress);
    print(&if args.json { report.json() } else { report.text(&args.out) })
}

/// Method and predicate, which must go together.
fn way(args: &ExtractArgs) -> Result<(Method, Predicate), UsageError> {
    let method = match args.method {
        MethodArg::FaceMask => Method::FaceMask,
        MethodArg::PerEdge => Method::PerEdge,
    };
    let predicate = match args.predicate {
        Some(PredicateArg::Exact) if method == Method::PerEdge => return Err(UsageError::ExactPerEdge),
        None => method.predicate(Predicate::Exact),
        Some(PredicateArg::Exact) => Predicate::Exact,
        Some(PredicateArg::Fast) => Predicate::Fast,
        Some(PredicateArg::Plane) => Predicate::Plane,
    };
    Ok((method, predicate))
}
