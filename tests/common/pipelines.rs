//! Pipelines that many share: each is made once, none is confused with another, results are those of pipelines of one's own.

use std::any::Any;

use rimline::gpu::{
    DeformError, Deformer, DeformerOptions, Extractor, ExtractorOptions, ListOptions, Pipelines, PositionBuffer,
    ShadowError, ShadowFormat, ShadowPipelines, ShadowQuery, ShadowQueryOptions,
};
use rimline::internals::Method;
use rimline::mesh::Weld;
use rimline::{Counting, DepthDirection, Displacement, Light, Predicate};
use rimline_testkit::shapes;

use rimline_testkit::device::Gpu;
use rimline_testkit::dispatch::storage_layout;
use rimline_testkit::harness::Test;
use rimline_testkit::models::random_model;
use rimline_testkit::on_gpu::{Found, compare, interleaved, limited, read, repeated_torus, text};
use rimline_testkit::polygons::quad_box;
use rimline_testkit::random::Random;
use rimline_testkit::{lights, must_fail, same};

pub(crate) const TESTS: &[Test] = &[
    ("each_shared_pipeline_is_made_once", once),
    ("displacements_share_by_source_and_layout", displacements),
    ("shared_pipelines_keep_windows_apart", windows),
    ("threads_share_pipelines_and_nothing_changes", threads),
];

const ROOM: u32 = 100_000;

fn lists(capacity: u32, ordered: bool) -> ListOptions {
    ListOptions { capacity: Some(capacity), ordered, ..ListOptions::default() }
}

/// Options of an extractor, and how many pipelines they need that those before do not.
fn kinds() -> Vec<(&'static str, ExtractorOptions, usize)> {
    let plain = ExtractorOptions { lists: Some(lists(ROOM, false)), ..Default::default() };
    let fast = ExtractorOptions { predicate: Predicate::Fast, ..plain };
    vec![
        ("as by default", plain, 4),
        ("for more lights", ExtractorOptions { max_lights: 40, ..plain }, 0),
        ("with masks", ExtractorOptions { masks: true, ..plain }, 1),
        // Edges that write masks and append nothing, and the three passes of compaction.
        ("in order", ExtractorOptions { lists: Some(lists(ROOM, true)), ..plain }, 4),
        ("only masks", ExtractorOptions { masks: true, lists: None, ..plain }, 0),
        ("fast", fast, 1),
        ("in the plane form", ExtractorOptions { predicate: Predicate::Plane, ..plain }, 1),
        ("an edge at a time", ExtractorOptions { method: Method::PerEdge, ..fast }, 1),
    ]
}

/// Fails where not as many pipelines were added as ought to be.
struct Count<'a> {
    pipelines: &'a Pipelines,
    before: usize,
}

impl Count<'_> {
    fn added(&mut self, what: &str, expected: usize) -> Result<(), String> {
        let now = self.pipelines.len();
        let added = now - std::mem::replace(&mut self.before, now);
        same(&format!("{what}, pipelines added"), &[added], &[expected])
    }
}

