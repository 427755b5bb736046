//! Stages with a variant that marks edges between objects.

use std::sync::OnceLock;

use crate::gpu::common::pipelines::{Pipeline, Pipelines};
use crate::stages::Stage;

/// A stage with and without edges between objects. The pipeline without them is smaller; the other is made for the first
/// objects.
#[derive(Debug)]
pub(super) struct ObjectStage {
    stage: &'static Stage,
    entry_point: &'static str,
    constants: Vec<(&'static str, f64)>,
    made: [OnceLock<Pipeline>; 2],
}

impl ObjectStage {
    pub(super) fn new(
        shared: &Pipelines,
        stage: &'static Stage,
        entry_point: &'static str,
        constants: &[(&'static str, u32)],
    ) -> Self {
        let constants = constants.iter().map(|&(name, value)| (name, f64::from(value))).collect();
        let stage = Self { stage, entry_point, constants, made: [const { OnceLock::new() }; 2] };
        stage.get(shared, false);
        stage
    }

    pub(super) fn get(&self, shared: &Pipelines, objects: bool) -> Pipeline {
        let make = || {
            let constants = [&self.constants[..], &[("OBJECTS", f64::from(u8::from(objects)))]].concat();
            shared.compute(self.stage, self.entry_point, &constants)
        };
        self.made[usize::from(objects)].get_or_init(make).clone()
    }
}
