//! The compute passes before the draws: `bounds`, `choose`, `caps`, `list_sides`, `shadow_arguments`, and four optional
//! ones. And the bind groups of the draws.

use wgpu::BindingResource;

use super::buffers::VolumeBuffers;
use super::draws::LightDraws;
use super::pipelines::{Layouts, layouts};
use super::sizes::{GroupSize, Room, VolumeSettings, VolumeSizes};
use super::source::VolumeSource;
use crate::gpu::common::dispatch_limits::{DispatchLimits, binding, loops};
use crate::gpu::common::pass::{Dispatch, Pass};
use crate::gpu::common::pipelines::{Pipeline, Pipelines, Program, group};
use crate::gpu::common::timer::StageTimer;
use crate::gpu::common::uniforms::{UniformTable, entry};
use crate::layout::{CHUNK, LANES, PieceDraws, SeenLight, ShadowDraw, ShadowDraws, ShadowShape};
use crate::stages::{
    BOUNDS, CAPS, CHOOSE, LIST_SIDES, PIECE_ARGUMENTS, PIECE_CROSSINGS, RELIST, SHADOW_ARGUMENTS, STENCIL_BOUND,
    STENCIL_CROSSINGS, STENCIL_PENCIL, Stage, ZP_PLUS_2005_CASES,
};
use crate::turns::{BOUND_CHUNKS, LISTED_ITEMS};

/// The pipelines of these stages.
#[derive(Clone, Debug)]
pub(crate) struct StagePipelines {
    device: wgpu::Device,
    /// Invocations share the chunks of casters, instead of taking turns with the faces of a single one.
    is_scene: bool,
    layouts: Layouts,
    /// Only for scenes.
    relist: Option<Pipeline>,
    bounds: Pipeline,
    choose: Pipeline,
    /// Only for ZP+ as published.
    zp_plus_2005_cases: Option<Pipeline>,
    caps: Pipeline,
    list_sides: Pipeline,
    arguments: Pipeline,
    /// Only for a caster with polygons.
    piece_arguments: Option<Pipeline>,
    /// The same, if the caller asks for a bound.
    piece_crossings: Option<Pipeline>,
    /// Pencil, crossings and bound. Only if the caller asks for a bound.
    bound: Option<[Pipeline; 3]>,
}

impl StagePipelines {
    /// The pipelines for the casters of a scene, or for a single caster.
    pub(crate) fn new(pipelines: &Pipelines, is_scene: bool, settings: &VolumeSettings) -> Self {
        let programs = programs(is_scene, settings);
        pipelines.make_together(&programs);
        let find = |stage: &Stage| programs.iter().find(|program| program.stage == stage);
        let optional = |stage| find(stage).map(|program| pipelines.get(program));
        let of_casters = |stage| pipelines.get(&of_casters(is_scene, stage));
        let of_lists = |stage| pipelines.get(&Program::of(stage, &[]));
        Self {
            device: pipelines.device().clone(),
            is_scene,
            layouts: layouts(pipelines),
            relist: optional(&RELIST),
            bounds: of_casters(&BOUNDS),
            choose: of_casters(&CHOOSE),
            zp_plus_2005_cases: optional(&ZP_PLUS_2005_CASES),
            caps: of_casters(&CAPS),
            list_sides: of_casters(&LIST_SIDES),
            arguments: of_lists(&SHADOW_ARGUMENTS),
            piece_arguments: optional(&PIECE_ARGUMENTS),
            piece_crossings: optional(&PIECE_CROSSINGS),
            bound: optional(&STENCIL_PENCIL)
                .zip(optional(&STENCIL_CROSSINGS))
                .zip(optional(&STENCIL_BOUND))
                .map(|((pencil, crossings), bound)| [pencil, crossings, bound]),
        }
    }
}

