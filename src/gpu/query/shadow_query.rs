//! Queries of occluder counts: the number of faces strictly between each point and each light.

use std::ops::Range;

use super::errors::QueryError;
use super::options::ShadowQueryOptions;
use super::plan::{
    GROUP, cluster_chunks, cluster_range, most_queries, point_chunks, range_clusters, undecided_bytes, workgroups,
};
use super::points::QueryPoints;
use crate::cpu::query::shadow_boxes::{self, CLUSTER, largest_polygon};
use crate::gpu::common::bindings::{Resource, part, uniform};
use crate::gpu::common::device_error::DeviceError;
use crate::gpu::common::dispatch_limits::DispatchLimits;
use crate::gpu::common::memory::{check, guarded};
use crate::gpu::common::pass::{Dispatch, Workgroups, record};
use crate::gpu::common::pipelines::{Pipeline, Pipelines, switch};
use crate::gpu::common::positions::{BoundPositions, PositionBuffer};
use crate::gpu::common::readback::read_back_first;
use crate::gpu::common::requirements::{Subject, check_alive, check_timer};
use crate::gpu::common::timer::StageTimer;
use crate::gpu::common::uniforms::UniformTable;
use crate::gpu::common::wanted::{Account, Wanted};
use crate::gpu::extract::extraction::Extraction;
use crate::layout::{FaceCluster, FaceRange, LightBatch, PointChunk};
use crate::light::{check_room, check_shadow_lights};
use crate::mesh::MeshId;
use crate::stages::{DEPTH_ARGUMENTS, EXACT_SHADOW_DEPTH, SHADOW_BOXES, SHADOW_DEPTH};
use crate::{Light, Mesh};

/// Counts the faces of one mesh that lie strictly between points and lights. Each face counts once, in either
/// orientation and in any mesh. A polygon counts once if an odd number of its triangles lie between. On a closed mesh
/// the parity is that of inside and outside. A point in shadow has a depth above 0. The depths equal those of
/// [`crate::cpu::shadow_depth`] on every device; that function describes how ties are broken. Points on the surface may name
/// their face ([`QueryPoints`]), or be moved off it before ([`Light::lift`]). Ranges and cones of lights are ignored. For
/// several meshes add the depths of a query for each, in its own space ([`Light::to_mesh_space`]).
///
/// The query records compute passes into the caller's encoder. Every face is tested against every pair of point and
/// light, except for faces that the boxes leave out.
#[derive(Debug)]
pub struct ShadowQuery {
    split: DispatchLimits,
    mesh: MeshId,
    vertices: u32,
    clusters: usize,
    buffers: Buffers,
    /// The number of pairs of point and light that `undecided_pairs` has room for.
    most_queries: u64,
    pipelines: Pipelines,
    /// Whether a polygon has several triangles.
    has_polygons: bool,
    options: ShadowQueryOptions,
    /// The number of pairs of the last encode.
    pairs: u64,
}

/// The buffers of a query.
#[derive(Debug)]
struct Buffers<B = wgpu::Buffer> {
    clusters: B,
    depths: B,
    undecided_pairs: B,
    /// The indirect dispatch of the recount.
    recount_dispatch: B,
}

