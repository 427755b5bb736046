//! Zero of anything that an extractor and its volumes are made with: no room for entries, faces and caps, no memory, no
//! vertices for an edge. No room counts as room for one, of which other tests have pictures.

use rimline::gpu::{
    DeviceError, DrawArguments, EdgeTopology, Extractor, ExtractorError, ExtractorOptions, ListOptions, PositionBuffer,
    ShadowError, ShadowFormat, ShadowPipelines,
};
use rimline::{Counting, DepthDirection, Light, ShadowCamera};
use rimline_testkit::OneCasterOptions;
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::{one_caster, shadow_statistics, text};
use rimline_testkit::{must_fail, same, shapes};

pub(crate) const TESTS: &[Test] =
    &[("no_room_is_room_for_one", without_room), ("no_memory_and_no_samples_are_typed_errors", without_memory)];

/// The results of one extraction and the statistics of its volumes.
#[derive(Debug, PartialEq)]
struct Found {
    facing: Vec<u32>,
    counts: Vec<u32>,
    draws: Vec<u32>,
    capacity: u32,
    volumes: Vec<u32>,
}

fn found(gpu: &Gpu, counting: Counting, room: Option<u32>, topology: EdgeTopology) -> Result<Found, String> {
    let shape = shapes::torus(12, 8, 1.0, 0.4);
    let mesh = shape.mesh().map_err(text)?;
    let buffer = gpu.storage(&shape.positions);
    let positions = PositionBuffer { buffer: &buffer, offset: 0, stride: 12 };
    // The second light is in planes of faces.
    let lights = [Light::point([1.0, 5.0, 2.0]), Light::directional([0.0, 1.0, 0.0])];
    let lists = Some(ListOptions { capacity: room, ordered: room.is_none(), topology });
    let options = ExtractorOptions { max_lights: 2, undecided_capacity: room, lists, ..ExtractorOptions::default() };
    let mut extractor = Extractor::new(&gpu.pipelines, &mesh, options).map_err(text)?;
    let pipelines = ShadowPipelines::new(&gpu.pipelines, &ShadowFormat::default(), counting).map_err(text)?;
    let options =
        OneCasterOptions { list_capacity: room, cap_capacity: room, bound_counts: true, ..OneCasterOptions::default() };
    let mut caster = one_caster(gpu, &pipelines, &mesh, options).map_err(text)?;
    let view_projection = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, -1.0], [0.0, 0.0, 0.1, 0.0]];
    let camera = ShadowCamera { view_projection, origin: [0.0, 0.0, 4.0], depth: DepthDirection::Reversed };
    let frame = gpu.submit(|encoder| {
        extractor.encode(encoder, positions, &lights).map_err(text)?;
        caster.encode(encoder, positions, &lights, Some(&camera), None).map_err(text)
    })?;
    let results = extractor.results();
    let statistics = [shadow_statistics(gpu, &frame)?];
    let draws: Vec<DrawArguments> = gpu.read(results.draw_arguments, 2)?;
    Ok(Found {
        facing: gpu.read(&results.facing[0], mesh.faces().len())?,
        counts: gpu.read(results.counts, 2)?,
        draws: bytemuck::cast_slice(&draws).to_vec(),
        capacity: results.capacity,
        volumes: bytemuck::cast_slice(&statistics).to_vec(),
    })
}

fn without_room() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    for counting in [Counting::Auto, Counting::ZPass, Counting::ZpPlus, Counting::ZFail] {
        let [none, one, all] =
            [Some(0), Some(1), None].map(|room| found(gpu, counting, room, EdgeTopology::TriangleStrip));
        let (none, one, all) = (none?, one?, all?);
        same(&format!("{counting:?}"), &[&none], &[&one])?;
        same(&format!("{counting:?}, facing"), &none.facing, &all.facing)?;
        must_fail("room for all", &same("one entry", &[&all], &[&one]))?;
    }
    for (topology, vertices) in
        [(EdgeTopology::TriangleStrip, 4), (EdgeTopology::TriangleList, 6), (EdgeTopology::LineList, 2)]
    {
        let drawn = found(gpu, Counting::Auto, None, topology)?;
        same("vertices", &[drawn.draws[0], drawn.draws[4]], &[vertices; 2])?;
    }
    Ok(())
}

fn without_memory() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mesh = shapes::cube().mesh().map_err(text)?;
    let refused =
        Extractor::new(&gpu.pipelines, &mesh, ExtractorOptions { memory_limit: Some(0), ..Default::default() });
    let Err(ExtractorError::Device(DeviceError::MemoryLimit { limit: 0, .. })) = refused else {
        return Err(format!("no memory: {:?}", refused.err()));
    };
    let made = |format: &ShadowFormat| ShadowPipelines::new(&gpu.pipelines, format, Counting::Auto);
    let refused = made(&ShadowFormat { samples: 0, ..ShadowFormat::default() }).err();
    let Some(ShadowError::Samples { samples: 0, .. }) = refused else {
        return Err(format!("no samples: {refused:?}"));
    };
    let options = OneCasterOptions { memory_limit: Some(0), ..OneCasterOptions::default() };
    let pipelines = made(&ShadowFormat::default()).map_err(text)?;
    match one_caster(gpu, &pipelines, &mesh, options).err() {
        Some(ShadowError::Device(DeviceError::MemoryLimit { limit: 0, .. })) => Ok(()),
        other => Err(format!("no memory for volumes: {other:?}")),
    }
}
