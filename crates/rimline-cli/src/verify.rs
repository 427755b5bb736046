//! `rimline verify`: do this machine's devices find the bits that a folder of extractions holds, or those of the CPU?
//! And making the folder.

mod make;

use std::fmt::Write as _;
use std::io::{self, Cursor};
use std::path::{Path, PathBuf};

use rimline::gltf::LoadOptions;
use rimline::{Light, MAX_LIGHTS, Mesh, check_lights};
use rimline_files::FileError;
use rimline_files::npz::{self, Arrays, Difference};
use rimline_models::check::{Bits, Case, Report as DeviceReport, Row, cases};
use serde_json::{Value, json};

use crate::args::VerifyArgs;
use crate::device::{self, Device, Gpu, Wanted};
use crate::extract::{extract_exactly, write_arrays};
use crate::failure::{Cause, Failure};
use crate::files;
use crate::input::{Scene, Shape};
use crate::output::{Line, Progress, counted, note, print};

pub(crate) fn run(args: &VerifyArgs) -> Result<(), Failure> {
    // It is there unless the check is of built-in scenes.
    let Some(folder) = &args.folder else { return run_built_in(args) };
    if args.make {
        return make::run(args, folder);
    }
    let files = archives(folder)?;
    let progress = Progress::start();
    progress.step("opening the devices");
    let (devices, unusable) = open(args.device.as_deref().unwrap_or("all"))?;
    let clips_wrongly: Vec<String> = devices.iter().filter(|device| device.clips_wrongly()).map(Device::name).collect();
    for device in &clips_wrongly {
        progress.aside(|| {
            note(&format!(
                "warning: {device} counts pixels wrongly where slivers leave the picture; extractions and queries are not \
                 concerned, and shadow volumes need ShadowFormat::trim there, which `rimline shadow` sets"
            ));
        });
    }
    let mut report = Report::new(&files, &devices);
    if !args.json {
        progress.aside(|| print(&report.head(&unusable)))?;
    }
    for (number, file) in (1..).zip(&files) {
        progress.step(format!("checking {} ({number} of {})", file.display(), files.len()));
        let line = report.add(file, check_file(file, &devices));
        if !args.json {
            progress.aside(|| print(&line))?;
        }
    }
    drop(progress);
    print(&if args.json { report.json(&clips_wrongly, &unusable) } else { report.summary() })?;
    report.outcome(folder)
}

fn archives(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let unreadable = |error: io::Error| Failure::input(folder, FileError::from(error));
    if folder.metadata().is_ok_and(|there| !there.is_dir()) {
        return Err(unreadable(io::Error::other("it is not a folder; give the folder that holds the .npz files")));
    }
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        let is_archive = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("npz"));
        // Names that begin with a dot are files in the making.
        let is_unfinished = path.file_name().is_some_and(|name| name.as_encoded_bytes().starts_with(b"."));
        if is_archive && !is_unfinished {
            files.push(path);
        }
    }
    files.sort();
    let none = "the folder contains no .npz file, so there is nothing to check; `rimline verify --make` writes some";
    if files.is_empty() { Err(Failure::input(folder, none)) } else { Ok(files) }
}

/// The devices that `--device` asks for, and why others that are there cannot be used.
fn open(wanted: &str) -> Result<(Vec<Device>, Vec<String>), Failure> {
    let wanted = if wanted.eq_ignore_ascii_case("all") { Wanted::Auto } else { wanted.into() };
    if wanted == Wanted::Cpu {
        return Ok((vec![Device::Cpu], Vec::new()));
    }
    let (gpus, unusable) = device::open_every(&wanted);
    let unusable: Vec<String> = unusable.iter().map(ToString::to_string).collect();
    let mut devices: Vec<Device> = gpus.into_iter().map(|gpu| Device::Gpu(Box::new(gpu))).collect();
    match wanted {
        Wanted::Auto => devices.push(Device::Cpu),
        // The message that says what there is instead.
        _ if devices.is_empty() => return device::open(&wanted).map(|device| (vec![device], unusable)),
        _ => {}
    }
    Ok((devices, unusable))
}

#[derive(Default)]
struct Report {
    devices: Vec<String>,
    name_width: usize,
    files: Vec<Value>,
    faces: usize,
    facing_bits: u64,
    /// Checks of a file on a device.
    checks: usize,
    different: usize,
    /// Could not be done, and the first reason.
    failed: usize,
    first_failure: Option<Failure>,
}

