//! Typed errors for input that would draw wrong shadows: formats, cameras, lights, extractors and pipelines that do not fit
//! together.

use glam::camera::rh::proj::directx::{orthographic, perspective, perspective_infinite, perspective_infinite_reverse};
use glam::camera::rh::view::look_at_mat4;
use glam::{Mat4, Vec3};
use rimline::gpu::{
    DrawArguments, Extraction, ExtractionDrawError, ExtractionIncludeError, Extractor, ExtractorOptions, MemoryError,
    PositionBuffer, ShadowDrawError, ShadowEncodeError, ShadowFormat, ShadowFormatError, ShadowFrame, ShadowOptions,
    ShadowPipelines, ShadowVolumes, ShadowVolumesError, StaleExtraction,
};
use rimline::reference::layout::ShadowDraws;
use rimline::{CameraError, Counting, DepthDirection, Light, ShadowCamera};
use rimline_testkit::shapes;

use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::{limited, text};
use rimline_testkit::{must_fail, same};

pub(crate) const TESTS: &[Test] = &[
    ("formats_that_do_not_serve_are_typed_errors", formats),
    ("z_fail_needs_pipelines_for_the_cameras_far_plane", far_planes),
    ("depth_of_camera_and_pipelines_must_agree", depths),
    ("mirror_images_need_pipelines_for_them", mirrors),
    ("near_planes_next_to_the_eye_are_refused", near_planes),
    ("volumes_belong_to_one_extractor", extractors),
    ("what_was_overwritten_and_lights_not_there_are_refused", stale),
    ("no_lights_draw_nothing", no_lights),
    ("pipelines_must_count_as_the_volumes_do", pipelines),
    ("default_lists_of_cap_faces_fit_the_device", capacities),
];

const METHODS: [Counting; 5] =
    [Counting::Auto, Counting::ZPass, Counting::ZpPlus, Counting::ZpPlus2005, Counting::ZFail];

/// Methods that draw z-fail.
fn is_fail(counting: Counting) -> bool {
    matches!(counting, Counting::ZFail | Counting::ZpPlus2005)
}

fn formats() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let made = |gpu: &Gpu, format: &ShadowFormat, counting| {
        ShadowPipelines::new(&gpu.pipelines, format, counting).map(|pipelines| pipelines.counting())
    };
    let depth_stencil = |depth_stencil| ShadowFormat { depth_stencil, ..ShadowFormat::default() };
    for format in [
        wgpu::TextureFormat::Depth32Float,
        wgpu::TextureFormat::Depth24Plus,
        wgpu::TextureFormat::Stencil8,
        wgpu::TextureFormat::Rgba8Unorm,
    ] {
        let found = made(gpu, &depth_stencil(format), Counting::Auto);
        same("no depth or no stencil", &[found], &[Err(ShadowFormatError::NoStencil(format))])?;
    }
    let format = wgpu::TextureFormat::Depth32FloatStencil8;
    let needed = wgpu::Features::DEPTH32FLOAT_STENCIL8;
    let found = made(gpu, &depth_stencil(format), Counting::Auto);
    same("a feature", &[found], &[Err(ShadowFormatError::Feature { format, needed })])?;
    let with = Gpu::with(needed | wgpu::Features::DEPTH_CLIP_CONTROL, wgpu::Limits::default())?;
    same("with it", &[made(&with, &depth_stencil(format), Counting::Auto)], &[Ok(Counting::Auto)])?;
    let far = ShadowFormat { has_far_plane: true, ..ShadowFormat::default() };
    for counting in METHODS {
        let expected = if is_fail(counting) { Err(ShadowFormatError::DepthClip) } else { Ok(counting) };
        same("a far plane without DEPTH_CLIP_CONTROL", &[made(gpu, &far, counting)], &[expected])?;
        same("a far plane with it", &[made(&with, &far, counting)], &[Ok(counting)])?;
        same("no far plane", &[made(gpu, &ShadowFormat::default(), counting)], &[Ok(counting)])?;
    }
    Ok(())
}

