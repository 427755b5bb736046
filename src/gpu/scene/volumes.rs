//! The shadow volumes of a scene: what chooses and lists for each view, and what draws.

use wgpu::BindingResource;

use super::layout::Group;
use super::structure::{GroupBatch, Making, Structure};
use super::table::choice_bytes;
use super::volume_buffers::{Lists, Room, VolumeBuffers};
use crate::gpu::common::dispatch_limits::{DispatchLimits, WORKGROUP, binding};
use crate::gpu::common::pass::{Dispatch, Pass};
use crate::gpu::common::pipelines::{Pipeline, group};
use crate::gpu::common::positions::bound;
use crate::gpu::common::timer::StageTimer;
use crate::gpu::common::uniforms::{UniformTable, entry};
use crate::gpu::shadow::buffers::{CAP_COUNTS, SIDE_COUNTS};
use crate::gpu::shadow::draws::LightDraws;
use crate::gpu::shadow::pipelines::{Layouts, layouts};
use crate::layout::{LANES, SeenLight, ShadowDraw, ShadowDraws, ShadowShape};
use crate::stages::{
    BOUNDS, CAPS, CHOOSE, LIST_SIDES, SHADOW_ARGUMENTS, STENCIL_BOUND, STENCIL_CROSSINGS, STENCIL_PENCIL, Stage,
};

use super::errors::SceneError;
use super::options::SceneOptions;

/// The bind groups of the draws of a group of casters.
#[derive(Debug)]
struct GroupDraws {
    /// For each batch: the shape of the group differs.
    frames: Vec<wgpu::BindGroup>,
    /// For each batch one for each view.
    sides: Vec<Vec<wgpu::BindGroup>>,
    caps: Vec<Vec<wgpu::BindGroup>>,
}

/// The volumes of a structure, for a number of views.
#[derive(Debug)]
pub(crate) struct Volumes {
    pub(crate) views: usize,
    pub(crate) buffers: VolumeBuffers,
    lights: usize,
    casters: usize,
    batches: usize,
    /// Where choices begin in the table, in bytes.
    choices_at: u64,
    has_measures: bool,
    /// `bounds`, `choose` and `caps`.
    choosing: Vec<Pass>,
    /// `list_sides`, `shadow_arguments` and what bounds stencil counts, which read the choices in the table.
    listing: Vec<Pass>,
    groups: Vec<GroupDraws>,
}

/// What the stages and draws of a scene's volumes bind.
struct Binder<'a> {
    making: &'a Making<'a>,
    structure: &'a Structure,
    buffers: &'a VolumeBuffers,
    shapes: &'a wgpu::Buffer,
    draws: &'a wgpu::Buffer,
}

impl Volumes {
    /// Makes the volumes of a structure whose table has room for the choices of `views` views.
    pub(crate) fn new(
        making: &Making<'_>,
        structure: &Structure,
        views: usize,
        others: u64,
    ) -> Result<Self, SceneError> {
        let device = making.pipelines.device();
        let limits = &DispatchLimits::new(&device.limits());
        let options = making.options;
        let parts = 0..structure.parts.len();
        let rooms: Vec<Room> = parts.filter_map(|part| Room::new(structure, part, options, limits)).collect();
        let buffers = VolumeBuffers::new(device, structure, &rooms, views, others, options, limits)?;
        let lights = 32 * structure.batches;
        let mut shapes = UniformTable::default();
        for (part, room) in structure.parts.iter().zip(&rooms) {
            shapes.push(&shape(structure, part, *room, views, options));
        }
        let mut draws = UniformTable::default();
        for count_batch in 0..options.count_batches.max(1) {
            for view in 0..views as u32 {
                for light in 0..lights as u32 {
                    draws.push(&ShadowDraw { light, first_light: light / 32 * 32, view, count_batch });
                }
            }
        }
        let shapes = &shapes.into_buffer(device, "shadow shapes");
        let draws = &draws.into_buffer(device, "shadow draw lights");
        bound(device, || {
            let binder = Binder { making, structure, buffers: &buffers, shapes, draws };
            (binder.choosing(views, limits), binder.listing(views, limits), binder.group_draws(views))
        })
        .map_err(SceneError::from)
        .map(|(choosing, listing, groups)| Self {
            views,
            lights,
            casters: structure.layout.order.len(),
            batches: structure.batches,
            choices_at: (16 * structure.choices_at) as u64,
            has_measures: options.end_at_range,
            choosing: choosing.into_iter().filter(|pass| !pass.dispatches.is_empty()).collect(),
            listing,
            groups,
            buffers,
        })
    }

    /// The entries for each view and light that each encode uploads.
    pub(crate) fn seen_bytes(&self) -> usize {
        self.views * self.lights * size_of::<SeenLight>()
    }

