//! `rimline bench`: run time against error, of this device, as a few lines, JSON and a page with charts. The crate
//! `rimline-bench` measures; here are its device, progress and files.

use std::cell::OnceCell;
use std::fs::File;
use std::io::{ErrorKind, Read as _, Write as _};
use std::path::{Path, PathBuf};

use rimline::internals::cpu::{self, Threads};
use rimline::mesh::Weld;
use rimline::wgpu;
use rimline_bench::gpu::Gpu as Measured;
use rimline_bench::{
    Adapter, CHARTS, Error, Host, Model, Opened, Options, Plan, PlanError, Results, SCHEMA, TITLE, depth_maps,
};

use crate::bench_args::BenchArgs;
use crate::device::{self, Device, Gpu, Wanted};
use crate::failure::{Failure, InputError, UsageError};
use crate::input::{Input, Scene, Shape};
use crate::output::{self, Folder, Output, is_interrupted, note, print};
use crate::progress::Progress;
use crate::target::{check_ending, check_folder};
use crate::{origin, source};
use rimline_files::Polygons;

pub(crate) fn run(args: &BenchArgs) -> Result<(), Failure> {
    if args.schema {
        return print(SCHEMA);
    }
    let wanted = Wanted::parse(&args.device.device);
    let measured_before = args.depth_maps.as_deref().map(times_of_depth_maps).transpose()?;
    let plan = match Plan::new(options(args, &wanted)?) {
        Ok(plan) => Some(plan),
        // Times from before are enough for a report.
        Err(PlanError::Nothing) if measured_before.is_some() => None,
        Err(error) => return Err(UsageError::Bench(error).into()),
    };
    let destination = Destination::new(args)?;
    let device = device::open(&wanted)?;
    let gpu = match &device {
        Device::Cpu => None,
        Device::Gpu(gpu) => Some(&**gpu),
    };
    output::finish_at_interrupt();
    // A second device on the same adapter, once it is needed.
    let second = OnceCell::new();
    let another = || {
        let gpu = device::open_gpu(&wanted).map_err(|error| Error::Device(error.to_string()))?;
        Ok(measured(second.get_or_init(|| gpu)))
    };
    let first = gpu.map(measured);
    let opened = match (gpu, &first) {
        (Some(gpu), Some(first)) => {
            let adapter = adapter(gpu, first).map_err(|error| failure(error, Some(gpu)))?;
            Some(Opened { gpu: first, adapter, another: &another })
        }
        _ => None,
    };
    let mut results = Results::new(plan.as_ref(), opened.as_ref());
    results.add(measured_before.unwrap_or_default());
    if !results.is_optimised() {
        note("warning: this build is not optimised: its times of the CPU mean nothing, its errors do");
    }
    let progress = Progress::rows(plan.as_ref().map_or(0, Plan::rows));
    progress.aside(|| print(&results.heading()))?;
    let outcome = plan.as_ref().map_or(Ok(()), |plan| results.measure(plan, opened.as_ref(), &Shown(&progress)));
    drop(progress);
    // Results from before a failure are written, too.
    if !results.is_empty() {
        print(&results.summary())?;
        destination.write(&results)?;
    }
    outcome.map_err(|error| failure(error, gpu))?;
    if results.is_complete() { Ok(()) } else { Err(Failure::Interrupted) }
}

fn options(args: &BenchArgs, wanted: &Wanted) -> Result<Options, Failure> {
    let counts = |numbers: &Option<Vec<usize>>| {
        numbers.as_ref().map(|numbers| numbers.iter().copied().filter(|&number| number > 0).collect())
    };
    Ok(Options {
        quick: args.quick,
        meshes: counts(&args.meshes),
        scenes: args.scenes.clone(),
        casters: counts(&args.casters),
        scene_faces: args.scene_faces.map(|faces| faces as usize),
        lights: args.lights.as_ref().map(|lights| lights.iter().copied().map(usize::from).collect()),
        rounds: args.rounds.map(usize::from),
        frames: args.frames.map(usize::from),
        cpu_only: *wanted == Wanted::Cpu,
        model: args.file.as_deref().map(|file| model(file, args)).transpose()?,
    })
}

/// The user's model at rest, with the lights of the command line.
fn model(file: &Path, args: &BenchArgs) -> Result<Model, Failure> {
    let mut input = Input::read(file, args.load.options(Weld::Data), Polygons::Triangles)?;
    origin::settle(std::slice::from_mut(&mut input), &[Vec::new()], 0.0)?;
    let Scene { mesh, shape } = input.scene(&[], 0.0, false)?;
    let positions = match &shape {
        Shape::World(positions) => positions.to_vec(),
        Shape::Posed { model, pose } => cpu::deform(model, pose, 0.0, None, Threads::all())?,
    };
    let lights = if args.light.is_empty() { Vec::new() } else { input.lights(&args.light, &[], 0.0)? };
    let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
    Ok(Model { name, positions, mesh, lights })
}

