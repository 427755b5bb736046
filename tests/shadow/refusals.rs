//! Typed errors for input that would draw wrong shadows: formats, cameras, lights, extractors and pipelines that do not fit
//! together.

use glam::camera::rh::proj::directx::{orthographic, perspective, perspective_infinite, perspective_infinite_reverse};
use glam::camera::rh::view::look_at_mat4;
use glam::{Mat4, Vec3};
use rimline::gpu::{
    DeviceError, DrawArguments, Extractor, ExtractorOptions, PositionBuffer, ShadowError, ShadowFormat, ShadowPipelines,
};
use rimline::{CameraError, Counting, DepthDirection, Light, Mesh, ShadowCamera};
use rimline_testkit::shapes;

use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::{limited, text};
use rimline_testkit::passes::draw_small;
use rimline_testkit::refusals::{Expected, is, refusal, refused, shows};
use rimline_testkit::{OneCaster, OneCasterOptions, OneFrame, must_fail, same};

pub(crate) const TESTS: &[Test] = &[
    ("formats_that_do_not_serve_are_typed_errors", formats),
    ("mirror_images_need_pipelines_for_them", mirrors),
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
    let made = |gpu: &Gpu, format: &ShadowFormat, counting| ShadowPipelines::new(&gpu.pipelines, format, counting);
    let depth_stencil = |depth_stencil| ShadowFormat { depth_stencil, ..ShadowFormat::default() };
    for format in [
        wgpu::TextureFormat::Depth32Float,
        wgpu::TextureFormat::Depth24Plus,
        wgpu::TextureFormat::Stencil8,
        wgpu::TextureFormat::Rgba8Unorm,
    ] {
        let made = made(gpu, &depth_stencil(format), Counting::Auto);
        refused([refusal("no depth or no stencil", made, is(ShadowError::NoStencil(format)))])?;
    }
    let format = wgpu::TextureFormat::Depth32FloatStencil8;
    let needed = wgpu::Features::DEPTH32FLOAT_STENCIL8;
    let with = Gpu::with(needed | wgpu::Features::DEPTH_CLIP_CONTROL, wgpu::Limits::default())?;
    let [plain, far] = [false, true].map(|has_far_plane| ShadowFormat { has_far_plane, ..ShadowFormat::default() });
    let feature = depth_stencil(format);
    refused([
        refusal("a feature", made(gpu, &feature, Counting::Auto), is(ShadowError::Feature { format, needed })),
        refusal("with it", made(&with, &feature, Counting::Auto), Expected::Taken),
    ])?;
    for counting in METHODS {
        let clipped = if is_fail(counting) { is(ShadowError::DepthClip) } else { Expected::Taken };
        refused([
            refusal("a far plane without DEPTH_CLIP_CONTROL", made(gpu, &far, counting), clipped),
            refusal("a far plane with it", made(&with, &far, counting), Expected::Taken),
            refusal("no far plane", made(gpu, &plain, counting), Expected::Taken),
        ])?;
        same("method", &[made(gpu, &plain, counting).map_err(text)?.counting()], &[counting])?;
    }
    Ok(())
}

type Encoded = Result<OneFrame, ShadowError>;

/// A caster with all that it needs.
struct Caster<'a> {
    gpu: &'a Gpu,
    mesh: Mesh,
    positions: wgpu::Buffer,
}

impl<'a> Caster<'a> {
    fn new(gpu: &'a Gpu) -> Result<Self, String> {
        let shape = shapes::torus(16, 8, 1.0, 0.4);
        Ok(Self { gpu, mesh: shape.mesh().map_err(text)?, positions: gpu.storage(&shape.positions) })
    }

    fn position_buffer(&self) -> PositionBuffer<'_> {
        PositionBuffer { buffer: &self.positions, offset: 0, stride: 12 }
    }

    fn volumes(&self, counting: Counting) -> Result<OneCaster, String> {
        let options = OneCasterOptions { counting, max_lights: 4, ..OneCasterOptions::default() };
        OneCaster::new(&self.gpu.pipelines, &self.gpu.queue, &self.mesh, &options).map_err(text)
    }

    fn encode(&self, volumes: &mut OneCaster, lights: &[Light], camera: &ShadowCamera) -> Result<Encoded, String> {
        self.gpu.submit(|encoder| Ok(volumes.encode(encoder, self.position_buffer(), lights, Some(camera), None)))
    }

    /// Result of encoding new volumes.
    fn encoded(&self, counting: Counting, camera: &ShadowCamera) -> Result<Encoded, String> {
        self.encode(&mut self.volumes(counting)?, &LIGHTS, camera)
    }
}

