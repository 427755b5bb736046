//! The compute passes before the draws: `bounds`, `choose`, `caps`, `list_sides`, `shadow_arguments`, and four optional
//! ones. And the bind groups of the draws.

use wgpu::BindingResource;

use super::buffers::{ANY_ZEROS_BYTES, SizedBuffers, VolumeBuffers};
use super::draws::LightDraws;
use super::pipelines::{Layouts, layouts};
use super::sizes::{GroupSize, Room, VolumeSizes};
use super::source::{Named, VolumeSource, named};
use crate::gpu::common::bindings::{Resource, part, uniform, whole};
use crate::gpu::common::dispatch_limits::{DispatchLimits, loops};
use crate::gpu::common::pass::{Dispatch, Step, Workgroups, record};
use crate::gpu::common::pipelines::{Pipeline, Pipelines, Program, group};
use crate::gpu::common::timer::StageTimer;
use crate::gpu::common::uniforms::UniformTable;
use crate::gpu::scene::options::SceneOptions;
use crate::layout::{CHUNK, ExtractionStatistics, LANES, PieceDraws, SeenLight, ShadowDraw, ShadowDraws, ShadowShape};
use crate::stages::{
    BOUNDS, CAPS, CHOOSE, LIST_SIDES, PIECE_ARGUMENTS, PIECE_CROSSINGS, RELIST, SHADOW_ARGUMENTS, STENCIL_BOUND,
    STENCIL_CROSSINGS, STENCIL_PENCIL, ZP_PLUS_2005_CASES,
};
use crate::turns::{BOUND_CHUNKS, LISTED_ITEMS};

/// The items that a stage walks along.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Over {
    /// The faces of each group whose boxes are not known.
    Boxes,
    /// All casters, lights and views in one dispatch.
    Pairs,
    /// For each group, batch and view: one workgroup, also only where there are pieces, or faces, edges, sides, pieces.
    One,
    OneOfPieces,
    Faces,
    Edges,
    Sides,
    Pieces,
    /// For each batch and view a workgroup for each light, for all groups together.
    Lights,
}

/// The stages in their order, and what they walk along. `is_scene`: invocations share the chunks of casters, instead of taking
/// turns with the faces of a single one. Those from `list_sides` on read the choices in the table.
fn stages(is_scene: bool, has_pieces: bool, options: &SceneOptions) -> Vec<(Program, Over)> {
    let many = [("MANY", 1.0)];
    let of_casters = |stage, over| (Program::of(stage, if is_scene { &many } else { &[] }), over);
    let of_lists = |stage, over| (Program::of(stage, &[]), over);
    let (pieces, bound) = (has_pieces, options.stencil.bound_counts);
    let stages = [
        (is_scene, of_lists(&RELIST, Over::One)),
        (true, of_casters(&BOUNDS, Over::Boxes)),
        (true, of_casters(&CHOOSE, Over::Pairs)),
        (options.counting.is_zp_plus_2005(), of_lists(&ZP_PLUS_2005_CASES, Over::Edges)),
        (true, of_casters(&CAPS, Over::Faces)),
        (true, of_casters(&LIST_SIDES, Over::Sides)),
        (true, of_lists(&SHADOW_ARGUMENTS, Over::One)),
        (pieces, of_casters(&PIECE_ARGUMENTS, Over::OneOfPieces)),
        (bound, of_casters(&STENCIL_PENCIL, Over::Lights)),
        (bound, of_casters(&STENCIL_CROSSINGS, Over::Sides)),
        (bound && pieces, of_casters(&PIECE_CROSSINGS, Over::Pieces)),
        (bound, of_lists(&STENCIL_BOUND, Over::Lights)),
    ];
    stages.into_iter().filter(|(is_there, _)| *is_there).map(|(_, stage)| stage).collect()
}

/// The programs of these stages, in their order.
pub(crate) fn programs(is_scene: bool, has_pieces: bool, options: &SceneOptions) -> Vec<Program> {
    stages(is_scene, has_pieces, options).into_iter().map(|(program, _)| program).collect()
}

