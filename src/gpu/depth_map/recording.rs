//! Encodes of volumes: what their stages and draws are bound to, and the passes.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use super::bound::{BoundStage, Workgroups};
use super::edges::BoundEdges;
use super::frame::{DepthMapFrame, DepthMapNearCap};
use super::frame_errors::DepthMapEncodeError;
use super::near::{NearReach, near_reach};
use super::pipelines::{layout, wall_group};
use super::view::{is_turned, world_step};
use super::volumes::DepthMapVolumes;
use crate::ShadowCamera;
use crate::gpu::common::dispatch_limits::{WORKGROUP, loops};
use crate::gpu::common::memory::{any_error, buffer, filled};
use crate::gpu::common::pipelines::group;
use crate::gpu::common::requirements::check_alive;
use crate::gpu::common::timer::StageTimer;
use crate::gpu::common::uniforms::entry;
use crate::layout::{DepthEdgeRule, DepthMapShape, DepthMapView, DepthNearBox};
use crate::shadow::DepthDirection;
use crate::turns::WORLD_BLOCKS;

/// A camera and, for each bit, the views of the maps as it sees them.
pub(super) type Eye<'a> = (&'a ShadowCamera, Vec<Vec<DepthMapView>>);

/// An encode that is bound, and not recorded yet.
pub(super) struct Planned<'a> {
    volumes: &'a DepthMapVolumes,
    /// What makes the texture that the stages read.
    before: Option<BoundStage<'a>>,
    /// `None`: the list of an encode before is drawn.
    stages: Option<BoundStages<'a>>,
    /// What tells whether the near caps of cameras are drawn.
    near: Vec<BoundStage<'a>>,
    /// A frame for each camera.
    frames: Vec<DepthMapFrame>,
}

/// The stages, and their workgroups.
struct BoundStages<'a> {
    edges: Option<BoundEdges>,
    stages: Vec<BoundStage<'a>>,
}

/// What stages and draws read of the map.
struct Uniforms {
    map: wgpu::Buffer,
    contour: Option<wgpu::Buffer>,
}

impl DepthMapVolumes {
    /// Records the stages for a texture and, for each bit, the views of its maps.
    pub(super) fn record(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        textures: [Option<&wgpu::TextureView>; 2],
        ([light, eye], formats): ([&ShadowCamera; 2], &[wgpu::TextureFormat]),
        views: Vec<Vec<DepthMapView>>,
        timer: Option<&mut StageTimer>,
    ) -> Result<DepthMapFrame, DepthMapEncodeError> {
        check_alive(self.shared.device())?;
        let planned = self.plan(textures, (std::slice::from_ref(light), formats), &[(eye, views)], true)?;
        let mut frames = planned.record(encoder, timer).into_iter();
        frames.next().ok_or_else(|| DepthMapEncodeError::Refused { message: "no camera".to_owned() })
    }

    /// Binds the stages, unless the list of an encode before is drawn, and the draws for each camera. All share their uniforms,
    /// and other encodes have others, so encodes may follow each other.
    pub(super) fn plan(
        &self,
        textures: [Option<&wgpu::TextureView>; 2],
        (lights, formats): (&[ShadowCamera], &[wgpu::TextureFormat]),
        eyes: &[Eye<'_>],
        is_listed_anew: bool,
    ) -> Result<Planned<'_>, DepthMapEncodeError> {
        let Some(light) = lights.first() else {
            return Err(DepthMapEncodeError::Refused { message: "no light".to_owned() });
        };
        let is_reversed = u32::from(light.depth == DepthDirection::Reversed);
        let mut shape = DepthMapShape { is_reversed, ..self.shape };
        if let Some(threshold) = self.world {
            [shape.threshold, shape.ratio, shape.at_infinity] = world_step(light, threshold)?;
        }
        let mut formats = formats.iter().copied().chain(self.rounded_to);
        let rule = self.edges.as_ref().map(|edges| edges.rule(light, &mut formats)).transpose()?;
        let bind = || {
            let textures = textures.map(|texture| wgpu::BindingResource::TextureView(texture.unwrap_or(&self.nothing)));
            let uniforms = self.uniforms(&shape, eyes);
            let stages = is_listed_anew.then(|| self.bind_stages(&textures, &shape, &uniforms, rule.as_ref()));
            let draws: Vec<_> = eyes.iter().map(|(_, views)| self.bind_draws(&textures, &uniforms, views)).collect();
            let near: Vec<_> = eyes.iter().map(|(eye, _)| self.near_cap(lights, eye, &textures, &uniforms)).collect();
            (stages, draws, near)
        };
        let (stages, draws, near) =
            any_error(self.shared.device(), bind).map_err(|message| DepthMapEncodeError::Refused { message })?;
        let encode = self.encodes.load(Ordering::Relaxed) + u64::from(is_listed_anew);
        let (near_caps, near): (Vec<_>, Vec<_>) = near.into_iter().unzip();
        let frame =
            |((groups, near_cap), (eye, _)): ((Vec<wgpu::BindGroup>, DepthMapNearCap), &Eye<'_>)| DepthMapFrame {
                device: self.shared.device().clone(),
                groups,
                near_cap,
                has_walls: self.contours.is_some(),
                draws: self.contours.as_ref().map_or(&self.draws, |own| &own.draws).clone(),
                list: self.cells().clone(),
                capacity: self.capacity(),
                format: self.eye.0,
                depth: self.eye.1,
                is_turned: is_turned(light, eye),
                encode,
                encodes: Arc::clone(&self.encodes),
            };
        let frames = draws.into_iter().zip(near_caps).zip(eyes).map(frame).collect();
        let near = near.into_iter().flatten().collect();
        Ok(Planned { volumes: self, before: None, stages, near, frames })
    }

