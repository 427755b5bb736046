//! The ways that are compared: a scene, and an extractor with shadow volumes for each mesh.

use rimline::gpu::{
    Caster, CasterHandle, Extraction, Extractor, ExtractorOptions, LightHandle, Measuring, MeshHandle, PositionBuffer,
    Scene, SceneFrame, SceneOptions, ScenePipelines, ShadowFormat, ShadowFrame, ShadowOptions, ShadowPipelines,
    ShadowVolumes, StageTimer, read_back_vec,
};
use rimline::{Counting, Light, MeshError, ShadowCamera, wgpu};
use rimline_bench::shapes::Shape;

use super::field::{Field, LIGHTS};
use crate::device::Gpu;
use crate::failure::Failure;
use crate::gpu_error::GpuError;

/// How far a frame is recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Until {
    /// Silhouettes are extracted.
    Extraction,
    /// Volumes are prepared for a view.
    Volumes,
}

/// Records frames.
pub(super) trait Recorder {
    fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        until: Until,
        timer: Option<&mut StageTimer>,
    ) -> Result<(), GpuError>;

    /// Draws the volumes of a light into a stencil pass.
    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, pipelines: &DrawPipelines, light: usize) -> Result<(), GpuError>;

    /// The number of silhouette edges of each light, of the last encode.
    fn silhouette_edges(&self, gpu: &Gpu) -> Result<[u64; LIGHTS], GpuError>;
}

/// Pipelines that draw volumes, of a scene and of one mesh.
pub(in super::super) struct DrawPipelines {
    pub(in super::super) scene: ScenePipelines,
    pub(super) volumes: ShadowPipelines,
}

impl DrawPipelines {
    pub(super) fn new(gpu: &Gpu, format: &ShadowFormat) -> Result<Self, GpuError> {
        Ok(Self {
            scene: ScenePipelines::new(&gpu.pipelines, format, Counting::Auto)?,
            volumes: ShadowPipelines::new(&gpu.pipelines, format, Counting::Auto)?,
        })
    }
}

/// Why a way cannot be made.
pub(in super::super) fn mesh_failure(source: MeshError) -> Failure {
    Failure::Input { file: "casters".into(), source: source.into() }
}

/// A scene with rigid casters of one mesh.
pub(super) struct SceneRecorder {
    scene: Scene,
    mesh: MeshHandle,
    lights: Vec<LightHandle>,
    camera: ShadowCamera,
    frame: Option<SceneFrame>,
}

impl SceneRecorder {
    /// A scene with the casters of `field`, and their handles.
    /// `keep_bits`: frames compute what changed only.
    pub(super) fn new(gpu: &Gpu, field: &Field, keep_bits: bool) -> Result<(Self, Vec<CasterHandle>), Failure> {
        let mesh = field.shape.mesh().map_err(mesh_failure)?;
        let make = || -> Result<_, GpuError> {
            let mut options = SceneOptions::default();
            options.measuring.set(Measuring::BITS, !keep_bits);
            let mut scene = Scene::new(&gpu.pipelines, &gpu.queue, options)?;
            let mesh = scene.add_mesh(&mesh, &field.shape.positions)?;
            let transforms = field.places.iter().map(Field::transform);
            let casters = transforms.map(|transform| scene.insert(Caster::rigid(mesh, transform)));
            let casters = casters.collect::<Result<Vec<_>, _>>()?;
            let lights = field.lights.iter().map(|&light| scene.add_light(light)).collect::<Result<_, _>>()?;
            Ok((Self { scene, mesh, lights, camera: field.camera, frame: None }, casters))
        };
        make().map_err(|error| error.on(gpu))
    }

    pub(super) fn scene(&mut self) -> &mut Scene {
        &mut self.scene
    }

    pub(super) fn mesh(&self) -> MeshHandle {
        self.mesh
    }

    pub(super) fn lights(&self) -> &[LightHandle] {
        &self.lights
    }

    /// Bytes of the last frame's buffers, topology not counted.
    pub(super) fn bytes(&self) -> Result<u64, GpuError> {
        Ok(self.frame.as_ref().map(SceneFrame::results).transpose()?.map_or(0, |results| results.bytes))
    }
}