fn file_name(file: &Path) -> String {
    file.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

impl Report {
    fn new(files: &[PathBuf], devices: &[Device]) -> Self {
        let widths = files.iter().map(|file| Line(file_name(file)).to_string().chars().count());
        let name_width = widths.fold("file".len(), usize::max);
        Self { devices: devices.iter().map(Device::name).collect(), name_width, ..Self::default() }
    }

    fn head(&self, unusable: &[String]) -> String {
        let mut text = String::new();
        for (number, device) in (1..).zip(&self.devices) {
            let _ = writeln!(text, "{number}  {device}");
        }
        for reason in unusable {
            let _ = writeln!(text, "-  {reason}");
        }
        let _ = write!(text, "\n{:<width$}  {:>9}  {:>6}", "file", "faces", "lights", width = self.name_width);
        for number in 1..=self.devices.len() {
            let _ = write!(text, "  {number:<9}");
        }
        format!("{}\n", text.trim_end())
    }

    /// Takes in a file; its line of the table, and more where something is wrong.
    fn add(&mut self, file: &Path, checked: Result<Checked, Failure>) -> String {
        let (file, devices, width) = (file_name(file), self.devices.len(), self.name_width);
        self.checks += devices;
        let Checked { faces, edges, lights, results } = match checked {
            Ok(checked) => checked,
            Err(failure) => {
                let (error, row) = (failure.to_string(), Line(&file).to_string());
                self.failed += devices;
                self.first_failure.get_or_insert(failure);
                self.files.push(json!({
                    "file": file, "faces": null, "edges": null, "lights": null, "error": error, "results": []
                }));
                return format!("{row:<width$}  cannot be checked: {}\n", Line(error));
            }
        };
        self.faces += faces;
        self.facing_bits += (faces * lights) as u64;
        let mut line = format!("{:<width$}  {faces:>9}  {lights:>6}", Line(&file).to_string());
        let (mut remarks, mut list) = (String::new(), Vec::new());
        for ((number, device), result) in (1..).zip(&self.devices).zip(results) {
            let differences = result.as_deref().unwrap_or_default();
            for difference in differences {
                let _ = writeln!(remarks, "  {number}: {}", Line(difference));
            }
            self.different += usize::from(!differences.is_empty());
            let error = result.as_ref().err().map(ToString::to_string);
            let cell = if error.is_some() { "failed".to_owned() } else { cell(differences) };
            let _ = write!(line, "  {cell:<9}");
            let differences: Vec<Value> = differences.iter().map(difference_json).collect();
            let equal = error.is_none() && differences.is_empty();
            list.push(json!({ "device": device, "equal": equal, "error": error, "differences": differences }));
            if let Err(failure) = result {
                let _ = writeln!(remarks, "  {number}: {}", Line(&failure));
                self.failed += 1;
                self.first_failure.get_or_insert(failure);
            }
        }
        self.files.push(json!({
            "file": file, "faces": faces, "edges": edges, "lights": lights, "error": null, "results": list
        }));
        format!("{}\n{remarks}", line.trim_end())
    }

    fn summary(&self) -> String {
        let Self { files, devices, faces, facing_bits, checks, different, failed, .. } = self;
        let what = format!("{} on {}", counted(files.len(), "file"), counted(devices.len(), "device"));
        let text = if different + failed == 0 {
            format!("\nAll equal: {what}, {faces} faces, {facing_bits} facing bits, every file byte for byte.\n")
        } else {
            let equal = checks - different - failed;
            format!(
                "\nNOT all equal: of {checks} checks ({what}) {equal} equal, {different} different, {failed} failed.\n"
            )
        };
        text + no_gpu(self.devices.iter())
    }

    fn json(&self, clips_wrongly: &[String], unusable: &[String]) -> String {
        let report = json!({
            "devices": self.devices,
            "clips_wrongly": clips_wrongly,
            "unusable": unusable,
            "equal": self.different + self.failed == 0,
            "files": self.files,
        });
        format!("{report:#}\n")
    }

    /// Other bits weigh more than what could not be checked.
    fn outcome(self, folder: &Path) -> Result<(), Failure> {
        match self.first_failure {
            _ if self.different > 0 => {
                Err(Failure::Differs { folder: folder.to_owned(), different: self.different, checked: self.checks })
            }
            Some(first) => Err(Failure::Unchecked { count: self.failed, first: Box::new(first) }),
            None => Ok(()),
        }
    }
}

/// A line that says if the CPU alone was checked.
fn no_gpu<'a>(mut devices: impl Iterator<Item = &'a String>) -> &'static str {
    if devices.all(|device| device == "cpu") { "No GPU was checked.\n" } else { "" }
}

fn cell(differences: &[Difference]) -> String {
    match differences.iter().map(Difference::bits).sum::<u64>() {
        _ if differences.is_empty() => "equal".to_owned(),
        0 => "DIFFERENT".to_owned(),
        bits => counted(bits as usize, "bit").to_uppercase(),
    }
}

fn difference_json(difference: &Difference) -> Value {
    let first = if let Difference::Bits { first, .. } = difference { Some(first) } else { None };
    json!({
        "array": difference.array(),
        "wrong_bits": difference.bits(),
        "row": first.map(|first| first.row),
        "column": first.map(|first| first.column),
        "light": first.and_then(|first| first.light),
        "file": first.map(|first| first.given),
        "found": first.map(|first| first.expected),
        "message": difference.to_string(),
    })
}