/// The pipelines of these stages.
#[derive(Clone, Debug)]
pub(crate) struct StagePipelines {
    device: wgpu::Device,
    is_scene: bool,
    layouts: Layouts,
    stages: Vec<(Pipeline, Over)>,
}

impl StagePipelines {
    /// The pipelines for the casters of a scene, or for a single caster.
    pub(crate) fn new(pipelines: &Pipelines, is_scene: bool, has_pieces: bool, options: &SceneOptions) -> Self {
        let stages = stages(is_scene, has_pieces, options);
        pipelines.make_together(&programs(is_scene, has_pieces, options));
        Self {
            device: pipelines.device().clone(),
            is_scene,
            layouts: layouts(pipelines),
            stages: stages.into_iter().map(|(program, over)| (pipelines.get(&program), over)).collect(),
        }
    }
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
    /// Before all, for each batch of lights, and the stages.
    clears: (Vec<Step>, Vec<Vec<Step>>),
    steps: Vec<Step>,
    groups: Vec<GroupDraws>,
}

impl VolumeStages {
    /// Binds everything.
    pub(crate) fn new(pipelines: &StagePipelines, buffers: &SizedBuffers, source: &VolumeSource<'_>) -> Self {
        let most = DispatchLimits::new(&pipelines.device.limits()).workgroups;
        let most = u32::try_from(most).unwrap_or(u32::MAX);
        let SizedBuffers { sizes, of, .. } = buffers;
        let binder = Binder { pipelines, sizes, buffers: of, source, most };
        Self { clears: buffers.clears(pipelines.is_scene), steps: binder.steps(), groups: binder.draws() }
    }

    /// Records the stages for the first `batches` batches of lights, after their extraction.
    pub(crate) fn record(&self, encoder: &mut wgpu::CommandEncoder, batches: usize, timer: Option<&mut StageTimer>) {
        let (first, of_batches) = &self.clears;
        let is_there = batches > 0 && !self.groups.is_empty();
        let stages = self.steps.iter().filter(|_| is_there);
        let clears = first.iter().chain(of_batches.iter().take(batches).flatten());
        record(clears.chain(stages), encoder, 0..batches, timer);
    }

