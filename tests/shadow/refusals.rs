//! Typed errors for input that would draw wrong shadows: formats, cameras, lights, scenes, receivers and pipelines that do
//! not fit together.

use glam::camera::rh::proj::directx::{orthographic, perspective, perspective_infinite, perspective_infinite_reverse};
use glam::camera::rh::view::look_at_mat4;
use glam::{Mat4, Vec3};
use rimline::gpu::depth_map::{DepthMapError, DepthMapPipelines};
use rimline::gpu::{
    Capacities, Caster, DeviceError, DrawArguments, Extractor, ExtractorOptions, FrameInputs, LightMask,
    PositionBuffer, Receivers, Scene, SceneFrame, SceneOptions, ShadowError, ShadowFormat, ShadowPipelines,
    StencilCounts, View,
};
use rimline::{CameraError, Counting, DepthDirection, Light, LightError, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::{limited, text, views};
use rimline_testkit::passes::{self, draw_small};
use rimline_testkit::refusals::{Expected, is, refusal, refused, shows};
use rimline_testkit::{IDENTITY, OneCaster, made_anew, must_fail, same, shapes};

pub(crate) const TESTS: &[Test] = &[
    ("formats_that_do_not_serve_are_typed_errors", formats),
    ("pipelines_must_fit_the_volumes_that_they_draw", pipelines),
    ("counts_own_one_to_eight_bits", count_bits),
    ("no_lights_draw_nothing", no_lights),
    ("scenes_refuse_cameras_lights_and_faces", recording),
    ("frames_of_scenes_refuse_what_does_not_go_with_them", drawing),
    ("receivers_that_cannot_be_read_are_refused", unreadable),
    ("default_lists_of_cap_faces_fit_the_device", capacities),
];

const METHODS: [Counting; 5] =
    [Counting::Auto, Counting::ZPass, Counting::ZpPlus, Counting::ZpPlus2005, Counting::ZFail];

/// Methods that draw z-fail.
fn is_fail(counting: Counting) -> bool {
    matches!(counting, Counting::ZFail | Counting::ZpPlus2005)
}

fn formats() -> Result<(), String> {
    let (gpu, with) = (&*Gpu::shared()?, &*Gpu::shared_with_depth_features()?);
    let made = |gpu: &Gpu, format: &ShadowFormat, counting| ShadowPipelines::new(&gpu.pipelines, format, counting);
    let depth_stencil = |depth_stencil| ShadowFormat { depth_stencil, ..ShadowFormat::default() };
    for format in [wgpu::TextureFormat::Depth24Plus, wgpu::TextureFormat::Stencil8, wgpu::TextureFormat::Rgba8Unorm] {
        let made = made(gpu, &depth_stencil(format), Counting::Auto);
        refused([refusal("no depth or no stencil", made, is(ShadowError::NoStencil(format)))])?;
    }
    let (format, needed) = (wgpu::TextureFormat::Depth32FloatStencil8, wgpu::Features::DEPTH32FLOAT_STENCIL8);
    let [plain, far] = [false, true].map(|has_far_plane| ShadowFormat { has_far_plane, ..ShadowFormat::default() });
    let feature = depth_stencil(format);
    refused([
        refusal("a feature", made(gpu, &feature, Counting::Auto), is(ShadowError::Feature { format, needed })),
        refusal("with it", made(with, &feature, Counting::Auto), Expected::Taken),
    ])?;
    for counting in METHODS {
        let clipped = if is_fail(counting) { is(ShadowError::DepthClip) } else { Expected::Taken };
        refused([
            refusal("a far plane without DEPTH_CLIP_CONTROL", made(gpu, &far, counting), clipped),
            refusal("a far plane with it", made(with, &far, counting), Expected::Taken),
        ])?;
        same("method", &[made(gpu, &plain, counting).map_err(text)?.counting()], &[counting])?;
    }
    Ok(())
}

fn camera(projection: Mat4, depth: DepthDirection) -> ShadowCamera {
    let view = look_at_mat4(Vec3::new(1.0, 2.0, 6.0), Vec3::ZERO, Vec3::Y);
    ShadowCamera { view_projection: (projection * view).to_cols_array_2d(), origin: [0.0; 3], depth }
}

fn plain_camera() -> ShadowCamera {
    camera(perspective_infinite_reverse(1.0, 1.0, 0.1), DepthDirection::Reversed)
}

/// The camera with its y, or another axis, the other way round.
fn flipped(camera: ShadowCamera, axes: Vec3) -> ShadowCamera {
    let matrix = Mat4::from_scale(axes) * Mat4::from_cols_array_2d(&camera.view_projection);
    ShadowCamera { view_projection: matrix.to_cols_array_2d(), ..camera }
}

/// A scene of a cube with two lights, encoded for a camera.
fn encoded(gpu: &Gpu, counting: Counting, camera: ShadowCamera) -> Result<impl Fn(&ShadowPipelines) -> Drawn, String> {
    let (mut scene, caster) = scene(gpu, SceneOptions { counting, ..SceneOptions::default() })?;
    let light = scene.add_light(Light::point([0.0, 4.0, 1.0])).map_err(text)?;
    scene.insert(caster).map_err(text)?;
    let frame = encode(gpu, &mut scene, &[camera]).map_err(text)?;
    Ok(move |pipelines: &ShadowPipelines| draw_small(gpu, |pass| frame.draw(pass, pipelines, 0, light)))
}

type Drawn = Result<Result<(), ShadowError>, String>;

fn scene(gpu: &Gpu, options: SceneOptions) -> Result<(Scene, Caster), String> {
    let shape = shapes::cube();
    let mut scene = Scene::new(&gpu.pipelines, &gpu.queue, options).map_err(text)?;
    let mesh = scene.add_mesh(&shape.mesh().map_err(text)?, &shape.positions).map_err(text)?;
    Ok((scene, Caster::rigid(mesh, IDENTITY)))
}

fn encode(gpu: &Gpu, scene: &mut Scene, cameras: &[ShadowCamera]) -> Result<SceneFrame, ShadowError> {
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let frame = scene.encode(&mut encoder, FrameInputs::new(&views(cameras)));
    gpu.queue.submit([encoder.finish()]);
    frame
}

/// Formats differ where attachments do; what volumes were made for must not. Near caps are wound by the light, and sides by
/// the picture, so a mirror image would count them against each other.
fn pipelines() -> Result<(), String> {
    use DepthDirection::{Reversed, Standard};
    let gpu = &*Gpu::shared_with_depth_features()?;
    let made = |format: ShadowFormat, counting| ShadowPipelines::new(&gpu.pipelines, &format, counting).map_err(text);
    let of = |depth, has_far_plane| ShadowFormat { depth, has_far_plane, ..ShadowFormat::default() };
    let standard = camera(perspective_infinite(1.0, 1.0, 0.1), Standard);
    let with_far = [
        camera(perspective(1.0, 1.0, 50.0, 0.1), Reversed),
        camera(perspective(1.0, 1.0, 0.1, 50.0), Standard),
        camera(orthographic(-2.0, 2.0, -2.0, 2.0, 50.0, 0.1), Reversed),
        camera(orthographic(-2.0, 2.0, -2.0, 2.0, 0.1, 50.0), Standard),
    ];
    for (number, ours) in METHODS.into_iter().enumerate() {
        let (plain, standard) = (encoded(gpu, ours, plain_camera())?, encoded(gpu, ours, standard)?);
        let theirs = METHODS[(number + 1) % METHODS.len()];
        let counting = is(ShadowError::OtherCounting { volumes: ours, pipelines: theirs });
        let depth = |volumes, pipelines| is(ShadowError::OtherDepth { volumes, pipelines });
        refused([
            refusal("alike", plain(&made(of(Reversed, false), ours)?)?, Expected::Taken),
            refusal("a far plane that is not needed", plain(&made(of(Reversed, true), ours)?)?, Expected::Taken),
            refusal("another method", plain(&made(of(Reversed, false), theirs)?)?, counting),
            refusal("standard depth", standard(&made(of(Standard, false), ours)?)?, Expected::Taken),
            refusal("reversed depth", standard(&made(of(Reversed, false), ours)?)?, depth(Standard, Reversed)),
            refusal("pipelines for the other", plain(&made(of(Standard, false), ours)?)?, depth(Reversed, Standard)),
        ])?;
        let far = with_far[number % 4];
        let drawn = encoded(gpu, ours, far)?;
        let without = if is_fail(ours) { is(ShadowError::OtherFarPlane) } else { Expected::Taken };
        refused([
            refusal("a far plane", drawn(&made(of(far.depth, true), ours)?)?, Expected::Taken),
            refusal("no far plane", drawn(&made(of(far.depth, false), ours)?)?, without),
        ])?;
    }
    let (ccw, cw) = (wgpu::FrontFace::Ccw, wgpu::FrontFace::Cw);
    for camera in [plain_camera(), with_far[3]] {
        let winding = |front_face| made(ShadowFormat { front_face, ..of(camera.depth, false) }, Counting::Auto);
        let (plain, mirroring) = (winding(ccw)?, winding(cw)?);
        let mirrored = flipped(camera, Vec3::new(1.0, -1.0, 1.0));
        same("the check", &[camera.check(), mirrored.check()], &[Ok(()), Err(CameraError::Mirrored)])?;
        for (camera, is_mirrored) in
            [(camera, false), (mirrored, true), (flipped(mirrored, Vec3::NEG_ONE.with_z(1.0)), true)]
        {
            let drawn = encoded(gpu, Counting::Auto, camera)?;
            let [matching, other] = if is_mirrored { [&mirroring, &plain] } else { [&plain, &mirroring] };
            let [volumes, pipelines] = if is_mirrored { [cw, ccw] } else { [ccw, cw] };
            let front_face = is(ShadowError::OtherFrontFace { volumes, pipelines });
            refused([
                refusal(format!("mirrored {is_mirrored}"), drawn(other)?, front_face),
                refusal(format!("mirrored {is_mirrored}, by its own"), drawn(matching)?, Expected::Taken),
            ])?;
        }
    }
    Ok(())
}

fn count_bits() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let format = |count_bits| ShadowFormat { count_bits, ..Default::default() };
    let volumes = |given| ShadowPipelines::new(&gpu.pipelines, &format(given), Counting::Auto);
    let scene = |count_bits, count_batches| {
        let stencil = StencilCounts { count_bits, count_batches, ..Default::default() };
        Scene::new(&gpu.pipelines, &gpu.queue, SceneOptions { stencil, ..Default::default() })
    };
    for given in [0, 9, u32::MAX] {
        let error = || ShadowError::CountBits { given, least: 1 };
        let maps = DepthMapPipelines::new(&gpu.pipelines, &format(given), 7);
        refused([
            refusal("volumes", volumes(given), is(error())),
            refusal("maps", maps, is(DepthMapError::Shadow(error()))),
            refusal("scene", scene(given, 1), is(error())),
        ])?;
    }
    let one = || is(ShadowError::CountBits { given: 1, least: 2 });
    let in_batches = ShadowPipelines::in_batches(&gpu.pipelines, &format(1), Counting::Auto);
    let shared = DepthMapPipelines::antialiased(&gpu.pipelines, &format(6), 5..8);
    let drawn = encoded(gpu, Counting::Auto, plain_camera())?(&volumes(7).map_err(text)?)?;
    refused([
        refusal("batches", in_batches, one()),
        refusal("scene in batches", scene(1, 2), one()),
        refusal("a bit of counts", shared, is(DepthMapError::Counted { bit: 5, count_bits: 6 })),
        refusal("counts of other bits", drawn, is(ShadowError::OtherCountBits { volumes: 8, pipelines: 7 })),
    ])
}

