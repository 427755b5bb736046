//! The volumes of six depth maps around a light.

use bytemuck::Zeroable;

use super::bound::{BoundStage, Workgroups};
use super::frame::DepthMapFrame;
use super::frame_errors::{DepthMapEncodeError, DepthMapTexture};
use super::meeting::{cameras, check_meeting};
use super::options::{DepthMapOptions, DepthMapReconstruction};
use super::pipelines::DepthMapPipelines;
use super::recording::{Eye, Planned};
use super::texture::{check_objects, check_texture, written_texture};
use super::volumes::{DepthMapVolumes, MOST_CELLS};
use super::volumes_errors::{DepthMapCubeError, DepthMapVolumesError};
use crate::ShadowCamera;
use crate::gpu::common::dispatch_limits::WORKGROUP;
use crate::gpu::common::memory::{Allocation, any_error, filled, guarded};
use crate::gpu::common::pipelines::{Pipeline, Pipelines};
use crate::gpu::common::requirements::{Subject, check_alive, check_timer};
use crate::gpu::common::timer::StageTimer;
use crate::gpu::common::uniforms::entry;
use crate::layout::{DepthMapShape, DepthMapView};
use crate::shadow::DepthDirection;
use crate::stages::DEPTH_CUBE;

/// Shadow volumes of all that a light sees around it, from six depth maps. It is [`DepthMapVolumes`] without an outside.
///
/// The middles of a map's outermost texels lie on the edges of the cube, so neighbouring maps have samples there on the same
/// rays. Where their depths differ, the nearest is taken for all. A map sees slightly more than 90°: [`Self::cameras`] makes
/// cameras that do.
///
/// Each map is an upright picture of its camera, with row 0 at the top. The faces of cube textures of graphics APIs are mirrored or
/// turned against it, so draw each map with its camera of [`Self::cameras`].
///
/// A map that is not there casts nothing, and shadows of the others end at its edges, as at the border of a single map.
#[derive(Debug)]
pub struct DepthMapCube {
    shared: Pipelines,
    stage: Pipeline,
    pub(super) volumes: DepthMapVolumes,
    cameras: [ShadowCamera; 6],
    shape: DepthMapShape,
    view: wgpu::TextureView,
    /// What is bound where a map is not there.
    nothing: wgpu::TextureView,
    has_objects: bool,
    /// The objects of all maps.
    objects: wgpu::TextureView,
    no_objects: wgpu::TextureView,
}

impl DepthMapCube {
    /// Cameras at `place` for maps of `side` texels, which look along +x, −x, +y, −y, +z, −z. y is up; it is z for the map along
    /// +y, and −z for the one along −y.
    ///
    /// # Errors
    /// [`DepthMapCubeError`] if `side` is below 3, the place or a distance is not finite, `near` is not above 0, or `far` not
    /// above `near`; and where they are so extreme that rounding to floats leaves no cameras that meet.
    pub fn cameras(
        place: [f32; 3],
        near: f32,
        far: Option<f32>,
        depth: DepthDirection,
        side: u32,
    ) -> Result<[ShadowCamera; 6], DepthMapCubeError> {
        cameras(place, near, far, depth, side)
    }

    /// Makes buffers for six maps of `side` × `side` texels, on the device of `pipelines`. The cameras may be turned all
    /// together, against those of [`Self::cameras`].
    ///
    /// # Errors
    /// [`DepthMapCubeError`] if the maps of the cameras do not meet, the side or an option is refused, or buffers and texture do
    /// not fit the device.
    pub fn new(
        pipelines: &DepthMapPipelines,
        side: u32,
        cameras: &[ShadowCamera; 6],
        options: DepthMapOptions,
    ) -> Result<Self, DepthMapCubeError> {
        let shared = pipelines.shared();
        shared.construct(Subject::DepthMap, || Self::with(pipelines, side, cameras, options))
    }