fn times_of_depth_maps(file: &Path) -> Result<Vec<rimline_bench::row::Row>, Failure> {
    let text = source::read_text(file).map_err(|error| Failure::input(file)(error.into()))?;
    depth_maps::from_json(&text).map_err(|what| Failure::input(file)(InputError::DepthMapTimes { what }))
}

/// The device as it is measured. What it is of is shared with the command's.
fn measured(gpu: &Gpu) -> Measured {
    let reported = gpu.reported();
    let Gpu { device, queue, pipelines, .. } = gpu;
    Measured {
        device: device.clone(),
        queue: queue.clone(),
        pipelines: pipelines.clone(),
        reported: Box::new(reported),
    }
}

fn adapter(gpu: &Gpu, measured: &Measured) -> Result<Adapter, Error> {
    let info = &gpu.info;
    Ok(Adapter {
        name: info.name.clone(),
        backend: device::backend_name(info.backend).to_owned(),
        kind: crate::devices::kind_name(info.device_type).to_owned(),
        driver: format!("{} {}", info.driver, info.driver_info).trim().to_owned(),
        has_timestamps: gpu.device.features().contains(wgpu::Features::TIMESTAMP_QUERY),
        copy_gb_per_s: measured.copy_bandwidth()?,
    })
}

fn failure(error: Error, gpu: Option<&Gpu>) -> Failure {
    match (error, gpu) {
        (Error::Stopped, _) => Failure::Interrupted,
        (error, Some(gpu)) => gpu.check().err().unwrap_or_else(|| gpu.failed(&error.to_string())),
        (error, None) => Failure::DeviceLost { adapter: "cpu".to_owned(), message: error.to_string() },
    }
}

/// Progress on the terminal, and Ctrl-C.
struct Shown<'a>(&'a Progress);

impl Host for Shown<'_> {
    fn is_stopped(&self) -> bool {
        is_interrupted()
    }

    fn step(&self, what: &str) {
        self.0.step(what.to_owned());
    }

    fn done(&self, what: &str) {
        self.0.advance(what);
    }

    fn note(&self, text: &str) {
        self.0.aside(|| note(text));
    }
}

/// The files that the command line asks for.
struct Destination {
    folder: Option<(PathBuf, Folder)>,
    json: Option<Output>,
}

impl Destination {
    /// Makes the folder, and tries both places, so that an unwritable one is known before the long work.
    fn new(args: &BenchArgs) -> Result<Self, Failure> {
        let folder = |path: &PathBuf| -> Result<_, Failure> {
            check_folder(path, |folder| UsageError::ReportEnding { folder })?;
            check_report_folder(path)?;
            let folder = Folder::create_all(path)?;
            drop(Output::create(&path.join("index.html"))?);
            Ok((path.clone(), folder))
        };
        args.json.as_deref().map_or(Ok(()), |file| check_ending(file, "json"))?;
        Ok(Self {
            folder: args.report.as_ref().map(folder).transpose()?,
            json: args.json.as_deref().map(Output::create).transpose()?,
        })
    }

    fn write(self, results: &Results) -> Result<(), Failure> {
        if let Some(file) = self.json {
            file.finish(|output| writeln!(output, "{:#}", results.json()))?;
        }
        let Some((folder, _kept)) = &self.folder else { return Ok(()) };
        // Charts of an earlier report may show results that this one does not have.
        for file in chart_files().map(|name| folder.join(name)) {
            match std::fs::remove_file(&file) {
                Err(source) if source.kind() != ErrorKind::NotFound => return Err(Failure::Output { file, source }),
                _ => {}
            }
        }
        for (name, bytes) in results.report().map_err(|error| failure(error, None))? {
            Output::create(&folder.join(name))?.finish(|output| output.write_all(&bytes))?;
        }
        note(&format!("wrote {}", folder.join("index.html").display()));
        Ok(())
    }
}

fn chart_files() -> impl Iterator<Item = String> {
    CHARTS.iter().map(|id| format!("{id}.png"))
}

/// Refuses a folder where a report would replace files of somebody else: those that it writes are there, and the page is
/// not a report's.
fn check_report_folder(folder: &Path) -> Result<(), UsageError> {
    let names = ["index.html", "data.json"].map(str::to_owned).into_iter().chain(chart_files());
    let there = names.map(|name| folder.join(name)).find(|file| file.symlink_metadata().is_ok());
    match there {
        Some(file) if !is_report(&folder.join("index.html")) => {
            Err(UsageError::NotAReport { folder: folder.to_owned(), file })
        }
        _ => Ok(()),
    }
}

/// Whether a page is one that this command wrote: its head has the title.
fn is_report(page: &Path) -> bool {
    const HEAD: u64 = 1 << 12;
    let mut head = Vec::new();
    // A pipe would be waited for.
    if page.is_file() {
        let _ = File::open(page).and_then(|file| file.take(HEAD).read_to_end(&mut head));
    }
    String::from_utf8_lossy(&head).contains(&format!("<title>{TITLE}</title>"))
}