fn made(gpu: &Gpu, format: &ShadowFormat, counting: Counting) -> Result<ShadowPipelines, String> {
    ShadowPipelines::new(&gpu.pipelines, format, counting).map_err(text)
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

/// Methods, depths, and whether there is a far plane.
fn all_conventions() -> Vec<(Counting, DepthDirection, bool)> {
    let depths = [DepthDirection::Reversed, DepthDirection::Standard];
    let of = |counting| depths.map(|depth| [false, true].map(|has_far_plane| (counting, depth, has_far_plane)));
    METHODS.map(of).into_iter().flatten().flatten().collect()
}

/// The camera with its y, or another axis, the other way round.
fn flipped(camera: ShadowCamera, axes: Vec3) -> ShadowCamera {
    let matrix = Mat4::from_scale(axes) * Mat4::from_cols_array_2d(&camera.view_projection);
    ShadowCamera { view_projection: matrix.to_cols_array_2d(), ..camera }
}

/// Near caps are wound by the light, and sides by the picture: a mirror image would count them against each other.
fn mirrors() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let caster = Caster::new(gpu)?;
    for (camera, _) in cameras() {
        let of = |front_face| ShadowFormat { depth: camera.depth, front_face, ..ShadowFormat::default() };
        let [plain, mirroring] =
            [wgpu::FrontFace::Ccw, wgpu::FrontFace::Cw].map(|front_face| made(gpu, &of(front_face), Counting::Auto));
        let (plain, mirroring) = (plain?, mirroring?);
        let mirrored = flipped(camera, Vec3::new(1.0, -1.0, 1.0));
        same("the check", &[camera.check(), mirrored.check()], &[Ok(()), Err(CameraError::Mirrored)])?;
        for (camera, is_mirrored) in
            [(camera, false), (mirrored, true), (flipped(mirrored, Vec3::NEG_ONE.with_z(1.0)), true)]
        {
            let frame = caster.encoded(Counting::Auto, &camera)?.map_err(text)?;
            let what = format!("{:?}, mirrored {is_mirrored}", camera.depth);
            let [matching, other] = if is_mirrored { [&mirroring, &plain] } else { [&plain, &mirroring] };
            let (ccw, cw) = (wgpu::FrontFace::Ccw, wgpu::FrontFace::Cw);
            let [volumes, pipelines] = if is_mirrored { [cw, ccw] } else { [ccw, cw] };
            let front_face = ShadowError::OtherFrontFace { volumes, pipelines };
            refused([
                refusal(format!("{what}: drawn"), drawn(gpu, &frame, other)?, is(front_face)),
                refusal(format!("{what}: drawn by its own"), drawn(gpu, &frame, matching)?, Expected::Taken),
            ])?;
        }
    }
    Ok(())
}

/// A frame without lights draws nothing, also where lights were before.
fn no_lights() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let caster = Caster::new(gpu)?;
    let (camera, _) = cameras()[0];
    let options = ExtractorOptions { max_lights: 4, ..Default::default() };
    let mut extractor = Extractor::new(&gpu.pipelines, &caster.mesh, options).map_err(text)?;
    let mut silhouettes = |lights: &[Light]| -> Result<(Vec<u32>, usize), String> {
        let extraction =
            gpu.submit(|encoder| extractor.encode(encoder, caster.position_buffer(), lights).map_err(text))?;
        let draws: Vec<DrawArguments> = gpu.read(extractor.results().draw_arguments, 4)?;
        Ok((draws.iter().map(|draw| draw.instance_count).collect(), extraction.batches()))
    };
    let (before, _) = silhouettes(&LIGHTS)?;
    let (none, batches) = silhouettes(&[])?;
    same("silhouettes of no lights", &none, &[0; 4])?;
    must_fail("silhouettes of three lights", &same("before", &before, &[0; 4]))?;
    same("batches", &[batches], &[0])?;
    let mut volumes = caster.volumes(Counting::Auto)?;
    caster.encode(&mut volumes, &LIGHTS, &camera)?.map_err(text)?;
    let frame = caster.encode(&mut volumes, &[], &camera)?.map_err(text)?;
    same("lights of the frame", &[frame.frame.lights().len(), frame.frame.batches()], &[0, 0])
}