impl Recorder for SceneRecorder {
    fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        until: Until,
        timer: Option<&mut StageTimer>,
    ) -> Result<(), GpuError> {
        let cameras = std::slice::from_ref(&self.camera);
        let cameras = if until == Until::Volumes { cameras } else { &[] };
        self.frame = Some(self.scene.encode(encoder, cameras, timer)?);
        Ok(())
    }

    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, pipelines: &DrawPipelines, light: usize) -> Result<(), GpuError> {
        if let (Some(frame), Some(&light)) = (&self.frame, self.lights.get(light)) {
            frame.draw(pass, &pipelines.scene, 0, light)?;
        }
        Ok(())
    }

    fn silhouette_edges(&self, gpu: &Gpu) -> Result<[u64; LIGHTS], GpuError> {
        let mut edges = [0; LIGHTS];
        let results = self.frame.as_ref().map(SceneFrame::results).transpose()?;
        for group in results.iter().flat_map(|results| &results.groups) {
            add(&mut edges, &read_back_vec(&gpu.device, &gpu.queue, group.lists)?);
        }
        Ok(edges)
    }
}

fn add(edges: &mut [u64; LIGHTS], counts: &[u32]) {
    for (sum, &count) in edges.iter_mut().zip(counts) {
        *sum += u64::from(count);
    }
}

/// An extractor with its volumes for each mesh, whose positions are in world space.
pub(super) struct MeshRecorders {
    meshes: Vec<MeshRecorder>,
    lights: Vec<Light>,
    camera: ShadowCamera,
}

struct MeshRecorder {
    positions: wgpu::Buffer,
    extractor: Extractor,
    volumes: ShadowVolumes,
    extraction: Option<Extraction>,
    frame: Option<ShadowFrame>,
}

impl MeshRecorders {
    /// Recorders for `shapes`, in the lights and the view of `field`.
    pub(super) fn new(
        gpu: &Gpu,
        pipelines: &DrawPipelines,
        field: &Field,
        shapes: impl IntoIterator<Item = Shape>,
    ) -> Result<Self, Failure> {
        let make = |shape: Shape| {
            let mesh = shape.mesh().map_err(mesh_failure)?;
            let options = ExtractorOptions { max_lights: LIGHTS, ..ExtractorOptions::default() };
            let make = || -> Result<_, GpuError> {
                let extractor = Extractor::new(&gpu.pipelines, &mesh, options)?;
                let volumes = ShadowVolumes::new(&pipelines.volumes, &extractor, ShadowOptions::default())?;
                let bytes: &[u8] = bytemuck::cast_slice(&shape.positions);
                let positions = gpu.device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some("positions"),
                    size: bytes.len() as u64,
                    usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
                    mapped_at_creation: false,
                });
                gpu.queue.write_buffer(&positions, 0, bytes);
                Ok(MeshRecorder { positions, extractor, volumes, extraction: None, frame: None })
            };
            make().map_err(|error| error.on(gpu))
        };
        let meshes = shapes.into_iter().map(make).collect::<Result<_, Failure>>()?;
        Ok(Self { meshes, lights: field.lights.clone(), camera: field.camera })
    }
}

impl Recorder for MeshRecorders {
    fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        until: Until,
        mut timer: Option<&mut StageTimer>,
    ) -> Result<(), GpuError> {
        for MeshRecorder { positions, extractor, volumes, extraction, frame } in &mut self.meshes {
            let positions = PositionBuffer { buffer: positions, offset: 0, stride: 12 };
            let found = extractor.encode(encoder, positions, &self.lights, timer.as_deref_mut())?;
            if until == Until::Volumes {
                *frame = Some(volumes.encode(encoder, &found, &self.camera, timer.as_deref_mut())?);
            }
            *extraction = Some(found);
        }
        Ok(())
    }

    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, pipelines: &DrawPipelines, light: usize) -> Result<(), GpuError> {
        for frame in self.meshes.iter().filter_map(|mesh| mesh.frame.as_ref()) {
            frame.draw(pass, &pipelines.volumes, light)?;
        }
        Ok(())
    }

    fn silhouette_edges(&self, gpu: &Gpu) -> Result<[u64; LIGHTS], GpuError> {
        let mut edges = [0; LIGHTS];
        for extraction in self.meshes.iter().filter_map(|mesh| mesh.extraction.as_ref()) {
            let results = extraction.results()?;
            add(&mut edges, &read_back_vec(&gpu.device, &gpu.queue, results.counts)?);
        }
        Ok(edges)
    }
}
