//! `rimline bench`: run time against error, of this device, as a few lines, JSON and a page with charts. The crate
//! `rimline-bench` measures; here are its device, progress and files.

use std::fs::File;
use std::io::{self, Read as _, Write as _};
use std::path::{Path, PathBuf};

use clap::Args;
use rimline::mesh::Weld;
use rimline::wgpu;
use rimline_bench::gpu::Gpu as Measured;
use rimline_bench::{
    Adapter, CHARTS, Error, Host, Model, Opened, Options, Plan, PlanError, Results, SCHEMA, TITLE, depth_maps,
};
use rimline_files::Polygons;

use crate::device::{self, Device, Gpu, GpuError};
use crate::failure::Failure;
use crate::files::{self, Inputs, check_ending, check_folder};
use crate::film;
use crate::input::{Input, Scene};
use crate::input_args::{DeviceArgs, LoadArgs, verbatim};
use crate::output::{self, Folder, Output, Progress, is_interrupted, note, print};
use crate::report::Times;
use crate::spec::{self, LightSpec};

pub(crate) fn run(args: &BenchArgs) -> Result<(), Failure> {
    if args.schema {
        return print(SCHEMA);
    }
    let wanted = &args.device.device;
    let measured_before = args.depth_maps.as_deref().map(times_of_depth_maps).transpose()?;
    let options = options(args)?;
    let device = device::open(wanted)?;
    // `auto` may have found no GPU.
    let plan = match Plan::new(Options { cpu_only: matches!(device, Device::Cpu), ..options }) {
        Ok(plan) => Some(plan),
        // Times from before are enough for a report.
        Err(PlanError::Nothing) if measured_before.is_some() => None,
        Err(error) => return Err(Failure::usage(error.to_string())),
    };
    let destination = Destination::new(args)?;
    let gpu = match &device {
        Device::Cpu => None,
        Device::Gpu(gpu) => Some(&**gpu),
    };
    output::finish_at_interrupt();
    // A second device on the same adapter, once it is needed.
    let another = || {
        let gpu = device::open_gpu(wanted).map_err(|error| Error::Device(error.to_string()))?;
        Ok(measured(&gpu))
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

/// The measurements that the command line asks for, on a device that is not open yet.
fn options(args: &BenchArgs) -> Result<Options, Failure> {
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
        cpu_only: false,
        model: args.file.as_deref().map(|file| model(file, args)).transpose()?,
    })
}

/// The user's model at rest, with the lights of the command line.
fn model(file: &Path, args: &BenchArgs) -> Result<Model, Failure> {
    let input = Input::at_rest(file, &args.load.options(Weld::Data, Polygons::Triangles))?;
    let Scene { mesh, shape } = input.scene(0.0, false)?;
    let positions = shape.on_cpu(&mut Times::default())?.into_owned();
    let lights = if args.light.is_empty() { Vec::new() } else { input.lights(&args.light, 0.0)? };
    let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
    Ok(Model { name, positions, mesh, lights })
}

fn times_of_depth_maps(file: &Path) -> Result<Vec<rimline_bench::row::Row>, Failure> {
    depth_maps::from_json(&files::read_text(file)?).map_err(|what| {
        let problem = format!("it is not what `cargo bench --bench depth_maps -- casters --json FILE` writes: {what}");
        Failure::input(file, problem)
    })
}

/// The command's device for the crate that measures: the same device, queue, pipelines and first error.
fn measured(gpu: &Gpu) -> Measured {
    let Gpu { device, queue, pipelines, .. } = gpu.clone();
    Measured { device, queue, pipelines, reported: Box::new(gpu.reported()) }
}

fn adapter(gpu: &Gpu, measured: &Measured) -> Result<Adapter, Error> {
    let info = &gpu.info;
    Ok(Adapter {
        name: info.name.clone(),
        backend: device::backend_name(info.backend).to_owned(),
        kind: device::kind_name(info.device_type).to_owned(),
        driver: format!("{} {}", info.driver, info.driver_info).trim().to_owned(),
        has_timestamps: gpu.device.features().contains(wgpu::Features::TIMESTAMP_QUERY),
        copy_gb_per_s: measured.copy_bandwidth()?,
    })
}