/// No lights are not refused: no silhouette is drawn then, also where lights were before. Scenes: `tests/scene/zero.rs`.
fn no_lights() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let shape = shapes::torus(16, 8, 1.0, 0.4);
    let (mesh, buffer) = (shape.mesh().map_err(text)?, gpu.storage(&shape.positions));
    let positions = PositionBuffer { buffer: &buffer, offset: 0, stride: 12 };
    let options = ExtractorOptions { max_lights: 4, ..Default::default() };
    let mut extractor = Extractor::new(&gpu.pipelines, &mesh, options).map_err(text)?;
    let mut silhouettes = |lights: &[Light]| {
        let extraction = gpu.submit(|encoder| extractor.encode(encoder, positions, lights).map_err(text))?;
        let draws: Vec<DrawArguments> = gpu.read(extractor.results().draw_arguments, 4)?;
        let instances: Vec<u32> = draws.iter().map(|draw| draw.instance_count).collect();
        Ok::<_, String>((instances, extraction.batches()))
    };
    let (before, _) = silhouettes(&[Light::point([0.0, 4.0, 1.0]), Light::directional([1.0, 2.0, 0.0])])?;
    let (none, batches) = silhouettes(&[])?;
    same("batches", &[batches], &[0])?;
    same("silhouettes of no lights", &none, &[0; 4])?;
    must_fail("silhouettes of two lights", &same("before", &before, &[0; 4]))
}

