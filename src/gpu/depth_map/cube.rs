//! The volumes of six depth maps around a light.

use bytemuck::Zeroable;
use glam::{DMat4, DVec4};

use super::bound::ObjectStage;
use super::error::DepthMapError;
use super::frame::DepthMapFrame;
use super::meeting::{AXES, check_meeting, tangent};
use super::options::{DepthCubeMaps, DepthMapMethod, DepthMapOptions};
use super::pipelines::DepthMapPipelines;
use super::recording::Inputs;
use super::texture::{check_objects, check_texture, written_texture};
use super::volumes::{DepthMapVolumes, MAX_CELLS, Maps};
use crate::ShadowCamera;
use crate::gpu::common::bindings::{texture, uniform};
use crate::gpu::common::dispatch_limits::WORKGROUP;
use crate::gpu::common::memory::{Allocation, check, filled};
use crate::gpu::common::pass::Workgroups;
use crate::gpu::common::pipelines::Pipelines;
use crate::gpu::common::requirements::{Subject, check_alive};
use crate::gpu::common::timer::StageTimer;
use crate::layout::DepthMapShape;
use crate::shadow::DepthDirection;
use crate::stages::DEPTH_CUBE;

/// Shadow volumes of casters all around a light, from six depth maps.
///
/// The middles of a map's outermost texels lie on the edges of the cube, so neighbouring maps have samples there on the same
/// rays. Where their depths differ, all get the nearest one. A map has a field of view slightly above 90°, as the cameras of
/// [`Self::cameras`] have.
///
/// Each map is an upright picture of its camera, with row 0 at the top. The faces of cube textures of graphics APIs are
/// mirrored or rotated against it, so draw each map with its camera of [`Self::cameras`].
///
/// A missing map casts nothing, and shadows of the others end at its edges, as at the border of a single map.
#[derive(Debug)]
pub struct DepthMapCube {
    shared: Pipelines,
    stage: ObjectStage,
    volumes: DepthMapVolumes,
    shape: DepthMapShape,
    view: wgpu::TextureView,
    /// Bound instead of a map that is missing.
    nothing: wgpu::TextureView,
    /// Bound instead of the objects of all maps, where there are none.
    unwritten_objects: wgpu::TextureView,
    /// The objects of all maps. Made in the first encode with objects.
    objects: Option<wgpu::TextureView>,
}

impl DepthMapCube {
    /// Cameras at `position` for maps of `side` texels, which look along +x, −x, +y, −y, +z, −z. y is up; it is z for the
    /// map along +y, and −z for the one along −y.
    ///
    /// # Errors
    /// [`DepthMapError`] if `side` is below 3, the position or a distance is not finite, `near` is not above 0, or `far` not
    /// above `near`; and where they are so extreme that rounding to floats leaves no cameras that meet.
    pub fn cameras(
        position: [f32; 3],
        near: f32,
        far: Option<f32>,
        depth: DepthDirection,
        side: u32,
    ) -> Result<[ShadowCamera; 6], DepthMapError> {
        if side < 3 {
            return Err(DepthMapError::Side(side));
        }
        if !position.iter().all(|coordinate| coordinate.is_finite()) {
            return Err(DepthMapError::Position(position));
        }
        if !(near.is_finite() && near > 0.0) {
            return Err(DepthMapError::Option { name: "near", given: near, range: "a finite distance above 0" });
        }
        if let Some(far) = far
            && !(far.is_finite() && far > near)
        {
            return Err(DepthMapError::Far { near, far });
        }
        let (near, far) = (f64::from(near), far.map(f64::from));
        let cameras = AXES.map(|[forward, right, up]| {
            let scale = 1.0 / tangent(side);
            let w = forward.extend(0.0);
            let z = match (depth, far) {
                (DepthDirection::Reversed, None) => DVec4::W * near,
                (DepthDirection::Reversed, Some(far)) => (DVec4::W * far - w) * (near / (far - near)),
                (DepthDirection::Standard, None) => w - DVec4::W * near,
                (DepthDirection::Standard, Some(far)) => (w - DVec4::W * near) * (far / (far - near)),
            };
            let rows = DMat4::from_cols((scale * right).extend(0.0), (scale * up).extend(0.0), z, w);
            ShadowCamera { view_projection: rows.transpose().as_mat4().to_cols_array_2d(), origin: position, depth }
        });
        check_meeting(&cameras, side)?;
        Ok(cameras)
    }

