//! The compute passes before the draws: `relist`, `bounds`, `counting_methods`, `caps`, `list_sides`, `shadow_arguments`,
//! and six optional ones. And the bind groups of the draws.

use wgpu::BindingResource;

use super::buffers::{SizedBuffers, VolumeBuffers};
use super::format::{Drawn, Polygons};
use super::pipelines::{Layouts, Part, PartDraw, VolumePipelines, layouts};
use super::sizes::{PartSizes, VolumeSizes};
use crate::gpu::common::bindings::{Resource, part, uniform, whole};
use crate::gpu::common::dispatch_limits::{is_software, loops};
use crate::gpu::common::pass::{Dispatch, Step, Workgroups};
use crate::gpu::common::pipelines::{Pipeline, Pipelines, Program, group};
use crate::gpu::common::uniforms::UniformTable;
use crate::gpu::scene::options::SceneOptions;
use crate::layout::{
    CHUNK, DrawArguments, ExtractionStatistics, LANES, PieceDraws, ShadowDraw, ShadowDraws, ShadowShape, ViewLight,
};
use crate::stages::{
    BOUNDS, CAPS, COUNTING_METHODS, LIST_SIDES, PIECE_ARGUMENTS, PIECE_CROSSINGS, RELIST, SHADOW_ARGUMENTS,
    STENCIL_BOUND, STENCIL_CROSSINGS, STENCIL_PENCIL, ZP_PLUS_2005_CASES,
};
use crate::turns::{BOUND_CHUNKS, LISTED_ITEMS};

/// The items that a stage walks along.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Over {
    /// The faces of each group whose boxes are not known.
    Boxes,
    /// All casters, lights and views in one dispatch.
    Pairs,
    /// For each group, batch and view one workgroup. The same only where there are pieces.
    One,
    OneOfPieces,
    /// For each group, batch and view its faces, edges, sides, or pieces where there are any.
    Faces,
    Edges,
    Sides,
    Pieces,
    /// For each batch and view a workgroup for each light, for all groups together.
    Lights,
}

/// The stages in their order, and what they walk along. Those from `list_sides` on read the choices in the table.
fn stages(has_pieces: bool, options: &SceneOptions) -> Vec<(Program, Over)> {
    let of = |stage, over| (Program::of(stage, &[]), over);
    let (pieces, bound) = (has_pieces, options.stencil.bound_counts);
    let stages = [
        (true, of(&RELIST, Over::One)),
        (true, of(&BOUNDS, Over::Boxes)),
        (true, of(&COUNTING_METHODS, Over::Pairs)),
        (options.counting.is_zp_plus_2005(), of(&ZP_PLUS_2005_CASES, Over::Edges)),
        (true, of(&CAPS, Over::Faces)),
        (true, of(&LIST_SIDES, Over::Sides)),
        (true, of(&SHADOW_ARGUMENTS, Over::One)),
        (pieces, of(&PIECE_ARGUMENTS, Over::OneOfPieces)),
        (bound, of(&STENCIL_PENCIL, Over::Lights)),
        (bound, of(&STENCIL_CROSSINGS, Over::Sides)),
        (bound && pieces, of(&PIECE_CROSSINGS, Over::Pieces)),
        (bound, of(&STENCIL_BOUND, Over::Lights)),
    ];
    stages.into_iter().filter(|(is_there, _)| *is_there).map(|(_, stage)| stage).collect()
}

/// The programs of these stages, in their order.
pub(crate) fn programs(has_pieces: bool, options: &SceneOptions) -> Vec<Program> {
    stages(has_pieces, options).into_iter().map(|(program, _)| program).collect()
}

/// The results of a scene's extraction, which volumes are made of.
pub(crate) struct VolumeSource<'a> {
    /// The scene table, with room for a copy of what is chosen.
    pub(crate) table: &'a wgpu::Buffer,
    /// For each group whether the boxes of its casters are known, with their rest positions.
    pub(crate) has_boxes: Vec<bool>,
    /// The resource that stages and draws bind by a name, for a group and a batch of lights.
    pub(crate) get: &'a dyn Fn(&str, usize, usize) -> Option<Resource<'a>>,
}

/// The bind groups of the draws of a group of casters, for a batch of lights.
#[derive(Debug)]
struct PartGroups {
    frame: wgpu::BindGroup,
    /// For each view those of sides and caps.
    views: Vec<[wgpu::BindGroup; 2]>,
    /// If its caster has polygons.
    pieces: Option<wgpu::BindGroup>,
}

/// The stages and draws of the volumes of some casters, with everything bound.
#[derive(Debug)]
pub(crate) struct VolumeStages {
    /// The clears before the first stage. The extraction has no part in what they clear.
    pub(crate) clears: Vec<Step>,
    /// The stages, for after the extraction.
    pub(crate) steps: Vec<Step>,
    /// For each group one for each batch of lights.
    parts: Vec<PartGroups>,
}

