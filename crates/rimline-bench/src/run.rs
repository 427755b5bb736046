//! Measures what a plan says, row after row.

use crate::casters::{self, Devices};
use crate::extraction::Prepared;
use crate::gpu::Gpu;
use crate::machine::{Adapter, Machine};
use crate::plan::Plan;
use crate::results::Results;
use crate::row::Row;
use crate::shadows::scene::{MODELS, PATHS, fitted};
use crate::shapes::Shape;
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
        let gpu = opened.map(|opened| opened.gpu);
        for (subject, lights) in &plan.subjects {
            host.step(&format!("{}: edge records", subject.title()));
            let prepared = Prepared::new(subject)?;
            for &count in lights {
                let title = format!("{}, lights: {count}", subject.title());
                self.row(&title, host, || prepared.measure(count, gpu, plan.rounds, host))?;
            }
        }
        let Some(Opened { gpu, another, .. }) = opened else { return Ok(()) };
        let frames = plan.shadows;
        let casters: Vec<(String, Shape)> = match &plan.user_model {
            _ if frames.count == 0 => Vec::new(),
            Some(model) => vec![(model.name.clone(), fitted(&model.positions, model.mesh.faces()))],
            None => MODELS.iter().take(plan.models).map(|model| (model.name.to_owned(), model.make())).collect(),
        };
        for (name, shape) in &casters {
            for path in PATHS {
                let title = format!("shadows of {name}: {}", path.name());
                self.row(&title, host, || shadows::measure(frames, gpu, (name, shape.clone()), path, host))?;
            }
        }
        if plan.casters.is_empty() && plan.one_mesh.is_empty() && plan.skipping.is_empty() {
            return Ok(());
        }
        let stages = another()?;
        let devices = &mut Devices::new(&stages, gpu)?;
        for &(mesh, count) in &plan.casters {
            let title = format!("scene of {}", mesh.counted(count));
            self.row(&title, host, || casters::measure(plan.rounds, devices, (mesh, count), frames.size, host))?;
        }
        for &faces in &plan.one_mesh {
            let title = format!("scene of one mesh of {} faces", crate::text::grouped(faces));
            self.row(&title, host, || casters::measure_one_mesh(plan.rounds, devices, faces, host))?;
        }
        for &(scene, count) in &plan.skipping {
            let title = scene.title(count);
            self.row(&title, host, || skipping::measure(plan.rounds, devices, (scene, count), frames.size, host))?;
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