/// A caster with all that it needs.
struct Caster<'a> {
    gpu: &'a Gpu,
    positions: wgpu::Buffer,
    extractor: Extractor,
    extraction: Option<Extraction>,
}

impl<'a> Caster<'a> {
    fn new(gpu: &'a Gpu) -> Result<Self, String> {
        let shape = shapes::torus(16, 8, 1.0, 0.4);
        let mesh = shape.mesh().map_err(text)?;
        let options = ExtractorOptions { max_lights: 4, ..Default::default() };
        let extractor = Extractor::new(&gpu.pipelines, &mesh, options).map_err(text)?;
        Ok(Self { gpu, positions: gpu.storage(&shape.positions), extractor, extraction: None })
    }

    fn volumes(&self, pipelines: &ShadowPipelines) -> Result<ShadowVolumes, String> {
        ShadowVolumes::new(pipelines, &self.extractor, ShadowOptions::default()).map_err(text)
    }

    fn extract(&mut self, lights: &[Light]) -> Result<Extraction, String> {
        let bound = PositionBuffer { buffer: &self.positions, offset: 0, stride: 12 };
        let extractor = &mut self.extractor;
        let extraction = self.gpu.submit(|encoder| extractor.encode(encoder, bound, lights, None).map_err(text))?;
        self.extraction = Some(extraction.clone());
        Ok(extraction)
    }

    /// Result of encoding the last extraction.
    fn encoded(&self, volumes: &mut ShadowVolumes, camera: &ShadowCamera) -> Result<Encoded, String> {
        let extraction = self.extraction.as_ref().ok_or("nothing was extracted")?;
        encoded(self.gpu, volumes, extraction, camera)
    }
}

type Encoded = Result<ShadowFrame, ShadowEncodeError>;

/// Result of encoding an extraction.
fn encoded(
    gpu: &Gpu,
    volumes: &mut ShadowVolumes,
    extraction: &Extraction,
    camera: &ShadowCamera,
) -> Result<Encoded, String> {
    gpu.submit(|encoder| Ok(volumes.encode(encoder, extraction, camera, None)))
}

const LIGHTS: [Light; 3] =
    [Light::point([0.0, 4.0, 1.0]), Light::directional([1.0, 2.0, 0.0]), Light::point([3.0, 1.0, 0.0])];

fn camera(projection: Mat4, depth: DepthDirection) -> ShadowCamera {
    let view = look_at_mat4(Vec3::new(1.0, 2.0, 6.0), Vec3::ZERO, Vec3::Y);
    ShadowCamera { view_projection: (projection * view).to_cols_array_2d(), origin: [0.0; 3], depth }
}

/// Cameras of both depth directions: without a far plane, with one, orthographic.
fn cameras() -> [(ShadowCamera, bool); 6] {
    use DepthDirection::{Reversed, Standard};
    let perspective = |near, far| perspective(1.0, 1.0, near, far);
    let orthographic = |near, far| orthographic(-2.0, 2.0, -2.0, 2.0, near, far);
    [
        (camera(perspective_infinite_reverse(1.0, 1.0, 0.1), Reversed), false),
        (camera(perspective_infinite(1.0, 1.0, 0.1), Standard), false),
        (camera(perspective(50.0, 0.1), Reversed), true),
        (camera(perspective(0.1, 50.0), Standard), true),
        (camera(orthographic(50.0, 0.1), Reversed), true),
        (camera(orthographic(0.1, 50.0), Standard), true),
    ]
}

/// Pipelines for no far plane and a camera that has one would have dark caps clipped.
fn far_planes() -> Result<(), String> {
    let gpu = &Gpu::with(wgpu::Features::DEPTH_CLIP_CONTROL, wgpu::Limits::default())?;
    let mut caster = Caster::new(gpu)?;
    caster.extract(&LIGHTS)?;
    for (number, (camera, camera_has)) in cameras().into_iter().enumerate() {
        for counting in METHODS {
            for has_far_plane in [false, true] {
                let format = ShadowFormat { depth: camera.depth, has_far_plane, ..ShadowFormat::default() };
                let pipelines = ShadowPipelines::new(&gpu.pipelines, &format, counting).map_err(text)?;
                let found = caster.encoded(&mut caster.volumes(&pipelines)?, &camera)?;
                let clips = is_fail(counting) && camera_has && !has_far_plane;
                let expected = if clips { Err(ShadowEncodeError::FarPlane { counting }) } else { Ok(()) };
                same(&format!("camera {number}, {counting:?}, {has_far_plane}"), &[found.map(drop)], &[expected])?;
            }
        }
    }
    let message = ShadowEncodeError::FarPlane { counting: Counting::ZFail }.to_string();
    if message.contains("DEPTH_CLIP_CONTROL") { Ok(()) } else { Err(message) }
}