fn recording() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let good = plain_camera();
    let (mut scene, caster) = scene(gpu, SceneOptions::default())?;
    let bad = ShadowCamera { view_projection: [[0.0; 4]; 4], ..good };
    let singular = ShadowError::ViewCamera { view: 1, error: CameraError::Singular };
    refused([refusal("a singular camera", encode(gpu, &mut scene, &[good, bad]), is(singular))])?;
    // A light that extraction takes and shadows do not. It is refused at once, and nothing changes.
    let light = scene.add_light(Light::point([1.0, 5.0, 3.0])).map_err(text)?;
    let caster = scene.insert(caster).map_err(text)?;
    let negative = Light::homogeneous([1.0, 2.0, 3.0, -1.0]);
    let expected = || is(ShadowError::Light(LightError::NegativeWeight { index: 0, w: -1.0 }));
    let too_many = ShadowError::NoSuchFace { face: 12, faces: 12 };
    let gone = ShadowError::Removed { what: "light" };
    refused([
        refusal("a negative w", scene.add_light(negative), expected()),
        refusal("a light's negative w", scene.set_light(light, negative), expected()),
        refusal("the light as it was", encode(gpu, &mut scene, &[good]), Expected::Taken),
        refusal("a face too many", scene.set_excluded(caster, light, &[3, 12]), is(too_many)),
        refusal("the last face", scene.set_excluded(caster, light, &[3, 11]), Expected::Taken),
        refusal("removal", scene.remove_light(light), Expected::Taken),
        refusal("a light that is gone", scene.set_excluded(caster, light, &[3]), is(gone)),
        refusal("without light", encode(gpu, &mut scene, &[good]), Expected::Taken),
    ])
}

