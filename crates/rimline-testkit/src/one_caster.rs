//! A scene of one caster, with lights by their indices.

use rimline::gpu::{
    Caster, CasterHandle, FrameInputs, LightHandle, MeshHandle, Pipelines, PositionBuffer, Scene, SceneFrame,
    SceneOptions, ShadowError, ShadowPipelines, StageTimer, View,
};
use rimline::{Light, Mesh, ShadowCamera};

/// The fields of a [`PositionBuffer`]: buffer, offset and stride.
type BufferLayout = (wgpu::Buffer, u64, u64);

/// A caster whose positions are in a buffer, in world space.
#[derive(Debug)]
pub struct OneCaster {
    pub scene: Scene,
    mesh: MeshHandle,
    /// [`Caster::in_depth`], true unless a test sets it before the first encode. Later changes have no effect.
    pub in_depth: bool,
    /// `None` before the first encode.
    caster: Option<(CasterHandle, BufferLayout)>,
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

    /// Records extraction for these lights, and with a camera the stages of volumes for view 0.
    pub fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        positions: PositionBuffer<'_>,
        lights: &[Light],
        camera: Option<&ShadowCamera>,
        timer: Option<&mut StageTimer>,
    ) -> Result<OneFrame, ShadowError> {
        let layout = (positions.buffer.clone(), positions.offset, positions.stride);
        match &mut self.caster {
            Some((_, last)) if *last == layout => {}
            Some((caster, last)) => {
                self.scene.set_positions(*caster, positions)?;
                *last = layout;
            }
            None => {
                let caster = Caster { in_depth: self.in_depth, ..Caster::in_buffer(self.mesh, positions) };
                self.caster = Some((self.scene.insert(caster)?, layout));
            }
        }
        while self.lights.len() > lights.len() {
            self.lights.pop().map_or(Ok(()), |light| self.scene.remove_light(light))?;
        }
        for (index, &light) in lights.iter().enumerate() {
            match self.lights.get(index) {
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
    /// Draws the volumes of the light with an index, in view 0.
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
