//! Encodes of volumes: the passes, and the bindings of stages and draws.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use super::bound::Bound;
use super::error::{DepthMapError, guard};
use super::frame::{DepthMapFrame, DepthMapNearCap};
use super::jitter::{jitters, max_jitter};
use super::metric::metric_steps;
use super::near::{NearShadow, near_shadow};
use super::options::DepthMap;
use super::pipelines::{surface_layout, wall_layout};
use super::texture::{check_objects, check_texture};
use super::view::{Placing, depth_map_view, steps};
use super::volumes::DepthMapVolumes;
use crate::ShadowCamera;
use crate::gpu::common::bindings::{texture, uniform, whole};
use crate::gpu::common::dispatch_limits::{WORKGROUP, loops};
use crate::gpu::common::memory::filled;
use crate::gpu::common::pass::{Step, Workgroups, record};
use crate::gpu::common::pipelines::{Pipeline, group};
use crate::gpu::common::requirements::{check_alive, check_timer};
use crate::gpu::common::timer::StageTimer;
use crate::gpu::common::wanted::Wanted;
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

impl DepthMapVolumes {
    /// Records the stages that find the edges of `map`. `camera` is the eye's. Frames of earlier encodes can no longer be
    /// drawn. The first encode with objects compiles a pipeline for them.
    ///
    /// # Errors
    /// [`DepthMapError`] if a texture or a camera is refused. Nothing is recorded then.
    pub fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        map: &DepthMap<'_>,
        camera: &ShadowCamera,
    ) -> Result<DepthMapFrame, DepthMapError> {
        self.encode_timed(encoder, map, camera, None)
    }

    /// The same with a timestamp around each stage.
    ///
    /// # Errors
    /// The errors of [`Self::encode`], and [`DepthMapError::Device`] for a timer of another device.
    pub fn encode_timed(
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

    /// Records the stages after `before`, which writes the texture. Each encode has new uniforms, so one encoder may hold
    /// several encodes.
    pub(super) fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        inputs: &Inputs<'_>,
        before: impl FnOnce() -> Option<Step>,
        timer: Option<&mut StageTimer>,
    ) -> Result<DepthMapFrame, DepthMapError> {
        let device = self.shared.device();
        check_timer(timer.as_deref(), device)?;
        let depth = inputs.lights.first().map_or(DepthDirection::Reversed, |light| light.depth);
        let rounding = steps(inputs.formats.iter().copied().chain(self.options.rounded_to), depth);
        let views = self.views(inputs, rounding)?;
        check_alive(device)?;
        let objects = inputs.objects.filter(|_| self.uses_objects());
        let is_reversed = u32::from(depth == DepthDirection::Reversed);
        let shape = DepthMapShape { is_reversed, has_objects: u32::from(objects.is_some()), ..self.shape };
        let bind = || {
            let uniform = |label, bytes: &[u8]| filled(device, label, bytes, wgpu::BufferUsages::UNIFORM);
            let contour = self.contours.as_ref().zip(views.first().and_then(|views| views.first()));
            let bound = Bound {
                textures: [inputs.texture, objects.unwrap_or(&self.no_objects)],
                shape,
                map: uniform("depth map", bytemuck::bytes_of(&shape)),
                contour: contour.map(|(contours, view)| contours.uniform(device, view)),
            };
            let mut steps: Vec<_> = before().into_iter().collect();
            steps.extend(self.steps(&bound, rounding));
            let draws: Vec<_> = views.iter().map(|views| self.bind_draw(&bound, views)).collect();
            let (near_cap, near) = self.near_cap(&bound, inputs);
            steps.extend(near);
            (steps, draws, near_cap)
        };
        let (steps, groups, near_cap) = guard(device, bind)?;
        record(&steps, encoder, timer);
        Ok(DepthMapFrame {
            device: device.clone(),
            groups,
            near_cap,
            has_walls: self.contours.is_some(),
            draws: self.contours.as_ref().map_or(&self.buffers.draws, |contours| &contours.buffers.draws).clone(),
            list: self.cells().clone(),
            capacity: self.capacity(),
            format: self.eye.0,
            depth: self.eye.1,
            encode: self.encodes.fetch_add(1, Ordering::Relaxed) + 1,
            encodes: Arc::clone(&self.encodes),
        })
    }

    /// The views of the maps for each bit, moved by the bit's jitter. All maps of a cube have the bias of the coarsest
    /// format, because they share samples on their borders. `rounding`: the error by the formats, a share and a constant.
    fn views(&self, inputs: &Inputs<'_>, rounding: [f64; 2]) -> Result<Vec<Vec<DepthMapView>>, DepthMapError> {
        if inputs.eye.depth != self.eye.1 {
            return Err(DepthMapError::Depth { what: "the eye", given: inputs.eye.depth, made: self.eye.1 });
        }
        // The lattice of a single map has a border of far samples, that of a cube has none.
        let border = if self.shape.faces > 1 { 0.0 } else { 1.0 };
        let slope_bias = f64::from(self.options.slope_bias) * (0.5 + max_jitter(self.bits));
        let view = |light: &ShadowCamera, jitter| {
            let off = metric_steps(light, self.options.metric)?;
            let error = [0, 1].map(|index| rounding[index] + off[index]);
            let placing = Placing { border, jitter, slope_bias };
            depth_map_view((light, self.shape.size), error, (inputs.eye, self.eye.0), &placing)
        };
        let views_of_bit = |jitter| inputs.lights.iter().map(|light| view(light, jitter)).collect();
        jitters(self.bits).into_iter().map(views_of_bit).collect()
    }

    /// Whether the near cap is drawn, and the stage that decides it unless the CPU can.
    fn near_cap(&self, bound: &Bound<'_>, inputs: &Inputs<'_>) -> (DepthMapNearCap, Option<Step>) {
        let Some(stage) = &self.near else { return (DepthMapNearCap::Drawn, None) };
        let eye = (inputs.eye, self.eye.0);
        let near = match near_shadow(inputs.lights, self.shape.size, eye, self.contours.is_some()) {
            Ok(near) => near,
            Err(NearShadow::Lit) => return (DepthMapNearCap::Skipped, None),
            Err(NearShadow::Unknown) => return (DepthMapNearCap::Drawn, None),
        };
        let device = self.shared.device();
        let rectangle = filled(device, "near rectangle", bytemuck::bytes_of(&near), wgpu::BufferUsages::UNIFORM);
        let draw = Wanted::new("draw of a near cap", 16).indirect().make(device);
        let dispatch = stage.dispatch(device, Workgroups::Known([1, 1]), |name| match name {
            "near" => Some(uniform::<DepthNearBox>(&rectangle, 0)),
            "draws" => Some(whole(&draw)),
            _ => bound.get(name),
        });
        let step = stage.pass([dispatch]);
        (DepthMapNearCap::Indirect(draw), Some(step))
    }

    fn steps(&self, bound: &Bound<'_>, rounding: [f64; 2]) -> Vec<Step> {
        let device = self.shared.device();
        let has_objects = bound.has_objects();
        if let Some(contours) = &self.contours {
            return contours.steps(&self.shared, bound);
        }
        let blocks = bound.shape.blocks;
        // On a CPU a workgroup costs more than an iteration of a loop, so few workgroups loop over blocks. With several bits
        // a block has many iterations.
        let few = loops(device, blocks.saturating_mul(WORKGROUP));
        let get = |name: &str| match name {
            "cell_words" => Some(whole(&self.buffers.words)),
            "cells" => Some(whole(&self.buffers.cells)),
            "draws" => Some(whole(&self.buffers.draws)),
            _ => bound.get(name),
        };
        let cell_step =
            |stage: &Pipeline, count: u32| stage.pass([stage.dispatch(device, Workgroups::over(device, count), get)]);
        let mut steps = Vec::new();
        if let Some(edges) = &self.edges {
            steps.extend(edges.steps(&self.shared, rounding, get, (has_objects, few)));
        }
        if let Some(count) = &self.count {
            let workgroups = if bound.shape.spread == 0 { few } else { blocks };
            steps.push(cell_step(&count.get(&self.shared, has_objects), workgroups));
        }
        steps.extend(self.stages.iter().zip([1, few]).map(|(stage, count)| cell_step(stage, count)));
        steps
    }

    /// The bindings of the draw of a bit.
    fn bind_draw(&self, bound: &Bound<'_>, views: &[DepthMapView]) -> wgpu::BindGroup {
        let device = self.shared.device();
        let view = filled(device, "depth map view", bytemuck::cast_slice(views), wgpu::BufferUsages::STORAGE);
        let [map, objects] = bound.textures;
        let mut resources = vec![whole(&bound.map), texture(map), whole(self.cells()), whole(&view), texture(objects)];
        let mut layout = surface_layout(&self.shared);
        if let (Some(contours), Some(contour)) = (&self.contours, &bound.contour) {
            resources.extend(contours.draw_bindings(contour));
            layout = wall_layout(&self.shared);
        }
        group(device, "draw of a depth map", &layout, &resources)
    }
}