impl<B> Buffers<B> {
    fn plan(
        clusters: &[FaceCluster],
        [depths, undecided_pairs]: [u64; 2],
        mut make: impl FnMut(Wanted<'_>) -> B,
    ) -> Self {
        Self {
            clusters: make(Wanted::filled("face clusters", bytemuck::cast_slice(clusters))),
            depths: make(Wanted::new("depths", depths)),
            undecided_pairs: make(Wanted::new("undecided pairs", undecided_pairs)),
            recount_dispatch: make(Wanted::new("recount dispatch", 12).indirect().free()),
        }
    }
}

/// The pipelines of a query.
struct Stages {
    boxes: Pipeline,
    depth: Pipeline,
    exact: Pipeline,
    /// The arguments of the recount.
    arguments: Pipeline,
    recount: Pipeline,
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
        let ShadowQueryOptions { max_points, max_lights, memory_limit, .. } = options;
        check_room(max_lights)?;
        let split = DispatchLimits::new(&device.limits());
        let range = cluster_range(&split)?;
        let faces = largest_polygon(mesh);
        if faces > range * CLUSTER {
            let (what, limit) = ("the triangles of a polygon", split.binding);
            let bytes = (faces.div_ceil(CLUSTER) * size_of::<FaceCluster>()) as u64;
            return Err(DeviceError::BindingTooLarge { what, bytes, limit }.into());
        }
        let max_points = max_points.max(1);
        let most_queries = most_queries(&split, max_points, max_lights);
        point_chunks(&split, most_queries, max_points, max_lights, 12)?;
        let mut clusters = shadow_boxes::clusters(mesh, range);
        if clusters.is_empty() {
            // A mesh without triangles has a cluster without a face. Else no dispatch would write the counts of its points.
            clusters.push(bytemuck::Zeroable::zeroed());
        }
        let sizes = [u64::from(max_points) * max_lights as u64 * 4, undecided_bytes(most_queries)];
        let mut account = Account::default();
        Buffers::<()>::plan(&clusters, sizes, |wanted| account.note(&wanted));
        let bytes = check(&account.all, split.buffer, memory_limit)?;
        let buffers = guarded(device, bytes, || Buffers::plan(&clusters, sizes, |wanted| wanted.make(device)))?;
        let query = Self {
            split,
            mesh: mesh.id,
            vertices: mesh.vertex_count(),
            clusters: clusters.len(),
            buffers,
            most_queries,
            pipelines,
            has_polygons: faces > 1,
            options,
            pairs: 0,
        };
        // Compiles them here, and an error is that of this constructor.
        query.stages(false, 0);
        Ok(query)
    }

    /// The stages. Where points name no face, the inner loop has no test of it.
    fn stages(&self, names_faces: bool, window_words: u32) -> Stages {
        let windows = ("WINDOW_WORDS", f64::from(window_words));
        let skip = ("SKIP", switch(self.options.skip_by_boxes));
        let pairs = [windows, skip, ("POLYGONS", switch(self.has_polygons)), ("NAMES_FACES", switch(names_faces))];
        let most = self.pipelines.device().limits().max_compute_workgroups_per_dimension;
        let most = ("MOST_WORKGROUPS", f64::from(most));
        Stages {
            boxes: self.pipelines.compute(&SHADOW_BOXES, SHADOW_BOXES.name, &[windows]),
            depth: self.pipelines.compute(&SHADOW_DEPTH, SHADOW_DEPTH.name, &pairs),
            exact: self.pipelines.compute(&EXACT_SHADOW_DEPTH, "exact_shadow_depth", &pairs),
            arguments: self.pipelines.compute(&DEPTH_ARGUMENTS, DEPTH_ARGUMENTS.name, &[most]),
            recount: self.pipelines.compute(&EXACT_SHADOW_DEPTH, "exact_shadow_depth_recount", &pairs),
        }
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
    ) -> Result<(), QueryError> {
        if extraction.shared.mesh != self.mesh {
            return Err(QueryError::OtherMesh);
        }
        extraction.check_current()?;
        self.encode_at(encoder, extraction.positions(), points, point_count, extraction.lights())
    }