/// Result of drawing the first light.
fn drawn(gpu: &Gpu, frame: &OneFrame, pipelines: &ShadowPipelines) -> Result<Result<(), ShadowError>, String> {
    draw_small(gpu, |pass| frame.draw(pass, pipelines, 0))
}

/// Formats differ where attachments do; what volumes were made for must not.
fn pipelines() -> Result<(), String> {
    let gpu = &Gpu::with(wgpu::Features::DEPTH_CLIP_CONTROL, wgpu::Limits::default())?;
    let caster = Caster::new(gpu)?;
    let all = all_conventions();
    let made = |&(counting, depth, has_far_plane): &(Counting, DepthDirection, bool)| {
        made(gpu, &ShadowFormat { depth, has_far_plane, ..ShadowFormat::default() }, counting)
    };
    for (number, ours) in all.iter().enumerate() {
        // Perspective and orthographic cameras with a far plane take turns.
        let far = if ours.2 { [2, 4][number / 2 % 2] } else { 0 };
        let (camera, has_far) = cameras()[far + usize::from(ours.1 == DepthDirection::Standard)];
        let frame = caster.encoded(ours.0, &camera)?.map_err(text)?;
        for theirs in &all {
            let found = drawn(gpu, &frame, &made(theirs)?)?;
            let expected = if ours.0 != theirs.0 {
                is(ShadowError::OtherCounting { volumes: ours.0, pipelines: theirs.0 })
            } else if ours.1 != theirs.1 {
                is(ShadowError::OtherDepth { volumes: ours.1, pipelines: theirs.1 })
            } else if is_fail(ours.0) && has_far && !theirs.2 {
                is(ShadowError::OtherFarPlane)
            } else {
                Expected::Taken
            };
            refused([refusal(format!("{ours:?}, {theirs:?}"), found, expected)])?;
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
    let made = |gpu: &Gpu, options: OneCasterOptions| {
        let positions = gpu.storage(&shape.positions);
        let buffer = PositionBuffer { buffer: &positions, offset: 0, stride: 12 };
        let lights: Vec<Light> = (0..32).map(|n| Light::point([0.0, 4.0, n as f32])).collect();
        gpu.submit(|encoder| {
            let caster = OneCaster::new(&gpu.pipelines, &gpu.queue, &mesh, &options);
            Ok(caster.and_then(|mut caster| caster.encode(encoder, buffer, &lights, Some(&cameras()[0].0), None)))
        })
    };
    let plain = OneCasterOptions { counting: Counting::ZFail, ..OneCasterOptions::default() };
    let small = limited(64 << 10, 1 << 20, 64)?;
    // Counts, and an entry for near caps, which z-fail has none of.
    let fitting = ((64 << 10) - 512) / (4 * 32) - 1;
    let bytes = |capacity: u32| 512 + 128 * (u64::from(capacity) + 1);
    let asked = |capacity| OneCasterOptions { cap_capacity: Some(capacity), ..plain };
    let binding = |bytes| {
        let what = "lists of cap faces";
        is(ShadowError::Device(DeviceError::BindingTooLarge { what, bytes, limit: 64 << 10 }))
    };
    refused([
        refusal("by default", made(&small, plain)?, Expected::Taken),
        refusal("all that fit", made(&small, asked(fitting))?, Expected::Taken),
        refusal("one more", made(&small, asked(fitting + 1))?, binding(bytes(fitting + 1))),
        refusal("every face", made(&small, asked(faces))?, binding(bytes(faces))),
    ])?;

    let gpu = &*Gpu::shared()?;
    let within = |memory_limit, cap_capacity| {
        made(gpu, OneCasterOptions { memory_limit: Some(memory_limit), cap_capacity, ..plain })
    };
    // Each step says how much it needs.
    let mut least = 0;
    while let Err(ShadowError::Device(DeviceError::MemoryLimit { bytes, .. })) = within(least, Some(1))? {
        least = bytes;
    }
    let too_little = || shows(&["Device(MemoryLimit {"]);
    refused([
        refusal("as little as can be", within(least, None)?, Expected::Taken),
        refusal("somewhat more", within(least + 10_000, None)?, Expected::Taken),
        refusal("lists of every face", within(least + 10_000, Some(faces))?, too_little()),
        refusal("a byte less", within(least - 1, None)?, too_little()),
    ])
}