    /// The number of lights of a view, with those that are not there.
    pub(crate) fn lights(&self) -> usize {
        self.lights
    }

    /// Records what chooses and lists, after the extraction.
    pub(crate) fn record(
        &self,
        structure: &Structure,
        encoder: &mut wgpu::CommandEncoder,
        mut timer: Option<&mut StageTimer>,
    ) {
        let VolumeBuffers { boxes, choices, statistics, lists, draws, bound, .. } = &self.buffers;
        let [words, all] = choice_bytes(self.casters, self.batches, self.views, self.has_measures);
        encoder.clear_buffer(statistics, 0, None);
        for draws in draws {
            encoder.clear_buffer(draws, 0, None);
        }
        if structure.parts.is_empty() {
            return;
        }
        encoder.clear_buffer(boxes, 0, None);
        encoder.clear_buffer(choices, 0, Some(words));
        if let Some(bound) = bound {
            encoder.clear_buffer(&bound.crossings, 0, None);
        }
        for Lists { sides, caps } in lists.iter().flatten() {
            encoder.clear_buffer(sides, 0, Some(SIDE_COUNTS));
            encoder.clear_buffer(caps, 0, Some(CAP_COUNTS));
        }
        Pass::record_all(&self.choosing, encoder, timer.as_deref_mut());
        encoder.copy_buffer_to_buffer(choices, 0, &structure.table, self.choices_at, all);
        Pass::record_all(&self.listing, encoder, timer);
    }

    /// The draws of a light in a view for a batch of casters, for each group.
    pub(crate) fn draws(
        &self,
        count_batch: usize,
        view: usize,
        light: usize,
        may_end: bool,
    ) -> impl Iterator<Item = LightDraws<'_>> {
        let (batch, place) = (light / 32, view * self.lights + light);
        let uniform = count_batch * self.views * self.lights + place;
        self.groups.iter().zip(&self.buffers.draws).filter_map(move |(group, draws)| {
            Some(LightDraws {
                frame: group.frames.get(batch)?,
                uniform: (uniform * UniformTable::stride::<ShadowDraw>()) as u32,
                seen: (place * size_of::<SeenLight>()) as u32,
                sides: group.sides.get(batch)?.get(view)?,
                caps: group.caps.get(batch)?.get(view)?,
                draws,
                first: (place * size_of::<ShadowDraws>()) as u64,
                may_end,
            })
        })
    }
}

fn shape(structure: &Structure, part: &GroupBatch, room: Room, views: usize, options: &SceneOptions) -> ShadowShape {
    let (faces, edges) =
        structure.layout.groups.get(part.group).map_or((0, 0), |group| (group.face_slots(), group.edge_slots()));
    let casters = structure.layout.order.len();
    let dispatch = part.dispatches.first().map_or_else(bytemuck::Zeroable::zeroed, |(dispatch, _)| *dispatch);
    let [choices, _] = choice_bytes(casters, structure.batches, views, false);
    ShadowShape {
        casters: casters as u32,
        lights: 32 * structure.batches as u32,
        batches: structure.batches as u32,
        faces,
        edges,
        capacity: part.sizes.capacity,
        side_capacity: room.sides,
        near_capacity: room.near,
        far_capacity: room.far,
        averted: 1,
        counting: options.counting.code(),
        skip_unseen: u32::from(options.skip_unseen),
        end_at_range: u32::from(options.end_at_range),
        choices_at: structure.choices_at as u32,
        measures_at: structure.choices_at as u32 + (choices / 16) as u32,
        lights_at: dispatch.lights_at,
        face_chunks_at: dispatch.face_chunks_at,
        edge_chunks_at: dispatch.edge_chunks_at,
        views: views as u32,
        count_batches: options.count_batches.max(1),
    }
}

