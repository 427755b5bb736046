//! A scene of one caster, for lights by their numbers.

use rimline::gpu::{
    Capacities, Caster, CasterHandle, FrameInputs, LightHandle, Measuring, MeshHandle, Pipelines, PositionBuffer,
    Scene, SceneFrame, SceneOptions, ShadowError, ShadowPipelines, StageTimer, StencilCounts, View,
};
use rimline::{Counting, Light, Mesh, ShadowCamera};

/// Options of a scene of one caster. It makes its lists anew for each camera.
#[derive(Clone, Copy, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "each is an option of a scene")]
pub struct OneCasterOptions {
    pub counting: Counting,
    pub max_lights: usize,
    /// Every face casts, always.
    pub every_face: bool,
    pub in_depth: bool,
    pub list_capacity: Option<u32>,
    pub cap_capacity: Option<u32>,
    pub piece_capacity: Option<u32>,
    pub cull_by_view: bool,
    pub end_at_range: bool,
    pub bound_counts: bool,
    pub count_bits: u32,
    pub memory_limit: Option<u64>,
}

impl Default for OneCasterOptions {
    fn default() -> Self {
        Self {
            counting: Counting::Auto,
            max_lights: 32,
            every_face: false,
            in_depth: true,
            list_capacity: None,
            cap_capacity: None,
            piece_capacity: None,
            cull_by_view: true,
            end_at_range: false,
            bound_counts: false,
            count_bits: 8,
            memory_limit: None,
        }
    }
}

impl OneCasterOptions {
    /// The options of the scene.
    pub fn of_scene(&self) -> SceneOptions {
        let &Self { counting, max_lights, end_at_range, bound_counts, count_bits, memory_limit, .. } = self;
        let mut measuring = Measuring::CACHED_LISTS;
        measuring.set(Measuring::EVERY_FACE, self.every_face);
        measuring.set(Measuring::CULLED_BY_VIEW, !self.cull_by_view);
        SceneOptions {
            max_lights,
            counting,
            stencil: StencilCounts { count_bits, count_batches: 1, bound_counts },
            capacities: Capacities {
                lists: self.list_capacity,
                caps: self.cap_capacity,
                pieces: self.piece_capacity,
                ..Capacities::default()
            },
            end_at_range,
            clusters_from: None,
            memory_limit,
            measuring,
        }
    }
}

/// A place in a position buffer.
type BufferRange = (wgpu::Buffer, u64, u64);

/// A caster whose positions are in a buffer, in world space.
#[derive(Debug)]
pub struct OneCaster {
    pub scene: Scene,
    mesh: MeshHandle,
    in_depth: bool,
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
        options: &OneCasterOptions,
    ) -> Result<Self, ShadowError> {
        let mut scene = Scene::new(pipelines, queue, options.of_scene())?;
        let mesh = scene.add_mesh(mesh, &vec![[0.0; 3]; mesh.vertex_count() as usize])?;
        Ok(Self { scene, mesh, in_depth: options.in_depth, caster: None, lights: Vec::new() })
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
