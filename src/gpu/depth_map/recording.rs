//! Encodes of volumes: what their stages and draws are bound to, and the passes.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use super::error::DepthMapError;
use super::frame::{DepthMapFrame, DepthMapNearCap};
use super::jitter::{jitters, reach};
use super::metric::metric_steps;
use super::near::{NearReach, near_reach};
use super::options::DepthMap;
use super::pipelines::{layout, wall_group};
use super::stage::{BoundStage, Workgroups};
use super::texture::{check_objects, check_texture};
use super::view::{Placing, depth_map_view};
use super::volumes::DepthMapVolumes;
use crate::ShadowCamera;
use crate::gpu::common::dispatch_limits::{WORKGROUP, loops};
use crate::gpu::common::memory::{any_error, buffer, filled};
use crate::gpu::common::pipelines::{Pipeline, group};
use crate::gpu::common::requirements::{check_alive, check_timer};
use crate::gpu::common::timer::StageTimer;
use crate::gpu::common::uniforms::entry;
use crate::layout::{DepthMapShape, DepthMapView, DepthNearBox};
use crate::shadow::DepthDirection;

/// The inputs of an encode: one map, or the six of a cube in one texture.
pub(super) struct Inputs<'a> {
    pub(super) texture: &'a wgpu::TextureView,
    pub(super) objects: Option<&'a wgpu::TextureView>,
    pub(super) lights: &'a [ShadowCamera],
    /// The formats that the depths of the maps were rounded to.
    pub(super) formats: &'a [wgpu::TextureFormat],
    pub(super) eye: &'a ShadowCamera,
}

/// The bindings of the map for stages and draws.
struct Bound<'a> {
    textures: [wgpu::BindingResource<'a>; 2],
    shape: DepthMapShape,
    map: wgpu::Buffer,
    contour: Option<wgpu::Buffer>,
}