fn drawing() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let other_device = &gpu.another(wgpu::Features::empty(), wgpu::Limits::default())?;
    let format = ShadowFormat::default();
    let made = |gpu: &Gpu| ShadowPipelines::new(&gpu.pipelines, &format, Counting::Auto).map_err(text);
    let (right, elsewhere) = (made(gpu)?, made(other_device)?);
    let in_batches = ShadowPipelines::in_batches(&gpu.pipelines, &format, Counting::Auto).map_err(text)?;
    let (mut ours, caster) = scene(gpu, SceneOptions::default())?;
    let light = ours.add_light(Light::point([1.0, 5.0, 3.0])).map_err(text)?;
    ours.insert(caster).map_err(text)?;
    let (mut other, _) = scene(gpu, SceneOptions::default())?;
    let foreign = other.add_light(Light::point([1.0, 5.0, 3.0])).map_err(text)?;
    let view = View { lights: LightMask::ALL.without(foreign), ..View::new(plain_camera()) };
    let without = gpu.submit(|encoder| other.encode(encoder, FrameInputs::new(&[view])).map_err(text))?;
    let first = encode(gpu, &mut ours, &[plain_camera()]).map_err(text)?;
    let frame = encode(gpu, &mut ours, &[plain_camera()]).map_err(text)?;
    let later = ours.add_light(Light::point([2.0, 5.0, 3.0])).map_err(text)?;
    let draw = |frame: &SceneFrame, pipelines: &ShadowPipelines, view: usize, light| {
        draw_small(gpu, |pass| frame.draw(pass, pipelines, view, light))
    };
    refused([
        refusal("all good", draw(&frame, &right, 0, light)?, Expected::Taken),
        refusal("an earlier frame", draw(&first, &right, 0, light)?, is(ShadowError::StaleFrame)),
        refusal("a view too many", draw(&frame, &right, 1, light)?, is(ShadowError::NoSuchView { view: 1, views: 1 })),
        refusal("a light left out", draw(&without, &right, 0, foreign)?, is(ShadowError::NotInView { view: 0 })),
        refusal("a later light", draw(&frame, &right, 0, later)?, is(ShadowError::NotEncoded)),
        refusal("a foreign light", draw(&frame, &right, 0, foreign)?, is(ShadowError::OtherScene { what: "light" })),
        refusal("in batches", draw(&frame, &in_batches, 0, light)?, is(ShadowError::CountBatches { count_batches: 1 })),
        refusal("another device", draw(&frame, &elsewhere, 0, light)?, shows(&["Device(OtherDevice {"])),
    ])
}