/// The programs of these stages, in their order.
pub(crate) fn programs(is_scene: bool, settings: &VolumeSettings) -> Vec<Program> {
    let of_casters = |stage| of_casters(is_scene, stage);
    let of_lists = |stage| Program::of(stage, &[]);
    let mut programs = Vec::new();
    programs.extend(is_scene.then(|| of_lists(&RELIST)));
    programs.extend([&BOUNDS, &CHOOSE].map(of_casters));
    programs.extend(settings.counting.is_zp_plus_2005().then(|| of_lists(&ZP_PLUS_2005_CASES)));
    programs.extend([&CAPS, &LIST_SIDES].map(of_casters));
    programs.push(of_lists(&SHADOW_ARGUMENTS));
    programs.extend(settings.has_pieces.then(|| of_lists(&PIECE_ARGUMENTS)));
    if settings.bound_counts {
        programs.extend([&STENCIL_PENCIL, &STENCIL_CROSSINGS].map(of_casters));
        programs.extend(settings.has_pieces.then(|| of_lists(&PIECE_CROSSINGS)));
        programs.push(of_lists(&STENCIL_BOUND));
    }
    programs
}

/// A stage that goes over casters.
fn of_casters(is_scene: bool, stage: &'static Stage) -> Program {
    let many = [("MANY", 1.0)];
    Program::of(stage, if is_scene { &many } else { &[] })
}

/// The bind groups of the draws of a group of casters.
#[derive(Debug)]
struct GroupDraws {
    /// For each batch of lights: the shape of the group differs.
    frames: Vec<wgpu::BindGroup>,
    /// For each batch one for each view.
    sides: Vec<Vec<wgpu::BindGroup>>,
    caps: Vec<Vec<wgpu::BindGroup>>,
    /// For each batch, of a caster with polygons.
    pieces: Vec<wgpu::BindGroup>,
}

/// The stages and draws of the volumes of some casters, with everything bound.
#[derive(Debug)]
pub(crate) struct VolumeStages {
    table: wgpu::Buffer,
    is_scene: bool,
    /// Up to `caps`.
    choosing: Vec<Pass>,
    /// From `list_sides` on. These read the choices in the table.
    listing: Vec<Pass>,
    groups: Vec<GroupDraws>,
}

impl VolumeStages {
    /// Binds everything.
    pub(crate) fn new(pipelines: &StagePipelines, buffers: &VolumeBuffers, source: &VolumeSource<'_>) -> Self {
        let most = DispatchLimits::new(&pipelines.device.limits()).workgroups;
        let most = u32::try_from(most).unwrap_or(u32::MAX);
        let binder = Binder { pipelines, sizes: &buffers.sizes, buffers, source, most };
        Self {
            table: source.table.clone(),
            is_scene: pipelines.is_scene,
            choosing: binder.choosing(),
            listing: binder.listing(),
            groups: binder.draws(),
        }
    }

    /// Records the stages for the first `batches` batches of lights, after their extraction.
    pub(crate) fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        buffers: &VolumeBuffers,
        batches: usize,
        mut timer: Option<&mut StageTimer>,
    ) {
        buffers.clear(encoder, batches, self.is_scene);
        if batches == 0 || self.groups.is_empty() {
            return;
        }
        let VolumeBuffers { sizes, choices, .. } = buffers;
        let [_, bytes] = sizes.choice_bytes();
        Pass::record_all(&self.choosing, encoder, 0..batches, timer.as_deref_mut());
        encoder.copy_buffer_to_buffer(choices, 0, &self.table, 16 * sizes.choices_at as u64, bytes);
        Pass::record_all(&self.listing, encoder, 0..batches, timer);
    }

    /// The draws of a light in a view for a batch of casters, for each group.
    pub(crate) fn draws<'a>(
        &'a self,
        buffers: &'a VolumeBuffers,
        count_batch: usize,
        view: usize,
        light: usize,
    ) -> impl Iterator<Item = LightDraws<'a>> {
        let sizes = &buffers.sizes;
        let (batch, place) = (light / 32, view * sizes.lights + light);
        let uniform = count_batch * sizes.seen() + place;
        let groups = self.groups.iter().zip(&buffers.draws).zip(&sizes.groups);
        groups.filter_map(move |((group, draws), size)| {
            Some(LightDraws {
                frame: group.frames.get(batch)?,
                uniform: (uniform * UniformTable::stride::<ShadowDraw>()) as u32,
                seen: (place * size_of::<SeenLight>()) as u32,
                sides: group.sides.get(batch)?.get(view)?,
                caps: group.caps.get(batch)?.get(view)?,
                draws,
                first: (place * size_of::<ShadowDraws>()) as u64,
                may_end: sizes.settings.end_at_range,
                has_proxies: size.proxies > 0,
                pieces: group.pieces.get(batch).zip(buffers.piece_draws.as_ref()),
                first_piece: (place * size_of::<PieceDraws>()) as u64,
            })
        })
    }
}