    /// The near cap of a camera, and the stage that tells about it, if one has to.
    fn near_cap(
        &self,
        lights: &[ShadowCamera],
        eye: &ShadowCamera,
        textures: &[wgpu::BindingResource<'_>; 2],
        uniforms: &Uniforms,
    ) -> (DepthMapNearCap, Option<BoundStage<'_>>) {
        let Some(stage) = &self.near else { return (DepthMapNearCap::Drawn, None) };
        let near = match near_reach(lights, self.shape.size, (eye, self.eye.0), self.contours.is_some()) {
            NearReach::Lit => return (DepthMapNearCap::Lit, None),
            NearReach::Unknown => return (DepthMapNearCap::Drawn, None),
            NearReach::Samples(near) => near,
        };
        let device = self.shared.device();
        let uniform = filled(device, "near rectangle", bytemuck::bytes_of(&near), wgpu::BufferUsages::UNIFORM);
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::INDIRECT | wgpu::BufferUsages::COPY_SRC;
        let draw = buffer(device, "draw of a near cap", 16, usage);
        let resources = [
            ("depth_map", entry::<DepthMapShape>(&uniforms.map)),
            ("depth_texture", textures[0].clone()),
            ("near", entry::<DepthNearBox>(&uniform)),
            ("draws", draw.as_entire_binding()),
        ];
        let group = stage.bind(device, &resources);
        (DepthMapNearCap::Told(draw), Some((stage, group, Workgroups::Known([1, 1]))))
    }

    /// What a contour's surfaces move by is the same for each camera.
    fn uniforms(&self, shape: &DepthMapShape, eyes: &[Eye<'_>]) -> Uniforms {
        let device = self.shared.device();
        let map = filled(device, "depth map", bytemuck::bytes_of(shape), wgpu::BufferUsages::UNIFORM);
        let view = eyes.first().and_then(|(_, views)| views.first()?.first());
        let contour = self.contours.as_ref().zip(view).map(|(own, view)| own.uniform(&self.shared, view));
        Uniforms { map, contour }
    }

    fn bind_stages(
        &self,
        textures: &[wgpu::BindingResource<'_>; 2],
        shape: &DepthMapShape,
        uniforms: &Uniforms,
        rule: Option<&DepthEdgeRule>,
    ) -> BoundStages<'_> {
        let device = self.shared.device();
        if let (Some(contours), Some(contour)) = (&self.contours, &uniforms.contour) {
            let stages = contours.bind(device, &uniforms.map, contour, textures.clone());
            return BoundStages { edges: None, stages };
        }
        let edges = self.edges.as_ref().zip(rule);
        let edges =
            edges.map(|(edges, rule)| edges.bind(&self.shared, (shape, &uniforms.map), rule, textures, &self.places));
        let most = device.limits().max_compute_workgroups_per_dimension;
        let over = |workgroups: u32| {
            let rows = workgroups.div_ceil(most).min(most);
            [workgroups.div_ceil(rows.max(1)).min(most), rows]
        };
        let every = over(shape.blocks);
        // Workgroups cost a CPU more than turns, so few take the blocks in turn. Several bits take many turns each.
        let few = over(loops(device, shape.blocks.saturating_mul(WORKGROUP)));
        let count = match (shape.spread, self.world) {
            (0, None) => few,
            (0, Some(_)) => over(shape.blocks.div_ceil(WORLD_BLOCKS)),
            _ => every,
        };
        // Marks are counted by a stage of their own.
        let of_cells = if edges.is_some() { &[[1, 1], few][..] } else { &[count, [1, 1], few] };
        let mut counts = of_cells.iter().copied();
        let stages = self.stages.iter().map(|stage| {
            let group = stage.bind(
                device,
                &[
                    ("depth_map", entry::<DepthMapShape>(&uniforms.map)),
                    ("depth_texture", textures[0].clone()),
                    ("object_texture", textures[1].clone()),
                    ("places", self.places.as_entire_binding()),
                    ("cells", self.cells.as_entire_binding()),
                    ("draws", self.draws.as_entire_binding()),
                ],
            );
            (stage, group, Workgroups::Known(counts.next().unwrap_or(every)))
        });
        BoundStages { edges, stages: stages.collect() }
    }

    /// The draws of a camera, for each bit.
    fn bind_draws(
        &self,
        [texture, objects]: &[wgpu::BindingResource<'_>; 2],
        uniforms: &Uniforms,
        views: &[Vec<DepthMapView>],
    ) -> Vec<wgpu::BindGroup> {
        let device = self.shared.device();
        let draw = |views: &Vec<DepthMapView>| {
            let view = filled(device, "depth map view", bytemuck::cast_slice(views), wgpu::BufferUsages::STORAGE);
            let resources = [
                uniforms.map.as_entire_binding(),
                texture.clone(),
                self.cells().as_entire_binding(),
                view.as_entire_binding(),
                objects.clone(),
            ];
            if let (Some(contours), Some(contour)) = (&self.contours, &uniforms.contour) {
                return wall_group(&self.shared, (0..).zip(resources).chain(contours.of_draws(contour)).collect());
            }
            group(device, "depth surface", &layout(&self.shared), &resources)
        };
        views.iter().map(draw).collect()
    }
}

impl<'a> Planned<'a> {
    /// With a stage before those that are recorded.
    pub(super) fn after(self, before: Option<BoundStage<'a>>) -> Self {
        Self { before, ..self }
    }

    /// Whether stages are recorded.
    pub(super) fn is_listed_anew(&self) -> bool {
        self.stages.is_some()
    }

    /// Whether near caps are drawn, for each camera.
    pub(super) fn near_caps(&self) -> impl Iterator<Item = &DepthMapNearCap> {
        self.frames.iter().map(|frame| &frame.near_cap)
    }

    /// Records the stages. The frames are for the cameras, in their order.
    pub(super) fn record(
        self,
        encoder: &mut wgpu::CommandEncoder,
        mut timer: Option<&mut StageTimer>,
    ) -> Vec<DepthMapFrame> {
        let Self { volumes, before, stages, near, frames } = self;
        // Each uniform begins at its buffer's start.
        let dispatch = |encoder: &mut wgpu::CommandEncoder,
                        (stage, group, workgroups): &BoundStage<'_>,
                        timer: Option<&mut StageTimer>| {
            let timestamp_writes = timer.and_then(|timer| timer.compute_pass(stage.label));
            let label = Some(stage.label);
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label, timestamp_writes });
            pass.set_pipeline(&stage.compute);
            pass.set_bind_group(0, group, &vec![0; stage.uniforms()]);
            match workgroups {
                Workgroups::Known([x, y]) => pass.dispatch_workgroups(*x, *y, 1),
                Workgroups::Written(buffer, at) => pass.dispatch_workgroups_indirect(buffer, *at),
            }
        };
        if let Some(bound) = &stages {
            if let Some(before) = &before {
                dispatch(encoder, before, timer.as_deref_mut());
            }
            if let (Some(edges), Some(bound)) = (&volumes.edges, &bound.edges) {
                let most = volumes.shared.device().limits().max_compute_workgroups_per_dimension;
                edges.record(encoder, bound, most, timer.as_deref_mut());
            }
            for stage in &bound.stages {
                dispatch(encoder, stage, timer.as_deref_mut());
            }
            volumes.encodes.fetch_add(1, Ordering::Relaxed);
        }
        for stage in &near {
            dispatch(encoder, stage, timer.as_deref_mut());
        }
        frames
    }
}