/// The next encode is as if nothing had been asked.
fn unreadable() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (mut scene, caster) = scene(gpu, SceneOptions::default())?;
    scene.insert(caster).map_err(text)?;
    scene.add_light(Light::point([0.0, 5.0, 0.0])).map_err(text)?;
    let (depth, color) = (wgpu::TextureFormat::Depth24PlusStencil8, wgpu::TextureFormat::Rgba8Unorm);
    let plain = |format| passes::texture([20, 30], format);
    let size = wgpu::Extent3d { depth_or_array_layers: 2, ..plain(depth).size };
    let of_depth = wgpu::TextureViewDescriptor { aspect: wgpu::TextureAspect::DepthOnly, ..Default::default() };
    let both = wgpu::TextureViewDescriptor::default();
    let unbound = wgpu::TextureDescriptor { usage: wgpu::TextureUsages::RENDER_ATTACHMENT, ..plain(depth) };
    let layers = wgpu::TextureDescriptor { size, ..plain(depth) };
    for (what, texture, view, expected) in [
        ("format", plain(color), &both, is(ShadowError::ReceiversFormat { view: 0, format: color })),
        ("usage", unbound, &of_depth, is(ShadowError::ReceiversUsage { view: 0 })),
        ("both aspects", plain(depth), &both, shows(&["ReceiversRefused { view: 0,"])),
        ("several layers", layers, &of_depth, shows(&["ReceiversRefused { view: 0,"])),
        ("none", plain(depth), &of_depth, Expected::Taken),
    ] {
        let view = gpu.device.create_texture(&texture).create_view(view);
        let depth = Some(Receivers { depth: &view, sky_receives: false, version: None });
        gpu.submit(|encoder| {
            let encoded = scene.encode(encoder, FrameInputs::new(&[View { depth, ..View::new(plain_camera()) }]));
            refused([refusal(what, encoded, expected)])?;
            scene.encode(encoder, FrameInputs::new(&[plain_camera().into()])).map(drop).map_err(text)
        })?;
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
    let made = |gpu: &Gpu, memory_limit, caps| {
        let capacities = Capacities { caps, ..Capacities::default() };
        let options = SceneOptions { memory_limit, capacities, ..made_anew(32, Counting::ZFail) };
        let positions = gpu.storage(&shape.positions);
        let buffer = PositionBuffer { buffer: &positions, offset: 0, stride: 12 };
        let lights: Vec<Light> = (0..32).map(|n| Light::point([0.0, 4.0, n as f32])).collect();
        gpu.submit(|encoder| {
            let caster = OneCaster::new(&gpu.pipelines, &gpu.queue, &mesh, options);
            Ok(caster.and_then(|mut caster| caster.encode(encoder, buffer, &lights, Some(&plain_camera()), None)))
        })
    };
    let small = limited(64 << 10, 1 << 20, 64)?;
    // Counts, and an entry for near caps, which z-fail has none of.
    let fitting = ((64 << 10) - 512) / (4 * 32) - 1;
    let binding = |capacity: u32| {
        let (what, bytes) = ("lists of cap faces", 512 + 128 * (u64::from(capacity) + 1));
        is(ShadowError::Device(DeviceError::BindingTooLarge { what, bytes, limit: 64 << 10 }))
    };
    let gpu = &*Gpu::shared()?;
    // Each step says how much it needs.
    let mut least = 0;
    while let Err(ShadowError::Device(DeviceError::MemoryLimit { bytes, .. })) = made(gpu, Some(least), Some(1))? {
        least = bytes;
    }
    let too_little = || shows(&["Device(MemoryLimit {"]);
    refused([
        refusal("by default", made(&small, None, None)?, Expected::Taken),
        refusal("all that fit", made(&small, None, Some(fitting))?, Expected::Taken),
        refusal("one more", made(&small, None, Some(fitting + 1))?, binding(fitting + 1)),
        refusal("every face", made(&small, None, Some(faces))?, binding(faces)),
        refusal("as little as can be", made(gpu, Some(least), None)?, Expected::Taken),
        refusal("somewhat more", made(gpu, Some(least + 10_000), None)?, Expected::Taken),
        refusal("lists of every face", made(gpu, Some(least + 10_000), Some(faces))?, too_little()),
        refusal("a byte less", made(gpu, Some(least - 1), None)?, too_little()),
    ])
}