    /// Records the query for the first `point_count` of `points` and for `lights`, all in the space of the positions.
    /// Several encodes in one encoder are allowed; each overwrites the depths of the one before. No lights or no points
    /// are allowed; there are no depths then. `points` is a [`PositionBuffer`], or [`QueryPoints`] that name the faces
    /// that they are on.
    ///
    /// # Errors
    /// [`QueryError`] if lights, positions or points are refused, or the device is lost. Nothing is recorded then.
    pub fn encode_at<'p>(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        positions: PositionBuffer<'_>,
        points: impl Into<QueryPoints<'p>>,
        point_count: u32,
        lights: &[Light],
    ) -> Result<(), QueryError> {
        self.encode_timed(encoder, positions, points, point_count, lights, None)
    }

    /// The same with a timestamp around each stage.
    ///
    /// # Errors
    /// The errors of [`Self::encode_at`], and [`QueryError::Device`] for a timer of another device.
    pub fn encode_timed<'p>(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        positions: PositionBuffer<'_>,
        points: impl Into<QueryPoints<'p>>,
        point_count: u32,
        lights: &[Light],
        timer: Option<&mut StageTimer>,
    ) -> Result<(), QueryError> {
        let points: QueryPoints<'p> = points.into();
        let bound = self.check_inputs(positions, points, point_count, lights, timer.as_deref())?;
        let pairs = u64::from(point_count) * lights.len() as u64;
        if pairs == 0 {
            self.pairs = 0;
            return Ok(());
        }
        let clusters = cluster_chunks(&self.split, self.clusters)?;
        let stride = points.points.stride;
        let chunks = point_chunks(&self.split, self.most_queries, point_count, lights.len(), stride)
            .map_err(QueryError::Points)?;
        self.pairs = pairs;
        let Some(most) = chunks.first().map(ExactSizeIterator::len) else { return Ok(()) };
        let batch_lights = lights.len().min(32) as u64;
        let range = range_clusters(&self.split, self.options.work_per_dispatch, most as u64 * batch_lights);
        let work = Work { bound, positions, points, lights, clusters, chunks };
        let tables = Tables::new(self, &work, range);
        let stages = self.stages(points.on_face.is_some(), work.bound.windows.words);
        let over_boxes = self.box_dispatches(&stages.boxes, &work, &tables);
        let pairs = self.pair_dispatches(&stages, &work, &tables);
        record([&stages.boxes.pass(over_boxes), &stages.depth.pass(pairs)], encoder, timer);
        Ok(())
    }

    /// Checks the inputs of an encode. Returns how the stages bind the positions.
    fn check_inputs(
        &self,
        positions: PositionBuffer<'_>,
        points: QueryPoints<'_>,
        point_count: u32,
        lights: &[Light],
        timer: Option<&StageTimer>,
    ) -> Result<BoundPositions, QueryError> {
        check_shadow_lights(lights, self.options.max_lights)?;
        let limit = self.options.max_points;
        if point_count > limit {
            return Err(QueryError::TooManyPoints { count: point_count, limit });
        }
        let bound = positions.bind(self.vertices, &self.split)?;
        points.check(point_count)?;
        check_timer(timer, self.pipelines.device())?;
        check_alive(self.pipelines.device())?;
        self.pipelines.check_bindable(positions.buffer)?;
        self.pipelines.check_bindable(points.points.buffer).map_err(QueryError::Points)?;
        Ok(bound)
    }

    /// The dispatches that compute boxes: one for each range of clusters.
    fn box_dispatches(&self, boxes: &Pipeline, work: &Work<'_>, tables: &Tables) -> Vec<Dispatch> {
        let dispatch = |(clusters, &whole): (&Range<usize>, &u32)| {
            let at = At { clusters, points: 0..0, offsets: [0, 0, whole] };
            let workgroups = Workgroups::Known([clusters.len().div_ceil(GROUP) as u32, 1]);
            boxes.dispatch(self.pipelines.device(), workgroups, |name| self.get(name, work, tables, &at))
        };
        work.clusters.iter().zip(&tables.whole_ranges).map(dispatch).collect()
    }

    /// The dispatches over pairs: four for each range of points, batch of lights and part of a range of clusters.
    fn pair_dispatches(&self, stages: &Stages, work: &Work<'_>, tables: &Tables) -> Vec<Dispatch> {
        let device = self.pipelines.device();
        let mut pairs = Vec::new();
        for (points_at, chunk) in (0_u64..).zip(&work.chunks) {
            for (clusters, ranges) in work.clusters.iter().zip(&tables.sub_ranges) {
                let at = At { clusters, points: chunk.clone(), offsets: [0; 3] };
                let bind = |pipeline: &Pipeline| {
                    let written = Workgroups::Written(self.buffers.recount_dispatch.clone(), 0);
                    pipeline.dispatch(device, written, |name| self.get(name, work, tables, &at))
                };
                let Stages { depth, exact, arguments, recount, .. } = stages;
                let [depth, exact, arguments, recount] = [depth, exact, arguments, recount].map(bind);
                for (batch, lights) in (0_u64..).zip(work.lights.chunks(32)) {
                    let batch_offset = batch as u32 * UniformTable::stride::<LightBatch>() as u32;
                    let chunk_offset = tables.chunk_offset(batch, points_at);
                    let all = Workgroups::Known([workgroups(chunk.len() as u64 * lights.len() as u64), 1]);
                    // Innermost, because each leaves parities of polygons to the next, pair by pair.
                    for &range in ranges {
                        let offsets = vec![batch_offset, chunk_offset, range];
                        let (one, of_range) = (Workgroups::Known([1, 1]), vec![range]);
                        pairs.extend([
                            Dispatch { offsets: offsets.clone(), workgroups: all.clone(), ..depth.clone() },
                            Dispatch { offsets: offsets.clone(), workgroups: all.clone(), ..exact.clone() },
                            Dispatch { offsets: of_range, workgroups: one, ..arguments.clone() },
                            Dispatch { offsets, ..recount.clone() },
                        ]);
                    }
                }
            }
        }
        pairs
    }

    fn get<'a>(&'a self, name: &str, work: &Work<'a>, tables: &'a Tables, at: &At<'_>) -> Option<Resource<'a>> {
        let Work { bound, positions, points: QueryPoints { points, .. }, .. } = work;
        let Buffers { clusters, depths, undecided_pairs, recount_dispatch } = &self.buffers;
        let [batch, chunk, range] = at.offsets;
        let bytes = |clusters: usize| (clusters * size_of::<FaceCluster>()) as u64;
        let byte = |point: u32| points.offset + u64::from(point) * points.stride;
        let depth = |point: u32| u64::from(point) * 4 * tables.lights;
        Some(match name {
            "batch" => uniform::<LightBatch>(&tables.batches, batch),
            "chunk" => uniform::<PointChunk>(&tables.chunks, chunk),
            "range" => uniform::<FaceRange>(&tables.ranges, range),
            "clusters" => part(clusters, bytes(at.clusters.start)..bytes(at.clusters.end)),
            "points" => {
                // The last point may end before its stride does, and a binding has whole words.
                let end = byte(at.points.end).min(points.buffer.size() / 4 * 4);
                part(points.buffer, self.split.align_down(byte(at.points.start))..end)
            }
            "depths" => part(depths, depth(at.points.start)..depth(at.points.end)),
            "undecided_pairs" => part(undecided_pairs, 0..undecided_bytes(self.most_queries)),
            "dispatch" => part(recount_dispatch, 0..12),
            _ => bound.named(name, positions.buffer)?,
        })
    }

    /// The depths, once the encoder was submitted: one `i32` for each pair. Points follow each other, and each point
    /// has one number for each light of that encode. A point that is infinite or NaN has −1. The buffer is as long as
    /// the options ask for; numbers behind those of the last encode have no meaning. Usages `STORAGE`, `COPY_SRC` and
    /// `COPY_DST`.
    pub fn occluder_counts(&self) -> &wgpu::Buffer {
        &self.buffers.depths
    }

    /// Reads [`Self::occluder_counts`] of the last encode, and no more, once its encoder was submitted. It waits for
    /// the device. `queue` must be the queue of the query's device.
    ///
    /// # Errors
    /// [`QueryError::Device`] if the device does not hand them back.
    pub fn read_occluder_counts(&self, queue: &wgpu::Queue) -> Result<Vec<i32>, QueryError> {
        Ok(read_back_first(self.pipelines.device(), queue, self.occluder_counts(), 4 * self.pairs)?)
    }

    /// The faces of the mesh in clusters, with the boxes of the last encode: one `FaceCluster` for each cluster. The
    /// usages are those of [`Self::occluder_counts`].
    #[doc(hidden)]
    pub fn clusters(&self) -> &wgpu::Buffer {
        &self.buffers.clusters
    }
}