struct Checked {
    faces: usize,
    edges: usize,
    lights: usize,
    /// One a device; empty where its bytes are the file's.
    results: Vec<Result<Vec<Difference>, Failure>>,
}

/// Finds everything again from positions, faces and lights, on each device, and compares the archives.
fn check_file(file: &Path, devices: &[Device]) -> Result<Checked, Failure> {
    let given = files::read(file, LoadOptions::DEFAULT_MEMORY_LIMIT).map_err(|error| Failure::input(file, error))?;
    let (arrays, lights) = read_archive(&given).map_err(|error| Failure::input(file, error))?;
    let Arrays { positions, faces, origin, .. } = arrays;
    let mesh = Mesh::from_faces(positions.len(), faces).map_err(|error| Failure::input(file, error))?;
    let scene = Scene { mesh, shape: Shape::World(&positions) };
    let (faces, edges) = (scene.mesh.faces().len(), scene.mesh.edges().len());
    let mut results = Vec::with_capacity(devices.len());
    for device in devices {
        let found = extract_exactly(device, &scene, &lights);
        let written = found.and_then(|found| {
            let mut bytes = Vec::with_capacity(given.len());
            let written = write_arrays(Cursor::new(&mut bytes), &scene.mesh, &lights, &found, origin);
            written.map_err(Failure::output(file)).map(|()| bytes)
        });
        // An array that cannot be read is the file's fault on every device.
        results.push(match written {
            Ok(written) => Ok(npz::compare(&given, &written).map_err(|error| Failure::input(file, error))?),
            Err(failure) => Err(failure),
        });
    }
    Ok(Checked { faces, edges, lights: lights.len(), results })
}

fn read_archive(archive: &[u8]) -> Result<(Arrays, Vec<Light>), Cause> {
    let (arrays, lights) = npz::read_with_lights(Cursor::new(archive), LoadOptions::DEFAULT_MEMORY_LIMIT)?;
    let lights: Vec<Light> = lights.into_iter().map(Light::homogeneous).collect();
    check_lights(&lights, MAX_LIGHTS).map_err(|error| format!("its lights cannot be used: {error}"))?;
    Ok((arrays, lights))
}

fn run_built_in(args: &VerifyArgs) -> Result<(), Failure> {
    let progress = Progress::start();
    progress.step("opening the devices");
    let (devices, unusable) = open(args.device.as_deref().unwrap_or("gpu"))?;
    let report = |device: &Device| DeviceReport { device: device.name(), rows: Vec::new() };
    let mut reports: Vec<DeviceReport> = devices.iter().map(report).collect();
    let mut first = None;
    for case in cases() {
        progress.step(format!("checking {}", case.name));
        let right = case.on_cpu();
        for (device, report) in devices.iter().zip(&mut reports) {
            let found = match device {
                Device::Cpu => Ok(case.on_cpu()),
                Device::Gpu(gpu) => case_on_gpu(&case, gpu),
            };
            let wrong_bits = found.map(|found| found.different(&right)).map_err(|failure| {
                let reason = failure.to_string();
                first.get_or_insert(failure);
                reason
            });
            report.rows.push(Row { scene: case.name.clone(), pairs: case.pairs(), wrong_bits });
        }
    }
    drop(progress);
    let wrong = reports.iter().map(DeviceReport::wrong_bits).sum();
    print(&if args.json {
        let equal = wrong == 0 && first.is_none();
        let reports: Vec<Value> = reports.iter().map(device_json).collect();
        format!("{:#}\n", json!({ "equal": equal, "unusable": unusable, "devices": reports }))
    } else {
        let left_out = unusable.iter().map(|reason| format!("not checked: {reason}\n"));
        let tables = reports.iter().map(ToString::to_string).chain(left_out).collect::<Vec<_>>().join("\n");
        tables + no_gpu(reports.iter().map(|report| &report.device))
    })?;
    match first {
        _ if wrong > 0 => Err(Failure::WrongBits { wrong }),
        Some(first) => {
            let count = reports.iter().map(DeviceReport::failed).sum();
            Err(Failure::Unchecked { count, first: Box::new(first) })
        }
        None => Ok(()),
    }
}

fn case_on_gpu(case: &Case, gpu: &Gpu) -> Result<Bits, Failure> {
    let failed = |reason: String| gpu.failed(&reason);
    let found = case.on_gpu(&gpu.queue, &gpu.pipelines).map_err(failed)?;
    gpu.wait()?;
    let found = pollster::block_on(found).map_err(failed)?;
    gpu.check()?;
    Ok(found)
}

fn device_json(report: &DeviceReport) -> Value {
    let row = |Row { scene, pairs, wrong_bits }: &Row| {
        let (wrong, error) = (wrong_bits.as_ref().ok(), wrong_bits.as_ref().err());
        json!({ "scene": scene, "pairs": pairs, "wrong_bits": wrong, "error": error })
    };
    json!({ "device": report.device, "scenes": report.rows.iter().map(row).collect::<Vec<_>>() })
}
