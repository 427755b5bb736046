//! The depth of the casters of a scene, as the light of a depth map sees them.

use glam::{BVec3, DMat4, DVec3, DVec4, Vec3, Vec4};

use super::error::{DepthMapError, guard};
use super::mesh_depth::{DepthPipeline, caster_of, check_depth_format, light_view, storage};
use crate::gpu::common::bindings::{part, whole};
use crate::gpu::common::dispatch_limits::DispatchLimits;
use crate::gpu::common::memory::{Allocation, check};
use crate::gpu::common::pipelines::{Pipelines, group};
use crate::gpu::common::requirements::Subject;
use crate::gpu::scene::depths::{DepthCaster, DepthGroup, SceneDepthCasters};
use crate::gpu::scene::scene::Scene;
use crate::layout::{CHUNK, MeshDepthCaster};
use crate::shadow::DepthDirection;
use crate::{ShadowCamera, Transform};

/// Draws the depth of casters of a [`Scene`] into a depth map, for
/// [`DepthMapVolumes`](crate::gpu::depth_map::DepthMapVolumes). Both front and back faces are drawn, and faces that are
/// excluded or occluded for a light are drawn, too. The same pass may hold several draws, and anything else that writes
/// depth.
///
/// For each page of topology there is one draw for rigid casters, and one for each buffer of positions. Casters whose box is
/// outside of the light's view are culled.
#[derive(Debug)]
pub struct SceneDepth {
    pipeline: DepthPipeline,
}

/// Counts of a call of [`SceneDepth::draw`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SceneDepthCounts {
    /// Casters that were drawn.
    pub drawn: usize,
    /// Chosen casters that were culled, because they are outside of the light's view. Casters with a singular transform
    /// count nowhere.
    pub outside: usize,
    /// Draws.
    pub draws: usize,
}

/// Bindings of a draw: view, positions, casters, faces, chunks.
const BINDINGS: u32 = 5;

/// The largest error of the shader's clip coordinates, as a share of the sum of their terms' absolute values: twelve
/// roundings of 2⁻²³, and those of `f64`. docs/numerics/depth-maps.md, "Depth of scenes".
const CLIP_ERROR: f64 = 16.0 / 8_388_608.0;

impl SceneDepth {
    /// Makes the pipeline that draws into attachments of `format`, without color and with one sample. `depth` is the
    /// [`ShadowCamera::depth`] of the light.
    ///
    /// # Errors
    /// [`DepthMapError`] if `format` has no depth, or the device lacks something or refuses it.
    pub fn new(
        pipelines: impl Into<Pipelines>,
        format: wgpu::TextureFormat,
        depth: DepthDirection,
    ) -> Result<Self, DepthMapError> {
        check_depth_format(format)?;
        let shared = pipelines.into();
        shared.clone().construct(Subject::DepthMap, || {
            Ok(Self { pipeline: DepthPipeline::new(shared, ("scene_depth", BINDINGS), format, depth)? })
        })
    }

