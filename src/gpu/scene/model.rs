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
    /// Whether the deformer has a displacement.
    pub(super) is_displaced: bool,
    /// The number of vertices, and the faces, of each geometry.
    pub(super) geometries: Vec<(usize, Box<[[u32; 3]]>)>,
    /// The index of each instance's geometry.
    pub(super) instances: Vec<usize>,
    /// The mesh of a geometry, by its index and whether faces are turned. Only those that a pose needed, until the model is
    /// removed.
    pub(super) meshes: HashMap<(usize, bool), DefaultKey>,
    /// The caster of each instance, in the order of instances. Empty before the first pose.
    pub(super) casters: Vec<CasterHandle>,
    /// The current pose, as the stage `deform` reads it.
    pub(super) words: Vec<u32>,
    /// The time for the displacement.
    pub(super) time_s: f32,
    /// The bind group of the displacement.
    pub(super) resources: Option<wgpu::BindGroup>,
    /// The number of poses so far. The positions of an instance have the number of its last pose that differed, or none if
    /// the displacement has resources.
    pub(super) version: u64,
}

/// The result of `Scene::deform`: all models were deformed for the next encode. It holds if that has these views, their lights
/// or fewer, and neither a pose, a light nor the layout changes before (`Scene::take_deformed`).
#[derive(Debug)]
pub(super) struct Deformed {
    /// The states of instances, as the stage `needs` writes them: a word each, in the order of `Scene::deforming`.
    pub(super) states: wgpu::Buffer,
    pub(super) views: Vec<ShadowView>,
    pub(super) lights: Vec<LightMask>,
}