/// The checked inputs of an encode, and the ranges of clusters and of points that its dispatches take.
struct Work<'a> {
    bound: BoundPositions,
    positions: PositionBuffer<'a>,
    points: QueryPoints<'a>,
    lights: &'a [Light],
    clusters: Vec<Range<usize>>,
    chunks: Vec<Range<u32>>,
}

/// A range of clusters and one of points, and the dynamic offsets of batch, chunk and range.
struct At<'a> {
    clusters: &'a Range<usize>,
    points: Range<u32>,
    offsets: [u32; 3],
}

/// The uniforms of one encode. They have their own buffers, so an encoder may hold several encodes.
struct Tables {
    batches: wgpu::Buffer,
    chunks: wgpu::Buffer,
    ranges: wgpu::Buffer,
    lights: u64,
    point_chunks: u64,
    /// Dynamic offsets in `ranges`: for each chunk of clusters that of the whole chunk, and those of its parts.
    whole_ranges: Vec<u32>,
    sub_ranges: Vec<Vec<u32>>,
}

impl Tables {
    /// `range` is the largest number of clusters of a dispatch.
    fn new(query: &ShadowQuery, work: &Work<'_>, range: usize) -> Self {
        let Work { bound, points: QueryPoints { points, on_face }, lights, clusters, chunks, .. } = work;
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
            lights: lights.len() as u64,
            point_chunks: chunks.len() as u64,
            whole_ranges,
            sub_ranges,
        }
    }

    /// The dynamic offset for a range of points and a batch of lights.
    fn chunk_offset(&self, batch: u64, chunk: u64) -> u32 {
        ((batch * self.point_chunks + chunk) * UniformTable::stride::<PointChunk>() as u64) as u32
    }
}
