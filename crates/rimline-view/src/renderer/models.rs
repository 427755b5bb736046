//! Models on the GPU: the scene that throws their shadows, and what draws them.

use rimline::gpu::{
    DeformerOptions, FrameInputs, LightHandle, ModelHandle, Scene, SceneFrame, SceneOptions, StageTimer, View,
};
use rimline::{Geometry, InstancePose, Model, Pose};
use rimline_picture::{
    FacingMasks, NormalPipeline, Normals, Resources, Smoothing, Surface, SurfaceBuffers, corner_colors,
};

use super::error::RenderError;
use super::gpu::{Gpu, granted};
use super::skipping::measuring;
use crate::state::body::Body;
use crate::state::options::{Counting, Skipping};
use crate::state::viewer::Viewer;

/// The models that the scene was made for. Another one needs another scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Made {
    generation: u64,
    /// The number of models, which callers may change beside the generation.
    bodies: usize,
    counting: Counting,
    skipping: Skipping,
    /// Batches of 32 points that shine.
    batches: usize,
}

impl Made {
    pub(super) fn of(viewer: &Viewer) -> Self {
        let options = &viewer.options;
        let batches = viewer.sources().len().div_ceil(32).max(1);
        let (generation, bodies) = (viewer.generation(), viewer.bodies.len());
        Self { generation, bodies, counting: options.counting, skipping: options.skipping, batches }
    }
}

/// All models.
pub(super) struct Models {
    pub(super) made: Made,
    scene: Scene,
    placed: Vec<Placed>,
    /// The surface of each model, as of the last encode, and the bytes of its slots.
    pub(super) surfaces: Vec<Surface>,
    slot_bytes: u64,
    /// The frame of the last encode, unless surfaces are to be made anew.
    frame: Option<SceneFrame>,
    /// The points that shine, in the order of the viewer's.
    pub(super) lights: Vec<LightHandle>,
}

/// A model in the scene.
struct Placed {
    handle: ModelHandle,
    faces: wgpu::Buffer,
    normals: Normals,
    colors: Option<wgpu::Buffer>,
    state: State,
    bytes: u64,
}

/// The state of a model that its buffers depend on.
#[derive(Clone, Debug, PartialEq)]
struct State {
    /// Whether the pose turns the faces of each instance.
    turned: Vec<bool>,
    is_smooth: bool,
    is_colored: bool,
}

impl State {
    fn of(pose: &Pose, viewer: &Viewer) -> Self {
        let turned = pose.instances().iter().map(InstancePose::faces_turned).collect();
        Self { turned, is_smooth: viewer.options.smooth, is_colored: viewer.options.colors }
    }
}

impl Models {
    pub(super) fn new(
        gpu: &Gpu,
        resources: &Resources,
        normals: &NormalPipeline,
        viewer: &Viewer,
    ) -> Result<Self, RenderError> {
        let made = Made::of(viewer);
        let options = SceneOptions {
            max_lights: 32 * made.batches,
            counting: made.counting,
            measuring: measuring(made.skipping),
            ..SceneOptions::default()
        };
        let scene = Scene::new(&gpu.pipelines, &gpu.queue, options)?;
        let (placed, surfaces, lights) = (Vec::new(), Vec::new(), Vec::new());
        let mut models = Self { made, scene, placed, surfaces, slot_bytes: 0, frame: None, lights };
        for (index, body) in viewer.bodies.iter().enumerate() {
            let failed = |error: &dyn ToString| RenderError::body(index, &body.name, error);
            let pose = body.pose(viewer.clock.seconds).map_err(|error| failed(&error))?;
            let limit = gpu.device.limits().max_storage_buffer_binding_size;
            if 12 * body.report().faces as u64 > limit {
                return Err(failed(&format!("its {} faces do not fit the device {}", body.report().faces, gpu.name)));
            }
            let handle = models.scene.insert_model(body.model(), &pose, DeformerOptions::default());
            let handle = handle.map_err(|error| failed(&error))?;
            let state = State::of(&pose, viewer);
            let placed = granted(&gpu.device, || models.placed_body(resources, normals, (handle, body), state));
            models.placed.push(placed.map_err(|why| failed(&why))??);
        }
        Ok(models)
    }

    fn placed_body(
        &self,
        resources: &Resources,
        normals: &NormalPipeline,
        (handle, body): (ModelHandle, &Body),
        state: State,
    ) -> Result<Placed, RenderError> {
        let (faces, smoothing) = drawn(body.model(), &state);
        let faces = resources.factory.buffer("faces", bytemuck::cast_slice(&faces));
        let positions = self.scene.positions(handle)?.buffer;
        let normals = normals.normals(&resources.factory, &smoothing, [positions, &faces]);
        let turned = state.turned.iter().copied();
        let colors = state.is_colored.then(|| corner_colors(body.model(), turned, |geometry| body.colors(geometry)));
        let colors = colors.flatten().map(|colors| resources.factory.buffer("colors", bytemuck::cast_slice(&colors)));
        let buffers = [Some(&faces), Some(&normals.buffer), Some(positions), colors.as_ref()];
        let bytes = buffers.into_iter().flatten().map(wgpu::Buffer::size).sum();
        Ok(Placed { handle, faces, normals, colors, state, bytes })
    }

