//! Samples that no device has, things of two devices, lost devices: typed errors, and no error of the device.

use rimline::gpu::{
    DeformError, Deformer, DeformerOptions, DeviceError, ExtractionEncodeError, ExtractionIncludeError, Extractor,
    ExtractorError, ExtractorOptions, PositionError, ReadError, ShadowDrawError, ShadowEncodeError, ShadowFormat,
    ShadowFormatError, ShadowOptions, ShadowPipelines, ShadowQuery, ShadowQueryEncodeError, ShadowQueryError,
    ShadowQueryOptions, ShadowVolumes, ShadowVolumesError, StageTimer, TimerError, read_back_vec,
    results_bind_group_layout,
};
use rimline::{Counting, Mesh};
use rimline_testkit::harness::Test;
use rimline_testkit::models::{random_model, random_pose};
use rimline_testkit::on_gpu::text;
use rimline_testkit::random::Random;
use rimline_testkit::same;

use crate::watched::{LIGHT, Watched, camera, caster, depth_stencil, extractor, packed};

pub(crate) const TESTS: &[Test] = &[
    ("samples_and_colours_that_are_not_to_be_had_are_typed_errors", formats),
    ("things_of_two_devices_are_typed_errors", mixed),
    ("nothing_is_made_on_a_lost_device", made_on_lost),
    ("nothing_is_encoded_on_a_lost_device", encoded_on_lost),
];

/// Fails unless `fits` says that the error is the one.
fn expect<T, E: std::fmt::Debug>(what: &str, found: Result<T, E>, fits: impl Fn(&E) -> bool) -> Result<(), String> {
    match found {
        Err(error) if fits(&error) => Ok(()),
        Err(error) => Err(format!("{what}: another error, {error:?}")),
        Ok(_) => Err(format!("{what}: no error")),
    }
}

fn formats() -> Result<(), String> {
    let watched = Watched::plain()?;
    let make = |watched: &Watched, format: ShadowFormat| {
        ShadowPipelines::new(&watched.gpu.pipelines, &format, Counting::Auto).map(drop)
    };
    let format = ShadowFormat::default().depth_stencil;
    for samples in [0, 2, 3, 8, 64, u32::MAX] {
        let found = make(&watched, ShadowFormat { samples, ..Default::default() });
        let expected = ShadowFormatError::Samples { samples, format, supported: vec![1, 4] };
        same(&format!("{samples} samples"), &[found], &[Err(expected)])?;
        watched.quiet(&format!("{samples} samples"))?;
    }
    for samples in [1, 4] {
        make(&watched, ShadowFormat { samples, ..Default::default() }).map_err(text)?;
    }
    for (what, color, count) in [
        ("a format that cannot be drawn into", wgpu::TextureFormat::Rgb9e5Ufloat, 1),
        ("too many colours", wgpu::TextureFormat::Rgba8Unorm, 9),
    ] {
        let found = make(&watched, ShadowFormat { colors: vec![Some(color); count], ..Default::default() });
        expect(what, found, |error| matches!(error, ShadowFormatError::Refused { .. }))?;
        watched.quiet(what)?;
    }
    // Where the adapter's own counts are allowed, the device has the last word.
    let feature = wgpu::Features::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES;
    let watched = Watched::new(feature, wgpu::Limits::default())?;
    for samples in [2, 8, 16] {
        match make(&watched, ShadowFormat { samples, ..Default::default() }) {
            Ok(()) => println!("{samples} samples are there"),
            Err(ShadowFormatError::Refused { message }) => println!("{samples} samples: {message}"),
            Err(error) => return Err(format!("{samples} samples: {error:?}")),
        }
        watched.quiet(&format!("{samples} samples of the adapter"))?;
    }
    expect("3 samples of the adapter", make(&watched, ShadowFormat { samples: 3, ..Default::default() }), |error| {
        matches!(error, ShadowFormatError::Samples { samples: 3, .. })
    })?;
    watched.quiet("3 samples of the adapter")
}