impl VolumeStages {
    /// Binds everything.
    pub(crate) fn new<'a>(pipelines: &'a Pipelines, buffers: &'a SizedBuffers, source: &'a VolumeSource<'a>) -> Self {
        let most = pipelines.device().limits().max_compute_workgroups_per_dimension;
        let SizedBuffers { sizes, of, .. } = buffers;
        let binder = Binder { pipelines, device: pipelines.device(), sizes, buffers: of, source, most };
        let steps = if sizes.parts.is_empty() { Vec::new() } else { binder.steps() };
        Self { clears: buffers.clears(), steps, parts: binder.draws() }
    }

    /// Draws the shadow volumes of a light in a view, for a batch of casters: all parts that a group may have. The arguments
    /// say how many instances each has.
    pub(crate) fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        pipelines: &VolumePipelines,
        SizedBuffers { sizes, of: buffers, .. }: &SizedBuffers,
        [count_batch, view, light]: [usize; 3],
    ) {
        let (batch, view_light) = (light / 32, view * sizes.lights + light);
        let uniform = (count_batch * sizes.view_lights() + view_light) * UniformTable::stride::<ShadowDraw>();
        let offsets = |part: usize| {
            [uniform, view_light * size_of::<ViewLight>(), part * UniformTable::stride::<[u32; 4]>()]
                .map(|at| at as u32)
        };
        let [first, first_piece] =
            [size_of::<ShadowDraws>(), size_of::<PieceDraws>()].map(|size| (view_light * size) as u64);
        let groups = self.parts.chunks(sizes.batches().max(1));
        let groups = groups.zip(&buffers.draws).zip(sizes.groups()).zip(&buffers.piece_draws);
        for (((batches, draws), size), piece_draws) in groups {
            let Some(PartGroups { frame, views, pieces }) = batches.get(batch) else { continue };
            let Some([sides, caps]) = views.get(view) else { continue };
            let pieces = pieces.as_ref().zip(piece_draws.as_ref());
            pass.set_bind_group(0, frame, &offsets(0));
            let parts = [
                (sizes.options.end_at_range, Part::Ends),
                (size.shape.proxies > 0, Part::Proxies),
                (true, Part::All),
                (pieces.is_some(), Part::Pieces),
            ];
            let parts = parts.into_iter().filter(|(is_drawn, _)| *is_drawn);
            let mut set = None;
            for PartDraw { drawn, pipeline, polygon_parts } in parts.flat_map(|(_, part)| pipelines.of(part)) {
                let Drawn { polygons, argument, .. } = drawn;
                let (data, arguments, first) = match (polygons, pieces) {
                    (Polygons::Pieces, Some((pieces, draws))) => (pieces, draws, first_piece),
                    (Polygons::Caps, _) => (caps, draws, first),
                    _ => (sides, draws, first),
                };
                if set != Some(*polygons) {
                    pass.set_bind_group(1, data, &[]);
                    set = Some(*polygons);
                }
                pass.set_pipeline(pipeline);
                for part in 0..*polygon_parts {
                    // Draws with one part do not read its index.
                    if *polygon_parts > 1 {
                        pass.set_bind_group(0, frame, &offsets(part as usize));
                    }
                    pass.draw_indirect(arguments, first + argument * size_of::<DrawArguments>() as u64);
                }
            }
        }
    }
}

/// The inputs for binding stages and draws.
struct Binder<'a> {
    pipelines: &'a Pipelines,
    device: &'a wgpu::Device,
    sizes: &'a VolumeSizes,
    buffers: &'a VolumeBuffers,
    source: &'a VolumeSource<'a>,
    /// The most workgroups along an axis.
    most: u32,
}

/// The group of casters, batch of lights and view of a dispatch or draw.
#[derive(Clone, Copy)]
struct Scope {
    /// The index of the group and batch among all.
    part: usize,
    group: usize,
    batch: usize,
    view: usize,
}

impl<'a> Binder<'a> {
    fn scope(&self, part: usize, view: usize) -> Scope {
        let batches = self.sizes.batches().max(1);
        Scope { part, group: part / batches, batch: part % batches, view }
    }

