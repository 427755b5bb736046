//! `rimline verify`: do this machine's devices find the bits that a folder of extractions holds, or those of the CPU?
//! And making the folder.

mod built_in;
mod make;
mod report;

use std::path::{Path, PathBuf};

use report::Report;

use crate::args::VerifyArgs;
use crate::device::{self, Device, Wanted};
use crate::failure::{Failure, InputError, NoDevice};
use crate::output::{note, print};
use crate::progress::Progress;

pub(crate) fn run(args: &VerifyArgs) -> Result<(), Failure> {
    // It is there unless the check is of built-in scenes.
    let Some(folder) = &args.folder else { return built_in::run(args) };
    if args.make {
        return make::run(args, folder);
    }
    let files = archives(folder)?;
    let progress = Progress::start();
    progress.step("opening the devices");
    let (devices, unusable) = open(args.device.as_deref().unwrap_or("all"))?;
    for device in devices.iter().filter(|device| device.clips_wrongly()) {
        progress.aside(|| {
            note(&format!(
                "warning: {} counts pixels wrongly where slivers leave the picture; extractions and queries are not \
                 concerned, and shadow volumes need ShadowFormat::trim there, which `rimline shadow` sets",
                device.name()
            ));
        });
    }
    let mut report = Report::new(folder, &files, &devices, &unusable);
    if !args.json {
        progress.aside(|| print(&report.head()))?;
    }
    for (number, file) in (1..).zip(&files) {
        progress.step(format!("checking {} ({number} of {})", file.display(), files.len()));
        let line = report.add(file, report::file(file, &devices));
        if !args.json {
            progress.aside(|| print(&line))?;
        }
    }
    drop(progress);
    print(&if args.json { report.json() } else { report.summary() })?;
    report.outcome()
}

/// The folder's .npz files, in the order of their names.
fn archives(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let failed = Failure::input(folder);
    let unreadable = |error: std::io::Error| failed(error.into());
    if folder.metadata().is_ok_and(|there| !there.is_dir()) {
        return Err(unreadable(std::io::Error::other("it is not a folder; give the folder that holds the .npz files")));
    }
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        let is_archive = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("npz"));
        // Names that begin with a dot are files in the making.
        let is_hidden = path.file_name().is_some_and(|name| name.as_encoded_bytes().starts_with(b"."));
        if is_archive && !is_hidden {
            files.push(path);
        }
    }
    files.sort();
    if files.is_empty() { Err(failed(InputError::NoArchives)) } else { Ok(files) }
}

/// The devices that `--device` asks for, and those that are there but cannot be used.
fn open(wanted: &str) -> Result<(Vec<Device>, Vec<NoDevice>), Failure> {
    let wanted = match wanted {
        "all" => Wanted::Auto,
        other => Wanted::parse(other),
    };
    if wanted == Wanted::Cpu {
        return Ok((vec![Device::Cpu], Vec::new()));
    }
    let (gpus, unusable) = device::open_every(&wanted);
    let mut devices: Vec<Device> = gpus.into_iter().map(|gpu| Device::Gpu(Box::new(gpu))).collect();
    match wanted {
        Wanted::Auto => devices.push(Device::Cpu),
        // The message that says what there is instead.
        _ if devices.is_empty() => return device::open(&wanted).map(|device| (vec![device], unusable)),
        _ => {}
    }
    Ok((devices, unusable))
}
