//! The shadow depth query: the number of faces strictly between each point and each light.

use std::ops::Range;

use wgpu::BufferUsages;

use super::errors::QueryError;
use super::options::ShadowQueryOptions;
use super::plan::{
    CLUSTER, GROUP, cluster_chunks, cluster_run, most_queries, point_chunks, range_clusters, undecided_bytes,
    workgroups,
};
use super::points::QueryPoints;
use crate::cpu::query::shadow_boxes::{self, cluster_count, largest_polygon};
use crate::gpu::common::device_error::DeviceError;
use crate::gpu::common::dispatch_limits::{DispatchLimits, binding};
use crate::gpu::common::memory::{Allocation, buffer, check, filled, guarded, padded};
use crate::gpu::common::pipelines::{Pipeline, Pipelines};
use crate::gpu::common::positions::{BoundPositions, PositionBuffer};
use crate::gpu::common::requirements::{Subject, check_alive, check_timer};
use crate::gpu::common::timer::StageTimer;
use crate::gpu::common::uniforms::{UniformTable, entry};
use crate::gpu::extract::extraction::Extraction;
use crate::layout::{FaceCluster, FaceRange, LightBatch, PointChunk};
use crate::light::{check_room, check_shadow_lights};
use crate::mesh::MeshId;
use crate::stages::{DEPTH_ARGUMENTS, EXACT_SHADOW_DEPTH, SHADOW_BOXES, SHADOW_DEPTH, Stage};
use crate::{Light, Mesh};

/// Counts the faces of one mesh that lie strictly between points and lights. Each face counts once, whatever its
/// orientation and whatever the mesh. A polygon counts once if an odd number of its triangles lie between. On a closed mesh the
/// parity tells inside from outside. A point in shadow has a depth above 0. The depths equal those of
/// [`crate::cpu::shadow_depth`] on every device; that function describes how ties are broken. Points on the surface may name
/// their face ([`QueryPoints`]), or be moved off it before ([`Light::lift`]).
///
/// The query records compute passes into the caller's encoder. Every face is tested against every pair of point and
/// light, except for faces that the boxes leave out.
#[derive(Debug)]
pub struct ShadowQuery {
    split: DispatchLimits,
    mesh: MeshId,
    vertices: u32,
    clusters: usize,
    cluster_buffer: wgpu::Buffer,
    depths: wgpu::Buffer,
    undecided_pairs: wgpu::Buffer,
    /// The indirect dispatch of the recount.
    recount_dispatch: wgpu::Buffer,
    /// The number of pairs of point and light that `undecided_pairs` has room for.
    most_queries: u64,
    pipelines: Pipelines,
    passes: Passes,
    options: ShadowQueryOptions,
}

/// The pipelines for one kind of query.
#[derive(Debug)]
struct Passes {
    kind: PassKind,
    boxes: Pipeline,
    depth: Pipeline,
    exact: Pipeline,
    arguments: Pipeline,
    recount: Pipeline,
}

/// The constants that specialise shaders. Where points name no face, the inner loop has no test of it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PassKind {
    skip_by_boxes: bool,
    /// Whether a polygon has several triangles.
    has_polygons: bool,
    /// Whether points name their faces.
    names_faces: bool,
    window_words: u32,
}

impl Passes {
    fn new(pipelines: &Pipelines, kind: PassKind) -> Self {
        let PassKind { skip_by_boxes, has_polygons, names_faces, window_words } = kind;
        let windows = ("WINDOW_WORDS", f64::from(window_words));
        let skip = ("SKIP", f64::from(u8::from(skip_by_boxes)));
        let polygons = ("POLYGONS", f64::from(u8::from(has_polygons)));
        let names = ("NAMES_FACES", f64::from(u8::from(names_faces)));
        let pair = |stage: &'static Stage, entry_point: usize| {
            pipelines.compute(stage, stage.entry_points[entry_point], &[windows, skip, polygons, names])
        };
        let (boxes, arguments) = (&SHADOW_BOXES, &DEPTH_ARGUMENTS);
        let most = [("MOST_WORKGROUPS", f64::from(pipelines.device().limits().max_compute_workgroups_per_dimension))];
        Self {
            boxes: pipelines.compute(boxes, boxes.name, &[windows]),
            depth: pair(&SHADOW_DEPTH, 0),
            exact: pair(&EXACT_SHADOW_DEPTH, 0),
            arguments: pipelines.compute(arguments, arguments.name, &most),
            recount: pair(&EXACT_SHADOW_DEPTH, 1),
            kind,
        }
    }
}