fn failure(error: Error, gpu: Option<&Gpu>) -> Failure {
    // Meshes that the CPU takes were measured there.
    let of_gpu = |error: GpuError, gpu: &Gpu| {
        let mut gpu = gpu.clone();
        gpu.cpu_would_do = false;
        error.on(&gpu)
    };
    match (error, gpu) {
        (Error::Stopped, _) => Failure::Interrupted,
        (Error::Deform(error), Some(gpu)) => of_gpu(error.into(), gpu),
        (Error::Extractor(error), Some(gpu)) => of_gpu(error.into(), gpu),
        (Error::Shadow(error), Some(gpu)) => of_gpu(error.into(), gpu),
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
    /// Makes the folder, and tries all files, so that one that cannot be written is known before the long work.
    fn new(args: &BenchArgs) -> Result<Self, Failure> {
        let inputs = Inputs::new(args.file.iter().chain(&args.depth_maps));
        let folder = |path: &PathBuf| -> Result<_, Failure> {
            check_folder(path, "--report names a folder; give the name of a folder")?;
            check_report_folder(path)?;
            let folder = Folder::create_all(path)?;
            for file in report_files().map(|name| path.join(name)) {
                inputs.spare(&file)?;
                Output::check(&file)?;
            }
            Ok((path.clone(), folder))
        };
        args.json.as_deref().map_or(Ok(()), |file| check_ending(file, "json").and_then(|()| inputs.spare(file)))?;
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
        film::remove_earlier(chart_files().map(|name| folder.join(name)))?;
        let report = results.report().map_err(|error| Failure::output(folder)(io::Error::other(error.to_string())))?;
        for (name, bytes) in report {
            Output::create(&folder.join(name))?.finish(|output| output.write_all(&bytes))?;
        }
        note(&format!("wrote the report; open {}", folder.join("index.html").display()));
        Ok(())
    }
}

fn chart_files() -> impl Iterator<Item = String> {
    CHARTS.iter().map(|id| format!("{id}.png"))
}

/// The files of a report. Some charts may be missing in one.
fn report_files() -> impl Iterator<Item = String> {
    ["index.html", "data.json"].map(str::to_owned).into_iter().chain(chart_files())
}

/// Refuses a folder where a report would replace files of somebody else: those that it writes are there, and the page is
/// not a report's.
fn check_report_folder(folder: &Path) -> Result<(), Failure> {
    let there: Vec<String> = report_files().filter(|name| folder.join(name).symlink_metadata().is_ok()).collect();
    if there.is_empty() || is_report(&folder.join("index.html")) {
        return Ok(());
    }
    Err(Failure::usage(format!(
        "{} has files that are not of a report of `rimline bench` and would be replaced: {}; choose another folder, or \
         move them away",
        folder.display(),
        there.join(", ")
    )))
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

#[derive(Args, Debug)]
#[command(help_template = verbatim(EXAMPLES), after_help = REMARKS, mut_arg("device", measured_device))]
pub(crate) struct BenchArgs {
    /// A model to measure instead of meshes and scenes made by code: a .gltf, .glb, .obj, .ply, .stl or .npz file. It is measured
    /// at rest
    pub(crate) file: Option<PathBuf>,

    /// A light for the model, as of `extract`. The option can be repeated. Without it there are lights all around
    #[arg(long, value_name = "SPEC", requires = "file", allow_hyphen_values = true, value_parser = spec::light)]
    pub(crate) light: Vec<LightSpec>,

    #[command(flatten)]
    pub(crate) load: LoadArgs,

    /// Measure smaller meshes, one scene of each class, fewer casters and fewer rounds. It takes about a minute instead of
    /// about half an hour
    #[arg(long)]
    pub(crate) quick: bool,

    /// The folder for the report: index.html, plots as PNG, data.json. It is made if it does not exist. No input may be one of
    /// these files
    #[arg(long, value_name = "DIR")]
    pub(crate) report: Option<PathBuf>,

    /// Where to write the data as JSON (--schema describes it)
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,

    #[command(flatten)]
    pub(crate) device: DeviceArgs,

    /// Face counts of the closed meshes, or `none` [default: 1,024 to 4 million, by fours (quick: 1,024, 16,384 and 262,144);
    /// `none` with a model]
    #[arg(long, value_name = "N,N,…", value_delimiter = ',', value_parser = count(16_777_216, "faces up to 16,777,216"))]
    pub(crate) meshes: Option<Vec<usize>>,

    /// Names of stress scenes, `casters` for scenes of many casters, `still`, `city`, `crowd`, `moving`, `house` and
    /// `big` for what a frame skips, `all` or `none` [default: all, and `none` with a model]
    #[arg(long, visible_alias = "scene", value_name = "NAME,…", value_delimiter = ',')]
    pub(crate) scenes: Option<Vec<String>>,

    /// Numbers of casters for the scenes `casters`, `still`, `city`, `crowd`, `moving` and `house`, or `none`: boxes, and up
    /// to 1,000 figures of 4,000 faces, in `house` 108 [default: `casters` 1, 10, 100, 200, 1,000 and 10,000 (quick: 1, 10
    /// and 100), `city` 10,000 (quick: 100), `still` and `crowd` 1,000, `moving` 200, `house` 100 (quick: 20 each)]
    #[arg(long, value_name = "N,N,…", value_delimiter = ',', value_parser = count(100_000, "casters up to 100,000"))]
    pub(crate) casters: Option<Vec<usize>>,

    /// The approximate number of faces of a stress scene [default: 65,536 (quick: 16,384)]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4_194_304))]
    pub(crate) scene_faces: Option<u32>,

    /// Numbers of lights [default: 1, 8 and 32; for stress scenes 8]. `casters`, `still` and `moving` always have 5,
    /// `house` 9, `city` and `big` 1, and `crowd` 32
    #[arg(
        long,
        value_name = "N,N,…",
        value_delimiter = ',',
        value_parser = clap::value_parser!(u16).range(1..=1024),
        conflicts_with = "light",
    )]
    pub(crate) lights: Option<Vec<u16>>,

    /// The largest number of counted runs of each method. Slow rows have fewer, but at least 5 (quick, of camera paths, and of
    /// what a frame skips: 3) [default: 21 (quick: 9)]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub(crate) rounds: Option<u16>,

    /// Frames of each camera path for shadows. 0 leaves shadows out [default: 16 (quick: 6)]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(0..=1000))]
    pub(crate) frames: Option<u16>,

    /// Also show the times in this file, which `cargo bench --bench depth_maps -- casters --json FILE` writes: shadows
    /// by depth maps, by meshes and by lookups
    #[arg(long, value_name = "FILE")]
    pub(crate) depth_maps: Option<PathBuf>,

    /// Print the JSON Schema of the data and measure nothing
    #[arg(long)]
    pub(crate) schema: bool,
}