fn is_other(error: &DeviceError) -> bool {
    matches!(error, DeviceError::OtherDevice { .. })
}

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
    let volumes = ShadowVolumes::new(&foreign_drawing, &extractor, ShadowOptions::default());
    expect("volumes", volumes, |error| matches!(error, ShadowVolumesError::Device(error) if is_other(error)))?;
    quiet("volumes")?;

    let mut encoder = ours.encoder();
    let found = extractor.encode(&mut encoder, packed(&foreign), &[LIGHT], None).map(drop);
    let refused = |error: &ExtractionEncodeError| {
        matches!(error, ExtractionEncodeError::Positions(PositionError::Refused { .. }))
    };
    expect("positions", found, refused)?;
    quiet("positions")?;
    let mut timer = StageTimer::new(&theirs.gpu.device, &theirs.gpu.queue).ok_or("no timer")?;
    let found = extractor.encode(&mut encoder, packed(&positions), &[LIGHT], Some(&mut timer)).map(drop);
    expect("timer", found, |error| matches!(error, ExtractionEncodeError::Device(error) if is_other(error)))?;
    quiet("timer")?;
    // The refused calls changed no state.
    let extraction = extractor.encode(&mut encoder, packed(&positions), &[LIGHT], None).map_err(text)?;
    let mut volumes = ShadowVolumes::new(&drawing, &extractor, ShadowOptions::default()).map_err(text)?;
    let found = volumes.encode(&mut encoder, &extraction, &camera(), Some(&mut timer));
    expect("volumes' timer", found, |error| matches!(error, ShadowEncodeError::Device(error) if is_other(error)))?;
    quiet("volumes' timer")?;
    let shadows = volumes.encode(&mut encoder, &extraction, &camera(), None).map_err(text)?;
    let view = depth_stencil(ours);
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("volumes"),
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: &view,
            depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Store }),
            stencil_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0), store: wgpu::StoreOp::Store }),
        }),
        ..Default::default()
    });
    let found = shadows.draw(&mut pass, &foreign_drawing, 0);
    expect("drawing", found, |error| matches!(error, ShadowDrawError::Device(error) if is_other(error)))?;
    shadows.draw(&mut pass, &drawing, 0).map_err(text)?;
    drop(pass);
    ours.gpu.queue.submit([encoder.finish()]);
    if ours.gpu.read::<u32>(extractor.results().counts, 1)? == [0] {
        return Err("no silhouette after what was refused".to_owned());
    }
    let layout = results_bind_group_layout(&theirs.gpu.device, wgpu::ShaderStages::COMPUTE);
    let found = extraction.bind_group(&layout, 0);
    expect("layout", found.map(drop), |error| {
        matches!(error, ExtractionIncludeError::Positions(PositionError::Refused { .. }))
    })?;
    quiet("layout")?;

    let options = ShadowQueryOptions { max_points: 64, ..Default::default() };
    let mut query = ShadowQuery::new(&ours.gpu.pipelines, &mesh, options).map_err(text)?;
    let mut encoder = ours.encoder();
    let found = query.encode_at(&mut encoder, packed(&foreign), packed(&positions), 9, &[LIGHT], None);
    expect("query", found, |error| matches!(error, ShadowQueryEncodeError::Positions(PositionError::Refused { .. })))?;
    let found = query.encode_at(&mut encoder, packed(&positions), packed(&foreign), 9, &[LIGHT], None);
    expect("points", found, |error| matches!(error, ShadowQueryEncodeError::Points(PositionError::Refused { .. })))?;
    let found = query.encode_at(&mut encoder, packed(&positions), packed(&positions), 9, &[LIGHT], Some(&mut timer));
    expect("query's timer", found, |error| matches!(error, ShadowQueryEncodeError::Device(error) if is_other(error)))?;
    quiet("query")?;
    let found = read_back_vec::<u32>(&ours.gpu.device, &ours.gpu.queue, &foreign);
    expect("reading back", found, |error| matches!(error, ReadError::Device { .. }))?;
    quiet("reading back")
}

fn is_lost(error: &DeviceError) -> bool {
    *error == DeviceError::Lost
}

fn made_on_lost() -> Result<(), String> {
    let watched = Watched::plain()?;
    let (_, mesh) = caster()?;
    let pipelines = &watched.gpu.pipelines;
    let extractor = extractor(&watched, &mesh, 1)?;
    let drawing = ShadowPipelines::new(pipelines, &ShadowFormat::default(), Counting::Auto).map_err(text)?;
    watched.gpu.device.destroy();
    let made = Extractor::new(pipelines, &mesh, ExtractorOptions::default());
    expect("extractor", made, |error| matches!(error, ExtractorError::Device(error) if is_lost(error)))?;
    let made = ShadowPipelines::new(pipelines, &ShadowFormat::default(), Counting::ZFail);
    expect("pipelines", made, |error| matches!(error, ShadowFormatError::Device(error) if is_lost(error)))?;
    let made = ShadowVolumes::new(&drawing, &extractor, ShadowOptions::default());
    expect("volumes", made, |error| matches!(error, ShadowVolumesError::Device(error) if is_lost(error)))?;
    let made = ShadowQuery::new(pipelines, &mesh, ShadowQueryOptions::default());
    expect("query", made, |error| matches!(error, ShadowQueryError::Device(error) if is_lost(error)))?;
    let model = random_model(&mut Random::new(93), 50);
    let made = Deformer::new(pipelines, &model, DeformerOptions::default());
    expect("deformer", made, |error| matches!(error, DeformError::Device(error) if is_lost(error)))?;
    // Nor with pipelines of one's own.
    let made = Extractor::new(&watched.gpu.device, &mesh, ExtractorOptions::default());
    expect("extractor", made, |error| matches!(error, ExtractorError::Device(error) if is_lost(error)))?;
    watched.quiet("constructors")
}