impl ShadowQuery {
    /// Uploads the faces of the mesh and makes buffers on the caller's device. `pipelines` is that device, or the
    /// [`Pipelines`] that many meshes share.
    ///
    /// # Errors
    /// [`QueryError`] if the device lacks what the query needs, the number of lights is impossible, or the mesh
    /// or the results do not fit the device's limits, the `memory_limit` or the device's memory.
    pub fn new(pipelines: impl Into<Pipelines>, mesh: &Mesh, options: ShadowQueryOptions) -> Result<Self, QueryError> {
        let pipelines = pipelines.into();
        pipelines.clone().construct(Subject::Query, || Self::with(pipelines, mesh, options))
    }

    fn with(pipelines: Pipelines, mesh: &Mesh, options: ShadowQueryOptions) -> Result<Self, QueryError> {
        let device = pipelines.device();
        let ShadowQueryOptions { max_points, max_lights, skip_by_boxes, memory_limit, .. } = options;
        check_room(max_lights)?;
        let split = DispatchLimits::new(&device.limits());
        let run = cluster_run(&split)?;
        let faces = largest_polygon(mesh);
        if faces > run * CLUSTER {
            let bytes = (faces.div_ceil(CLUSTER) * size_of::<FaceCluster>()) as u64;
            return Err(DeviceError::BindingTooLarge {
                what: "the triangles of a polygon",
                bytes,
                limit: split.binding,
            }
            .into());
        }
        let clusters = cluster_count(mesh, run);
        let max_points = max_points.max(1);
        let most_queries = most_queries(&split, max_points, max_lights);
        point_chunks(&split, most_queries, max_points, max_lights, 12)?;
        let cluster_bytes = (clusters * size_of::<FaceCluster>()) as u64;
        let depth_bytes = u64::from(max_points) * max_lights as u64 * 4;
        let undecided_bytes = undecided_bytes(most_queries);
        let wanted = [("face clusters", cluster_bytes), ("depths", depth_bytes), ("undecided pairs", undecided_bytes)];
        let bytes = check(
            &wanted.map(|(label, bytes)| Allocation { label, bytes: padded(bytes) }),
            split.buffer,
            memory_limit,
        )?;
        let kind = PassKind { skip_by_boxes, has_polygons: faces > 1, names_faces: false, window_words: 0 };
        let storage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let [cluster_buffer, depths, undecided_pairs, recount_dispatch] = guarded(device, bytes, || {
            [
                filled(device, "face clusters", bytemuck::cast_slice(&shadow_boxes::clusters(mesh, run)), storage),
                buffer(device, "depths", depth_bytes, storage),
                buffer(device, "undecided pairs", undecided_bytes, storage),
                buffer(device, "recount dispatch", 12, storage | BufferUsages::INDIRECT),
            ]
        })?;
        Ok(Self {
            split,
            mesh: mesh.id(),
            vertices: mesh.vertex_count(),
            clusters,
            cluster_buffer,
            depths,
            undecided_pairs,
            recount_dispatch,
            most_queries,
            passes: Passes::new(&pipelines, kind),
            pipelines,
            options,
        })
    }

