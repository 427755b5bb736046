//! Models of a scene. Each encode morphs, skins and displaces the instances that its frame needs.

use std::collections::HashMap;
use std::sync::Arc;

use slotmap::DefaultKey;

use super::caster::{Caster, Content};
use super::handles::{CasterHandle, MeshHandle, ModelHandle};
use super::model::ModelEntry;
use super::scene::Scene;
use super::topology::Topology;
use crate::Mesh;
use crate::gpu::common::positions::PositionBuffer;
use crate::gpu::deform::deformer::{DeformError, Deformer, DeformerOptions, PoseInputs};
use crate::gpu::shadow::errors::ShadowError;
use crate::model::{Geometry, Instance, InstancePose, Model, ModelBounds, ModelError};

impl Scene {
    /// Adds a model, and a caster for each of its instances: in the depth buffer, for all lights. Each encode computes the
    /// positions of the pose, by morph targets, skins and the displacement of `options`, for the instances that the frame
    /// needs. A frame needs an instance if a view may see it, or its shadow from a light of the view that affects it. Without
    /// views it needs all. So give a view for each camera that sees the positions, even if it draws no shadows.
    ///
    /// [`Self::set_pose`] changes the pose. Draw the model from [`Self::positions`].
    ///
    /// ```no_run
    /// use rimline::gpu::{DeformerOptions, FrameInputs, ModelHandle, Scene, SceneFrame, ShadowError};
    /// use rimline::{Model, Pose, ShadowCamera, wgpu};
    ///
    /// fn begin(scene: &mut Scene, model: &Model, pose: &Pose) -> Result<ModelHandle, ShadowError> {
    ///     scene.insert_model(model, pose, DeformerOptions::default())
    /// }
    ///
    /// fn frame(
    ///     (scene, walker): (&mut Scene, ModelHandle),
    ///     encoder: &mut wgpu::CommandEncoder,
    ///     (pose, camera): (&Pose, ShadowCamera),
    /// ) -> Result<SceneFrame, ShadowError> {
    ///     scene.set_pose(walker, pose)?;
    ///     let frame = scene.encode(encoder, FrameInputs::new(&[camera.into()]))?;
    ///     let positions = scene.positions(walker)?; // Draw the walker from this buffer.
    ///     # let _ = positions;
    ///     Ok(frame)
    /// }
    /// ```
    ///
    /// # Errors
    /// [`ShadowError::Deform`] if the pose does not fit the model, the model does not fit the device, or the displacement's
    /// resources are missing or refused. The errors of [`Self::add_mesh`]. The scene is as before then.
    pub fn insert_model<'a>(
        &mut self,
        model: &Model,
        pose: impl Into<PoseInputs<'a>>,
        options: DeformerOptions<'_>,
    ) -> Result<ModelHandle, ShadowError> {
        let limit = self.options.memory_limit;
        let deformer = Deformer::beside(&self.pipelines, model, options, (self.used(), limit))?;
        let geometry = |geometry: &Geometry| (geometry.positions().len(), geometry.faces().into());
        let key = self.models.insert(ModelEntry {
            deformer,
            bounds: ModelBounds::new(model),
            is_displaced: options.displacement.is_some(),
            geometries: model.geometries().iter().map(geometry).collect(),
            instances: model.instances().iter().map(Instance::geometry).collect(),
            meshes: HashMap::new(),
            casters: Vec::new(),
            words: Vec::new(),
            time_s: 0.0,
            resources: None,
            version: 0,
        });
        let handle = ModelHandle { scene: self.id, key };
        match self.pose_model(key, pose.into()) {
            Ok(()) => Ok(handle),
            Err(error) => self.remove_model(handle).and(Err(error)),
        }
    }

    /// Changes the pose of a model. Results stay cached for instances whose part of the pose is the same, unless a displacement
    /// has resources or another time. If an instance becomes mirrored or stops being so, its faces change, and the next encode
    /// makes a new layout.
    ///
    /// # Errors
    /// [`ShadowError::Deform`] if the pose does not fit the model or the displacement's resources are missing or refused,
    /// an error of the handle, or, where an instance's faces change, an error of [`Self::add_mesh`]. The pose does not change
    /// then.
    pub fn set_pose<'a>(&mut self, model: ModelHandle, pose: impl Into<PoseInputs<'a>>) -> Result<(), ShadowError> {
        self.pose_model(model.key_in(self.id)?, pose.into())
    }

    /// The casters of a model, one for each of its instances. They take [`Self::set_lights`] and [`Self::set_excluded`].
    ///
    /// # Errors
    /// An error of the handle.
    pub fn casters(&self, model: ModelHandle) -> Result<&[CasterHandle], ShadowError> {
        self.model(model).map(|model| &*model.casters)
    }

    /// The positions of a model in world space, once an encode was submitted: those of all instances, in the vertex order of
    /// [`Model::mesh`], three tightly packed `f32` each. The buffer has the usages `VERTEX` and `STORAGE`, and stays
    /// the same while the model exists. An instance that the frame does not need has all vertices at (0, 0, 0), so
    /// drawing it draws nothing.
    ///
    /// # Errors
    /// An error of the handle.
    pub fn positions(&self, model: ModelHandle) -> Result<PositionBuffer<'_>, ShadowError> {
        self.model(model).map(|model| model.deformer.positions())
    }

    /// Removes a model and its casters.
    ///
    /// # Errors
    /// An error of the handle.
    pub fn remove_model(&mut self, model: ModelHandle) -> Result<(), ShadowError> {
        let removed = ShadowError::Removed { what: "model" };
        let entry = self.models.remove(model.key_in(self.id)?).ok_or(removed)?;
        let positions = entry.deformer.positions().buffer;
        self.removed.extend(self.last.as_ref().filter(|last| last.binds(positions)).map(|_| positions.clone()));
        self.deformed = None;
        for caster in entry.casters {
            self.remove_caster(caster.key);
        }
        for key in entry.meshes.into_values() {
            self.remove_mesh(MeshHandle { scene: self.id, key })?;
        }
        Ok(())
    }

    fn model(&self, model: ModelHandle) -> Result<&ModelEntry, ShadowError> {
        self.models.get(model.key_in(self.id)?).ok_or(ShadowError::Removed { what: "model" })
    }

    /// Sets the pose of a model. The first pose inserts its casters.
    fn pose_model(&mut self, key: DefaultKey, inputs: PoseInputs<'_>) -> Result<(), ShadowError> {
        let removed = ShadowError::Removed { what: "model" };
        let entry = self.models.get(key).ok_or(removed.clone())?;
        entry.deformer.check_resources(inputs.resources)?;
        let words = entry.deformer.pose_words(inputs.pose)?;
        let displaced_by = if entry.is_displaced { inputs.displaced_by } else { 0.0 };
        let boxes = entry.bounds.boxes(inputs.pose, displaced_by).map_err(DeformError::from)?;
        let meshes = self.meshes_of(key, inputs.pose.instances())?;
        self.insert_instances(key, &meshes)?;
        self.deformed = None;
        let entry = self.models.get_mut(key).ok_or(removed)?;
        let is_same_time = !entry.is_displaced || entry.time_s.to_bits() == inputs.time_s.to_bits();
        let before = std::mem::replace(&mut entry.words, words);
        (entry.time_s, entry.resources) = (inputs.time_s, inputs.resources.cloned());
        entry.version += 1;
        let version = Some(entry.version).filter(|_| !entry.deformer.has_resources);
        let compare = |(instance, caster): (usize, &CasterHandle)| {
            let [before, now] = [&before, &entry.words].map(|words| entry.deformer.words_of(instance, words));
            (caster.key, is_same_time && before == now)
        };
        let instances: Vec<_> = entry.casters.iter().enumerate().map(compare).collect();
        for (((caster, is_same), bounds), mesh) in instances.into_iter().zip(boxes).zip(meshes) {
            let Some(entry) = self.content.casters.get_mut(caster) else { continue };
            let is_cached = is_same && entry.positions_version.is_some();
            if entry.bounds != bounds || !is_cached {
                entry.bounds = bounds;
                entry.positions_version = if is_cached { entry.positions_version } else { version };
                self.mark_changed(caster);
            }
            self.set_mesh(caster, mesh);
        }
        Ok(())
    }

    /// The mesh of each instance in a pose. Adds missing ones.
    fn meshes_of(&mut self, key: DefaultKey, poses: &[InstancePose]) -> Result<Vec<DefaultKey>, ShadowError> {
        let mut keys = Vec::with_capacity(poses.len());
        for (instance, pose) in poses.iter().enumerate() {
            let Some(entry) = self.models.get(key) else { break };
            let Some(&geometry) = entry.instances.get(instance) else { break };
            let kind = (geometry, pose.faces_turned());
            if let Some(&mesh) = entry.meshes.get(&kind) {
                keys.push(mesh);
                continue;
            }
            let Some((vertices, faces)) = entry.geometries.get(geometry) else { break };
            let turned = |&[a, b, c]: &[u32; 3]| if kind.1 { [a, c, b] } else { [a, b, c] };
            let mesh = Mesh::from_faces(*vertices, faces.iter().map(turned).collect());
            let mesh = mesh.map_err(|error| DeformError::from(ModelError::from(error)))?;
            // Deforming casters need neither clusters nor rest positions.
            let mesh = self.add_topology(&mesh, &Topology::plain(&mesh), &[])?;
            if let Some(entry) = self.models.get_mut(key) {
                entry.meshes.insert(kind, mesh);
            }
            keys.push(mesh);
        }
        Ok(keys)
    }

    /// Inserts a caster for each instance that has none.
    fn insert_instances(&mut self, key: DefaultKey, meshes: &[DefaultKey]) -> Result<(), ShadowError> {
        let first = self.models.get(key).map_or(meshes.len(), |entry| entry.casters.len());
        for (instance, &mesh) in meshes.iter().enumerate().skip(first) {
            let Some(positions) = self.models.get(key).and_then(|entry| entry.deformer.instance_positions(instance))
            else {
                break;
            };
            let caster = Caster::in_buffer(MeshHandle { scene: self.id, key: mesh }, positions);
            let caster = self.insert(caster)?;
            if let Some(entry) = self.content.casters.get_mut(caster.key) {
                entry.is_of_model = true;
            }
            if let Some(entry) = self.models.get_mut(key) {
                entry.casters.push(caster);
            }
        }
        Ok(())
    }

    /// Gives an instance another mesh, with the same faces turned. Slots of excluded faces stay the same.
    fn set_mesh(&mut self, caster: DefaultKey, mesh: DefaultKey) {
        let Content { casters, meshes, .. } = &mut self.content;
        if let Some((entry, mesh)) = casters.get_mut(caster).zip(meshes.get(mesh))
            && !Arc::ptr_eq(&entry.mesh, mesh)
        {
            entry.mesh = Arc::clone(mesh);
            self.structure = None;
        }
    }

    /// Gives the instances of all models their indices, for a new structure.
    pub(super) fn index_deforming(&mut self) {
        self.deforming = self.models.values().flat_map(|model| model.casters.iter().map(|caster| caster.key)).collect();
        for (key, number) in self.deforming.iter().zip(1..) {
            if let Some(entry) = self.content.casters.get_mut(*key) {
                entry.deforming_index = number;
            }
        }
    }
}
