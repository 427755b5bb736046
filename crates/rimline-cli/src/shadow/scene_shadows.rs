//! The casters of all files in one scene: a mesh for each geometry of a file, and a caster for each of its instances.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use rimline::cpu::HiddenFaces;
use rimline::gpu::{
    Caster, CasterHandle, LightHandle, MeshHandle, Scene, SceneFrame, SceneOptions, ScenePipelines, ShadowError,
    StageTimer,
};
use rimline::{Counting, Light, wgpu};

use super::cast_inputs::CastInputs;
use super::covered::{CoveredFaces, VERSION};
use super::layers::{BatchPipelines, Layers};
use super::posed_model::{PosedModel, Topology};
use crate::device::Gpu;
use crate::failure::Failure;
use crate::gpu_error::GpuError;

/// The scene, and what of it is whose.
pub(crate) struct SceneShadows {
    scene: Scene,
    pub(super) counting: Counting,
    /// Each light has the bit of its number.
    pub(super) lights: Vec<LightHandle>,
    pub(super) files: Vec<File>,
    /// Frame of the last encode.
    frame: Option<SceneFrame>,
    max_lights: usize,
    /// If the bound of the stages leaves it open whether the stencil counts to what lies over each other.
    pub(super) layers: Option<Layers>,
}

/// Meshes and casters of a file in the scene.
#[derive(Default)]
pub(super) struct File {
    meshes: BTreeMap<Topology, MeshHandle>,
    /// For each instance.
    pub(super) casters: Vec<(Topology, CasterHandle)>,
}

/// The options of scenes, but for the number of lights.
pub(super) fn options(counting: Counting) -> SceneOptions {
    SceneOptions { counting, bound_counts: true, ..SceneOptions::default() }
}

impl SceneShadows {
    pub(super) fn new(gpu: &Gpu, counting: Counting, max_lights: usize) -> Result<Self, GpuError> {
        let options = SceneOptions { max_lights, ..options(counting) };
        let scene = Scene::new(&gpu.pipelines, &gpu.queue, options)?;
        Ok(Self { scene, counting, lights: Vec::new(), files: Vec::new(), frame: None, max_lights, layers: None })
    }

    /// Adds the instances of all files. An instance that is mirrored anew has other faces, so another caster takes its place.
    pub(super) fn place(&mut self, gpu: &Gpu, bodies: &[PosedModel<'_>]) -> Result<(), Failure> {
        self.layers = None;
        let Self { scene, files, .. } = self;
        let failed = |error: ShadowError| GpuError::from(error).on(gpu);
        files.resize_with(bodies.len(), File::default);
        for (File { meshes, casters }, body) in files.iter_mut().zip(bodies) {
            for (instance, &topology) in body.topologies.iter().enumerate() {
                let old = casters.get(instance).copied();
                if old.is_some_and(|(of, _)| of == topology) {
                    continue;
                }
                let mesh = match meshes.entry(topology) {
                    Entry::Occupied(mesh) => *mesh.get(),
                    Entry::Vacant(place) => {
                        let rest = body.input.model().geometries()[topology.geometry].positions();
                        *place.insert(scene.add_mesh(&body.mesh_of(topology)?, rest).map_err(failed)?)
                    }
                };
                let Some(positions) = body.positions.of_instance(instance) else { break };
                let caster = scene.insert(Caster::in_buffer(mesh, positions)).map_err(failed)?;
                match old {
                    None => casters.push((topology, caster)),
                    Some((_, old)) => {
                        scene.remove(old).map_err(failed)?;
                        casters[instance] = (topology, caster);
                    }
                }
            }
        }
        Ok(())
    }

    pub(super) fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        inputs: CastInputs<'_>,
        timer: Option<&mut StageTimer>,
    ) -> Result<(), GpuError> {
        self.set_lights(inputs.lights)?;
        self.frame = Some(self.scene.encode(encoder, &[*inputs.camera], timer)?);
        if let Some(layers) = &mut self.layers {
            layers.encode(encoder, &inputs)?;
        }
        Ok(())
    }

    /// Where the bound of what was encoded and submitted is above what the stencil counts, looks at the layers for `all` lights that
    /// are drawn before bodies are placed anew. Waits for the device.
    pub(super) fn count_layers(&mut self, inputs: CastInputs<'_>, all: &[Light]) -> Result<(), Failure> {
        let CastInputs { gpu, bodies, .. } = inputs;
        self.layers = None;
        let failed = |error: GpuError| error.on(gpu);
        if self.statistics(gpu).map_err(|error| failed(error.into()))?.may_wrap == 0 {
            return Ok(());
        }
        let mut layers = Layers::new(gpu, bodies, self.counting, self.max_lights, all)?;
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("batches") });
        layers.encode(&mut encoder, &inputs).map_err(|error| failed(error.into()))?;
        gpu.queue.submit([encoder.finish()]);
        self.layers = Some(layers);
        Ok(())
    }

    fn set_lights(&mut self, lights: &[Light]) -> Result<(), ShadowError> {
        let Self { scene, lights: handles, .. } = self;
        for (number, &light) in lights.iter().enumerate() {
            match handles.get(number) {
                Some(&handle) => scene.set_light(handle, light)?,
                None => handles.push(scene.add_light(light)?),
            }
        }
        Ok(())
    }

    /// Leaves out covered faces. All files are placed and stay.
    pub(super) fn leave_out(&mut self, covered: &CoveredFaces) -> Result<(), GpuError> {
        let lights: Vec<Light> = covered.found.iter().map(HiddenFaces::light).collect();
        self.set_lights(&lights)?;
        let casters: Vec<CasterHandle> =
            self.files.iter().flat_map(|file| file.casters.iter().map(|&(_, caster)| caster)).collect();
        for &caster in &casters {
            self.scene.set_position_version(caster, Some(VERSION))?;
        }
        for (&light, found) in self.lights.iter().zip(&covered.found) {
            self.scene.set_hidden_faces(light, &casters, Some(found))?;
        }
        Ok(())
    }

    pub(super) fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        (pipelines, batches): (&ScenePipelines, &BatchPipelines),
        light: usize,
    ) -> Result<(), GpuError> {
        if let Some(layers) = &self.layers
            && layers.draw(pass, batches, light)?
        {
            return Ok(());
        }
        let handle = *self.lights.get(light).ok_or(ShadowError::NotEncoded)?;
        Ok(self.frame()?.draw(pass, pipelines, 0, handle)?)
    }

    /// Frame of the last encode.
    pub(super) fn frame(&self) -> Result<&SceneFrame, ShadowError> {
        self.frame.as_ref().ok_or(ShadowError::NotEncoded)
    }
}