fn once() -> Result<(), String> {
    // A device of its own, where nobody else makes pipelines meanwhile.
    let gpu = Gpu::with_limits(wgpu::Limits::default())?;
    let pipelines = Pipelines::new(&gpu.device);
    let mut count = Count { pipelines: &pipelines, before: 0 };
    // Attachments that no pipeline can have: the error comes every time, and nothing is kept of it.
    let undrawable = vec![Some(wgpu::TextureFormat::Rgb9e5Ufloat)];
    for _ in 0..2 {
        let format = ShadowFormat { colors: undrawable.clone(), ..ShadowFormat::default() };
        match ShadowPipelines::new(&pipelines, &format, Counting::Auto) {
            Err(ShadowError::Refused { .. }) => count.added("a pipeline with an error", 0)?,
            other => return Err(format!("expected a refusal, got {:?}", other.err())),
        }
    }
    let mesh = shapes::torus(24, 16, 1.0, 0.4).mesh().map_err(text)?;
    let mut made: Vec<Box<dyn Any>> = Vec::new();
    for (what, options, adds) in kinds() {
        for adds in [adds, 0] {
            made.push(Box::new(Extractor::new(&pipelines, &mesh, options).map_err(text)?));
            count.added(what, adds)?;
        }
    }
    // Four stages in the place of facing, for any number of polygons.
    for (what, cuts, adds) in [("polygons", 2, 4), ("more polygons", 3, 0)] {
        let mesh = quad_box(cuts).mesh(Weld::Position).map_err(text)?;
        made.push(Box::new(Extractor::new(&pipelines, &mesh, kinds()[0].1).map_err(text)?));
        count.added(what, adds)?;
    }
    let extractor = Extractor::new(&pipelines, &mesh, ExtractorOptions::default()).map_err(text)?;
    let plain = ShadowFormat::default();
    let format = ShadowFormat { samples: 4, ..plain.clone() };
    let trimmed = ShadowFormat { trim: true, ..plain.clone() };
    let with_far_plane = ShadowFormat { has_far_plane: true, ..plain.clone() };
    let standard = ShadowFormat { depth: DepthDirection::Standard, ..plain.clone() };
    let seven_bits = ShadowFormat { count_bits: 7, ..plain.clone() };
    // `warm_up.rs` counts those that compute.
    for (counting, format, new) in [
        (Counting::Auto, &plain, 4),
        (Counting::ZpPlus, &plain, 0),
        (Counting::ZPass, &plain, 0),
        (Counting::ZFail, &plain, 5),
        (Counting::ZpPlus2005, &plain, 3),
        (Counting::Auto, &format, 4),
        // One pipeline draws all parts of trimmed sides.
        (Counting::ZPass, &trimmed, 1),
        // Light caps are not trimmed, nor is what ZP+ as published adds.
        (Counting::ZFail, &trimmed, 3),
        (Counting::ZpPlus2005, &trimmed, 0),
        // A far plane changes only z-fail, and the depth direction only draws that compare depths.
        (Counting::Auto, &with_far_plane, 0),
        (Counting::Auto, &standard, 2),
        (Counting::ZPass, &seven_bits, 1),
    ] {
        for new in [new, 0] {
            made.push(Box::new(ShadowPipelines::new(&pipelines, format, counting).map_err(text)?));
            count.added(&format!("{counting:?}"), new)?;
        }
    }
    // One of eight bits is the dark bit. The pipeline that sets it is not shared.
    drop(ShadowPipelines::in_batches(&pipelines, &plain, Counting::ZPass).map_err(text)?);
    count.added("batches of casters", 0)?;
    for (skip, adds) in [(true, 5), (false, 3), (true, 0)] {
        let options = ShadowQueryOptions { skip_by_boxes: skip, ..Default::default() };
        made.push(Box::new(ShadowQuery::new(&pipelines, &mesh, options).map_err(text)?));
        count.added(&format!("query, skipping {skip}"), adds)?;
    }
    // There are no other live pipelines.
    println!("{} pipelines for {} things: {pipelines:?}", pipelines.len(), made.len());
    same("live pipelines", &[gpu.live_pipelines()?], &[pipelines.len()])?;
    made.push(Box::new(Extractor::new(&gpu.device, &mesh, ExtractorOptions::default()).map_err(text)?));
    count.added("an extractor with pipelines of its own", 0)?;
    must_fail("pipelines of its own", &same("live", &[gpu.live_pipelines()?], &[pipelines.len()]))?;
    // Everything goes with the last that holds it.
    drop((made, extractor, pipelines));
    same("pipelines left", &[gpu.live_pipelines()?], &[0])
}

const UP: &str = "fn displace(position: vec3<f32>, vertex: u32, time: f32) -> vec3<f32> {
  return position + vec3<f32>(0.0, 1.0, 0.0);
}";
const FROM_BUFFER: &str = "@group(1) @binding(0) var<storage, read> offset: vec4<f32>;
fn displace(position: vec3<f32>, vertex: u32, time: f32) -> vec3<f32> {
  return position + offset.xyz;
}";

fn displacements() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let pipelines = Pipelines::new(&gpu.device);
    let mut count = Count { pipelines: &pipelines, before: 0 };
    let model = random_model(&mut Random::new(81), 50);
    let [one, equal, wrong] = [0, 0, 1].map(|binding| storage_layout(gpu, &[(binding, true)]));
    let [up, up_again, from_buffer] = [UP, UP, FROM_BUFFER].map(|source| Displacement::new(source).map_err(text));
    let [up, up_again, from_buffer] = [up?, up_again?, from_buffer?];
    for (what, displacement, displacement_layout, adds) in [
        ("none", None, None, Some(1)),
        ("none again", None, None, Some(0)),
        ("up", Some(&up), None, Some(1)),
        ("up from another object", Some(&up_again), None, Some(0)),
        // An error is not kept, and reported again.
        ("with the wrong layout", Some(&from_buffer), Some(&wrong), None),
        ("with the wrong layout again", Some(&from_buffer), Some(&wrong), None),
        ("from a buffer", Some(&from_buffer), Some(&one), Some(1)),
        ("from a buffer again", Some(&from_buffer), Some(&one), Some(0)),
        ("from a buffer by another layout object", Some(&from_buffer), Some(&equal), Some(1)),
        ("with the wrong layout at last", Some(&from_buffer), Some(&wrong), None),
    ] {
        let options = DeformerOptions { displacement, displacement_layout, memory_limit: None };
        let refused = match Deformer::new(&pipelines, &model, options) {
            Ok(_) => false,
            Err(DeformError::Pipeline { .. }) => true,
            Err(error) => return Err(format!("{what}: {error}")),
        };
        same(&format!("{what}, refused"), &[refused], &[adds.is_none()])?;
        count.added(what, adds.unwrap_or(0))?;
    }
    Ok(())
}

