//! Models on the GPU: the scene that throws their shadows, and what draws them.

use rimline::gpu::{
    DeformerOptions, FrameInputs, LightHandle, ModelHandle, Scene, SceneFrame, SceneOptions, StageTimer,
};
use rimline::{Model, Pose, ShadowCamera};

use super::error::RenderError;
use super::gpu::{Gpu, READ_ONLY, UNIFORM, WRITTEN};
use super::skipping::measuring;
use crate::state::body::{Body, Smoothing};
use crate::state::options::{Counting, Skipping};
use crate::state::viewer::Viewer;

/// The models that the scene was made for. Another one needs another scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Made {
    generation: u64,
    counting: Counting,
    skipping: Skipping,
    /// Batches of 32 points that shine.
    batches: usize,
}

impl Made {
    pub(super) fn of(viewer: &Viewer) -> Self {
        let options = &viewer.options;
        let batches = viewer.sources().len().div_ceil(32).max(1);
        Self { generation: viewer.generation(), counting: options.counting, skipping: options.skipping, batches }
    }
}

/// All models.
pub(super) struct Models {
    pub(super) made: Made,
    scene: Scene,
    pub(super) placed: Vec<Placed>,
    /// The points that shine, in the order of the viewer's.
    pub(super) lights: Vec<LightHandle>,
    pub(super) bytes: u64,
}

/// A model in the scene.
pub(super) struct Placed {
    handle: ModelHandle,
    /// The group that draws it, and the number of its corners.
    pub(super) draw: wgpu::BindGroup,
    pub(super) corners: u32,
    normals: wgpu::BindGroup,
    groups: u32,
    /// Whether the pose turns the faces of each instance; another one needs another buffer of faces.
    turned: Vec<bool>,
}

/// Layouts and the pipeline of normals.
pub(super) struct ModelLayouts {
    pub(super) draw: wgpu::BindGroupLayout,
    normals: wgpu::BindGroupLayout,
    pipeline: wgpu::ComputePipeline,
}

impl ModelLayouts {
    pub(super) fn new(gpu: &Gpu) -> Self {
        let draw = [UNIFORM, READ_ONLY, READ_ONLY, READ_ONLY, READ_ONLY];
        let draw = gpu.layout(wgpu::ShaderStages::VERTEX_FRAGMENT, &draw);
        let read = [READ_ONLY, READ_ONLY, READ_ONLY, READ_ONLY, WRITTEN];
        let normals = gpu.layout(wgpu::ShaderStages::COMPUTE, &read);
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("normals"),
            source: wgpu::ShaderSource::Wgsl(include_str!("normals.wgsl").into()),
        });
        let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("normals"),
            bind_group_layouts: &[Some(&normals)],
            immediate_size: 0,
        });
        let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("normals"),
            layout: Some(&layout),
            module: &module,
            entry_point: Some("normals_of_groups"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        Self { draw, normals, pipeline }
    }
}

/// Front and back of the first, second … model; then from the beginning again.
const CLAYS: [[[f32; 3]; 2]; 5] = [
    [[0.62, 0.60, 0.565], [0.50, 0.33, 0.24]],
    [[0.36, 0.49, 0.56], [0.58, 0.40, 0.29]],
    [[0.60, 0.42, 0.31], [0.33, 0.45, 0.51]],
    [[0.46, 0.54, 0.38], [0.58, 0.40, 0.29]],
    [[0.58, 0.50, 0.30], [0.36, 0.40, 0.52]],
];

impl Models {
    pub(super) fn new(gpu: &Gpu, layouts: &ModelLayouts, viewer: &Viewer) -> Result<Self, RenderError> {
        let made = Made::of(viewer);
        let options = SceneOptions {
            max_lights: 32 * made.batches,
            counting: made.counting,
            measuring: measuring(made.skipping),
            ..SceneOptions::default()
        };
        let scene = Scene::new(&gpu.pipelines, &gpu.queue, options)?;
        let mut models = Self { made, scene, placed: Vec::new(), lights: Vec::new(), bytes: 0 };
        for (index, body) in viewer.bodies.iter().enumerate() {
            let failed = |error: &dyn ToString| RenderError::body(index, &body.name, &error.to_string());
            let pose =
                body.pose(viewer.clock.seconds).map_err(|error| RenderError::of_body(index, &body.name, &error))?;
            let limit = gpu.device.limits().max_storage_buffer_binding_size;
            if 12 * body.report().faces as u64 > limit {
                return Err(failed(&format!("its {} faces do not fit the device {}", body.report().faces, gpu.name)));
            }
            let handle = models.scene.insert_model(body.model(), &pose, DeformerOptions::default());
            let handle = handle.map_err(|error| failed(&error))?;
            let placed = models.place(gpu, layouts, (index, body), handle, &pose)?;
            models.placed.push(placed);
        }
        Ok(models)
    }

