//! Checks of one file on each device, and the output of `verify`.

use std::fmt::Write as _;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use rimline::gltf::LoadOptions;
use rimline::internals::light::check_lights;
use rimline::{Light, MAX_LIGHTS, Mesh};
use serde_json::{Value, json};

use crate::device::Device;
use crate::extract::{arrays, extract_exactly};
use crate::failure::{Failure, InputError, NoDevice};
use crate::input::{Scene, Shape};
use crate::shown::Line;
use crate::source;
use rimline_files::npz::{self, Arrays, Difference};

#[derive(Default)]
pub(super) struct Report {
    folder: PathBuf,
    devices: Vec<String>,
    /// Names of those whose driver clips slivers wrongly.
    clips_wrongly: Vec<String>,
    unusable: Vec<String>,
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

fn name(file: &Path) -> String {
    file.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// The name as it stands in the table.
fn name_cell(name: &str) -> String {
    Line(name).to_string()
}

impl Report {
    pub(super) fn new(folder: &Path, files: &[PathBuf], devices: &[Device], unusable: &[NoDevice]) -> Self {
        Self {
            folder: folder.to_owned(),
            devices: devices.iter().map(Device::name).collect(),
            clips_wrongly: devices.iter().filter(|device| device.clips_wrongly()).map(Device::name).collect(),
            unusable: unusable.iter().map(ToString::to_string).collect(),
            name_width: files.iter().map(|file| name_cell(&name(file)).chars().count()).max().unwrap_or(0).max(4),
            ..Self::default()
        }
    }

    /// The devices, and the table's first line.
    pub(super) fn head(&self) -> String {
        let mut text = String::new();
        for (number, device) in (1..).zip(&self.devices) {
            let _ = writeln!(text, "{number}  {device}");
        }
        for reason in &self.unusable {
            let _ = writeln!(text, "-  {reason}");
        }
        let _ = write!(text, "\n{:<width$}  {:>9}  {:>6}", "file", "faces", "lights", width = self.name_width);
        for number in 1..=self.devices.len() {
            let _ = write!(text, "  {number:<9}");
        }
        format!("{}\n", text.trim_end())
    }

    /// Takes in a file; its line of the table, and more where something is wrong.
    pub(super) fn add(&mut self, file: &Path, checked: Result<Checked, Failure>) -> String {
        let (file, devices) = (name(file), self.devices.len());
        let width = self.name_width;
        self.checks += devices;
        let Checked { faces, edges, lights, results } = match checked {
            Ok(checked) => checked,
            Err(failure) => {
                let (error, row) = (failure.to_string(), name_cell(&file));
                self.fail(failure, devices);
                self.files.push(json!({
                    "file": file, "faces": null, "edges": null, "lights": null, "error": error, "results": []
                }));
                return format!("{row:<width$}  cannot be checked: {}\n", Line(error));
            }
        };
        self.faces += faces;
        self.facing_bits += (faces * lights) as u64;
        let mut line = format!("{:<width$}  {faces:>9}  {lights:>6}", name_cell(&file));
        let (mut remarks, mut list) = (String::new(), Vec::new());
        for (number, result) in results.into_iter().enumerate() {
            let device = self.devices.get(number).cloned().unwrap_or_default();
            let (cell, error) = match &result {
                Ok(differences) if differences.is_empty() => ("equal".to_owned(), None),
                Ok(differences) => {
                    self.different += 1;
                    for difference in differences {
                        let _ = writeln!(remarks, "  {}: {}", number + 1, Line(difference));
                    }
                    (cell(differences), None)
                }
                Err(failure) => {
                    let _ = writeln!(remarks, "  {}: {}", number + 1, Line(failure));
                    ("failed".to_owned(), Some(failure.to_string()))
                }
            };
            let _ = write!(line, "  {cell:<9}");
            let differences: Vec<Value> = result.iter().flatten().map(to_json).collect();
            let equal = error.is_none() && differences.is_empty();
            list.push(json!({ "device": device, "equal": equal, "error": error, "differences": differences }));
            if let Err(failure) = result {
                self.fail(failure, 1);
            }
        }
        self.files.push(json!({
            "file": file, "faces": faces, "edges": edges, "lights": lights, "error": null, "results": list
        }));
        format!("{}\n{remarks}", line.trim_end())
    }

    fn fail(&mut self, failure: Failure, checks: usize) {
        self.failed += checks;
        self.first_failure.get_or_insert(failure);
    }

    pub(super) fn summary(&self) -> String {
        let Self { files, devices, faces, facing_bits, checks, different, failed, .. } = self;
        let what = format!("{} on {}", counted(files.len(), "file"), counted(devices.len(), "device"));
        let mut text = if different + failed == 0 {
            format!("\nAll equal: {what}, {faces} faces, {facing_bits} facing bits, every file byte for byte.\n")
        } else {
            let equal = checks - different - failed;
            format!(
                "\nNOT all equal: of {checks} checks ({what}) {equal} equal, {different} different, {failed} failed.\n"
            )
        };
        if self.devices.iter().all(|device| device == "cpu") {
            text += "No GPU was checked.\n";
        }
        text
    }

    pub(super) fn json(&self) -> String {
        let report = json!({
            "devices": self.devices,
            "clips_wrongly": self.clips_wrongly,
            "unusable": self.unusable,
            "equal": self.different + self.failed == 0,
            "files": self.files,
        });
        format!("{report:#}\n")
    }

    /// Other bits weigh more than what could not be checked.
    pub(super) fn outcome(self) -> Result<(), Failure> {
        match self.first_failure {
            _ if self.different > 0 => {
                Err(Failure::Differs { folder: self.folder, different: self.different, checked: self.checks })
            }
            Some(first) => Err(Failure::Unchecked { count: self.failed, first: Box::new(first) }),
            None => Ok(()),
        }
    }
}

fn counted(count: usize, what: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{count} {what}{plural}")
}

fn cell(differences: &[Difference]) -> String {
    match differences.iter().map(Difference::bits).sum() {
        0 => "DIFFERENT".to_owned(),
        bits => counted(bits as usize, "bit").to_uppercase(),
    }
}

fn to_json(difference: &Difference) -> Value {
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

/// Contents of a file, and results of each device for it.
pub(super) struct Checked {
    pub(super) faces: usize,
    pub(super) edges: usize,
    pub(super) lights: usize,
    /// One a device; empty where its bytes are the file's.
    pub(super) results: Vec<Result<Vec<Difference>, Failure>>,
}

/// Finds everything again from positions, faces and lights, on each device, and compares the archives.
pub(super) fn file(file: &Path, devices: &[Device]) -> Result<Checked, Failure> {
    let failed = Failure::input(file);
    let given = source::read(file).map_err(|error| failed(error.into()))?;
    let (arrays, lights) = read(&given).map_err(&failed)?;
    let Arrays { positions, faces, origin, .. } = arrays;
    let mesh = Mesh::from_faces(positions.len(), faces).map_err(|error| failed(error.into()))?;
    let scene = Scene { mesh, shape: Shape::World(&positions) };
    let (faces, edges) = (scene.mesh.faces().len(), scene.mesh.edges().len());
    let mut results = Vec::with_capacity(devices.len());
    for device in devices {
        let found = extract_exactly(device, &scene, &lights);
        let written = found.and_then(|found| {
            let mut bytes = Vec::with_capacity(given.len());
            let target = file.to_owned();
            arrays::write(Cursor::new(&mut bytes), &scene.mesh, &lights, &found, origin)
                .map_err(|source| Failure::Output { file: target, source })?;
            Ok(bytes)
        });
        results.push(match written {
            // An array that cannot be read is the file's fault on every device.
            Ok(written) => Ok(npz::compare(&given, &written).map_err(|error| failed(error.into()))?),
            Err(failure) => Err(failure),
        });
    }
    Ok(Checked { faces, edges, lights: lights.len(), results })
}

fn read(archive: &[u8]) -> Result<(Arrays, Vec<Light>), InputError> {
    let (arrays, lights) = npz::read_with_lights(Cursor::new(archive), LoadOptions::DEFAULT_MEMORY_LIMIT)?;
    let lights: Vec<Light> = lights.into_iter().map(Light::homogeneous).collect();
    check_lights(&lights, MAX_LIGHTS).map_err(InputError::Lights)?;
    Ok((arrays, lights))
}