    fn with(
        pipelines: &DepthMapPipelines,
        side: u32,
        cameras: &[ShadowCamera; 6],
        options: DepthMapOptions,
    ) -> Result<Self, DepthMapCubeError> {
        if side < 3 {
            return Err(DepthMapCubeError::Side(side));
        }
        if matches!(options.reconstruction, DepthMapReconstruction::Contours { .. }) {
            return Err(DepthMapCubeError::Contours);
        }
        if options.bits != 1 {
            return Err(DepthMapCubeError::Bits(options.bits));
        }
        let cells = u64::from(side - 1).pow(2).saturating_mul(6);
        if cells > MOST_CELLS {
            return Err(DepthMapCubeError::Cells(side));
        }
        check_meeting(cameras, side)?;
        let shared = pipelines.shared().clone();
        let device = shared.device();
        let most = device.limits().max_texture_dimension_2d;
        let size = [side.saturating_mul(3), side.saturating_mul(2)];
        if size[0] > most {
            return Err(DepthMapVolumesError::Texture { size, most }.into());
        }
        let texels = u64::from(size[0]) * u64::from(size[1]);
        let mut textures = vec![Allocation { label: "cube of depth maps", bytes: 4 * texels }];
        if options.objects {
            textures.push(Allocation { label: "objects of a cube", bytes: 4 * texels });
        }
        let bytes = textures.iter().map(|texture| texture.bytes).sum();
        let volumes = DepthMapVolumes::with(pipelines, [side; 2], (6, &textures), options)?;
        let (floats, numbers) = (wgpu::TextureFormat::R32Float, wgpu::TextureFormat::R32Uint);
        // What is not there has one texel.
        let [one, objects] = [[1, 1], if options.objects { size } else { [1, 1] }];
        let make = || {
            [
                ("cube of depth maps", size, floats),
                ("no depth map", one, floats),
                ("objects of a cube", objects, numbers),
                ("no objects", one, numbers),
            ]
            .map(|(label, size, format)| written_texture(device, label, size, format))
        };
        let made = guarded(device, bytes, make);
        let [view, nothing, objects, no_objects] = made
            .map_err(DepthMapVolumesError::from)?
            .map(|texture| texture.create_view(&wgpu::TextureViewDescriptor::default()));
        let blocks = texels.div_ceil(u64::from(WORKGROUP)) as u32;
        let shape = DepthMapShape { size: [side; 2], blocks, faces: 6, ..DepthMapShape::zeroed() };
        let stage = shared.compute(&DEPTH_CUBE, "depth_cube", &[("OBJECTS", f64::from(u8::from(options.objects)))]);
        let has_objects = options.objects;
        Ok(Self { shared, stage, volumes, cameras: *cameras, shape, has_objects, view, nothing, objects, no_objects })
    }

    /// Moves the light: its cameras from the next encode on.
    ///
    /// # Errors
    /// [`DepthMapCubeError`] if the maps of the cameras do not meet. The cameras stay as they were then.
    pub fn set_cameras(&mut self, cameras: &[ShadowCamera; 6]) -> Result<(), DepthMapCubeError> {
        check_meeting(cameras, self.shape.size[0])?;
        self.cameras = *cameras;
        Ok(())
    }