/// Help of `--device` where software GPUs are measured like others.
fn measured_device(arg: clap::Arg) -> clap::Arg {
    arg.help(
        "Where to measure: `auto` (any GPU, software GPUs included, else the CPU), `gpu`, `cpu`, or a part of a device's name or \
         backend (`rimline devices` lists them)",
    )
}

const EXAMPLES: &str = "\
Examples:
  rimline bench --quick --report report
  rimline bench fox.glb --light point:-1,2e2,.5 --light dir:0,1,0
  rimline bench --report report --json figures.json
  rimline bench --scene casters --meshes none --frames 0 --casters 200,10000
  rimline bench --scene still,city,crowd,moving,house,big --meshes none \\
      --frames 0 --report report
  rimline bench --meshes none --scenes none --frames 0 --depth-maps times.json \\
      --report report
  rimline bench --meshes 65536 --lights 8 --scenes translation-1e6,plate-third \\
      --rounds 5
";

const REMARKS: &str = "\
At the end, a line for each question: how fast, at which price, how right. Report and data have everything else. The methods \
run in turn, round by round, for each mesh and number of lights. Errors are bits that differ from exact arithmetic, and \
vertices where loops stay open. A model of yours also casts in the room of the camera paths, as large as the others there. For \
the scene `casters`, CPU times are of recording a frame with one view, and GPU times are compared with the same faces merged \
into one mesh. The scenes `still`, `city`, `crowd`, `moving`, `house` and `big` are measured with all levels of skipping on, with all \
off, and with each off alone. Ctrl-C ends the run. Report and data then contain the finished rows and say so, and the exit code \
is 130.";

/// Reads a number of faces or casters; 0 for none.
fn count(most: usize, what: &'static str) -> impl Fn(&str) -> Result<usize, String> + Clone {
    move |text| match text.parse() {
        _ if text == "none" => Ok(0),
        Ok(count) if (1..=most).contains(&count) => Ok(count),
        _ => Err(format!("give numbers of {what}, or `none`")),
    }
}