    /// The draws of a light in a view for a batch of casters, for each group.
    pub(crate) fn draws<'a>(
        &'a self,
        buffers: &'a SizedBuffers,
        count_batch: usize,
        view: usize,
        light: usize,
    ) -> impl Iterator<Item = LightDraws<'a>> {
        let SizedBuffers { sizes, of: buffers, .. } = buffers;
        let (batch, place) = (light / 32, view * sizes.lights + light);
        let uniform = count_batch * sizes.seen() + place;
        let groups = self.groups.iter().zip(&buffers.draws).zip(&sizes.groups).zip(&buffers.piece_draws);
        groups.filter_map(move |(((group, draws), size), piece_draws)| {
            Some(LightDraws {
                frame: group.frames.get(batch)?,
                uniform: (uniform * UniformTable::stride::<ShadowDraw>()) as u32,
                seen: (place * size_of::<SeenLight>()) as u32,
                sides: group.sides.get(batch)?.get(view)?,
                caps: group.caps.get(batch)?.get(view)?,
                draws,
                first: (place * size_of::<ShadowDraws>()) as u64,
                may_end: sizes.options.end_at_range,
                has_proxies: size.proxies > 0,
                pieces: group.pieces.get(batch).zip(piece_draws.as_ref()),
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

    fn get(&self, name: &str, at: Place) -> Option<Resource<'a>> {
        let Self { buffers, source, .. } = *self;
        let group = source.groups.get(at.group)?;
        let batch = group.batches.get(at.batch)?;
        let lists = || buffers.lists.get(self.part(at))?.get(at.view);
        // The shape, and the first light of the batch in the view.
        let shape = (self.part(at) * UniformTable::stride::<ShadowShape>()) as u32;
        let light = at.view * self.sizes.lights + 32 * at.batch;
        let draw = (light * UniformTable::stride::<ShadowDraw>()) as u32;
        Some(match name {
            "shape" => uniform::<ShadowShape>(&buffers.shapes, shape),
            "draw" => uniform::<ShadowDraw>(&buffers.draw_lights, draw),
            "seen" => whole(&buffers.seen),
            "table" => whole(source.table),
            "boxes" => whole(&buffers.boxes),
            "choices" => whole(&buffers.choices),
            "receivers" => whole(&buffers.receivers),
            "listed" => whole(&buffers.listed),
            "shadow_statistics" => whole(&buffers.statistics),
            "shadow_draws" => whole(buffers.draws.get(at.group)?),
            "sides" => whole(&lists()?.sides),
            "caps_listed" => whole(&lists()?.caps),
            "piece_draws" => whole(buffers.piece_draws.get(at.group)?.as_ref()?),
            "pencils" => whole(&buffers.bound.as_ref()?.pencils),
            "crossings" => whole(&buffers.bound.as_ref()?.crossings),
            _ => {
                let given = [batch, &group.named, &source.named].into_iter().find_map(|of| named(of, name));
                // Where all lights matter, `lit` is not read.
                given.or_else(|| (name == "lit").then(|| whole(source.table)))?
            }
        })
    }

    fn dispatch(&self, pipeline: &Pipeline, over: Over, at: Place, [x, y]: [u32; 2]) -> Dispatch {
        let workgroups = Workgroups::Known([x.min(self.most), y]);
        // Facing is not waited for.
        let of_all = || named(&self.source.named, "all_statistics").unwrap_or_else(|| whole(&self.buffers.any_zeros));
        let get = |name: &str| match name {
            "extraction_statistics" if over == Over::Pairs => Some(of_all()),
            _ => self.get(name, at),
        };
        Dispatch { batch: at.batch, ..pipeline.dispatch(&self.pipelines.device, workgroups, get) }
    }

    /// The dispatches of a stage, with their workgroups.
    fn dispatches(&self, over: Over) -> Vec<(Place, [u32; 2])> {
        let VolumeSizes { groups, rooms, casters, views, .. } = self.sizes;
        let device = &self.pipelines.device;
        let batches = self.sizes.batches();
        let numbered = || groups.iter().enumerate();
        match over {
            Over::Boxes => {
                let unknown =
                    numbered().filter(|(group, _)| !self.source.groups.get(*group).is_some_and(|of| of.has_boxes));
                // An invocation takes some 64 faces. So there are few atomics, and all cores have work.
                let workgroups = |size: &GroupSize| {
                    let chunks = size.faces.div_ceil(CHUNK);
                    [chunks.div_ceil(64).clamp(1, 1024).max(chunks.div_ceil(64 * BOUND_CHUNKS)), 1]
                };
                unknown.map(|(group, size)| (Place { group, ..Place::default() }, workgroups(size))).collect()
            }
            Over::Pairs => {
                let pairs = u32::try_from(*casters as u64 * self.sizes.used_lights() as u64).unwrap_or(u32::MAX);
                let workgroups = (4 * loops(device, pairs)).min(pairs.div_ceil(64)).min(self.most).max(1);
                groups.iter().take(1).map(|_| (Place::default(), [workgroups, *views as u32])).collect()
            }
            Over::Lights => {
                let lights = |batch: usize| (self.sizes.lights - 32 * batch).min(32) as u32;
                let batches = (0..batches).filter(|_| !groups.is_empty());
                let places = batches.flat_map(|batch| (0..*views).map(move |view| Place { group: 0, batch, view }));
                places.map(|at| (at, [lights(at.batch), 1])).collect()
            }
            _ => {
                let is_of_pieces = matches!(over, Over::Pieces | Over::OneOfPieces);
                let parts = numbered().zip(rooms.chunks(batches.max(1)));
                let parts = parts.filter(|((group, _), _)| !is_of_pieces || self.sizes.pieces_of(*group));
                let parts = parts.flat_map(|(group, rooms)| rooms.iter().enumerate().map(move |room| (group, room)));
                let places = parts.flat_map(|((group, size), (batch, room))| {
                    let workgroups = self.of_lists(over, size, room);
                    (0..*views).map(move |view| (Place { group, batch, view }, workgroups))
                });
                places.collect()
            }
        }
    }

    /// The workgroups of a stage for a group, batch and view.
    fn of_lists(&self, over: Over, size: &GroupSize, room: &Room) -> [u32; 2] {
        let StagePipelines { device, is_scene, .. } = self.pipelines;
        let is_cpu = device.adapter_info().device_type == wgpu::DeviceType::Cpu;
        // All edges take few turns.
        let fewest = size.edges.div_ceil(64 * LISTED_ITEMS);
        match over {
            Over::Faces => {
                let items = if *is_scene { size.faces.div_ceil(CHUNK) * LANES } else { size.faces };
                [loops(device, items), 1]
            }
            Over::Edges => [fewest.max(1), room.lights],
            Over::Sides => {
                // An invocation takes some sixteen sides of a list that is full.
                let most = if is_cpu { 64_u32.div_ceil(room.lights).max(4) } else { 256 };
                [room.silhouettes.div_ceil(16 * 64).clamp(1, most).max(fewest), room.lights]
            }
            Over::Pieces => {
                // An invocation takes few pieces of many.
                let fewest = room.pieces.div_ceil(64 * LISTED_ITEMS);
                [if is_cpu { 4 } else { 64 }.max(fewest), room.lights]
            }
            _ => [1, 1],
        }
    }

    /// For each group and batch with polygons, a copy of the lights for which they are twisted to where `choose` reads them.
    fn twisted(&self) -> Vec<Step> {
        let parts = self.source.groups.iter().flat_map(|group| &group.batches).enumerate();
        let copy = |(part, batch): (usize, &Named<'_>)| {
            named(batch, "pieces")?;
            let BindingResource::Buffer(statistics) = named(batch, "extraction_statistics")?.bound else { return None };
            let from = statistics.offset + std::mem::offset_of!(ExtractionStatistics, twisted_lights) as u64;
            let to = ANY_ZEROS_BYTES + 4 * part as u64;
            Some(Step::Copy([(statistics.buffer.clone(), from), (self.buffers.any_zeros.clone(), to)], 4))
        };
        parts.filter_map(copy).collect()
    }

    /// The stages, with a copy of the choices to the table before the lists are made.
    fn steps(&self) -> Vec<Step> {
        let mut steps = Vec::new();
        for (pipeline, over) in &self.pipelines.stages {
            if pipeline.label == CHOOSE.name {
                steps.extend(self.twisted());
            }
            if pipeline.label == LIST_SIDES.name {
                let [_, bytes] = self.sizes.choice_bytes();
                let table = (self.source.table.clone(), 16 * self.sizes.choices_at as u64);
                steps.push(Step::Copy([(self.buffers.choices.clone(), 0), table], bytes));
            }
            let dispatches = self.dispatches(*over);
            if !dispatches.is_empty() {
                let bind = |(at, workgroups)| self.dispatch(pipeline, *over, at, workgroups);
                steps.push(pipeline.pass(dispatches.into_iter().map(bind)));
            }
        }
        steps
    }

    /// The bind groups of the draws, for each group.
    fn draws(&self) -> Vec<GroupDraws> {
        let Layouts { frame, side_data, cap_data, piece_data } = &self.pipelines.layouts;
        let bind = |layout: &wgpu::BindGroupLayout, resources: &[Resource<'_>]| {
            group(&self.pipelines.device, "shadow volumes", layout, resources)
        };
        let frame = |at: Place| {
            let first = (self.part(at) * UniformTable::stride::<ShadowShape>()) as u64;
            let VolumeBuffers { shapes, draw_lights, seen, .. } = self.buffers;
            let resources = [
                part(shapes, first..first + size_of::<ShadowShape>() as u64),
                uniform::<ShadowDraw>(draw_lights, 0),
                part(seen, 0..size_of::<SeenLight>() as u64),
                whole(self.source.table),
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
