//! Samples that no device has, things of two devices, lost devices: typed errors, and no error of the device.

use rimline::Counting;
use rimline::gpu::{
    Deformer, DeformerOptions, Extractor, ExtractorOptions, ShadowError, ShadowFormat, ShadowPipelines, ShadowQuery,
    ShadowQueryOptions, StageTimer, read_back_vec, results_bind_group_layout,
};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::made_anew;
use rimline_testkit::models::{random_model, random_pose};
use rimline_testkit::on_gpu::{one_caster, text};
use rimline_testkit::passes::{CLEARED, depth_pass};
use rimline_testkit::random::Random;
use rimline_testkit::refusals::{Expected, is, refusal, refused, shows};

use crate::watched::{LIGHT, Watched, camera, caster, depth_stencil, extractor, packed};

pub(crate) const TESTS: &[Test] = &[
    ("samples_and_colours_that_are_not_to_be_had_are_typed_errors", formats),
    ("things_of_two_devices_are_typed_errors", mixed),
    ("nothing_is_made_on_a_lost_device", made_on_lost),
    ("nothing_is_encoded_on_a_lost_device", encoded_on_lost),
];

fn formats() -> Result<(), String> {
    let watched = Watched::plain()?;
    let make = |watched: &Watched, format: ShadowFormat| {
        ShadowPipelines::new(&watched.gpu.pipelines, &format, Counting::Auto).map(drop)
    };
    let of = |samples| ShadowFormat { samples, ..Default::default() };
    for samples in [0, 2, 3, 8, 64, u32::MAX] {
        let expected = ShadowError::Samples { samples, format: of(1).depth_stencil, supported: vec![1, 4] };
        refused([refusal(format!("{samples} samples"), make(&watched, of(samples)), is(expected))])?;
    }
    let colors = |color, count| make(&watched, ShadowFormat { colors: vec![Some(color); count], ..Default::default() });
    refused([
        refusal("1 sample", make(&watched, of(1)), Expected::Taken),
        refusal("4 samples", make(&watched, of(4)), Expected::Taken),
        refusal("no target", colors(wgpu::TextureFormat::Rgb9e5Ufloat, 1), shows(&["Refused {"])),
        refusal("too many colours", colors(wgpu::TextureFormat::Rgba8Unorm, 9), shows(&["Refused {"])),
    ])?;
    watched.quiet("samples and colours")?;
    // Where the adapter's own counts are allowed, the device has the last word.
    let feature = wgpu::Features::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES;
    let watched = Watched::new(feature, wgpu::Limits::default())?;
    for samples in [2, 8, 16] {
        match make(&watched, of(samples)) {
            Ok(()) | Err(ShadowError::Refused { .. }) => {}
            Err(error) => return Err(format!("{samples} samples: {error:?}")),
        }
    }
    refused([refusal("3 samples of the adapter", make(&watched, of(3)), shows(&["Samples { samples: 3,"]))])?;
    watched.quiet("samples of the adapter")
}

/// Parts of the errors of other devices, of their buffers, and of lost devices.
const OTHER: &[&str] = &["Device(OtherDevice {"];
const REFUSED: &[&str] = &["Device(BufferRefused {"];
const LOST: &[&str] = &["Device(Lost)"];

fn mixed() -> Result<(), String> {
    // Both devices are of one instance. wgpu confuses resources of different instances that have the same id.
    let ours = &Watched::plain()?;
    let theirs = &Watched::of(ours.gpu.another(wgpu::Features::TIMESTAMP_QUERY, wgpu::Limits::default())?);
    let quiet = |what: &str| ours.quiet(what).and_then(|()| theirs.quiet(what));
    let (shape, mesh) = caster()?;
    let [positions, foreign] = [ours, theirs].map(|watched| watched.gpu.storage(&shape.positions));
    let make = |watched: &Watched| {
        ShadowPipelines::new(&watched.gpu.pipelines, &ShadowFormat::default(), Counting::Auto).map_err(text)
    };
    let [drawing, foreign_drawing] = [make(ours)?, make(theirs)?];
    let mut extractor = extractor(ours, &mesh, 1)?;
    let mut encoder = ours.encoder();
    let of_theirs = extractor.encode(&mut encoder, packed(&foreign), &[LIGHT]);
    let mut timer = StageTimer::new(&theirs.gpu.device, &theirs.gpu.queue).ok_or("no timer")?;
    let timed = extractor.encode_timed(&mut encoder, packed(&positions), &[LIGHT], Some(&mut timer));
    refused([refusal("positions", of_theirs, shows(REFUSED)), refusal("timer", timed, shows(OTHER))])?;
    quiet("volumes, positions and timer")?;
    // The refused calls changed no state.
    let extraction = extractor.encode(&mut encoder, packed(&positions), &[LIGHT]).map_err(text)?;
    let mut volumes = one_caster(&ours.gpu, &drawing, &mesh, made_anew(32, Counting::Auto)).map_err(text)?;
    let mut encode = |timer| volumes.encode(&mut encoder, packed(&positions), &[LIGHT], Some(&camera()), timer);
    let timed = encode(Some(&mut timer));
    refused([refusal("volumes' timer", timed, shows(OTHER))])?;
    quiet("volumes' timer")?;
    let shadows = encode(None).map_err(text)?;
    let view = depth_stencil(ours);
    let mut pass = encoder.begin_render_pass(&depth_pass(&view, CLEARED));
    refused([
        refusal("drawing", shadows.draw(&mut pass, &foreign_drawing, 0), shows(OTHER)),
        refusal("its own", shadows.draw(&mut pass, &drawing, 0), Expected::Taken),
    ])?;
    drop(pass);
    ours.gpu.queue.submit([encoder.finish()]);
    if ours.gpu.read::<u32>(extractor.results().counts, 1)? == [0] {
        return Err("no silhouette after what was refused".to_owned());
    }
    let layout = results_bind_group_layout(&theirs.gpu.device, wgpu::ShaderStages::COMPUTE);
    let options = ShadowQueryOptions { max_points: 64, ..Default::default() };
    let mut query = ShadowQuery::new(&ours.gpu.pipelines, &mesh, options).map_err(text)?;
    let mut encoder = ours.encoder();
    let [points, foreign_points] = [packed(&positions), packed(&foreign)];
    let mut encode = |at, points, timer| query.encode_timed(&mut encoder, at, points, 9, &[LIGHT], timer);
    let read = read_back_vec::<u32>(&ours.gpu.device, &ours.gpu.queue, &foreign);
    refused([
        refusal("layout", extraction.bind_group(&layout, 0), shows(REFUSED)),
        refusal("query", encode(foreign_points, points, None), shows(REFUSED)),
        refusal("points", encode(points, foreign_points, None), shows(&["Points(BufferRefused {"])),
        refusal("query's timer", encode(points, points, Some(&mut timer)), shows(OTHER)),
        refusal("reading back", read, shows(&["ReadBack {"])),
    ])?;
    quiet("layout, query and reading back")
}

