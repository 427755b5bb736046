//! The records of models in a scene.

use std::collections::HashMap;

use slotmap::DefaultKey;

use super::handles::CasterHandle;
use crate::gpu::deform::deformer::Deformer;
use crate::layout::ShadowView;
use crate::model::ModelBounds;

/// The scene's record of a model.
#[derive(Debug)]
pub(super) struct ModelEntry {
    pub(super) deformer: Deformer,
    pub(super) bounds: ModelBounds,
    pub(super) is_displaced: bool,
    /// Vertices and faces of each geometry.
    pub(super) geometries: Vec<(usize, Box<[[u32; 3]]>)>,
    /// The geometry of each instance.
    pub(super) instances: Vec<usize>,
    /// The mesh of each geometry, as it is and turned, if an instance ever had it.
    pub(super) meshes: HashMap<(usize, bool), DefaultKey>,
    /// The casters of the instances.
    pub(super) casters: Vec<CasterHandle>,
    /// The pose at hand, as the stage reads it, with time and bind group of the displacement.
    pub(super) words: Vec<u32>,
    pub(super) time_s: f32,
    pub(super) resources: Option<wgpu::BindGroup>,
    /// Poses so far.
    pub(super) version: u64,
}

/// The models that were deformed, for which views, and which of their instances these need.
#[derive(Debug)]
pub(super) struct Deformed {
    pub(super) words: wgpu::Buffer,
    pub(super) views: Vec<ShadowView>,
}
