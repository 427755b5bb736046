//! The records of models in a scene.

use std::collections::HashMap;

use slotmap::DefaultKey;

use super::handles::CasterHandle;
use super::mask::LightMask;
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
    /// The mesh of each geometry, and with faces turned, if an instance ever had it.
    pub(super) meshes: HashMap<(usize, bool), DefaultKey>,
    /// The casters of the instances.
    pub(super) casters: Vec<CasterHandle>,
    /// The current pose for the stage, with time and bind group of the displacement.
    pub(super) words: Vec<u32>,
    pub(super) time_s: f32,
    pub(super) resources: Option<wgpu::BindGroup>,
    /// The number of poses so far.
    pub(super) version: u64,
}

/// Models that were deformed for an encode of these views and the lights of each.
#[derive(Debug)]
pub(super) struct Deformed {
    /// The states of instances, as the stage `needs` writes them.
    pub(super) states: wgpu::Buffer,
    pub(super) views: Vec<ShadowView>,
    pub(super) lights: Vec<LightMask>,
}
