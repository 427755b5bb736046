//! `verify --built-in`: scenes that the command makes itself, on each GPU, against the CPU.

use rimline_models::check::{Bits, Case, Report, Row, cases};
use serde_json::{Value, json};

use super::open;
use crate::args::VerifyArgs;
use crate::device::{Device, Gpu};
use crate::failure::Failure;
use crate::output::print;
use crate::progress::Progress;

pub(super) fn run(args: &VerifyArgs) -> Result<(), Failure> {
    let progress = Progress::start();
    progress.step("opening the devices");
    let (devices, unusable) = open(args.device.as_deref().unwrap_or("gpu"))?;
    let report = |device: &Device| Report { device: device.name(), rows: Vec::new() };
    let mut reports: Vec<Report> = devices.iter().map(report).collect();
    let mut first = None;
    for case in cases() {
        progress.step(format!("checking {}", case.name));
        let right = case.on_cpu();
        for (device, report) in devices.iter().zip(&mut reports) {
            let found = match device {
                Device::Cpu => Ok(case.on_cpu()),
                Device::Gpu(gpu) => on_gpu(&case, gpu),
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
    let unusable: Vec<String> = unusable.iter().map(ToString::to_string).collect();
    let wrong = reports.iter().map(Report::wrong_bits).sum();
    print(&if args.json {
        let equal = wrong == 0 && first.is_none();
        let reports: Vec<Value> = reports.iter().map(to_json).collect();
        format!("{:#}\n", json!({ "equal": equal, "unusable": unusable, "devices": reports }))
    } else {
        let left_out = unusable.iter().map(|reason| format!("not checked: {reason}\n"));
        reports.iter().map(ToString::to_string).chain(left_out).collect::<Vec<_>>().join("\n")
    })?;
    match first {
        _ if wrong > 0 => Err(Failure::WrongBits { wrong }),
        Some(first) => {
            let count = reports.iter().map(Report::failed).sum();
            Err(Failure::Unchecked { count, first: Box::new(first) })
        }
        None => Ok(()),
    }
}

fn on_gpu(case: &Case, gpu: &Gpu) -> Result<Bits, Failure> {
    let failed = |reason: String| gpu.failed(&reason);
    let found = case.on_gpu(&gpu.queue, &gpu.pipelines).map_err(failed)?;
    gpu.wait()?;
    let found = pollster::block_on(found).map_err(failed)?;
    gpu.check()?;
    Ok(found)
}

fn to_json(report: &Report) -> Value {
    let row = |Row { scene, pairs, wrong_bits }: &Row| {
        let (wrong, error) = (wrong_bits.as_ref().ok(), wrong_bits.as_ref().err());
        json!({ "scene": scene, "pairs": pairs, "wrong_bits": wrong, "error": error })
    };
    json!({ "device": report.device, "scenes": report.rows.iter().map(row).collect::<Vec<_>>() })
}