impl DepthMapVolumes {
    /// Records the stages: finds the edges of `map`, for `camera`. `timer` takes the time of each stage. Frames of earlier
    /// encodes can no longer be drawn. The first encode with objects compiles a pipeline for them.
    ///
    /// # Errors
    /// [`DepthMapError`] if a texture or a camera is refused. Nothing is recorded then.
    pub fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        map: &DepthMap<'_>,
        camera: &ShadowCamera,
        timer: Option<&mut StageTimer>,
    ) -> Result<DepthMapFrame, DepthMapError> {
        let DepthMap { texture, light, objects } = *map;
        let formats = [check_texture(texture.texture(), self.shape.size, "the map")?];
        if let Some(objects) = objects {
            check_objects(objects.texture(), self.shape.size, "the texture of objects")?;
        }
        let lights = std::slice::from_ref(&light);
        let inputs = Inputs { texture, objects, lights, formats: &formats, eye: camera };
        self.record(encoder, &inputs, || None, timer)
    }

    /// Records the stages, after one that makes the texture. Each encode has uniforms of its own, so encodes may follow each
    /// other.
    pub(super) fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        inputs: &Inputs<'_>,
        before: impl FnOnce() -> Option<BoundStage>,
        mut timer: Option<&mut StageTimer>,
    ) -> Result<DepthMapFrame, DepthMapError> {
        let device = self.shared.device();
        check_timer(timer.as_deref(), device)?;
        let views = self.views(inputs)?;
        check_alive(device)?;
        let depth = inputs.lights.first().map_or(DepthDirection::Reversed, |light| light.depth);
        let objects = inputs.objects.filter(|_| self.takes_objects);
        let is_reversed = u32::from(depth == DepthDirection::Reversed);
        let shape = DepthMapShape { is_reversed, objects: u32::from(objects.is_some()), ..self.shape };
        let bind = || {
            let uniform = |label, bytes: &[u8]| filled(device, label, bytes, wgpu::BufferUsages::UNIFORM);
            let contour = self.contours.as_ref().zip(views.first().and_then(|views| views.first()));
            let bound = Bound {
                textures: [inputs.texture, objects.unwrap_or(&self.nothing)].map(wgpu::BindingResource::TextureView),
                shape,
                map: uniform("depth map", bytemuck::bytes_of(&shape)),
                contour: contour.map(|(own, view)| own.uniform(device, view)),
            };
            let mut stages: Vec<_> = before().into_iter().collect();
            stages.extend(self.bind_stages(&bound, inputs, depth));
            let draws: Vec<_> = views.iter().map(|views| self.bind_draw(&bound, views)).collect();
            let (near_cap, near) = self.near_cap(&bound, inputs);
            stages.extend(near);
            (stages, draws, near_cap)
        };
        let (stages, groups, near_cap) =
            any_error(device, bind).map_err(|message| DepthMapError::Refused { message })?;
        for stage in &stages {
            stage.record(encoder, timer.as_deref_mut());
        }
        Ok(DepthMapFrame {
            device: device.clone(),
            groups,
            near_cap,
            has_walls: self.contours.is_some(),
            draws: self.contours.as_ref().map_or(&self.draws, |own| &own.draws).clone(),
            list: self.cells().clone(),
            capacity: self.capacity(),
            format: self.eye.0,
            depth: self.eye.1,
            encode: self.encodes.fetch_add(1, Ordering::Relaxed) + 1,
            encodes: Arc::clone(&self.encodes),
        })
    }

    /// For each bit the views of the maps, moved by parts of a texel. All move by the errors of the coarsest, because maps of a
    /// cube share samples on their borders.
    fn views(&self, inputs: &Inputs<'_>) -> Result<Vec<Vec<DepthMapView>>, DepthMapError> {
        if inputs.eye.depth != self.eye.1 {
            return Err(DepthMapError::Depth { what: "the eye", given: inputs.eye.depth, made: self.eye.1 });
        }
        // A cube has no border.
        let border = if self.shape.faces > 1 { 0.0 } else { 1.0 };
        let slope_bias = f64::from(self.slope_bias) * (0.5 + reach(self.bits));
        let view = |light: &ShadowCamera, jitter| {
            let mut formats = inputs.formats.iter().copied().chain(self.rounded_to);
            let off = metric_steps(light, self.metric)?;
            let placing = Placing { border, jitter, slope_bias };
            depth_map_view((light, self.shape.size), (off, &mut formats), (inputs.eye, self.eye.0), &placing)
        };
        let of_bit = |jitter| inputs.lights.iter().map(|light| view(light, jitter)).collect();
        jitters(self.bits).into_iter().map(of_bit).collect()
    }

    /// The near cap, and the stage that tells about it, if one has to.
    fn near_cap(&self, bound: &Bound<'_>, inputs: &Inputs<'_>) -> (DepthMapNearCap, Option<BoundStage>) {
        let Some(stage) = &self.near else { return (DepthMapNearCap::Drawn, None) };
        let eye = (inputs.eye, self.eye.0);
        let near = match near_reach(inputs.lights, self.shape.size, eye, self.contours.is_some()) {
            NearReach::Lit => return (DepthMapNearCap::Lit, None),
            NearReach::Unknown => return (DepthMapNearCap::Drawn, None),
            NearReach::Samples(near) => near,
        };
        let device = self.shared.device();
        let uniform = filled(device, "near rectangle", bytemuck::bytes_of(&near), wgpu::BufferUsages::UNIFORM);
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::INDIRECT | wgpu::BufferUsages::COPY_SRC;
        let draw = buffer(device, "draw of a near cap", 16, usage);
        let resources = [
            ("depth_map", entry::<DepthMapShape>(&bound.map)),
            ("depth_texture", bound.textures[0].clone()),
            ("near", entry::<DepthNearBox>(&uniform)),
            ("draws", draw.as_entire_binding()),
        ];
        let groups = vec![stage.bind(device, &resources)];
        let stage = BoundStage { stage: stage.clone(), groups, workgroups: Workgroups::Known([1, 1]) };
        (DepthMapNearCap::Told(draw), Some(stage))
    }

    fn bind_stages(&self, bound: &Bound<'_>, inputs: &Inputs<'_>, depth: DepthDirection) -> Vec<BoundStage> {
        let device = self.shared.device();
        let has_objects = bound.shape.objects == 1;
        if let (Some(contours), Some(contour)) = (&self.contours, &bound.contour) {
            return contours.bind(&self.shared, &bound.map, contour, &bound.textures, has_objects);
        }
        let blocks = bound.shape.blocks;
        // Workgroups cost a CPU more than turns, so few take the blocks in turn. Several bits take many turns each.
        let few = loops(device, blocks.saturating_mul(WORKGROUP));
        let resources = [
            ("depth_map", entry::<DepthMapShape>(&bound.map)),
            ("depth_texture", bound.textures[0].clone()),
            ("object_texture", bound.textures[1].clone()),
            ("places", self.places.as_entire_binding()),
            ("cells", self.cells.as_entire_binding()),
            ("draws", self.draws.as_entire_binding()),
        ];
        let of_cells = |stage: Pipeline, count: u32| {
            let groups = vec![stage.bind(device, &resources)];
            BoundStage { stage, groups, workgroups: Workgroups::over(device, count) }
        };
        let mut stages = Vec::new();
        if let Some(edges) = &self.edges {
            let mut formats = inputs.formats.iter().copied().chain(self.rounded_to);
            let rule = edges.rule(depth, &mut formats);
            stages.extend(edges.bind(&self.shared, &rule, &resources[..4], (has_objects, few)));
        }
        if let Some(count) = &self.count {
            let workgroups = if bound.shape.spread == 0 { few } else { blocks };
            stages.push(of_cells(count.get(&self.shared, has_objects), workgroups));
        }
        stages.extend(self.stages.iter().zip([1, few]).map(|(stage, count)| of_cells(stage.clone(), count)));
        stages
    }

    /// The draw of a bit.
    fn bind_draw(&self, bound: &Bound<'_>, views: &[DepthMapView]) -> wgpu::BindGroup {
        let device = self.shared.device();
        let view = filled(device, "depth map view", bytemuck::cast_slice(views), wgpu::BufferUsages::STORAGE);
        let [texture, objects] = &bound.textures;
        let resources = [
            bound.map.as_entire_binding(),
            texture.clone(),
            self.cells().as_entire_binding(),
            view.as_entire_binding(),
            objects.clone(),
        ];
        match (&self.contours, &bound.contour) {
            (Some(contours), Some(contour)) => {
                wall_group(&self.shared, (0..).zip(resources).chain(contours.of_draws(contour)).collect())
            }
            _ => group(device, "depth surface", &layout(&self.shared), &resources),
        }
    }
}