    /// Makes buffers for six maps of `side` × `side` texels, on the device of `pipelines`.
    ///
    /// # Errors
    /// [`DepthMapError`] if the side, an option or the number of bits is refused, or buffers and texture do not fit the
    /// device.
    pub fn new(pipelines: &DepthMapPipelines, side: u32, options: DepthMapOptions) -> Result<Self, DepthMapError> {
        pipelines.shared.construct(Subject::DepthMap, || Self::with(pipelines, side, options))
    }

    fn with(pipelines: &DepthMapPipelines, side: u32, options: DepthMapOptions) -> Result<Self, DepthMapError> {
        if side < 3 {
            return Err(DepthMapError::Side(side));
        }
        if let DepthMapMethod::Contours { .. } = options.method {
            return Err(DepthMapError::CubeContours);
        }
        // Each map would be moved along its own axes, and leave the others.
        if pipelines.bits().len() > 1 {
            return Err(DepthMapError::OneBit(pipelines.bits().len() as u32));
        }
        let cells = u64::from(side - 1).pow(2).saturating_mul(6);
        if cells > MAX_CELLS {
            return Err(DepthMapError::Cells(side));
        }
        let shared = pipelines.shared.clone();
        let device = shared.device();
        let max_side = device.limits().max_texture_dimension_2d;
        let size = [side.saturating_mul(3), side.saturating_mul(2)];
        if size[0] > max_side {
            return Err(DepthMapError::Texture { size, max_side });
        }
        let texels = u64::from(size[0]) * u64::from(size[1]);
        let texture = Allocation { label: "cube of depth maps", bytes: 4 * texels };
        let maps = Maps { size: [side; 2], faces: 6, textures: &[texture] };
        let volumes = DepthMapVolumes::with(pipelines, &maps, options)?;
        let view = written_texture(device, texture.label, size, wgpu::TextureFormat::R32Float)?;
        // Stand-ins for missing maps have one texel.
        let nothing = written_texture(device, "no depth map", [1, 1], wgpu::TextureFormat::R32Float)?;
        let unwritten_objects = written_texture(device, "no objects of a cube", [1, 1], wgpu::TextureFormat::R32Uint)?;
        let blocks = texels.div_ceil(u64::from(WORKGROUP)) as u32;
        let shape = DepthMapShape { size: [side; 2], blocks, faces: 6, ..DepthMapShape::zeroed() };
        let stage = ObjectStage::new(&shared, &DEPTH_CUBE, "depth_cube", &[]);
        Ok(Self { stage, volumes, shape, view, nothing, unwritten_objects, objects: None, shared })
    }