fn depths() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut caster = Caster::new(gpu)?;
    caster.extract(&LIGHTS)?;
    for (camera, _) in cameras() {
        for depth in [DepthDirection::Reversed, DepthDirection::Standard] {
            let format = ShadowFormat { depth, ..ShadowFormat::default() };
            let pipelines = ShadowPipelines::new(&gpu.pipelines, &format, Counting::Auto).map_err(text)?;
            let found = caster.encoded(&mut caster.volumes(&pipelines)?, &camera)?;
            let differ = ShadowEncodeError::Depth { camera: camera.depth, pipelines: depth };
            let expected = if camera.depth == depth { Ok(()) } else { Err(differ) };
            same(&format!("{depth:?}"), &[found.map(drop)], &[expected])?;
        }
    }
    Ok(())
}

/// The camera with its y, or another axis, the other way round.
fn flipped(camera: ShadowCamera, axes: Vec3) -> ShadowCamera {
    let matrix = Mat4::from_scale(axes) * Mat4::from_cols_array_2d(&camera.view_projection);
    ShadowCamera { view_projection: matrix.to_cols_array_2d(), ..camera }
}

/// Near caps are wound by the light, and sides by the picture: a mirror image would count them against each other.
fn mirrors() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut caster = Caster::new(gpu)?;
    caster.extract(&LIGHTS)?;
    for (camera, _) in cameras() {
        let made = |front_face| {
            let format = ShadowFormat { depth: camera.depth, front_face, ..ShadowFormat::default() };
            ShadowPipelines::new(&gpu.pipelines, &format, Counting::Auto).map_err(text)
        };
        let [plain, mirroring] = [made(wgpu::FrontFace::Ccw)?, made(wgpu::FrontFace::Cw)?];
        let mirrored = flipped(camera, Vec3::new(1.0, -1.0, 1.0));
        same("the check", &[camera.check(), mirrored.check()], &[Ok(()), Err(CameraError::Mirrored)])?;
        for (camera, is_mirrored) in
            [(camera, false), (mirrored, true), (flipped(mirrored, Vec3::NEG_ONE.with_z(1.0)), true)]
        {
            for (pipelines, for_mirrors) in [(&plain, false), (&mirroring, true)] {
                let found = caster.encoded(&mut caster.volumes(pipelines)?, &camera)?;
                let expected = match (is_mirrored, for_mirrors) {
                    (true, false) => Err(ShadowEncodeError::Camera(CameraError::Mirrored)),
                    (false, true) => Err(ShadowEncodeError::Camera(CameraError::NotMirrored)),
                    _ => Ok(()),
                };
                let what = format!("{:?}, mirrored {is_mirrored}, for mirrors {for_mirrors}", camera.depth);
                same(&what, &[found.as_ref().map(|_| ()).map_err(Clone::clone)], &[expected])?;
                let Ok(frame) = found else { continue };
                let [own, other] = if for_mirrors { [&mirroring, &plain] } else { [&plain, &mirroring] };
                let (ccw, cw) = (wgpu::FrontFace::Ccw, wgpu::FrontFace::Cw);
                let [volumes, pipelines] = if for_mirrors { [cw, ccw] } else { [ccw, cw] };
                let refused = Err(ShadowDrawError::FrontFace { volumes, pipelines });
                same(&format!("{what}: drawn"), &[drawn(gpu, &frame, other, 0)?], &[refused])?;
                same(&format!("{what}: drawn by its own"), &[drawn(gpu, &frame, own, 0)?], &[Ok(())])?;
            }
        }
    }
    Ok(())
}

