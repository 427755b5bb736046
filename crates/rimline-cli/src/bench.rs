//! `rimline bench`: run time against error, of this device, as text, JSON and a page with plots.

pub(crate) mod args;
mod bench_mesh;
mod casters;
mod depth_maps;
mod figures;
mod grouped;
mod machine;
mod measure;
mod method;
mod on_cpu;
mod on_gpu;
mod plan;
mod report;
mod results;
mod row;
mod shadows;
mod skip;
mod summary_json;
mod text;

use std::time::Instant;

use rimline::mesh::Mesh;
use rimline::wgpu;

use crate::device::{self, Device, Gpu, Wanted};
use crate::failure::Failure;
use crate::output::{self, is_interrupted, note, print};
use crate::progress::Progress;
use args::BenchArgs;
use bench_mesh::{BenchMesh, Case, Made};
use depth_maps::DepthMapResults;
use machine::{Adapter, Machine};
use plan::Plan;
use report::Destination;
use results::{Results, SubjectFacts};

/// The data's description, for programs and people.
const SCHEMA: &str = include_str!("../bench.schema.json");

pub(crate) fn run(args: &BenchArgs) -> Result<(), Failure> {
    if args.schema {
        return print(SCHEMA);
    }
    let plan = Plan::new(args)?;
    let depth_maps = args.depth_maps.as_deref().map(DepthMapResults::read).transpose()?;
    let destination = Destination::new(args)?;
    let wanted = Wanted::parse(&args.device.device);
    let device = device::open(&wanted)?;
    let gpu = match &device {
        Device::Cpu => None,
        Device::Gpu(gpu) => Some(&**gpu),
    };
    output::finish_at_interrupt();
    let mut results = Results {
        machine: Machine::this(),
        adapter: gpu.map(adapter).transpose()?,
        subjects: Vec::new(),
        rows: Vec::new(),
        planned_rows: plan.rows(),
        shadows: gpu.map(|_| plan.shadows.empty_results()).filter(|shadows| shadows.planned_rows > 0),
        casters: gpu.map(|_| plan.casters.empty_results()).filter(|casters| casters.planned_rows > 0),
        skipping: gpu.map(|_| plan.skipping.empty_results()).filter(|skipping| skipping.planned_rows > 0),
        depth_maps,
    };
    let progress = Progress::rows(results.rows_planned());
    if !results.machine.is_optimised {
        note("warning: this build is not optimised: its times of the CPU mean nothing, its errors do");
    }
    print(&heading(&results))?;
    // Results from before a failure are written, too.
    let measured = measure_all(&plan, &wanted, gpu, &progress, &mut results);
    drop(progress);
    if !results.is_empty() {
        destination.write(&results)?;
    }
    measured?;
    if results.is_complete() { Ok(()) } else { Err(Failure::Interrupted) }
}

fn measure_all(
    plan: &Plan,
    wanted: &Wanted,
    gpu: Option<&Gpu>,
    progress: &Progress,
    results: &mut Results,
) -> Result<(), Failure> {
    for (subject, lights) in &plan.subjects {
        progress.step(format!("{}: edge records", subject.title()));
        let (made, facts) = make(*subject)?;
        results.subjects.push(facts.clone());
        for &count in lights {
            progress.step(format!("{}, lights: {count}", subject.title()));
            let lights = made.lights(count);
            let case = Case { positions: &made.positions, mesh: &made.mesh, lights: &lights };
            let Some(entries) = row::measure(&case, gpu, plan.rounds)? else { return Ok(()) };
            let row = results::Row { subject: facts.clone(), lights: count, entries };
            progress.aside(|| print(&text::row(&row)))?;
            results.rows.push(row);
            progress.advance(&format!("{}, lights: {count}", subject.title()));
        }
    }
    if let (Some(gpu), Some(shadows)) = (gpu, &mut results.shadows) {
        shadows::measure_all(&plan.shadows, gpu, progress, shadows)?;
    }
    let Some(gpu) = gpu.filter(|_| results.casters.is_some() || results.skipping.is_some()) else { return Ok(()) };
    if is_interrupted() {
        return Ok(());
    }
    let another = device::open_gpu(wanted)?;
    if let Some(casters) = &mut results.casters {
        casters::measure_all(&plan.casters, gpu, &another, progress, casters)?;
    }
    match &mut results.skipping {
        Some(skipping) if !is_interrupted() => skip::measure_all(&plan.skipping, gpu, &another, progress, skipping),
        _ => Ok(()),
    }
}

fn make(subject: BenchMesh) -> Result<(Made, SubjectFacts), Failure> {
    let failed = |source: rimline::MeshError| Failure::Input { file: subject.title().into(), source: source.into() };
    let made = subject.make().map_err(failed)?;
    let faces = made.mesh.faces().to_vec();
    let begin = Instant::now();
    let again = Mesh::from_faces(made.positions.len(), faces).map_err(failed)?;
    let topology_ms = begin.elapsed().as_secs_f64() * 1e3;
    let facts = SubjectFacts {
        name: made.name.clone(),
        class: made.class,
        vertices: made.positions.len(),
        faces: made.mesh.faces().len(),
        edges: made.mesh.edges().len(),
        is_closed: made.mesh.is_closed(),
        topology_ms,
        topology_bytes: again.edge_record_bytes(),
    };
    Ok((made, facts))
}

fn adapter(gpu: &Gpu) -> Result<Adapter, Failure> {
    let info = &gpu.info;
    Ok(Adapter {
        name: info.name.clone(),
        backend: device::backend_name(info.backend),
        kind: crate::devices::kind_name(info.device_type),
        driver: format!("{} {}", info.driver, info.driver_info).trim().to_owned(),
        has_timestamps: gpu.device.features().contains(wgpu::Features::TIMESTAMP_QUERY),
        copy_gb_per_s: on_gpu::copy_bandwidth(gpu, 5)?,
    })
}

fn heading(results: &Results) -> String {
    let Results { machine, adapter, .. } = results;
    let gpu = match adapter {
        None => "only the CPU is measured".to_owned(),
        Some(adapter) => {
            let clock = if adapter.has_timestamps { "timestamps" } else { "no timestamps, so by the clock" };
            format!("{}, {clock}, copies {} GB/s", adapter.line(), text::figures(adapter.copy_gb_per_s))
        }
    };
    let Machine { os, cpu, threads, .. } = machine;
    format!("rimline {}\n{gpu}\n{cpu}, {threads} threads, {os}\n\n", env!("CARGO_PKG_VERSION"))
}