    /// Records the stages that merge the six maps and find their edges. `camera` is the eye's. Frames of earlier encodes can
    /// no longer be drawn. The first encode with objects makes a texture and a pipeline for them.
    ///
    /// # Errors
    /// [`DepthMapError`] if a texture or a camera is refused, the maps of the cameras do not meet, or the first objects
    /// do not fit. Nothing is recorded then.
    pub fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        maps: &DepthCubeMaps<'_>,
        camera: &ShadowCamera,
    ) -> Result<DepthMapFrame, DepthMapError> {
        self.encode_timed(encoder, maps, camera, None)
    }

    /// The same with a timestamp around each stage.
    ///
    /// # Errors
    /// The errors of [`Self::encode`], and [`DepthMapError::Device`] for a timer of another device.
    pub fn encode_timed(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        maps: &DepthCubeMaps<'_>,
        camera: &ShadowCamera,
        timer: Option<&mut StageTimer>,
    ) -> Result<DepthMapFrame, DepthMapError> {
        let side = self.shape.size[0];
        check_meeting(&maps.lights, side)?;
        // A missing map may have any format.
        let mut formats = [wgpu::TextureFormat::R32Float; 6];
        for (face, (map, format)) in maps.textures.iter().zip(&mut formats).enumerate() {
            if let Some(map) = map {
                *format = check_texture(map.texture(), self.shape.size, &format!("map {face} of the cube"))?;
            }
        }
        self.check_objects(maps)?;
        check_alive(self.shared.device())?;
        let has_objects = self.volumes.uses_objects() && maps.objects != [None; 6];
        if has_objects && self.objects.is_none() {
            self.objects = Some(self.object_texture()?);
        }
        let Self { shared, stage, volumes, shape, view, nothing, unwritten_objects, .. } = &*self;
        let objects = self.objects.as_ref().filter(|_| has_objects);
        let before = || {
            let device = shared.device();
            let is_reversed = u32::from(maps.lights[0].depth == DepthDirection::Reversed);
            let shape = DepthMapShape { is_reversed, ..*shape };
            let uniforms = filled(device, "depth map", bytemuck::bytes_of(&shape), wgpu::BufferUsages::UNIFORM);
            let get = |name: &str| {
                let index_after = |prefix: &str| name.strip_prefix(prefix)?.parse::<usize>().ok();
                let map = |map: usize| texture(maps.textures.get(map).copied().flatten().unwrap_or(nothing));
                Some(match name {
                    "depth_map" => uniform::<DepthMapShape>(&uniforms, 0),
                    "depth_texture" => map(0),
                    "cube_texture" => texture(view),
                    "cube_objects" => texture(objects.unwrap_or(unwritten_objects)),
                    _ => match (index_after("texture_"), index_after("objects_")) {
                        (Some(index), _) => map(index),
                        (_, Some(index)) => {
                            let given = maps.objects.get(index).copied().flatten().filter(|_| has_objects);
                            texture(given.unwrap_or(&volumes.no_objects))
                        }
                        _ => return None,
                    },
                })
            };
            let stage = stage.get(shared, has_objects);
            Some(stage.pass([stage.dispatch(device, Workgroups::over(device, shape.blocks), get)]))
        };
        let inputs = Inputs { texture: view, objects, lights: &maps.lights, formats: &formats, eye: camera };
        volumes.record(encoder, &inputs, before, timer)
    }

    /// Refuses objects of another size, or for some maps only.
    fn check_objects(&self, maps: &DepthCubeMaps<'_>) -> Result<(), DepthMapError> {
        if maps.objects == [None; 6] {
            return Ok(());
        }
        for (face, (map, objects)) in maps.textures.iter().zip(maps.objects).enumerate() {
            match objects {
                Some(objects) => {
                    let name = format!("the texture of objects of map {face} of the cube");
                    check_objects(objects.texture(), self.shape.size, &name)?;
                }
                None if map.is_some() => return Err(DepthMapError::NoObjects { face }),
                None => {}
            }
        }
        Ok(())
    }

    /// A texture for the objects of all maps.
    fn object_texture(&self) -> Result<wgpu::TextureView, DepthMapError> {
        let (size, label) = ([3, 2].map(|maps| maps * self.shape.size[0]), "objects of a cube");
        let bytes = 4 * u64::from(size[0]) * u64::from(size[1]);
        // The texture of depths has as many bytes.
        let others = Allocation { label: "everything else of a cube", bytes: self.volumes.bytes + bytes };
        check(&[others, Allocation { label, bytes }], u64::MAX, self.volumes.options.memory_limit)?;
        Ok(written_texture(self.shared.device(), label, size, wgpu::TextureFormat::R32Uint)?)
    }

    /// The listed cells, as [`DepthMapVolumes::cells`] has them. A map has (side − 1)² cells, and its cells follow those of
    /// the map before.
    pub fn cells(&self) -> &wgpu::Buffer {
        self.volumes.cells()
    }

    /// Cells that the list has room for, as [`DepthMapVolumes::capacity`].
    pub fn capacity(&self) -> u32 {
        self.volumes.capacity()
    }

    /// The six maps in one: a view of `R32Float`, with three in a row. Each has its samples after the choice at its border.
    pub fn texture(&self) -> &wgpu::TextureView {
        &self.view
    }
}