    /// Draws the current casters of `scene` as `light` sees them. Rigid ones have the positions of their mesh and their
    /// transform; others have the positions that are in their buffers when the pass runs. The scene need not be encoded,
    /// but for models: an instance that the last encode did not need is missing. For all that the light sees, encode with
    /// one more [`View`](crate::gpu::View), of this camera and with [`LightMask::NONE`](crate::gpu::LightMask::NONE).
    /// Clear the depth of the pass to the far end before: 0 with reversed depth, else 1.
    ///
    /// The draw reads the scene's pages, so [`Scene::remove_mesh`] treats it like an encode.
    ///
    /// Casters with the unit matrix as their transform, and casters with positions in a buffer, have the same depths bit for
    /// bit as with [`MeshDepth::draw`](crate::gpu::depth_map::MeshDepth::draw).
    ///
    /// # Errors
    /// [`DepthMapError`] if a handle or the light is refused, or the device refuses a buffer. Nothing is drawn then.
    pub fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        scene: &Scene,
        casters: SceneDepthCasters<'_>,
        light: &ShadowCamera,
    ) -> Result<SceneDepthCounts, DepthMapError> {
        self.pipeline.check(light)?;
        let view_volume = LightView { matrix: light.matrix(), origin: light.origin_point() };
        let mut counts = SceneDepthCounts::default();
        let mut bound = Vec::new();
        let device = self.pipeline.shared.device();
        let view = guard(device, || light_view(device, light))?;
        for group in scene.depth_groups(casters)? {
            let (drawn, outside): (Vec<_>, Vec<_>) =
                group.casters.iter().partition(|caster| !view_volume.is_outside(caster));
            counts.drawn += drawn.len();
            counts.outside += outside.len();
            if !drawn.is_empty() {
                bound.push(self.bind(&view, &group, &drawn, light)?);
            }
        }
        counts.draws = bound.len();
        pass.set_pipeline(&self.pipeline.pipeline);
        for (group, chunks) in bound {
            pass.set_bind_group(0, &group, &[]);
            pass.draw(0..3 * CHUNK, 0..chunks);
        }
        Ok(counts)
    }

    /// Binds casters of a group. Also returns the count of their chunks.
    fn bind(
        &self,
        view: &wgpu::Buffer,
        depth_group: &DepthGroup<'_>,
        drawn: &[DepthCaster],
        light: &ShadowCamera,
    ) -> Result<(wgpu::BindGroup, u32), DepthMapError> {
        let device = self.pipeline.shared.device();
        let casters: Vec<MeshDepthCaster> = drawn
            .iter()
            .map(|caster| caster_of(caster.rows.unwrap_or(Transform::UNIT), light, caster.layout))
            .collect();
        let chunks: Vec<[u32; 2]> = (0..)
            .zip(drawn)
            .flat_map(|(index, caster)| (0..caster.layout[3]).step_by(CHUNK as usize).map(move |face| [index, face]))
            .collect();
        let limits = DispatchLimits::new(&device.limits());
        let allocations = [
            Allocation { label: "casters of a depth map", bytes: size_of_val(&casters[..]) as u64 },
            Allocation { label: "chunks of a depth map", bytes: size_of_val(&chunks[..]) as u64 },
        ];
        check(&allocations, limits.binding, None)?;
        let group = guard(device, || {
            let [casters, chunks] = [bytemuck::cast_slice(&casters), bytemuck::cast_slice(&chunks)];
            let [casters, chunks] = [casters, chunks].map(|contents| storage(device, contents));
            let positions = part(&depth_group.positions, depth_group.range.clone());
            let resources = [whole(view), positions, whole(&casters), whole(depth_group.faces), whole(&chunks)];
            group(device, "scene depth", &self.pipeline.layout, &resources)
        })?;
        Ok((group, u32::try_from(chunks.len()).unwrap_or(u32::MAX)))
    }
}

/// The light's camera, in `f64`.
struct LightView {
    matrix: DMat4,
    origin: DVec3,
}

impl LightView {
    /// Whether no texel can have a depth of the caster: one plane of the light's clip space clips its whole box, despite the
    /// shader's rounding.
    fn is_outside(&self, caster: &DepthCaster) -> bool {
        let Some(bounds) = caster.bounds else { return false };
        let rows = caster.rows.unwrap_or(Transform::UNIT).map(|row| Vec4::from_array(row).as_dvec4());
        let [low, high] = bounds.map(|corner| Vec3::from_array(corner).as_dvec3());
        let largest = low.abs().max(high.abs());
        let sizes = DVec3::from_array(rows.map(|row| row.truncate().abs().dot(largest) + row.w.abs()));
        let sizes = sizes + self.origin.abs();
        let [x, y, z, w] = [0, 1, 2, 3].map(|axis| {
            let row = self.matrix.row(axis).abs();
            CLIP_ERROR * (row.truncate().dot(sizes) + row.w)
        });
        let corners: [DVec4; 8] = std::array::from_fn(|index| {
            let is_high = BVec3::new(index & 1 != 0, index & 2 != 0, index & 4 != 0);
            let corner = DVec3::select(is_high, high, low);
            let position = DVec3::from_array(rows.map(|row| row.truncate().dot(corner) + row.w));
            self.matrix * (position - self.origin).extend(1.0)
        });
        let is_beyond = |height: &dyn Fn(DVec4) -> f64, error: f64| corners.iter().all(|&at| height(at) < -error);
        is_beyond(&|at| at.w + at.x, w + x)
            || is_beyond(&|at| at.w - at.x, w + x)
            || is_beyond(&|at| at.w + at.y, w + y)
            || is_beyond(&|at| at.w - at.y, w + y)
            || is_beyond(&|at| at.w - at.z, w + z)
            || is_beyond(&|at| at.z, z)
    }
}
