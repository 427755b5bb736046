//! Pipelines that many share: each is made once, none is confused with another, results are those of pipelines of one's own.

use std::any::Any;

use rimline::gpu::{
    DeformError, Deformer, DeformerOptions, Extractor, ExtractorOptions, ListOptions, Pipelines, PositionBuffer,
    ShadowError, ShadowFormat, ShadowPipelines, ShadowQuery, ShadowQueryOptions,
};
use rimline::internals::Method;
use rimline::{Counting, Displacement, Light, Mesh, Predicate};
use rimline_testkit::shapes;

use crate::watched::camera;
use rimline_testkit::device::Gpu;
use rimline_testkit::dispatch::storage_layout;
use rimline_testkit::harness::Test;
use rimline_testkit::models::random_model;
use rimline_testkit::on_gpu::interleaved;
use rimline_testkit::on_gpu::{Found, read};
use rimline_testkit::on_gpu::{compare, limited, repeated_torus, text};
use rimline_testkit::random::Random;
use rimline_testkit::{OneCaster, OneCasterOptions, lights, must_fail, same};

pub(crate) const TESTS: &[Test] = &[
    ("each_shared_pipeline_is_made_once", once),
    ("displacements_share_by_source_and_layout", displacements),
    ("shared_pipelines_keep_windows_apart", windows),
    ("threads_share_pipelines_and_nothing_changes", threads),
    ("a_pipeline_with_an_error_is_not_kept", errors),
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
    same("none yet", &[pipelines.is_empty()], &[true])?;
    let mesh = shapes::torus(24, 16, 1.0, 0.4).mesh().map_err(text)?;
    let mut made: Vec<Box<dyn Any>> = Vec::new();
    for (what, options, adds) in kinds() {
        for adds in [adds, 0] {
            made.push(Box::new(Extractor::new(&pipelines, &mesh, options).map_err(text)?));
            count.added(what, adds)?;
        }
    }
    let extractor = Extractor::new(&pipelines, &mesh, ExtractorOptions::default()).map_err(text)?;
    let plain = ShadowFormat::default();
    let format = ShadowFormat { samples: 4, ..plain.clone() };
    let bounded = OneCasterOptions { bound_counts: true, ..Default::default() };
    let positions = gpu.storage(&vec![[0.0_f32; 3]; mesh.vertex_count() as usize]);
    let positions = PositionBuffer { buffer: &positions, offset: 0, stride: 12 };
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    // Drawing pipelines that are new, and computing ones.
    for (counting, format, options, draws, computes) in [
        (Counting::Auto, &plain, OneCasterOptions::default(), 4, 12),
        (Counting::ZpPlus, &plain, OneCasterOptions::default(), 0, 0),
        // The three stages that bound counts.
        (Counting::ZPass, &plain, bounded, 0, 3),
        (Counting::ZFail, &plain, bounded, 5, 0),
        (Counting::ZpPlus2005, &plain, bounded, 3, 1),
        (Counting::Auto, &format, bounded, 4, 0),
    ] {
        for new in [1, 0] {
            let drawing = ShadowPipelines::new(&pipelines, format, counting).map_err(text)?;
            count.added(&format!("{counting:?}"), new * draws)?;
            for new in [new, 0] {
                let options = OneCasterOptions { counting, ..options };
                let mut caster = OneCaster::new(&pipelines, &gpu.queue, &mesh, &options).map_err(text)?;
                let lights = [Light::point([0.0, 5.0, 2.0])];
                caster.encode(&mut encoder, positions, &lights, Some(&camera()), None).map_err(text)?;
                made.push(Box::new(caster));
                count.added(&format!("volumes by {counting:?}"), new * computes)?;
            }
            made.push(Box::new(drawing));
        }
    }
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
    drop((encoder, made, extractor, pipelines));
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

/// An extraction for these options' lights, with those pipelines.
fn found(
    gpu: &Gpu,
    pipelines: &Pipelines,
    (positions, mesh): (&[[f32; 3]], &Mesh),
    options: ExtractorOptions,
) -> Result<Found, String> {
    let buffer = gpu.storage(positions);
    let bound = PositionBuffer { buffer: &buffer, offset: 0, stride: 12 };
    let options = ExtractorOptions { for_volumes: true, ..options };
    let mut extractor = Extractor::new(pipelines, mesh, options).map_err(text)?;
    let lights = lights(&mut Random::new(82), options.max_lights);
    gpu.submit(|encoder| extractor.encode(encoder, bound, &lights).map_err(text))?;
    read(gpu, &extractor, mesh, options.max_lights)
}

fn is_ordered(options: &ExtractorOptions) -> bool {
    options.lists.is_some_and(|lists| lists.ordered)
}

/// Positions in one binding and in several, by one extractor and by two.
fn windows() -> Result<(), String> {
    let gpu = limited(16 << 10, 1 << 20, 64)?;
    let shared = Pipelines::new(&gpu.device);
    // With more room than that, lists would not fit a binding.
    let options =
        ExtractorOptions { masks: true, lists: Some(lists(2000, true)), for_volumes: true, ..Default::default() };
    let query = ShadowQueryOptions { max_points: 300, ..Default::default() };
    let light = [Light::point([3.0, 2.0, 1.0])];
    for [rings, segments] in [[20, 16], [60, 40], [20, 16]] {
        let shape = repeated_torus(rings, segments, 0);
        let mesh = shape.mesh().map_err(text)?;
        let [pipelines, unshared] = [shared.clone(), Pipelines::new(&gpu.device)];
        let mut extractors = Vec::new();
        for pipelines in [&pipelines, &unshared] {
            let extractor = Extractor::new(pipelines, &mesh, options).map_err(text)?;
            extractors.push((extractor, ShadowQuery::new(pipelines, &mesh, query).map_err(text)?));
        }
        for stride in [12, 60, 12, 24] {
            // Past four bindings.
            if shape.positions.len() as u64 * stride > 64 << 10 {
                continue;
            }
            let buffer = gpu.storage(&interleaved(&shape.positions, 0, stride));
            let bound = PositionBuffer { buffer: &buffer, offset: 0, stride };
            let mut results = Vec::new();
            for (extractor, query) in &mut extractors {
                gpu.submit(|encoder| {
                    extractor.encode(encoder, bound, &light).map_err(text)?;
                    query.encode_at(encoder, bound, bound, 270, &light).map_err(text)
                })?;
                results.push((read(&gpu, extractor, &mesh, 1)?, gpu.read::<i32>(query.occluder_counts(), 270)?));
            }
            let what = format!("{rings}·{segments} at {stride} bytes");
            let [(sharing, depths), (alone, unshared_depths)] = &results[..] else { return Err(what) };
            compare(&what, sharing, alone, 2000, true)?;
            same(&format!("{what}, depths"), depths, unshared_depths)?;
            if sharing.counts == [0] {
                return Err(format!("{what}: no silhouette"));
            }
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
    let expected: Vec<Found> = kinds
        .iter()
        .map(|(_, options, _)| found(gpu, &Pipelines::new(&gpu.device), (&shape.positions, mesh), *options))
        .collect::<Result<_, _>>()?;
    let expected = &expected;
    same("live pipelines before", &[gpu.live_pipelines()?], &[0])?;
    std::thread::scope(|scope| {
        // All begin with the same; then each has an order of its own.
        let run = move |first: usize| -> Result<Vec<Extractor>, String> {
            let extractor = |(_, options, _): &(_, _, _)| Extractor::new(shared, mesh, *options).map_err(text);
            let kept = kinds.iter().map(extractor).collect::<Result<_, _>>()?;
            for kind in (0..kinds.len()).map(|kind| (first + kind) % kinds.len()) {
                let (what, options, _) = &kinds[kind];
                let sharing = found(gpu, shared, (&shape.positions, mesh), *options)?;
                compare(what, &sharing, &expected[kind], ROOM, is_ordered(options))?;
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

/// Attachments that no pipeline can have: the error comes every time, and nothing is kept of it.
fn errors() -> Result<(), String> {
    let gpu = Gpu::with_limits(wgpu::Limits::default())?;
    let pipelines = Pipelines::new(&gpu.device);
    let colors = vec![Some(wgpu::TextureFormat::Rgb9e5Ufloat)];
    let (mut kept, mut messages) = (Vec::new(), Vec::new());
    for _ in 0..2 {
        let format = ShadowFormat { colors: colors.clone(), ..ShadowFormat::default() };
        match ShadowPipelines::new(&pipelines, &format, Counting::Auto) {
            Err(ShadowError::Refused { message }) => messages.push(message),
            other => return Err(format!("expected a refusal, got {:?}", other.err())),
        }
        kept.push(pipelines.len());
    }
    same("message", &messages[1..], &messages[..1])?;
    same("pipelines kept", &kept, &[0, 0])?;
    ShadowPipelines::new(&pipelines, &ShadowFormat::default(), Counting::Auto).map(drop).map_err(text)?;
    must_fail("pipelines kept", &same("pipelines", &[pipelines.len()], &[0]))
}