fn near_planes() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut caster = Caster::new(gpu)?;
    caster.extract(&LIGHTS)?;
    let pipelines = ShadowPipelines::new(&gpu.pipelines, &ShadowFormat::default(), Counting::Auto).map_err(text)?;
    for (near, is_good) in [(1e-30, true), (1e-33, true), (1e-35, false), (1e-36, false), (1e-38, false)] {
        let eye = Vec3::new(1.0, 2.0, 6.0);
        let view = look_at_mat4(Vec3::ZERO, -eye, Vec3::Y);
        let matrix = perspective_infinite_reverse(1.0, 1.0, 1.0) * view;
        let mut view_projection = matrix.to_cols_array_2d();
        // Without products that would round it away.
        view_projection[3][2] = near;
        let camera = ShadowCamera { view_projection, origin: eye.to_array(), depth: DepthDirection::Reversed };
        let expected = if is_good { Ok(()) } else { Err(CameraError::DepthRange) };
        same(&format!("{near:e}"), &[camera.check()], &[expected])?;
        let found = caster.encoded(&mut caster.volumes(&pipelines)?, &camera)?.map(drop);
        same(&format!("{near:e}"), &[found], &[expected.map_err(ShadowEncodeError::Camera)])?;
    }
    Ok(())
}

fn extractors() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let [mut caster, mut other] = [Caster::new(gpu)?, Caster::new(gpu)?];
    caster.extract(&LIGHTS)?;
    other.extract(&LIGHTS)?;
    let (camera, _) = cameras()[0];
    let pipelines = ShadowPipelines::new(&gpu.pipelines, &ShadowFormat::default(), Counting::Auto).map_err(text)?;
    let mut volumes = caster.volumes(&pipelines)?;
    let found = other.encoded(&mut volumes, &camera)?.map(drop);
    same("another extractor of an equal mesh", &[found], &[Err(ShadowEncodeError::OtherExtractor)])?;
    same("its own", &[caster.encoded(&mut volumes, &camera)?.map(drop)], &[Ok(())])
}

/// Every reader refuses results that were overwritten, and lights that are not there.
fn stale() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut caster = Caster::new(gpu)?;
    let (camera, _) = cameras()[0];
    let pipelines = ShadowPipelines::new(&gpu.pipelines, &ShadowFormat::default(), Counting::Auto).map_err(text)?;
    let mut volumes = caster.volumes(&pipelines)?;
    let mut expect = |what: &str, extraction: &Extraction, expected: Result<(), ShadowEncodeError>| {
        let found = encoded(gpu, &mut volumes, extraction, &camera)?;
        same(what, &[found.as_ref().map(|_| ()).map_err(Clone::clone)], &[expected])?;
        Ok::<_, String>(found.ok())
    };
    let first = caster.extract(&LIGHTS[..2])?;
    let one = expect("the first", &first, Ok(()))?.ok_or("no frame")?;
    let two = expect("the first again, for another frame", &first, Ok(()))?.ok_or("no frame")?;
    let draws = |frame: &ShadowFrame, light: usize| drawn(gpu, frame, &pipelines, light);
    same("an earlier frame", &[draws(&one, 0)?], &[Err(ShadowDrawError::StaleFrame)])?;
    same("the later frame", &[draws(&two, 0)?, draws(&two, 1)?], &[Ok(()), Ok(())])?;
    let missing = |light| Err(ShadowDrawError::NoSuchLight { light, lights: 2 });
    // One within the batch, one past it, one past what the extractor has room for.
    for light in [2, 3, 4, 31, 32, usize::MAX] {
        same("a light past those extracted", &[draws(&two, light)?], &[missing(light)])?;
    }
    let second = caster.extract(&LIGHTS[2..])?;
    same("after another encode", &[draws(&two, 0)?], &[Err(StaleExtraction.into())])?;
    expect("the first after another encode", &first, Err(StaleExtraction.into()))?;
    expect("the second", &second, Ok(()))?;
    let layout = rimline::gpu::results_bind_group_layout(&gpu.device, wgpu::ShaderStages::VERTEX);
    same("its bind group", &[first.bind_group(&layout, 0).map(drop)], &[Err(StaleExtraction.into())])?;
    same("its draws", &[first.draw_arguments(0).map(drop)], &[Err(ExtractionDrawError::Stale(StaleExtraction))])?;
    same("its results", &[first.results().map(drop)], &[Err(StaleExtraction)])?;
    let past = |light| Err(ExtractionDrawError::NoSuchLight { light, lights: 1 });
    same("draws past the lights", &[second.draw_arguments(1).map(drop)], &[past(1)])?;
    let batch = Err(ExtractionIncludeError::NoSuchBatch { batch: 1, batches: 1 });
    same("a batch past the lights", &[second.bind_group(&layout, 1).map(drop)], &[batch])?;
    same("a good one", &[second.bind_group(&layout, 0).map(drop)], &[Ok(())])?;
    // A refused extraction does not change the results.
    if caster.extract(&[Light::homogeneous([0.0; 4])]).is_ok() {
        return Err("no light was extracted".to_owned());
    }
    expect("the second after what was refused", &second, Ok(())).map(drop)
}