/// Positions in one binding and in several, by an extractor and a query of shared pipelines, and by those of their own.
fn windows() -> Result<(), String> {
    let gpu = limited(16 << 10, 1 << 20, 64)?;
    let shared = Pipelines::new(&gpu.device);
    // With more room than that, lists would not fit a binding.
    let lists = Some(lists(2000, true));
    let options = ExtractorOptions { masks: true, lists, for_volumes: true, ..Default::default() };
    let light = [Light::point([3.0, 2.0, 1.0])];
    for [rings, segments] in [[20, 16], [60, 40], [20, 16]] {
        let shape = repeated_torus(rings, segments, 0);
        let mesh = shape.mesh().map_err(text)?;
        let made = |pipelines: &Pipelines| {
            let query = ShadowQueryOptions { max_points: 300, ..Default::default() };
            let extractor = Extractor::new(pipelines, &mesh, options).map_err(text)?;
            Ok::<_, String>((extractor, ShadowQuery::new(pipelines, &mesh, query).map_err(text)?))
        };
        let (mut sharing, mut alone) = (made(&shared)?, made(&Pipelines::new(&gpu.device))?);
        // No more than four bindings.
        for stride in
            [12_u64, 60, 12, 24].into_iter().filter(|stride| shape.positions.len() as u64 * stride <= 64 << 10)
        {
            let buffer = gpu.storage(&interleaved(&shape.positions, 0, stride));
            let bound = PositionBuffer { buffer: &buffer, offset: 0, stride };
            let found = |(extractor, query): &mut (Extractor, ShadowQuery)| {
                gpu.submit(|encoder| {
                    extractor.encode(encoder, bound, &light).map_err(text)?;
                    query.encode_at(encoder, bound, bound, 270, &light).map_err(text)
                })?;
                Ok::<_, String>((read(&gpu, extractor, &mesh, 1)?, gpu.read::<i32>(query.occluder_counts(), 270)?))
            };
            let what = format!("{rings}·{segments} at {stride} bytes");
            let ((by_sharing, counts), (by_alone, counts_alone)) = (found(&mut sharing)?, found(&mut alone)?);
            compare(&what, &by_sharing, &by_alone, 2000, true)?;
            same(&format!("{what}, counts"), &counts, &counts_alone)?;
            must_fail("no silhouette", &same(&what, &by_sharing.counts, &[0]))?;
        }
    }
    Ok(())
}

fn threads() -> Result<(), String> {
    let gpu = &Gpu::with_limits(wgpu::Limits::default())?;
    let shared = &Pipelines::new(&gpu.device);
    let shape = &shapes::blob(20, 0.5, 4);
    let mesh = &shape.mesh().map_err(text)?;
    let kinds = &kinds();
    let buffer = &gpu.storage(&shape.positions);
    let found = |pipelines: &Pipelines, options: ExtractorOptions| {
        let bound = PositionBuffer { buffer, offset: 0, stride: 12 };
        let options = ExtractorOptions { for_volumes: true, ..options };
        let mut extractor = Extractor::new(pipelines, mesh, options).map_err(text)?;
        let lights = lights(&mut Random::new(82), options.max_lights);
        gpu.submit(|encoder| extractor.encode(encoder, bound, &lights).map_err(text))?;
        read(gpu, &extractor, mesh, options.max_lights)
    };
    let alone = |(_, options, _): &(_, ExtractorOptions, _)| found(&Pipelines::new(&gpu.device), *options);
    let expected = &kinds.iter().map(alone).collect::<Result<Vec<Found>, String>>()?;
    same("live pipelines before", &[gpu.live_pipelines()?], &[0])?;
    std::thread::scope(|scope| {
        // All begin with the same; then each has an order of its own.
        let run = move |first: usize| -> Result<Vec<Extractor>, String> {
            let extractor = |(_, options, _): &(_, _, _)| Extractor::new(shared, mesh, *options).map_err(text);
            let kept = kinds.iter().map(extractor).collect::<Result<_, _>>()?;
            for kind in (0..kinds.len()).map(|kind| (first + kind) % kinds.len()) {
                let (what, options, _) = &kinds[kind];
                let is_ordered = options.lists.is_some_and(|lists| lists.ordered);
                compare(what, &found(shared, *options)?, &expected[kind], ROOM, is_ordered)?;
            }
            Ok(kept)
        };
        let running: Vec<_> = (0..4).map(|thread| scope.spawn(move || run(2 * thread))).collect();
        let mut kept = Vec::new();
        for thread in running {
            kept.push(thread.join().map_err(|_| "a thread panicked")??);
        }
        let all: usize = kinds.iter().map(|(_, _, adds)| adds).sum();
        same("pipelines", &[shared.len()], &[all])?;
        // None was made twice: the extractors would hold it.
        same("live pipelines", &[gpu.live_pipelines()?], &[all])
    })
}