    /// Records the query for the first `point_count` of `points`, with the positions and lights of an extraction.
    /// Points are in the space of the positions. [`Self::encode_at`] needs no extraction.
    ///
    /// # Errors
    /// [`QueryError`] if the extraction belongs to another mesh or is out of date, or if lights or points
    /// are refused. Nothing is recorded then.
    pub fn encode<'p>(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        extraction: &Extraction,
        points: impl Into<QueryPoints<'p>>,
        point_count: u32,
        timer: Option<&mut StageTimer>,
    ) -> Result<(), QueryError> {
        if extraction.shared.mesh != self.mesh {
            return Err(QueryError::OtherMesh);
        }
        extraction.check_current()?;
        self.encode_at(encoder, extraction.positions(), points, point_count, extraction.lights(), timer)
    }

    /// Records the query for the first `point_count` of `points` and for `lights`, all in the space of the positions.
    /// Several encodes in one encoder are allowed; each overwrites the depths of the one before. No lights or no points
    /// are allowed; there are no depths then. `points` is a [`PositionBuffer`], or [`QueryPoints`] that name the faces that they are
    /// on. `timer` takes a timestamp around each stage.
    ///
    /// # Errors
    /// [`QueryError`] if lights, positions or points are refused, or the device is lost or not the timer's.
    /// Nothing is recorded then.
    pub fn encode_at<'p>(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        positions: PositionBuffer<'_>,
        points: impl Into<QueryPoints<'p>>,
        point_count: u32,
        lights: &[Light],
        mut timer: Option<&mut StageTimer>,
    ) -> Result<(), QueryError> {
        check_shadow_lights(lights, self.options.max_lights)?;
        let limit = self.options.max_points;
        if point_count > limit {
            return Err(QueryError::TooManyPoints { count: point_count, limit });
        }
        let bound = positions.bind(self.vertices, &self.split)?;
        let given: QueryPoints<'p> = points.into();
        given.check(point_count)?;
        let points = given.points;
        check_timer(timer.as_deref(), self.pipelines.device())?;
        check_alive(self.pipelines.device())?;
        self.pipelines.check_bindable(positions.buffer)?;
        self.pipelines.check_bindable(points.buffer).map_err(QueryError::Points)?;
        if lights.is_empty() {
            return Ok(());
        }
        let clusters = cluster_chunks(&self.split, self.clusters)?;
        let chunks = point_chunks(&self.split, self.most_queries, point_count, lights.len(), points.stride)
            .map_err(QueryError::Points)?;
        let (names_faces, window_words) = (given.on_face.is_some(), bound.windows.words);
        let kind = PassKind { names_faces, window_words, ..self.passes.kind };
        if self.passes.kind != kind {
            self.passes = Passes::new(&self.pipelines, kind);
        }
        let Some(most) = chunks.first().map(ExactSizeIterator::len) else { return Ok(()) };
        let batch_lights = lights.len().min(32) as u64;
        let range = range_clusters(&self.split, self.options.work_per_dispatch, most as u64 * batch_lights);
        let tables = Tables::new(self, &bound, given, &chunks, &clusters, lights, range);

        let mut pass = begin(encoder, SHADOW_BOXES.name, timer.as_deref_mut());
        pass.set_pipeline(&self.passes.boxes.compute);
        for (clusters, &whole) in clusters.iter().zip(&tables.whole_ranges) {
            let mut resources =
                vec![("batch", entry::<LightBatch>(&tables.batches)), ("range", entry::<FaceRange>(&tables.ranges))];
            resources.extend(bound.bindings(positions.buffer));
            resources.push(("clusters", binding(&self.cluster_buffer, cluster_bytes(clusters))));
            pass.set_bind_group(0, &self.passes.boxes.bind(self.pipelines.device(), &resources), &[0, whole]);
            pass.dispatch_workgroups(clusters.len().div_ceil(GROUP) as u32, 1, 1);
        }
        drop(pass);
        let mut pass = begin(encoder, SHADOW_DEPTH.name, timer);
        let arguments = self.passes.arguments.bind(
            self.pipelines.device(),
            &[
                ("range", entry::<FaceRange>(&tables.ranges)),
                ("undecided_pairs", binding(&self.undecided_pairs, 0..undecided_bytes(self.most_queries))),
                ("dispatch", binding(&self.recount_dispatch, 0..12)),
            ],
        );
        for (points_at, chunk) in (0_u64..).zip(&chunks) {
            for (clusters, ranges) in clusters.iter().zip(&tables.sub_ranges) {
                let resources =
                    self.pair_resources(&tables, &bound, [positions, points], chunk, clusters, lights.len());
                let bind = |pipeline: &Pipeline| pipeline.bind(self.pipelines.device(), &resources);
                let Passes { depth, exact, recount, .. } = &self.passes;
                let groups = [(depth, bind(depth)), (exact, bind(exact)), (recount, bind(recount))];
                for (batch, lights) in (0_u64..).zip(lights.chunks(32)) {
                    let pairs = chunk.len() as u64 * lights.len() as u64;
                    let chunk_offset = tables.chunk_offset(batch, points_at);
                    let batch_offset = batch as u32 * UniformTable::stride::<LightBatch>() as u32;
                    for &range in ranges {
                        for (pipeline, group) in &groups {
                            if pipeline.label == recount.label {
                                pass.set_pipeline(&self.passes.arguments.compute);
                                pass.set_bind_group(0, &arguments, &[range]);
                                pass.dispatch_workgroups(1, 1, 1);
                            }
                            pass.set_pipeline(&pipeline.compute);
                            pass.set_bind_group(0, group, &[batch_offset, chunk_offset, range]);
                            if pipeline.label == recount.label {
                                pass.dispatch_workgroups_indirect(&self.recount_dispatch, 0);
                            } else {
                                pass.dispatch_workgroups(workgroups(pairs), 1, 1);
                            }
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// The resources of the stages that work on pairs of point and light, for a run of points and a run of clusters.
    fn pair_resources<'a>(
        &'a self,
        tables: &'a Tables,
        bound: &BoundPositions,
        [positions, points]: [PositionBuffer<'a>; 2],
        chunk: &Range<u32>,
        clusters: &Range<usize>,
        lights: usize,
    ) -> Vec<(&'static str, wgpu::BindingResource<'a>)> {
        let first_byte = points.offset + u64::from(chunk.start) * points.stride;
        let end = (first_byte + chunk.len() as u64 * points.stride).min(points.buffer.size());
        let depths = [chunk.start, chunk.end].map(|point| u64::from(point) * 4 * lights as u64);
        let mut resources =
            vec![("batch", entry::<LightBatch>(&tables.batches)), ("chunk", entry::<PointChunk>(&tables.chunks))];
        resources.extend(bound.bindings(positions.buffer));
        resources.extend([
            ("range", entry::<FaceRange>(&tables.ranges)),
            ("clusters", binding(&self.cluster_buffer, cluster_bytes(clusters))),
            ("points", binding(points.buffer, self.split.align_down(first_byte)..end)),
            ("depths", binding(&self.depths, depths[0]..depths[1])),
            ("undecided_pairs", binding(&self.undecided_pairs, 0..undecided_bytes(self.most_queries))),
        ]);
        resources
    }

    /// The depths, once the encoder was submitted: one `i32` for each pair. Points follow each other, and each point
    /// has one number for each light of that encode. A point that is infinite or NaN has −1. Usages `STORAGE`,
    /// `COPY_SRC` and `COPY_DST`.
    pub fn depths(&self) -> &wgpu::Buffer {
        &self.depths
    }

    /// The faces of the mesh in clusters, with the boxes of the last encode: one `FaceCluster` for each cluster. The
    /// usages are those of [`Self::depths`].
    #[cfg(feature = "reference")]
    pub fn clusters(&self) -> &wgpu::Buffer {
        &self.cluster_buffer
    }
}

/// Begins a compute pass.
fn begin<'encoder>(
    encoder: &'encoder mut wgpu::CommandEncoder,
    label: &'static str,
    timer: Option<&mut StageTimer>,
) -> wgpu::ComputePass<'encoder> {
    let timestamp_writes = timer.and_then(|timer| timer.compute_pass(label));
    encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some(label), timestamp_writes })
}

fn cluster_bytes(clusters: &Range<usize>) -> Range<u64> {
    let bytes = size_of::<FaceCluster>() as u64;
    clusters.start as u64 * bytes..clusters.end as u64 * bytes
}

/// The uniforms of one encode. They have their own buffers, so an encoder may hold several encodes.
struct Tables {
    batches: wgpu::Buffer,
    chunks: wgpu::Buffer,
    ranges: wgpu::Buffer,
    point_chunks: u64,
    /// Dynamic offsets in `ranges`: for each chunk of clusters that of the whole chunk, and those of its parts.
    whole_ranges: Vec<u32>,
    sub_ranges: Vec<Vec<u32>>,
}

impl Tables {
    fn new(
        query: &ShadowQuery,
        bound: &BoundPositions,
        QueryPoints { points, on_face }: QueryPoints<'_>,
        chunks: &[Range<u32>],
        clusters: &[Range<usize>],
        lights: &[Light],
        range: usize,
    ) -> Self {
        let mut batches = UniformTable::default();
        let mut chunk_table = UniformTable::default();
        for (first_light, batch) in (0..).step_by(32).zip(lights.chunks(32)) {
            batches.push(&LightBatch::new(batch, bound.offset_words, bound.stride_words));
            for chunk in chunks {
                let first_byte = points.offset + u64::from(chunk.start) * points.stride;
                chunk_table.push(&PointChunk {
                    count: chunk.len() as u32,
                    offset: ((first_byte - query.split.align_down(first_byte)) / 4) as u32,
                    stride: (points.stride / 4) as u32,
                    lights: lights.len() as u32,
                    first_light,
                    on_face: on_face.map_or(0, |bytes| (bytes / 4) as u32),
                });
            }
        }
        let mut ranges = UniformTable::default();
        let mut push = |first: usize, end: usize, is_first: bool| {
            let before = first.saturating_sub(range) as u32;
            ranges.push(&FaceRange { first: first as u32, end: end as u32, is_first: u32::from(is_first), before })
        };
        let whole_ranges = clusters.iter().map(|chunk| push(0, chunk.len(), false)).collect();
        let sub_ranges = clusters
            .iter()
            .map(|chunk| {
                let firsts = (0..chunk.len()).step_by(range);
                firsts.map(|first| push(first, (first + range).min(chunk.len()), chunk.start + first == 0)).collect()
            })
            .collect();
        Self {
            batches: batches.into_buffer(query.pipelines.device(), "light batches"),
            chunks: chunk_table.into_buffer(query.pipelines.device(), "point chunks"),
            ranges: ranges.into_buffer(query.pipelines.device(), "face ranges"),
            point_chunks: chunks.len() as u64,
            whole_ranges,
            sub_ranges,
        }
    }

    /// The dynamic offset for a run of points and a batch of lights.
    fn chunk_offset(&self, batch: u64, chunk: u64) -> u32 {
        ((batch * self.point_chunks + chunk) * UniformTable::stride::<PointChunk>() as u64) as u32
    }
}