    /// The resource that stages bind by this name.
    fn get(&self, name: &str, scope: Scope) -> Option<Resource<'a>> {
        let Self { buffers, source, .. } = *self;
        let lists = || buffers.lists.get(scope.part)?.get(scope.view);
        // The shape, and the first light of the batch in the view.
        let shape = (scope.part * UniformTable::stride::<ShadowShape>()) as u32;
        let light = scope.view * self.sizes.lights + 32 * scope.batch;
        let draw = (light * UniformTable::stride::<ShadowDraw>()) as u32;
        Some(match name {
            "shape" => uniform::<ShadowShape>(&buffers.shapes, shape),
            "draw" => uniform::<ShadowDraw>(&buffers.draw_lights, draw),
            "view_lights" => whole(&buffers.view_lights),
            "table" => whole(source.table),
            "boxes" => whole(&buffers.boxes),
            "twisted_lights" => whole(&buffers.twisted_lights),
            "choices" => whole(&buffers.choices),
            "receivers" => whole(&buffers.receivers),
            "list_versions" => whole(&buffers.list_versions),
            "shadow_statistics" => whole(&buffers.statistics),
            "shadow_draws" => whole(buffers.draws.get(scope.group)?),
            "sides" => whole(&lists()?.sides),
            "caps_listed" => whole(&lists()?.caps),
            "piece_draws" => whole(buffers.piece_draws.get(scope.group)?.as_ref()?),
            "pencils" => whole(&buffers.bound.as_ref()?.pencils),
            "bin_rows" => whole(&buffers.bound.as_ref()?.bin_rows),
            _ => (source.get)(name, scope.group, scope.batch)?,
        })
    }

    fn dispatch(&self, pipeline: &Pipeline, scope: Scope, [x, y]: [u32; 2]) -> Dispatch {
        let workgroups = Workgroups::Known([x.min(self.most), y]);
        pipeline.dispatch(self.device, workgroups, |name| self.get(name, scope))
    }

    /// The dispatches of a stage, with their workgroups.
    fn dispatches(&self, over: Over) -> Vec<(Scope, [u32; 2])> {
        let VolumeSizes { parts, casters, views, .. } = self.sizes;
        let batches = self.sizes.batches().max(1);
        match over {
            Over::Boxes => {
                let has_boxes = |group: usize| self.source.has_boxes.get(group).is_some_and(|has_boxes| *has_boxes);
                let unknown = self.sizes.groups().enumerate().filter(|(group, _)| !has_boxes(*group));
                // An invocation takes a chunk, of more than four million faces several. So there are few atomics, and all
                // cores have work.
                let workgroups = |part: &PartSizes| {
                    let chunks = part.shape.faces.div_ceil(CHUNK);
                    [chunks.div_ceil(64).clamp(1, 1024).max(chunks.div_ceil(64 * BOUND_CHUNKS)), 1]
                };
                unknown.map(|(group, part)| (self.scope(group * batches, 0), workgroups(part))).collect()
            }
            Over::Pairs => {
                let pairs = u32::try_from(*casters as u64 * self.sizes.used_lights() as u64).unwrap_or(u32::MAX);
                let workgroups = (4 * loops(self.device, pairs)).min(pairs.div_ceil(64)).min(self.most).max(1);
                parts.iter().take(1).map(|_| (self.scope(0, 0), [workgroups, *views as u32])).collect()
            }
            Over::Lights => {
                let lights = |batch: usize| (self.sizes.lights - 32 * batch).min(32) as u32;
                // The parts of the first group.
                let batches = (0..batches).filter(|_| !parts.is_empty());
                let scopes = batches.flat_map(|batch| (0..*views).map(move |view| self.scope(batch, view)));
                scopes.map(|scope| (scope, [lights(scope.batch), 1])).collect()
            }
            _ => {
                let is_of_pieces = matches!(over, Over::Pieces | Over::OneOfPieces);
                let scopes = parts.iter().enumerate().flat_map(|(number, part)| {
                    let has_pieces = matches!(self.buffers.piece_draws.get(number / batches), Some(Some(_)));
                    let views = if is_of_pieces && !has_pieces { 0 } else { *views };
                    let workgroups = self.workgroups_of(over, part);
                    (0..views).map(move |view| (self.scope(number, view), workgroups))
                });
                scopes.collect()
            }
        }
    }

    /// The workgroups of a stage for a group, batch and view.
    fn workgroups_of(&self, over: Over, &PartSizes { shape, lights }: &PartSizes) -> [u32; 2] {
        let is_cpu = is_software(self.device);
        match over {
            Over::Faces => [loops(self.device, shape.faces.div_ceil(CHUNK) * LANES), 1],
            Over::Edges => [fewest(shape.edges).max(1), lights],
            Over::Sides => [workgroups_of_sides(&shape, lights, is_cpu), lights],
            Over::Pieces => [if is_cpu { 4 } else { 64 }.max(fewest(shape.piece_capacity)), lights],
            _ => [1, 1],
        }
    }

    /// For each group and batch with polygons, a copy of the lights for which they are twisted to where
    /// `counting_methods` reads them.
    fn twisted(&self) -> Vec<Step> {
        let copy = |part: usize| {
            let Scope { group, batch, .. } = self.scope(part, 0);
            let named = |name: &str| (self.source.get)(name, group, batch);
            named("pieces")?;
            let BindingResource::Buffer(statistics) = named("extraction_statistics")?.bound else { return None };
            let from = statistics.offset + std::mem::offset_of!(ExtractionStatistics, twisted_lights) as u64;
            let to = 4 * part as u64;
            Some(Step::Copy([(statistics.buffer.clone(), from), (self.buffers.twisted_lights.clone(), to)], 4))
        };
        (0..self.sizes.parts.len()).filter_map(copy).collect()
    }

    /// The stages. Before `list_sides` the choices are complete, and are copied to the table.
    fn steps(&self) -> Vec<Step> {
        let mut steps = Vec::new();
        let VolumeSizes { parts, options, .. } = self.sizes;
        let has_pieces = parts.iter().any(|part| part.shape.piece_capacity > 0);
        self.pipelines.make_together(&programs(has_pieces, options));
        for (program, over) in stages(has_pieces, options) {
            let pipeline = &self.pipelines.get(&program);
            if pipeline.label == COUNTING_METHODS.name {
                steps.extend(self.twisted());
            }
            if pipeline.label == LIST_SIDES.name {
                let [_, bytes] = self.sizes.choice_bytes();
                let table = (self.source.table.clone(), 16 * self.sizes.choices_offset as u64);
                steps.push(Step::Copy([(self.buffers.choices.clone(), 0), table], bytes));
            }
            let dispatches = self.dispatches(over);
            if !dispatches.is_empty() {
                let bind = |(scope, workgroups)| self.dispatch(pipeline, scope, workgroups);
                steps.push(pipeline.pass(dispatches.into_iter().map(bind)));
            }
        }
        steps
    }

    /// The bind groups of the draws, for each group and batch.
    fn draws(&self) -> Vec<PartGroups> {
        let Layouts { frame, side_data, cap_data, piece_data } = &layouts(self.pipelines);
        let VolumeBuffers { shapes, draw_lights, view_lights, polygon_parts, .. } = self.buffers;
        let bind = |layout: &wgpu::BindGroupLayout, resources: &[Resource<'_>]| {
            group(self.device, "shadow volumes", layout, resources)
        };
        let data = |layout: &wgpu::BindGroupLayout, names: &[&str], scope: Scope| {
            let resources: Vec<_> = names.iter().filter_map(|name| self.get(name, scope)).collect();
            bind(layout, &resources)
        };
        let side_names = ["positions", "edge_vertices", "edge_faces", "facing_masks", "excluded_masks", "sides"];
        let cap_names = ["positions", "faces", "facing_masks", "excluded_masks", "caps_listed"];
        let of_part = |number: usize| {
            let first = (number * UniformTable::stride::<ShadowShape>()) as u64;
            let resources = [
                part(shapes, first..first + size_of::<ShadowShape>() as u64),
                uniform::<ShadowDraw>(draw_lights, 0),
                part(view_lights, 0..size_of::<ViewLight>() as u64),
                whole(self.source.table),
                uniform::<[u32; 4]>(polygon_parts, 0),
            ];
            let of_view = |view: usize| {
                let scope = self.scope(number, view);
                [data(side_data, &side_names, scope), data(cap_data, &cap_names, scope)]
            };
            PartGroups {
                frame: bind(frame, &resources),
                views: (0..self.sizes.views).map(of_view).collect(),
                pieces: self.get("pieces", self.scope(number, 0)).map(|pieces| bind(piece_data, &[pieces])),
            }
        };
        (0..self.sizes.parts.len()).map(of_part).collect()
    }
}