    /// Takes the poses and the lights of now. The models are those that it was made for.
    pub(super) fn set(
        &mut self,
        (resources, normals): (&Resources, &NormalPipeline),
        viewer: &Viewer,
    ) -> Result<(), RenderError> {
        for (index, body) in viewer.bodies.iter().enumerate() {
            let failed = |error: &dyn ToString| RenderError::body(index, &body.name, error);
            let pose = body.pose(viewer.clock.seconds).map_err(|error| failed(&error))?;
            let handle = self.placed[index].handle;
            self.scene.set_pose(handle, &pose).map_err(|error| failed(&error))?;
            let state = State::of(&pose, viewer);
            if self.placed[index].state != state {
                let make = || self.placed_body(resources, normals, (handle, body), state);
                self.placed[index] = granted(&resources.factory.device, make).map_err(|why| failed(&why))??;
                self.frame = None;
            }
        }
        let sources = viewer.sources();
        while self.lights.len() > sources.len() {
            self.lights.pop().map_or(Ok(()), |light| self.scene.remove_light(light))?;
        }
        for (number, (_, source)) in sources.iter().enumerate() {
            match self.lights.get(number) {
                Some(&light) => self.scene.set_light(light, source.light())?,
                None => self.lights.push(self.scene.add_light(source.light())?),
            }
        }
        Ok(())
    }

    /// Records where everything is now, and its normals.
    pub(super) fn deform(
        &mut self,
        normals: &NormalPipeline,
        encoder: &mut wgpu::CommandEncoder,
        view: View<'_>,
        timer: Option<&mut StageTimer>,
    ) -> Result<(), RenderError> {
        self.scene.deform(encoder, FrameInputs { views: &[view], timer })?;
        normals.encode(encoder, self.placed.iter().map(|placed| &placed.normals));
        Ok(())
    }

    /// Whether the surfaces of the last encode are those of now.
    pub(super) fn has_surfaces(&self) -> bool {
        self.frame.is_some()
    }

    /// Records the shadow volumes that a view sees, after [`Self::deform`].
    pub(super) fn encode(
        &mut self,
        resources: &Resources,
        encoder: &mut wgpu::CommandEncoder,
        view: View<'_>,
        timer: Option<&mut StageTimer>,
        viewer: &Viewer,
    ) -> Result<SceneFrame, RenderError> {
        let frame = self.scene.encode(encoder, FrameInputs { views: &[view], timer })?;
        if self.frame.as_ref().is_none_or(|last| !last.has_layout_of(&frame)) {
            let placed = self.placed.iter().zip(&viewer.bodies).enumerate();
            let surfaces = placed.map(|(number, (placed, body))| {
                let made = granted(&resources.factory.device, || self.surface(resources, number, placed, &frame));
                made.map_err(|why| RenderError::body(number, &body.name, &why))?
            });
            let (surfaces, bytes): (Vec<_>, Vec<u64>) = surfaces.collect::<Result<Vec<_>, _>>()?.into_iter().unzip();
            (self.surfaces, self.slot_bytes) = (surfaces, bytes.iter().sum());
        }
        self.frame = Some(frame.clone());
        Ok(frame)
    }

    fn surface(
        &self,
        resources: &Resources,
        number: usize,
        placed: &Placed,
        frame: &SceneFrame,
    ) -> Result<(Surface, u64), RenderError> {
        let masks = FacingMasks::of_scene(frame, self.scene.casters(placed.handle)?.iter().copied())?;
        let slots = resources.factory.buffer("slots", bytemuck::cast_slice(&masks.slots));
        let (faces, normals, colors) = (&placed.faces, &placed.normals.buffer, placed.colors.as_ref());
        let positions = self.scene.positions(placed.handle)?.buffer;
        let buffers = SurfaceBuffers { positions, faces, normals, slots: &slots, colors };
        Ok((Surface::new(resources, number, buffers, &masks), slots.size()))
    }

    /// Bytes of the models' buffers.
    pub(super) fn bytes(&self) -> u64 {
        self.slot_bytes + self.placed.iter().map(|placed| placed.bytes).sum::<u64>()
    }

    /// The positions of a model in world space, packed.
    pub(super) fn positions(&self, index: usize) -> Result<rimline::gpu::PositionBuffer<'_>, RenderError> {
        Ok(self.scene.positions(self.placed[index].handle)?)
    }
}

/// Faces and smoothing of all instances, with the vertices of one after those of the other.
fn drawn(model: &Model, State { turned, is_smooth, .. }: &State) -> (Vec<[u32; 3]>, Smoothing) {
    let smoothing = |geometry: &Geometry| match is_smooth {
        true => Smoothing::of(geometry.positions(), geometry.faces()),
        false => Smoothing::flat(geometry.faces()),
    };
    let of_geometry: Vec<Smoothing> = model.geometries().iter().map(smoothing).collect();
    let (mut faces, mut all, mut first_vertex) = (Vec::new(), Smoothing::default(), 0);
    for ((geometry, instance), &is_turned) in model.placed_geometries().zip(model.instances()).zip(turned) {
        // A turned face has its last two corners swapped.
        let swap = |[a, b, c]: [u32; 3]| if is_turned { [a, c, b] } else { [a, b, c] };
        faces.extend(geometry.faces().iter().map(|face| swap(face.map(|vertex| vertex + first_vertex))));
        all.append(&of_geometry[instance.geometry()], is_turned);
        first_vertex += geometry.positions().len() as u32;
    }
    (faces, all)
}