/// The inputs for binding stages and draws.
struct Binder<'a> {
    pipelines: &'a StagePipelines,
    sizes: &'a VolumeSizes,
    buffers: &'a VolumeBuffers,
    source: &'a VolumeSource<'a>,
    /// The most workgroups along an axis.
    most: u32,
}

/// A group of casters, a batch of lights and a view.
#[derive(Clone, Copy, Default)]
struct Place {
    group: usize,
    batch: usize,
    view: usize,
}

impl<'a> Binder<'a> {
    /// The number of a group and batch.
    fn part(&self, at: Place) -> usize {
        at.group * self.sizes.batches() + at.batch
    }

    fn get(&self, name: &str, at: Place) -> Option<BindingResource<'a>> {
        let Self { buffers, source, .. } = *self;
        let group = source.groups.get(at.group)?;
        let batch = group.batches.get(at.batch)?;
        let lists = || buffers.lists.get(self.part(at))?.get(at.view);
        let whole = wgpu::Buffer::as_entire_binding;
        Some(match name {
            "shape" => entry::<ShadowShape>(&buffers.shapes),
            "draw" => entry::<ShadowDraw>(&buffers.draw_lights),
            "seen" => whole(&buffers.seen),
            "table" => whole(source.table),
            "boxes" => whole(&buffers.boxes),
            "choices" => whole(&buffers.choices),
            // Where all lights matter, it is not read.
            "receivers" => whole(&buffers.receivers),
            "listed" => whole(&buffers.listed),
            "kept" => whole(source.kept?),
            "lit" => whole(source.lit.unwrap_or(source.table)),
            "shadow_statistics" => whole(&buffers.statistics),
            "shadow_draws" => whole(buffers.draws.get(at.group)?),
            "sides" => whole(&lists()?.sides),
            "caps_listed" => whole(&lists()?.caps),
            "faces" => whole(group.faces),
            "edge_vertices" => whole(group.edge_vertices),
            "edge_faces" => whole(group.edge_faces),
            "positions" => group.positions.clone(),
            "facing_masks" => batch.facing.clone(),
            "excluded_masks" => batch.excluded.clone(),
            "silhouette_counts" => batch.silhouette_counts.clone(),
            "silhouettes" => batch.silhouettes.clone(),
            "extraction_statistics" => batch.statistics.clone(),
            "pieces" => batch.pieces.clone()?,
            "piece_draws" => whole(buffers.piece_draws.as_ref()?),
            "pencils" => whole(&buffers.bound.as_ref()?.pencils),
            "crossings" => whole(&buffers.bound.as_ref()?.crossings),
            _ => return None,
        })
    }

    fn dispatch(&self, pipeline: &Pipeline, at: Place, workgroups: [u32; 2]) -> Dispatch {
        let resources: Vec<_> =
            pipeline.names().iter().filter_map(|name| Some((name.as_str(), self.get(name, at)?))).collect();
        self.bound(pipeline, at, workgroups, &resources)
    }

    fn bound(
        &self,
        pipeline: &Pipeline,
        at: Place,
        [x, y]: [u32; 2],
        resources: &[(&str, BindingResource<'_>)],
    ) -> Dispatch {
        // The shape, and the first light of the batch in the view.
        let place = at.view * self.sizes.lights + 32 * at.batch;
        let mut offsets = vec![(self.part(at) * UniformTable::stride::<ShadowShape>()) as u32];
        offsets.push((place * UniformTable::stride::<ShadowDraw>()) as u32);
        offsets.truncate(pipeline.uniforms());
        Dispatch {
            group: Some(pipeline.bind(&self.pipelines.device, resources)),
            offsets,
            workgroups: x.min(self.most),
            rows: y,
            ..Dispatch::over(at.batch, 0..0, 0)
        }
    }

    /// A stage with a dispatch for each group, batch and view.
    fn for_each(&self, pipeline: &Pipeline, workgroups: impl Fn(&GroupSize, &Room) -> [u32; 2]) -> Pass {
        let VolumeSizes { groups, rooms, views, .. } = self.sizes;
        let batches = self.sizes.batches().max(1);
        let parts = groups.iter().zip(rooms.chunks(batches)).enumerate();
        let dispatches = parts.flat_map(|(group, (size, rooms))| {
            let workgroups = &workgroups;
            rooms.iter().enumerate().flat_map(move |(batch, room)| {
                let at = move |view| Place { group, batch, view };
                (0..*views).map(move |view| self.dispatch(pipeline, at(view), workgroups(size, room)))
            })
        });
        Pass { pipeline: pipeline.clone(), dispatches: dispatches.collect() }
    }

    /// A stage with a dispatch for each batch and view, of a workgroup for each light, for all groups together.
    fn for_all(&self, pipeline: &Pipeline) -> Pass {
        let lights = |batch: usize| (self.sizes.lights - 32 * batch).min(32) as u32;
        let places = (0..self.sizes.batches()).flat_map(|batch| (0..self.sizes.views).map(move |view| (batch, view)));
        let dispatch = |(batch, view)| self.dispatch(pipeline, Place { group: 0, batch, view }, [lights(batch), 1]);
        let is_empty = self.sizes.groups.is_empty();
        Pass { pipeline: pipeline.clone(), dispatches: places.filter(|_| !is_empty).map(dispatch).collect() }
    }

    /// Up to `caps`.
    fn choosing(&self) -> Vec<Pass> {
        let StagePipelines { is_scene, relist, bounds, choose, zp_plus_2005_cases, caps, .. } = self.pipelines;
        let without_boxes = self.sizes.groups.iter().zip(&self.source.groups).enumerate();
        let boxed = without_boxes.filter(|(_, (_, source))| !source.has_boxes).map(|(group, (size, _))| {
            // An invocation takes some 64 faces. So there are few atomics, and all cores have work.
            let chunks = size.faces.div_ceil(CHUNK);
            let workgroups = [chunks.div_ceil(64).clamp(1, 1024).max(chunks.div_ceil(64 * BOUND_CHUNKS)), 1];
            self.dispatch(bounds, Place { group, ..Place::default() }, workgroups)
        });
        let mut passes: Vec<Pass> = relist.iter().map(|relist| self.for_each(relist, |_, _| [1, 1])).collect();
        passes.extend([Pass { pipeline: bounds.clone(), dispatches: boxed.collect() }, self.choose(choose)]);
        if let Some(cases) = zp_plus_2005_cases {
            passes
                .push(self.for_each(cases, |size, room| [size.edges.div_ceil(64 * LISTED_ITEMS).max(1), room.lights]));
        }
        passes.push(self.for_each(caps, |size, _| {
            let items = if *is_scene { size.faces.div_ceil(CHUNK) * LANES } else { size.faces };
            [loops(&self.pipelines.device, items), 1]
        }));
        passes.retain(|pass| !pass.dispatches.is_empty());
        passes
    }

    /// From `list_sides` on.
    fn listing(&self) -> Vec<Pass> {
        let StagePipelines { device, list_sides, arguments, piece_arguments, piece_crossings, bound, .. } =
            self.pipelines;
        let is_cpu = device.adapter_info().device_type == wgpu::DeviceType::Cpu;
        let over_sides = |size: &GroupSize, room: &Room| {
            // An invocation takes some sixteen sides of a list that is full, and all edges take few turns.
            let fewest = size.edges.div_ceil(64 * LISTED_ITEMS);
            let most = if is_cpu { 64_u32.div_ceil(room.lights).max(4) } else { 256 };
            [room.silhouettes.div_ceil(16 * 64).clamp(1, most).max(fewest), room.lights]
        };
        let mut listing = vec![self.for_each(list_sides, over_sides), self.for_each(arguments, |_, _| [1, 1])];
        listing.extend(piece_arguments.iter().map(|stage| self.for_each(stage, |_, _| [1, 1])));
        if let Some([pencil, crossings, bound]) = bound {
            listing.extend([self.for_all(pencil), self.for_each(crossings, over_sides)]);
            // An invocation takes few pieces of many. Each has nine words.
            let bytes = self.source.groups.iter().flat_map(|group| &group.batches).map(|batch| match &batch.pieces {
                Some(BindingResource::Buffer(pieces)) => pieces.buffer.size(),
                _ => 0,
            });
            let most_pieces = u32::try_from(bytes.max().unwrap_or(0) / 36).unwrap_or(u32::MAX);
            let over_pieces = |_: &GroupSize, room: &Room| {
                let fewest = (most_pieces / room.lights.max(1)).div_ceil(64 * LISTED_ITEMS);
                [if is_cpu { 4 } else { 64 }.max(fewest), room.lights]
            };
            listing.extend(piece_crossings.iter().map(|stage| self.for_each(stage, over_pieces)));
            listing.push(self.for_all(bound));
        }
        listing
    }

    /// All casters, lights and views in one dispatch.
    fn choose(&self, choose: &Pipeline) -> Pass {
        let VolumeSizes { casters, views, .. } = *self.sizes;
        // Facing is not waited for.
        let any_zeros = || self.buffers.any_zeros.as_entire_binding();
        let statistics = || self.source.statistics.clone().unwrap_or_else(any_zeros);
        let get = |name: &str| match name {
            "extraction_statistics" => Some(statistics()),
            _ => self.get(name, Place::default()),
        };
        let resources: Vec<_> = choose.names().iter().filter_map(|name| Some((name.as_str(), get(name)?))).collect();
        let pairs = u32::try_from(casters as u64 * self.sizes.used_lights() as u64).unwrap_or(u32::MAX);
        let workgroups = (4 * loops(&self.pipelines.device, pairs)).min(pairs.div_ceil(64)).min(self.most).max(1);
        let dispatches = if self.sizes.groups.is_empty() {
            Vec::new()
        } else {
            vec![self.bound(choose, Place::default(), [workgroups, views as u32], &resources)]
        };
        Pass { pipeline: choose.clone(), dispatches }
    }

    /// The bind groups of the draws, for each group.
    fn draws(&self) -> Vec<GroupDraws> {
        let Layouts { frame, side_data, cap_data, piece_data } = &self.pipelines.layouts;
        let bind = |layout: &wgpu::BindGroupLayout, resources: &[BindingResource<'_>]| {
            group(&self.pipelines.device, "shadow volumes", layout, resources)
        };
        let frame = |at: Place| {
            let first = (self.part(at) * UniformTable::stride::<ShadowShape>()) as u64;
            let VolumeBuffers { shapes, draw_lights, seen, .. } = self.buffers;
            let resources = [
                binding(shapes, first..first + size_of::<ShadowShape>() as u64),
                entry::<ShadowDraw>(draw_lights),
                binding(seen, 0..size_of::<SeenLight>() as u64),
                self.source.table.as_entire_binding(),
            ];
            bind(frame, &resources)
        };
        let data = |layout: &wgpu::BindGroupLayout, names: &[&str], group: usize, batch: usize| {
            let of_view = |view| {
                let at = Place { group, batch, view };
                let resources: Vec<_> = names.iter().filter_map(|name| self.get(name, at)).collect();
                bind(layout, &resources)
            };
            (0..self.sizes.views).map(of_view).collect::<Vec<_>>()
        };
        let side_names = ["positions", "edge_vertices", "edge_faces", "facing_masks", "excluded_masks", "sides"];
        let cap_names = ["positions", "faces", "facing_masks", "excluded_masks", "caps_listed"];
        let batches = || 0..self.sizes.batches();
        let of_group = |group| GroupDraws {
            frames: batches().map(|batch| frame(Place { group, batch, view: 0 })).collect(),
            sides: batches().map(|batch| data(side_data, &side_names, group, batch)).collect(),
            caps: batches().map(|batch| data(cap_data, &cap_names, group, batch)).collect(),
            pieces: batches()
                .filter_map(|batch| Some(bind(piece_data, &[self.get("pieces", Place { group, batch, view: 0 })?])))
                .collect(),
        };
        (0..self.sizes.groups.len()).map(of_group).collect()
    }
}