/// The fewest workgroups of 64 invocations that take no more than [`LISTED_ITEMS`] each.
fn fewest(items: u32) -> u32 {
    items.div_ceil(64 * LISTED_ITEMS)
}

/// The workgroups that share the silhouettes or sides of a light, or all edges. A side of weight 2 is listed twice, so
/// there may be more sides than edges.
fn workgroups_of_sides(shape: &ShadowShape, lights: u32, is_cpu: bool) -> u32 {
    // An invocation takes some sixteen silhouettes of a full list, or more of a long one.
    let most = if is_cpu { 64_u32.div_ceil(lights).max(4) } else { 256 };
    shape.capacity.div_ceil(16 * 64).clamp(1, most).max(fewest(shape.edges.max(shape.side_capacity)))
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable;

    use super::*;

    /// Every edge has a side of weight 2.
    #[test]
    fn invocations_take_no_more_sides_than_loops_have_turns() {
        let edges = 1 << 23;
        let shape = ShadowShape { edges, capacity: edges, side_capacity: 2 * edges, ..ShadowShape::zeroed() };
        for is_cpu in [false, true] {
            let workgroups = workgroups_of_sides(&shape, 32, is_cpu);
            assert!(64 * LISTED_ITEMS * workgroups >= 2 * edges, "{workgroups}");
        }
    }
}