/// A frame without lights draws nothing, also where lights were before.
fn no_lights() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut caster = Caster::new(gpu)?;
    let (camera, _) = cameras()[0];
    let pipelines = ShadowPipelines::new(&gpu.pipelines, &ShadowFormat::default(), Counting::Auto).map_err(text)?;
    let mut volumes = caster.volumes(&pipelines)?;
    caster.extract(&LIGHTS)?;
    caster.encoded(&mut volumes, &camera)?.map_err(text)?;
    let silhouettes = |caster: &Caster<'_>| -> Result<Vec<u32>, String> {
        let draws: Vec<DrawArguments> = gpu.read(caster.extractor.results().draw_arguments, 4)?;
        Ok(draws.iter().map(|draw| draw.instance_count).collect())
    };
    let before = silhouettes(&caster)?;
    let none = caster.extract(&[])?;
    let frame = caster.encoded(&mut volumes, &camera)?.map_err(text)?;
    same("silhouettes of no lights", &silhouettes(&caster)?, &[0; 4])?;
    must_fail("silhouettes of three lights", &same("before", &before, &[0; 4]))?;
    let draws: Vec<ShadowDraws> = gpu.read(&volumes.draw_arguments()[0], 4)?;
    same("volumes of no lights", &draws, &[bytemuck::Zeroable::zeroed(); 4])?;
    let missing = Err(ShadowDrawError::NoSuchLight { light: 0, lights: 0 });
    same("drawing a light of none", &[drawn(gpu, &frame, &pipelines, 0)?], &[missing])?;
    same("batches", &[none.batches()], &[0])
}

/// Result of drawing a light.
fn drawn(
    gpu: &Gpu,
    frame: &ShadowFrame,
    pipelines: &ShadowPipelines,
    light: usize,
) -> Result<Result<(), ShadowDrawError>, String> {
    let target = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("target"),
        size: wgpu::Extent3d { width: 8, height: 8, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Depth24PlusStencil8,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    let target = target.create_view(&wgpu::TextureViewDescriptor::default());
    gpu.submit(|encoder| {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("target"),
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &target,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.5), store: wgpu::StoreOp::Store }),
                stencil_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0), store: wgpu::StoreOp::Store }),
            }),
            ..Default::default()
        });
        Ok(frame.draw(&mut pass, pipelines, light))
    })
}

