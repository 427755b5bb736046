//! Stages of a map with objects or without, and what they bind.

use crate::gpu::common::bindings::{Resource, texture, uniform};
use crate::gpu::common::pipelines::{Pipeline, Pipelines, Program};
use crate::layout::{ContourShape, DepthMapShape};
use crate::stages::Stage;

/// A stage without and with edges between objects. The pipeline without them is smaller; the other is made for the first
/// objects.
#[derive(Debug)]
pub(super) struct ObjectStage([Program; 2]);

impl ObjectStage {
    pub(super) fn new(
        shared: &Pipelines,
        stage: &'static Stage,
        entry_point: &'static str,
        constants: &[(&'static str, f64)],
    ) -> Self {
        let program = |objects| Program::at(stage, entry_point, &[constants, &[("OBJECTS", objects)]].concat());
        let stage = Self([program(0.0), program(1.0)]);
        stage.get(shared, false);
        stage
    }

    pub(super) fn get(&self, shared: &Pipelines, objects: bool) -> Pipeline {
        shared.get(&self.0[usize::from(objects)])
    }
}

/// The resources of a map that stages and draws bind.
pub(super) struct Bound<'a> {
    /// The map, and its objects.
    pub(super) textures: [&'a wgpu::TextureView; 2],
    pub(super) shape: DepthMapShape,
    pub(super) map: wgpu::Buffer,
    pub(super) contour: Option<wgpu::Buffer>,
}

impl Bound<'_> {
    pub(super) fn has_objects(&self) -> bool {
        self.shape.has_objects == 1
    }

    pub(super) fn get(&self, name: &str) -> Option<Resource<'_>> {
        Some(match name {
            "depth_map" => uniform::<DepthMapShape>(&self.map, 0),
            "depth_texture" => texture(self.textures[0]),
            "object_texture" => texture(self.textures[1]),
            "contour" => uniform::<ContourShape>(self.contour.as_ref()?, 0),
            _ => return None,
        })
    }
}
