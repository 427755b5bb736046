//! The depth of a mesh, as the light of a depth map sees it.

use super::error::{DepthMapError, guard};
use crate::gpu::PositionBuffer;
use crate::gpu::common::bindings::{READ, entries, part, whole};
use crate::gpu::common::dispatch_limits::DispatchLimits;
use crate::gpu::common::drawing::{Drawn, depth_stencil};
use crate::gpu::common::memory::filled;
use crate::gpu::common::pipelines::{Pipelines, group};
use crate::gpu::common::requirements::{Subject, check_alive};
use crate::gpu::scene::caster::Rigid;
use crate::layout::{MeshDepthCaster, MeshDepthView};
use crate::shadow::DepthDirection;
use crate::stages::MESH_DEPTH;
use crate::{Matrix3x4, Mesh, ShadowCamera, Transform};

/// Bindings of a draw: view, positions, caster.
const BINDINGS: u32 = 3;

/// Draws the depth of a mesh into a depth map, for [`DepthMapVolumes`](crate::gpu::depth_map::DepthMapVolumes). Both front
/// and back faces are drawn. One pass may draw many meshes, and anything else that writes depth. For the casters of a scene
/// use [`SceneDepth`](crate::gpu::depth_map::SceneDepth).
///
/// It is for meshes that share a map with other casters, and for comparisons. A mesh with a shadow volume does not need it.
#[derive(Debug)]
pub struct MeshDepth {
    pipeline: DepthPipeline,
    indices: wgpu::Buffer,
    count: u32,
    vertices: u32,
}

impl MeshDepth {
    /// Makes the pipeline that draws `mesh` into attachments of `format`, without color and with one sample. `depth` is the
    /// [`ShadowCamera::depth`] of the light.
    ///
    /// # Errors
    /// [`DepthMapError`] if `format` has no depth, or the device lacks something or refuses it.
    pub fn new(
        pipelines: impl Into<Pipelines>,
        mesh: &Mesh,
        format: wgpu::TextureFormat,
        depth: DepthDirection,
    ) -> Result<Self, DepthMapError> {
        check_depth_format(format)?;
        let count = 3 * mesh.faces().len() as u64;
        let count = u32::try_from(count).map_err(|_| DepthMapError::Faces(mesh.faces().len()))?;
        let shared = pipelines.into();
        shared.clone().construct(Subject::DepthMap, || {
            let pipeline = DepthPipeline::new(shared, ("mesh_depth", BINDINGS), format, depth)?;
            let faces = bytemuck::cast_slice(mesh.faces());
            let indices = guard(pipeline.shared.device(), || {
                filled(pipeline.shared.device(), "faces of a depth map", faces, wgpu::BufferUsages::INDEX)
            })?;
            Ok(Self { pipeline, indices, count, vertices: mesh.vertex_count() })
        })
    }

    /// Draws the mesh as `light` sees it. `positions` are in world space, the space of the light's camera. Clear the depth
    /// of the pass to the far end before: 0 with reversed depth, else 1.
    ///
    /// # Errors
    /// [`DepthMapError`] if the positions or the light are refused. Nothing is drawn then.
    pub fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        positions: PositionBuffer<'_>,
        light: &ShadowCamera,
    ) -> Result<(), DepthMapError> {
        self.draw_rigid(pass, positions, Transform::UNIT, light)
    }

    /// Like [`Self::draw`], with `positions` in mesh space. `mesh_to_world` places them in world space.
    /// It may mirror. With a singular matrix, or one that is not finite, nothing is drawn.
    ///
    /// A vertex relative to the light's origin is at `row.xyz · position + (row.w − origin)` for each axis, by
    /// [`Transform::rows`], as for [`CasterPositions::Rigid`](crate::gpu::CasterPositions::Rigid).
    ///
    /// # Errors
    /// [`DepthMapError`] if the positions or the light are refused. Nothing is drawn then.
    pub fn draw_rigid(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        positions: PositionBuffer<'_>,
        mesh_to_world: impl Into<Transform>,
        light: &ShadowCamera,
    ) -> Result<(), DepthMapError> {
        let mesh_to_world = mesh_to_world.into().rows();
        self.pipeline.check(light)?;
        let device = self.pipeline.shared.device();
        let end = positions.end(self.vertices)?;
        if self.count == 0 || Rigid::new(mesh_to_world).space.is_none() {
            return Ok(());
        }
        let base = DispatchLimits::new(&device.limits()).align_down(positions.offset);
        let word = |bytes: u64| u32::try_from(bytes / 4).unwrap_or(u32::MAX);
        let layout = [word(positions.offset - base), word(positions.stride), 0, self.count / 3];
        let group = guard(device, || {
            let view = light_view(device, light);
            let caster = storage(device, bytemuck::bytes_of(&caster_of(mesh_to_world, light, layout)));
            let resources = [whole(&view), part(positions.buffer, base..end), whole(&caster)];
            group(device, "mesh depth", &self.pipeline.layout, &resources)
        })?;
        pass.set_pipeline(&self.pipeline.pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed(0..self.count, 0, 0..1);
        Ok(())
    }
}

