//! Measures what a plan says, row after row.

use std::cell::OnceCell;

use crate::casters::{self, Devices};
use crate::gpu::Gpu;
use crate::machine::{Adapter, Machine};
use crate::plan::{Job, Plan};
use crate::results::Results;
use crate::row::Row;
use crate::{Error, Host, extraction, shadows, skipping};

/// The device, and a way to open another one on the same adapter, on which nothing was drawn.
pub struct Opened<'a> {
    pub gpu: &'a Gpu,
    pub adapter: Adapter,
    pub another: &'a dyn Fn() -> Result<Gpu, Error>,
}

impl Results {
    /// No rows yet.
    pub fn new(plan: Option<&Plan>, opened: Option<&Opened<'_>>) -> Self {
        Self {
            machine: Machine::this(),
            adapter: opened.map(|opened| opened.adapter.clone()),
            rows: Vec::new(),
            planned_rows: plan.map_or(0, Plan::rows),
        }
    }

    /// Measures all rows. Rows from before an error are kept.
    pub fn measure(&mut self, plan: &Plan, opened: Option<&Opened<'_>>, host: &dyn Host) -> Result<(), Error> {
        let (rounds, size) = (plan.rounds, plan.frames.size);
        let (second, mut devices) = (OnceCell::new(), None);
        for job in &plan.jobs {
            let title = job.title();
            match (job, opened) {
                (Job::Extraction(subject, lights), _) => {
                    host.step(&format!("{title}: edge records"));
                    let (made, gpu) = (subject.make()?, opened.map(|opened| opened.gpu));
                    for &count in lights {
                        let title = format!("{title}, lights: {count}");
                        self.row(&title, host, || extraction::measure(&made, count, gpu, rounds, host))?;
                    }
                }
                (_, None) => {}
                (Job::Shadows(name, shape, path), Some(Opened { gpu, .. })) => {
                    self.row(&title, host, || shadows::measure(plan.frames, gpu, (name, shape), *path, host))?;
                }
                (_, Some(Opened { gpu, another, .. })) => {
                    if devices.is_none() {
                        let stages = another()?;
                        devices = Some(Devices::new(second.get_or_init(|| stages), gpu)?);
                    }
                    let Some(devices) = &mut devices else { continue };
                    self.row(&title, host, || match *job {
                        Job::Casters(mesh, count) => casters::measure(rounds, devices, (mesh, count), size, host),
                        Job::OneMesh(faces) => casters::measure_one_mesh(rounds, devices, faces, size, host),
                        Job::Skipping(scene, count) => skipping::measure(rounds, devices, (scene, count), size, host),
                        _ => Err(Error::Stopped),
                    })?;
                }
            }
        }
        Ok(())
    }

    /// Adds a row. A scene that does not fit the device is left out, unless it is the only one.
    fn row(&mut self, title: &str, host: &dyn Host, measure: impl FnOnce() -> Result<Row, Error>) -> Result<(), Error> {
        if host.is_stopped() {
            return Err(Error::Stopped);
        }
        host.step(title);
        match measure() {
            Err(error) if error.is_too_large() && self.planned_rows > 1 => {
                host.note(&format!("without {title}: {error}"));
                self.planned_rows -= 1;
            }
            row => self.rows.push(row?),
        }
        host.done(title);
        Ok(())
    }
}
