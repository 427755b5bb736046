//! A scene of one caster, for lights by their numbers.

use rimline::gpu::{
    Caster, CasterHandle, FrameInputs, LightHandle, MeshHandle, Pipelines, PositionBuffer, Scene, SceneFrame,
    SceneOptions, ShadowError, ShadowPipelines, StageTimer, View,
};
use rimline::{Light, Mesh, ShadowCamera};

/// A place in a position buffer.
type BufferRange = (wgpu::Buffer, u64, u64);

/// A caster whose positions are in a buffer, in world space.
#[derive(Debug)]
pub struct OneCaster {
    pub scene: Scene,
    mesh: MeshHandle,
    /// Whether the caster is in the depth buffer. It is, unless a test says else before the first encode.
    pub in_depth: bool,
    caster: Option<(CasterHandle, BufferRange)>,
    lights: Vec<LightHandle>,
}

/// The result of an encode.
#[derive(Clone, Debug)]
pub struct OneFrame {
    pub frame: SceneFrame,
    lights: Vec<LightHandle>,
}

impl OneCaster {
    pub fn new(
        pipelines: &Pipelines,
        queue: &wgpu::Queue,
        mesh: &Mesh,
        options: SceneOptions,
    ) -> Result<Self, ShadowError> {
        let mut scene = Scene::new(pipelines, queue, options)?;
        let mesh = scene.add_mesh(mesh, &vec![[0.0; 3]; mesh.vertex_count() as usize])?;
        Ok(Self { scene, mesh, in_depth: true, caster: None, lights: Vec::new() })
    }

    /// Records all stages, for a camera the volumes too.
    pub fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        positions: PositionBuffer<'_>,
        lights: &[Light],
        camera: Option<&ShadowCamera>,
        timer: Option<&mut StageTimer>,
    ) -> Result<OneFrame, ShadowError> {
        let range = (positions.buffer.clone(), positions.offset, positions.stride);
        match &mut self.caster {
            Some((_, at)) if *at == range => {}
            Some((caster, at)) => {
                self.scene.set_positions(*caster, positions)?;
                *at = range;
            }
            None => {
                let caster = Caster { in_depth: self.in_depth, ..Caster::in_buffer(self.mesh, positions) };
                self.caster = Some((self.scene.insert(caster)?, range));
            }
        }
        while self.lights.len() > lights.len() {
            self.lights.pop().map_or(Ok(()), |light| self.scene.remove_light(light))?;
        }
        for (number, &light) in lights.iter().enumerate() {
            match self.lights.get(number) {
                Some(&handle) => self.scene.set_light(handle, light)?,
                None => self.lights.push(self.scene.add_light(light)?),
            }
        }
        let views: Vec<View<'_>> = camera.into_iter().map(|&camera| camera.into()).collect();
        let frame = self.scene.encode(encoder, FrameInputs { timer, ..FrameInputs::new(&views) })?;
        Ok(OneFrame { frame, lights: self.lights.clone() })
    }
}

impl OneFrame {
    /// Draws the volume of a light.
    pub fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        pipelines: &ShadowPipelines,
        light: usize,
    ) -> Result<(), ShadowError> {
        let light = *self.lights.get(light).ok_or(ShadowError::NotEncoded)?;
        self.frame.draw(pass, pipelines, 0, light)
    }
}