/// The buffer of a light's matrix.
pub(super) fn light_view(device: &wgpu::Device, light: &ShadowCamera) -> wgpu::Buffer {
    storage(device, bytemuck::bytes_of(&MeshDepthView { columns: light.view_projection }))
}

/// A buffer that a draw reads.
pub(super) fn storage(device: &wgpu::Device, contents: &[u8]) -> wgpu::Buffer {
    filled(device, "mesh depth", contents, wgpu::BufferUsages::STORAGE)
}

/// The parameters of a caster for a light. `layout`: the last four fields of the result.
pub(super) fn caster_of(rows: Matrix3x4, light: &ShadowCamera, layout: [u32; 4]) -> MeshDepthCaster {
    let relative_row = |axis: usize| {
        let [x, y, z, shift] = rows[axis];
        [x, y, z, shift - light.origin[axis]]
    };
    let [position_offset, position_stride, first_face, face_count] = layout;
    MeshDepthCaster {
        row_0: relative_row(0),
        row_1: relative_row(1),
        row_2: relative_row(2),
        position_offset,
        position_stride,
        first_face,
        face_count,
    }
}

/// A pipeline of the stage, for attachments without color.
#[derive(Debug)]
pub(super) struct DepthPipeline {
    pub(super) shared: Pipelines,
    pub(super) pipeline: wgpu::RenderPipeline,
    pub(super) layout: wgpu::BindGroupLayout,
    depth: DepthDirection,
}

impl DepthPipeline {
    /// `bindings`: how many of the stage's bindings the entry point has.
    pub(super) fn new(
        shared: Pipelines,
        (entry_point, bindings): (&str, u32),
        format: wgpu::TextureFormat,
        depth: DepthDirection,
    ) -> Result<Self, DepthMapError> {
        let types = (0..bindings).map(|binding| (binding, READ));
        let (layout, pipeline) = guard(shared.device(), || {
            let layout = shared.layout("mesh depth", entries(wgpu::ShaderStages::VERTEX, types));
            let module = shared.module(MESH_DEPTH.name, &MESH_DEPTH.wgsl());
            let pipeline = shared.draws(&Drawn {
                label: entry_point,
                layouts: &[&layout],
                vertex: (&module, entry_point),
                fragment: None,
                constants: &[],
                primitive: wgpu::PrimitiveState::default(),
                depth_stencil: Some(depth_stencil(format, true, depth.nearer(), wgpu::StencilState::default())),
                samples: 1,
                targets: &[],
            });
            (layout, pipeline)
        })?;
        Ok(Self { shared, pipeline, layout, depth })
    }

    /// Refuses a light of the other depth direction, or whose camera is refused, and a device that is lost.
    pub(super) fn check(&self, light: &ShadowCamera) -> Result<(), DepthMapError> {
        light.check_any_hand()?;
        if light.depth != self.depth {
            return Err(DepthMapError::Depth { what: "the light", given: light.depth, made: self.depth });
        }
        Ok(check_alive(self.shared.device())?)
    }
}

/// Refuses a format without depth.
pub(super) fn check_depth_format(format: wgpu::TextureFormat) -> Result<(), DepthMapError> {
    if format.has_depth_aspect() { Ok(()) } else { Err(DepthMapError::NoDepth(format)) }
}