fn made_on_lost() -> Result<(), String> {
    let watched = Watched::plain()?;
    let (_, mesh) = caster()?;
    let pipelines = &watched.gpu.pipelines;
    let drawing = ShadowPipelines::new(pipelines, &ShadowFormat::default(), Counting::Auto).map_err(text)?;
    watched.gpu.device.destroy();
    let model = random_model(&mut Random::new(93), 50);
    let options = ExtractorOptions::default();
    let format = ShadowFormat::default();
    refused([
        refusal("extractor", Extractor::new(pipelines, &mesh, options), shows(LOST)),
        refusal("pipelines", ShadowPipelines::new(pipelines, &format, Counting::ZFail), shows(LOST)),
        refusal("a scene", one_caster(&watched.gpu, &drawing, &mesh, made_anew(32, Counting::Auto)), shows(LOST)),
        refusal("query", ShadowQuery::new(pipelines, &mesh, ShadowQueryOptions::default()), shows(LOST)),
        refusal("deformer", Deformer::new(pipelines, &model, DeformerOptions::default()), shows(LOST)),
        // Nor with pipelines of one's own.
        refusal("its own pipelines", Extractor::new(&watched.gpu.device, &mesh, options), shows(LOST)),
    ])?;
    watched.quiet("constructors")
}

/// Objects that encode, made while the device was alive, which is lost before their first encode, and after one.
fn encoded_on_lost() -> Result<(), String> {
    for is_used in [false, true] {
        let watched = Watched::new(wgpu::Features::TIMESTAMP_QUERY, wgpu::Limits::default())?;
        let Gpu { device, queue, pipelines, .. } = &watched.gpu;
        let (shape, mesh) = caster()?;
        let buffer = watched.gpu.storage(&shape.positions);
        let positions = packed(&buffer);
        let mut random = Random::new(94);
        let model = random_model(&mut random, 50);
        let pose = random_pose(&mut random, &model);
        let deformer = Deformer::new(pipelines, &model, DeformerOptions::default()).map_err(text)?;
        let layout = results_bind_group_layout(device, wgpu::ShaderStages::COMPUTE);
        let mut extractor = extractor(&watched, &mesh, 1)?;
        let drawing = ShadowPipelines::new(pipelines, &ShadowFormat::default(), Counting::Auto).map_err(text)?;
        let mut volumes = one_caster(&watched.gpu, &drawing, &mesh, made_anew(32, Counting::Auto)).map_err(text)?;
        let options = ShadowQueryOptions { max_points: 64, ..Default::default() };
        let mut query = ShadowQuery::new(pipelines, &mesh, options).map_err(text)?;
        let mut timer = StageTimer::new(device, queue).ok_or("no timer")?;
        let extraction = watched.gpu.submit(|encoder| {
            if is_used {
                volumes.encode(encoder, positions, &[LIGHT], Some(&camera()), None).map_err(text)?;
            }
            extractor.encode(encoder, positions, &[LIGHT]).map_err(text)
        })?;
        let before = watched.encoder();
        device.destroy();
        let mut encoder = if is_used { watched.encoder() } else { before };
        let timer = &mut timer;
        refused([
            refusal("extractor", extractor.encode_timed(&mut encoder, positions, &[LIGHT], Some(timer)), shows(LOST)),
            refusal(
                "query",
                query.encode_timed(&mut encoder, positions, positions, 9, &[LIGHT], Some(timer)),
                shows(LOST),
            ),
            refusal("deformer", deformer.encode_timed(&mut encoder, &pose, Some(timer)), shows(LOST)),
            refusal("bind group", extraction.bind_group(&layout, 0), shows(LOST)),
        ])?;
        if is_used {
            let encoded = volumes.encode(&mut encoder, positions, &[LIGHT], Some(&camera()), Some(timer));
            refused([refusal("used volumes", encoded, shows(LOST))])?;
        }
        timer.resolve(&mut encoder);
        let counts = read_back_vec::<u32>(device, queue, extractor.results().counts);
        refused([
            refusal("timer", timer.read(device, queue), shows(&["ReadBack {"])),
            refusal("reading back", counts, shows(&["ReadBack {"])),
        ])?;
        // wgpu itself takes encoders of a lost device.
        queue.submit([encoder.finish()]);
        watched.quiet(if is_used { "used" } else { "unused" })?;
    }
    Ok(())
}