impl<'a> Binder<'a> {
    /// A resource by its name, for a group and batch (by its number among the parts) and a view.
    fn get(&self, name: &str, number: usize, view: usize) -> Option<BindingResource<'a>> {
        let part = self.structure.parts.get(number)?;
        let extracted = self.structure.buffers.groups.get(part.group)?.get(part.batch)?;
        let (page, source) = self.structure.source(self.making, part.group)?;
        let lists = || self.buffers.lists.get(number)?.get(view);
        let whole = wgpu::Buffer::as_entire_binding;
        Some(match name {
            "shape" => entry::<ShadowShape>(self.shapes),
            "draw" => entry::<ShadowDraw>(self.draws),
            "seen" => whole(&self.buffers.seen),
            "table" => whole(&self.structure.table),
            "boxes" => whole(&self.buffers.boxes),
            "choices" => whole(&self.buffers.choices),
            "lit" => whole(&self.structure.buffers.lit),
            "shadow_statistics" => whole(&self.buffers.statistics),
            "shadow_draws" => whole(self.buffers.draws.get(part.group)?),
            "sides" => whole(&lists()?.sides),
            "caps_listed" => whole(&lists()?.caps),
            "faces" => whole(&page.faces),
            "edge_vertices" => whole(&page.edge_vertices),
            "edge_faces" => whole(&page.edge_faces),
            "positions" => match &source.buffer {
                Some(bound) => binding(&bound.buffer, bound.range.clone()),
                None => whole(&page.positions),
            },
            "facing_masks" => binding(&extracted.facing, 0..part.sizes.masks),
            "excluded_masks" => binding(&extracted.excluded, 0..part.sizes.masks),
            "silhouette_counts" => binding(&extracted.lists, 0..super::buffers::LISTS_HEAD),
            "silhouettes" => binding(&extracted.lists, super::buffers::LISTS_HEAD..part.sizes.lists),
            // Whether lights are in planes of faces is known for each group and batch, once the faces are decided.
            "extraction_statistics" => binding(&extracted.record, 0..16),
            "pencils" => whole(&self.buffers.bound.as_ref()?.pencils),
            "crossings" => whole(&self.buffers.bound.as_ref()?.crossings),
            _ => return None,
        })
    }

    fn pipeline(&self, stage: &Stage, is_many: bool) -> Pipeline {
        let many = [("MANY", 1.0)];
        self.making.pipelines.compute(stage, stage.name, if is_many { &many } else { &[] })
    }

    /// The offsets of the uniforms of a part and the first light of its batch in a view.
    fn offsets(&self, pipeline: &Pipeline, number: usize, view: usize) -> Vec<u32> {
        let batch = self.structure.parts.get(number).map_or(0, |part| part.batch);
        let place = view * 32 * self.structure.batches + 32 * batch;
        let mut offsets = vec![(number * UniformTable::stride::<ShadowShape>()) as u32];
        offsets.push((place * UniformTable::stride::<ShadowDraw>()) as u32);
        offsets.truncate(pipeline.uniforms());
        offsets
    }

    fn dispatch(&self, pipeline: &Pipeline, number: usize, view: usize, workgroups: [u32; 2]) -> Dispatch {
        let names = pipeline.names().to_vec();
        let device = self.making.pipelines.device();
        let resources: Vec<_> =
            names.iter().filter_map(|name| Some((name.as_str(), self.get(name, number, view)?))).collect();
        Dispatch {
            group: Some(pipeline.bind(device, &resources)),
            offsets: self.offsets(pipeline, number, view),
            workgroups: workgroups[0],
            rows: workgroups[1],
            ..Dispatch::over(0, 0..0, 0)
        }
    }

    /// A stage with a dispatch for each part and view.
    fn each(&self, stage: &Stage, is_many: bool, views: usize, workgroups: impl Fn(&GroupBatch) -> [u32; 2]) -> Pass {
        let pipeline = self.pipeline(stage, is_many);
        let places = self.structure.parts.iter().enumerate().flat_map(|part| (0..views).map(move |view| (part, view)));
        let dispatches =
            places.map(|((number, part), view)| self.dispatch(&pipeline, number, view, workgroups(part))).collect();
        Pass { pipeline, dispatches }
    }

    fn group_of(&self, part: &GroupBatch) -> Option<&'a Group> {
        self.structure.layout.groups.get(part.group)
    }

    /// `bounds`, `choose` and `caps`.
    fn choosing(&self, views: usize, limits: &DispatchLimits) -> [Pass; 3] {
        let Structure { layout, parts, batches, .. } = self.structure;
        let most = u32::try_from(limits.workgroups).unwrap_or(u32::MAX);
        let is_cpu = self.making.pipelines.device().adapter_info().device_type == wgpu::DeviceType::Cpu;
        let few = if is_cpu { 64 } else { 4096 };
        let mut bounds = Pass { pipeline: self.pipeline(&BOUNDS, true), dispatches: Vec::new() };
        for (number, part) in parts.iter().enumerate().filter(|(_, part)| part.batch == 0) {
            let is_rigid =
                self.structure.source(self.making, part.group).is_none_or(|(_, source)| source.buffer.is_none());
            if let Some(group) = self.group_of(part).filter(|_| !is_rigid) {
                let workgroups = [group.face_chunks.div_ceil(64).clamp(1, 1024).min(most), 1];
                bounds.dispatches.push(self.dispatch(&bounds.pipeline, number, 0, workgroups));
            }
        }
        let mut choose = Pass { pipeline: self.pipeline(&CHOOSE, true), dispatches: Vec::new() };
        if !parts.is_empty() {
            let pairs = (layout.order.len() * 32 * batches) as u64;
            let workgroups = [pairs.div_ceil(64).min(limits.workgroups) as u32, views as u32];
            choose.dispatches.push(self.choose(&choose.pipeline, workgroups));
        }
        let caps = self.each(&CAPS, true, views, |part| {
            let items = self.group_of(part).map_or(1, |group| group.face_chunks * LANES);
            // An invocation takes at most some hundred chunks, so its loops do not end early.
            let least = items.div_ceil(WORKGROUP * 128);
            [items.div_ceil(WORKGROUP).clamp(1, few).max(least).min(most), 1]
        });
        [bounds, choose, caps]
    }

    /// `list_sides`, `shadow_arguments`, and if the caller asks for it, what bounds stencil counts.
    fn listing(&self, views: usize, limits: &DispatchLimits) -> Vec<Pass> {
        let most = u32::try_from(limits.workgroups).unwrap_or(u32::MAX);
        let over_sides = |part: &GroupBatch| {
            let fewest = self.group_of(part).map_or(1, |group| group.edge_chunks).div_ceil(1024);
            [part.sizes.capacity.div_ceil(16 * 64).clamp(1, 256).max(fewest).min(most), part.lights.max(1)]
        };
        let mut listing = vec![
            self.each(&LIST_SIDES, true, views, over_sides),
            self.each(&SHADOW_ARGUMENTS, false, views, |_| [1, 1]),
        ];
        if self.buffers.bound.is_some() && !self.structure.parts.is_empty() {
            let every_light = [32 * self.structure.batches as u32, views as u32];
            let once = |stage: &Stage, is_many: bool| {
                let pipeline = self.pipeline(stage, is_many);
                let dispatches = vec![self.dispatch(&pipeline, 0, 0, every_light)];
                Pass { pipeline, dispatches }
            };
            listing.push(once(&STENCIL_PENCIL, true));
            listing.push(self.each(&STENCIL_CROSSINGS, true, views, over_sides));
            listing.push(once(&STENCIL_BOUND, false));
        }
        listing
    }

    /// All casters and views in one dispatch.
    fn choose(&self, pipeline: &Pipeline, workgroups: [u32; 2]) -> Dispatch {
        let names = pipeline.names().to_vec();
        let resources: Vec<_> = names
            .iter()
            .filter_map(|name| {
                // Facing is not waited for.
                let statistics = (name == "extraction_statistics").then(|| self.buffers.any_zeros.as_entire_binding());
                Some((name.as_str(), statistics.or_else(|| self.get(name, 0, 0))?))
            })
            .collect();
        Dispatch {
            group: Some(pipeline.bind(self.making.pipelines.device(), &resources)),
            offsets: self.offsets(pipeline, 0, 0),
            workgroups: workgroups[0],
            rows: workgroups[1],
            ..Dispatch::over(0, 0..0, 0)
        }
    }

    fn group_draws(&self, views: usize) -> Vec<GroupDraws> {
        let Layouts { frame, side_data, cap_data } = &layouts(self.making.pipelines);
        let device = self.making.pipelines.device();
        let make = |layout: &wgpu::BindGroupLayout, names: &[&str], number: usize, view: usize| {
            let resources: Vec<_> = names.iter().filter_map(|name| self.get(name, number, view)).collect();
            group(device, "shadow volumes", layout, &resources)
        };
        let frame_of = |number: usize| {
            let at = (number * UniformTable::stride::<ShadowShape>()) as u64;
            let resources = [
                binding(self.shapes, at..at + size_of::<ShadowShape>() as u64),
                entry::<ShadowDraw>(self.draws),
                binding(&self.buffers.seen, 0..size_of::<SeenLight>() as u64),
                self.structure.table.as_entire_binding(),
            ];
            group(device, "shadow volumes", frame, &resources)
        };
        let batches = self.structure.batches.max(1);
        let numbers: Vec<usize> = (0..self.structure.parts.len()).collect();
        let of_group = |numbers: &[usize]| {
            let lists = |layout: &wgpu::BindGroupLayout, names: &[&str]| {
                let of_views = |&number: &usize| (0..views).map(|view| make(layout, names, number, view)).collect();
                numbers.iter().map(of_views).collect()
            };
            let masks = ["facing_masks", "excluded_masks"];
            GroupDraws {
                frames: numbers.iter().map(|&number| frame_of(number)).collect(),
                sides: lists(side_data, &["positions", "edge_vertices", "edge_faces", masks[0], masks[1], "sides"]),
                caps: lists(cap_data, &["positions", "faces", masks[0], masks[1], "caps_listed"]),
            }
        };
        numbers.chunks(batches).map(of_group).collect()
    }
}