/// Objects that encode, made while the device was alive.
struct Made {
    extractor: Extractor,
    drawing: ShadowPipelines,
    volumes: ShadowVolumes,
    query: ShadowQuery,
    timer: StageTimer,
}

fn everything(watched: &Watched, mesh: &Mesh) -> Result<Made, String> {
    let extractor = extractor(watched, mesh, 1)?;
    let pipelines = &watched.gpu.pipelines;
    let drawing = ShadowPipelines::new(pipelines, &ShadowFormat::default(), Counting::Auto).map_err(text)?;
    let volumes = ShadowVolumes::new(&drawing, &extractor, ShadowOptions::default()).map_err(text)?;
    let options = ShadowQueryOptions { max_points: 64, ..Default::default() };
    let query = ShadowQuery::new(pipelines, mesh, options).map_err(text)?;
    let timer = StageTimer::new(&watched.gpu.device, &watched.gpu.queue).ok_or("no timer")?;
    Ok(Made { extractor, drawing, volumes, query, timer })
}

fn encoded_on_lost() -> Result<(), String> {
    let watched = Watched::new(wgpu::Features::TIMESTAMP_QUERY, wgpu::Limits::default())?;
    let (shape, mesh) = caster()?;
    let buffer = watched.gpu.storage(&shape.positions);
    let positions = packed(&buffer);
    let mut random = Random::new(94);
    let model = random_model(&mut random, 50);
    let pose = random_pose(&mut random, &model);
    let deformer = Deformer::new(&watched.gpu.pipelines, &model, DeformerOptions::default()).map_err(text)?;
    let layout = results_bind_group_layout(&watched.gpu.device, wgpu::ShaderStages::COMPUTE);
    // Lost before the first encode, and after one.
    let mut unused = everything(&watched, &mesh)?;
    let mut used = everything(&watched, &mesh)?;
    let extract = |made: &mut Made, encoder: &mut wgpu::CommandEncoder| {
        made.extractor.encode(encoder, positions, &[LIGHT], None).map_err(text)
    };
    // Recorded, and for one of them used by volumes too, before the device is lost.
    let mut extractions = watched
        .gpu
        .submit(|encoder| {
            let extractions = [extract(&mut unused, encoder)?, extract(&mut used, encoder)?];
            used.volumes.encode(encoder, &extractions[1], &camera(), None).map_err(text)?;
            Ok(extractions)
        })?
        .into_iter();
    let mut before = watched.encoder();
    watched.gpu.device.destroy();
    let mut after = watched.encoder();
    for (what, made, encoder) in [("unused", &mut unused, &mut before), ("used", &mut used, &mut after)] {
        let Made { extractor, volumes, query, timer, .. } = made;
        let extraction = extractions.next().ok_or("no extraction")?;
        let found = extractor.encode(encoder, positions, &[LIGHT], Some(timer)).map(drop);
        expect(what, found, |error| matches!(error, ExtractionEncodeError::Device(error) if is_lost(error)))?;
        let found = query.encode_at(encoder, positions, positions, 9, &[LIGHT], Some(timer));
        expect(what, found, |error| matches!(error, ShadowQueryEncodeError::Device(error) if is_lost(error)))?;
        let found = deformer.encode(encoder, &pose, 0.0, None, Some(timer));
        expect(what, found, |error| matches!(error, DeformError::Device(error) if is_lost(error)))?;
        if what == "used" {
            let found = volumes.encode(encoder, &extraction, &camera(), Some(timer));
            expect(what, found, |error| matches!(error, ShadowEncodeError::Device(error) if is_lost(error)))?;
        }
        let found = extraction.bind_group(&layout, 0);
        expect(what, found, |error| matches!(error, ExtractionIncludeError::Device(error) if is_lost(error)))?;
        timer.resolve(encoder);
        let found = timer.read(&watched.gpu.device, &watched.gpu.queue);
        expect(what, found, |error| matches!(error, TimerError::Read(ReadError::Device { .. })))?;
        let found = read_back_vec::<u32>(&watched.gpu.device, &watched.gpu.queue, extractor.results().counts);
        expect(what, found, |error| matches!(error, ReadError::Device { .. }))?;
        watched.quiet(what)?;
    }
    // wgpu itself takes encoders of a lost device.
    watched.gpu.queue.submit([before.finish(), after.finish()]);
    watched.quiet("submitting")?;
    drop((unused.drawing, used.drawing));
    Ok(())
}