/// Formats differ where attachments do; what volumes were made for must not.
fn pipelines() -> Result<(), String> {
    use DepthDirection::{Reversed, Standard};
    let gpu = &Gpu::with(wgpu::Features::DEPTH_CLIP_CONTROL, wgpu::Limits::default())?;
    let mut caster = Caster::new(gpu)?;
    caster.extract(&LIGHTS)?;
    let all = METHODS.map(|counting| {
        [Reversed, Standard].map(|depth| [false, true].map(|has_far_plane| (counting, depth, has_far_plane)))
    });
    let all: Vec<_> = all.into_iter().flatten().flatten().collect();
    let made = |&(counting, depth, has_far_plane): &(Counting, DepthDirection, bool)| {
        let format = ShadowFormat { depth, has_far_plane, ..ShadowFormat::default() };
        ShadowPipelines::new(&gpu.pipelines, &format, counting).map_err(text)
    };
    for ours in &all {
        let mut volumes = caster.volumes(&made(ours)?)?;
        let (camera, _) = cameras()[usize::from(ours.1 == Standard)];
        let frame = caster.encoded(&mut volumes, &camera)?.map_err(text)?;
        for theirs in &all {
            let drawing = made(theirs)?;
            let found = drawn(gpu, &frame, &drawing, 0)?;
            let expected = if ours.0 != theirs.0 {
                Err(ShadowDrawError::Counting { volumes: ours.0, pipelines: theirs.0 })
            } else if ours.1 != theirs.1 {
                Err(ShadowDrawError::Depth { volumes: ours.1, pipelines: theirs.1 })
            } else if is_fail(ours.0) && ours.2 && !theirs.2 {
                Err(ShadowDrawError::FarPlane)
            } else {
                Ok(())
            };
            same(&format!("{ours:?}, {theirs:?}"), &[found], &[expected])?;
        }
    }
    Ok(())
}

/// Lists that every face would have room in do not fit; by default they are as long as does, and what is asked for is
/// refused where it does not.
fn capacities() -> Result<(), String> {
    // 768 faces and 32 lights: 98,304 bytes for lists of all.
    let shape = shapes::torus(24, 16, 1.0, 0.4);
    let mesh = shape.mesh().map_err(text)?;
    let faces = mesh.faces().len() as u32;
    let extractor_options = ExtractorOptions { max_lights: 32, ..Default::default() };
    let made = |gpu: &Gpu, options| {
        let pipelines =
            ShadowPipelines::new(&gpu.pipelines, &ShadowFormat::default(), Counting::ZFail).map_err(text)?;
        let extractor = Extractor::new(&gpu.pipelines, &mesh, extractor_options).map_err(text)?;
        Ok::<_, String>(ShadowVolumes::new(&pipelines, &extractor, options).map(|_| ()))
    };
    let plain = ShadowOptions::default();
    let small = limited(64 << 10, 1 << 20, 64)?;
    same("by default", &[made(&small, plain)?], &[Ok(())])?;
    // Counts, and an entry for near caps, which z-fail has none of.
    let fitting = ((64 << 10) - 512) / (4 * 32) - 1;
    let bytes = |capacity: u32| 512 + 128 * (u64::from(capacity) + 1);
    let asked = |capacity| ShadowOptions { cap_capacity: Some(capacity), ..plain };
    same("all that fit", &[made(&small, asked(fitting))?], &[Ok(())])?;
    let binding = |bytes| {
        let what = "lists of cap faces";
        Err(ShadowVolumesError::Memory(MemoryError::Binding { what, bytes, limit: 64 << 10 }))
    };
    same("one more", &[made(&small, asked(fitting + 1))?], &[binding(bytes(fitting + 1))])?;
    same("every face", &[made(&small, asked(faces))?], &[binding(bytes(faces))])?;

    let gpu = &*Gpu::shared()?;
    let within = |memory_limit, cap_capacity| {
        let options = ShadowOptions { memory_limit: Some(memory_limit), cap_capacity, ..plain };
        made(gpu, options)
    };
    let Err(ShadowVolumesError::Memory(MemoryError::Total { bytes: least, .. })) = within(0, Some(1))? else {
        return Err("one entry a list was not refused".to_owned());
    };
    same("as little as can be", &[within(least, None)?], &[Ok(())])?;
    same("somewhat more", &[within(least + 10_000, None)?], &[Ok(())])?;
    match (within(least + 10_000, Some(faces))?, within(least - 1, None)?) {
        (
            Err(ShadowVolumesError::Memory(MemoryError::Total { .. })),
            Err(ShadowVolumesError::Memory(MemoryError::Total { .. })),
        ) => Ok(()),
        other => Err(format!("not refused: {other:?}")),
    }
}