    fn place(
        &mut self,
        gpu: &Gpu,
        layouts: &ModelLayouts,
        (index, body): (usize, &Body),
        handle: ModelHandle,
        pose: &Pose,
    ) -> Result<Placed, RenderError> {
        let turned: Vec<bool> = pose.instances().iter().map(rimline::InstancePose::faces_turned).collect();
        let (faces, smoothing) = drawn(body.model(), &turned);
        let stored = |label, words: &[u32]| gpu.filled(label, bytemuck::cast_slice(words), wgpu::BufferUsages::STORAGE);
        let [faces, corner_groups, starts, members] = [
            ("faces", faces.as_flattened()),
            ("groups", &smoothing.groups),
            ("starts", &smoothing.starts),
            ("members", &smoothing.faces),
        ]
        .map(|(label, words)| stored(label, words));
        let groups = smoothing.starts.len() as u32 - 1;
        let normals = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("normals"),
            size: 12 * u64::from(groups.max(2)),
            usage: wgpu::BufferUsages::STORAGE,
            mapped_at_creation: false,
        });
        let clay = CLAYS[index % CLAYS.len()].map(|[r, g, b]| [r, g, b, 0.0]);
        let clay = gpu.filled("clay", bytemuck::cast_slice(&clay), wgpu::BufferUsages::UNIFORM);
        let positions = self.scene.positions(handle)?.buffer;
        self.bytes += [&faces, &corner_groups, &starts, &members, &normals, positions]
            .map(wgpu::Buffer::size)
            .iter()
            .sum::<u64>();
        Ok(Placed {
            handle,
            draw: gpu.group(
                &layouts.draw,
                &[&clay, positions, &faces, &corner_groups, &normals].map(wgpu::Buffer::as_entire_binding),
            ),
            corners: smoothing.groups.len() as u32,
            normals: gpu.group(
                &layouts.normals,
                &[positions, &faces, &starts, &members, &normals].map(wgpu::Buffer::as_entire_binding),
            ),
            groups,
            turned,
        })
    }

    /// Records where everything is now, its normals, and its shadow volumes as the camera sees them.
    pub(super) fn encode(
        &mut self,
        gpu: &Gpu,
        layouts: &ModelLayouts,
        encoder: &mut wgpu::CommandEncoder,
        viewer: &Viewer,
        camera: ShadowCamera,
        timer: Option<&mut StageTimer>,
    ) -> Result<SceneFrame, RenderError> {
        for (index, body) in viewer.bodies.iter().enumerate() {
            let pose =
                body.pose(viewer.clock.seconds).map_err(|error| RenderError::of_body(index, &body.name, &error))?;
            let handle = self.placed[index].handle;
            self.scene.set_pose(handle, &pose).map_err(|error| RenderError::body(index, &body.name, &error))?;
            let turned = pose.instances().iter().map(rimline::InstancePose::faces_turned);
            if !turned.eq(self.placed[index].turned.iter().copied()) {
                self.placed[index] = self.place(gpu, layouts, (index, body), handle, &pose)?;
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
        let views = [camera.into()];
        let frame = self.scene.encode(encoder, FrameInputs { views: &views, timer })?;
        let mut pass =
            encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("normals"), timestamp_writes: None });
        pass.set_pipeline(&layouts.pipeline);
        for placed in &self.placed {
            let workgroups = placed.groups.div_ceil(64);
            let across = workgroups.min(65_535);
            pass.set_bind_group(0, &placed.normals, &[]);
            pass.dispatch_workgroups(across, workgroups.div_ceil(across.max(1)), 1);
        }
        drop(pass);
        Ok(frame)
    }

    /// The positions of a model in world space, packed.
    pub(super) fn positions(&self, index: usize) -> Result<rimline::gpu::PositionBuffer<'_>, RenderError> {
        Ok(self.scene.positions(self.placed[index].handle)?)
    }
}

/// Faces and smoothing of all instances, with the vertices of one after those of the other.
fn drawn(model: &Model, turned: &[bool]) -> (Vec<[u32; 3]>, Smoothing) {
    let of_geometry: Vec<Smoothing> = {
        let geometries = model.geometries().iter();
        geometries.map(|geometry| Smoothing::of(geometry.positions(), geometry.faces())).collect()
    };
    let (mut faces, mut all) = (Vec::new(), Smoothing { starts: vec![0], ..Smoothing::default() });
    let mut first_vertex = 0;
    for ((geometry, instance), &is_turned) in model.placed_geometries().zip(model.instances()).zip(turned) {
        let own = &of_geometry[instance.geometry()];
        let (first_group, first_face, first_member) =
            (all.starts.len() as u32 - 1, faces.len() as u32, all.faces.len() as u32);
        // A turned face has its last two corners swapped.
        let swap = |[a, b, c]: [u32; 3]| if is_turned { [a, c, b] } else { [a, b, c] };
        faces.extend(geometry.faces().iter().map(|face| swap(face.map(|vertex| vertex + first_vertex))));
        let groups = own.groups.as_chunks::<3>().0.iter();
        all.groups.extend(groups.flat_map(|groups| swap(groups.map(|group| group + first_group))));
        all.faces.extend(own.faces.iter().map(|face| face + first_face));
        all.starts.extend(own.starts.iter().skip(1).map(|start| start + first_member));
        first_vertex += geometry.positions().len() as u32;
    }
    (faces, all)
}
