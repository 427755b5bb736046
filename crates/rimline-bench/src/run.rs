//! Measures what a plan says, row after row.

use std::cell::OnceCell;

use crate::casters::{self, Devices};
use crate::extraction::Prepared;
use crate::gpu::Gpu;
use crate::machine::{Adapter, Machine};
use crate::plan::{Job, Plan};
use crate::results::Results;
use crate::row::Row;
use crate::text::grouped;
use crate::{Error, Host, shadows, skipping};

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
    ///
    /// # Errors
    /// [`Error::Stopped`] if the host stops it, and errors of the device.
    pub fn measure(&mut self, plan: &Plan, opened: Option<&Opened<'_>>, host: &dyn Host) -> Result<(), Error> {
        let (rounds, size) = (plan.rounds, plan.frames.size);
        let (second, mut devices) = (OnceCell::new(), None);
        for job in &plan.jobs {
            if let Job::Extraction(subject, lights) = job {
                host.step(&format!("{}: edge records", subject.title()));
                let prepared = Prepared::new(subject)?;
                for &count in lights {
                    let title = format!("{}, lights: {count}", subject.title());
                    let gpu = opened.map(|opened| opened.gpu);
                    self.row(&title, host, || prepared.measure(count, gpu, rounds, host))?;
                }
                continue;
            }
            let Some(Opened { gpu, another, .. }) = opened else { continue };
            if let Job::Shadows(name, shape, path) = job {
                let title = format!("shadows of {name}: {}", path.name);
                self.row(&title, host, || shadows::measure(plan.frames, gpu, (name, shape), *path, host))?;
                continue;
            }
            let devices = match &mut devices {
                Some(devices) => devices,
                none => {
                    let stages = another()?;
                    none.insert(Devices::new(second.get_or_init(|| stages), gpu)?)
                }
            };
            match job {
                Job::Extraction(..) | Job::Shadows(..) => {}
                &Job::Casters(mesh, count) => {
                    let title = format!("scene of {}", mesh.counted(count));
                    self.row(&title, host, || casters::measure(rounds, devices, (mesh, count), size, host))?;
                }
                &Job::OneMesh(faces) => {
                    let title = format!("scene of one mesh of {} faces", grouped(faces));
                    self.row(&title, host, || casters::measure_one_mesh(rounds, devices, faces, host))?;
                }
                &Job::Skipping(scene, count) => {
                    let title = scene.title(count);
                    self.row(&title, host, || skipping::measure(rounds, devices, (scene, count), size, host))?;
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