    /// Records the stages: makes the six maps one, and finds its edges, for `camera`. A map is a view as
    /// [`DepthMap::texture`](crate::gpu::DepthMap::texture), in the order of the cameras. `None` casts nothing. What was encoded
    /// before can no longer be drawn.
    ///
    /// # Errors
    /// [`DepthMapEncodeError`] if a texture or the camera is refused. Nothing is recorded then.
    pub fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        maps: [Option<&wgpu::TextureView>; 6],
        camera: &ShadowCamera,
        timer: Option<&mut StageTimer>,
    ) -> Result<DepthMapFrame, DepthMapEncodeError> {
        if self.has_objects {
            return Err(DepthMapEncodeError::NoObjects { face: None });
        }
        self.encode_maps(encoder, maps, [None; 6], camera, timer)
    }

    /// As [`Self::encode`], with [`DepthMapOptions::objects`]: for each map that is there a texture of objects, as for
    /// [`DepthMapVolumes::encode_objects`]. A sample that maps share has the object of the map that its depth is from.
    ///
    /// # Errors
    /// [`DepthMapEncodeError`] if a texture or the camera is refused. Nothing is recorded then.
    pub fn encode_objects(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        maps: [Option<&wgpu::TextureView>; 6],
        objects: [Option<&wgpu::TextureView>; 6],
        camera: &ShadowCamera,
        timer: Option<&mut StageTimer>,
    ) -> Result<DepthMapFrame, DepthMapEncodeError> {
        if !self.has_objects {
            return Err(DepthMapEncodeError::UnusedObjects);
        }
        self.check_objects(maps, objects)?;
        self.encode_maps(encoder, maps, objects, camera, timer)
    }

    fn encode_maps(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        maps: [Option<&wgpu::TextureView>; 6],
        objects: [Option<&wgpu::TextureView>; 6],
        camera: &ShadowCamera,
        timer: Option<&mut StageTimer>,
    ) -> Result<DepthMapFrame, DepthMapEncodeError> {
        check_timer(timer.as_deref(), self.shared.device())?;
        let formats = self.formats(maps)?;
        let views = self.views(&formats, camera)?;
        check_alive(self.shared.device())?;
        let planned = self.plan(maps, objects, &formats, &[(camera, views)], true)?;
        let mut frames = planned.record(encoder, timer).into_iter();
        frames.next().ok_or_else(|| DepthMapEncodeError::Refused { message: "no camera".to_owned() })
    }

    /// The formats of the maps. One that is not there has any.
    pub(super) fn formats(
        &self,
        maps: [Option<&wgpu::TextureView>; 6],
    ) -> Result<[wgpu::TextureFormat; 6], DepthMapEncodeError> {
        let mut formats = [wgpu::TextureFormat::R32Float; 6];
        for (face, (map, format)) in maps.iter().zip(&mut formats).enumerate() {
            if let Some(map) = map {
                *format = check_texture(map.texture(), self.shape.size, DepthMapTexture::CubeMap(face))?;
            }
        }
        Ok(formats)
    }

    /// Refuses objects that do not fit the maps.
    pub(super) fn check_objects(
        &self,
        maps: [Option<&wgpu::TextureView>; 6],
        objects: [Option<&wgpu::TextureView>; 6],
    ) -> Result<(), DepthMapEncodeError> {
        if !self.has_objects {
            return if objects == [None; 6] { Ok(()) } else { Err(DepthMapEncodeError::UnusedObjects) };
        }
        for (face, (map, objects)) in maps.iter().zip(objects).enumerate() {
            match objects {
                Some(objects) => {
                    check_objects(objects.texture(), self.shape.size, DepthMapTexture::CubeObjects(face))?;
                }
                None if map.is_some() => return Err(DepthMapEncodeError::NoObjects { face: Some(face) }),
                None => {}
            }
        }
        Ok(())
    }

    /// The views of the maps for a camera, in the only bit. All move by the errors of the coarsest, because samples on their
    /// borders are shared.
    pub(super) fn views(
        &self,
        formats: &[wgpu::TextureFormat; 6],
        camera: &ShadowCamera,
    ) -> Result<Vec<Vec<DepthMapView>>, DepthMapEncodeError> {
        let view = |light| self.volumes.view(light, formats, camera, 0.0, [0.0; 2]);
        Ok(vec![self.cameras.iter().map(view).collect::<Result<_, _>>()?])
    }

    /// Binds the stages, unless the list of an encode before is drawn, and the draws for each camera.
    pub(super) fn plan(
        &self,
        maps: [Option<&wgpu::TextureView>; 6],
        objects: [Option<&wgpu::TextureView>; 6],
        formats: &[wgpu::TextureFormat; 6],
        eyes: &[Eye<'_>],
        is_listed_anew: bool,
    ) -> Result<Planned<'_>, DepthMapEncodeError> {
        let textures = [Some(&self.view), self.has_objects.then_some(&self.objects)];
        let planned = self.volumes.plan(textures, (&self.cameras, formats), eyes, is_listed_anew)?;
        let one = is_listed_anew.then(|| self.bind_one(maps, objects)).transpose()?;
        Ok(planned.after(one))
    }

    /// The stage that makes the maps one.
    fn bind_one(
        &self,
        maps: [Option<&wgpu::TextureView>; 6],
        objects: [Option<&wgpu::TextureView>; 6],
    ) -> Result<BoundStage<'_>, DepthMapEncodeError> {
        let device = self.shared.device();
        let is_reversed = u32::from(self.cameras[0].depth == DepthDirection::Reversed);
        let shape = DepthMapShape { is_reversed, ..self.shape };
        let bind = || {
            let uniform = filled(device, "depth map", bytemuck::bytes_of(&shape), wgpu::BufferUsages::UNIFORM);
            let view = wgpu::BindingResource::TextureView;
            let mut resources = vec![("depth_map", entry::<DepthMapShape>(&uniform))];
            let names = ["depth_texture", "texture_1", "texture_2", "texture_3", "texture_4", "texture_5"];
            let maps = maps.map(|map| view(map.unwrap_or(&self.nothing)));
            resources.extend(names.into_iter().zip(maps));
            resources.push(("cube_texture", view(&self.view)));
            let names = ["objects_0", "objects_1", "objects_2", "objects_3", "objects_4", "objects_5"];
            let objects = objects.map(|objects| view(objects.unwrap_or(&self.no_objects)));
            resources.extend(names.into_iter().zip(objects));
            resources.push(("cube_objects", view(&self.objects)));
            self.stage.bind(device, &resources)
        };
        let group = any_error(device, bind).map_err(|message| DepthMapEncodeError::Refused { message })?;
        let most = device.limits().max_compute_workgroups_per_dimension;
        let rows = shape.blocks.div_ceil(most).min(most);
        Ok((&self.stage, group, Workgroups::Known([shape.blocks.div_ceil(rows).min(most), rows])))
    }

    /// The listed cells, as [`DepthMapVolumes::cells`] has them. A map has (side − 1)² cells, and its cells follow those of the
    /// map before.
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
