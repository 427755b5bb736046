//! Masks that cannot be written are typed errors, and nothing of them reaches the caller's encoder.

use std::sync::Arc;

use rimline::gpu::{
    Caster, DeviceError, MaskInputs, PositionBuffer, SceneFrame, SceneOptions, ShadowError, ShadowMasks,
};
use rimline::{Mesh, mesh::Weld};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::refusals::{Expected, is, refusal, refused, shows};
use rimline_testkit::shapes::Shape;
use wgpu::TextureFormat::{
    Depth16Unorm, Depth24Plus, Depth24PlusStencil8, Depth32Float, R8Uint, R8Unorm, R32Uint, Rgba8Unorm,
};
use wgpu::{TextureDimension, TextureUsages};

use crate::drawn::Picture;
use crate::world::{Encoded, World, encode};

pub(crate) const TESTS: &[Test] = &[
    ("frames_and_lights_that_have_no_masks_are_typed_errors", frames),
    ("textures_that_serve_no_masks_are_typed_errors", textures),
    ("textures_that_are_destroyed_between_calls_are_typed_errors", destroyed),
    ("frames_whose_buffers_are_destroyed_are_typed_errors", buffers),
];

const PICTURE: Picture = Picture { size: [16, 8], depth: Depth24Plus, samples: 1, target: R8Uint };

/// A frame with good inputs.
struct Given {
    gpu: Arc<Gpu>,
    other_device: Gpu,
    world: World,
    encoded: Encoded,
    depth: wgpu::TextureView,
    target: wgpu::Texture,
}

/// A texture of the picture's size with two layers.
fn odd(gpu: &Gpu, format: wgpu::TextureFormat, usage: TextureUsages, dimension: TextureDimension) -> wgpu::Texture {
    let [width, height] = PICTURE.size;
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 2 },
        mip_level_count: 1,
        sample_count: 1,
        dimension,
        format,
        usage,
        view_formats: &[],
    })
}

fn view(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

impl Given {
    fn new() -> Result<Self, String> {
        let gpu = Gpu::shared()?;
        let other_device = gpu.another(wgpu::Features::empty(), wgpu::Limits::default())?;
        let world = World::new(1, 0, 9);
        let encoded = gpu.submit(|encoder| world.encode(&gpu, encoder, SceneOptions::default()))?;
        let [depth, target] = [Depth24Plus, R8Uint].map(|format| PICTURE.texture(&gpu, format, 1, 1));
        Ok(Self { other_device, world, encoded, depth: view(&depth), target, gpu })
    }

    fn good(&self) -> MaskInputs<'_> {
        MaskInputs { depth: &self.depth, view: 0, lights: &self.encoded.lights[..3], target: &self.target }
    }

    fn write(&self, frame: &SceneFrame, masks: &mut ShadowMasks, inputs: MaskInputs<'_>) -> Result<(), ShadowError> {
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let written = frame.write_masks(&mut encoder, masks, &inputs);
        // An error in the encoder would end the test here.
        self.gpu.queue.submit([encoder.finish()]);
        written
    }

    /// Rows of inputs, and good ones before and after.
    fn refused<'a>(&'a self, mut rows: Vec<(&'a str, MaskInputs<'a>, Expected)>) -> Result<(), String> {
        let masks = &mut ShadowMasks::new(&self.gpu.pipelines).map_err(text)?;
        rows.insert(0, ("all good", self.good(), Expected::Taken));
        rows.push(("all good again", self.good(), Expected::Taken));
        let row = |(what, inputs, expected)| refusal(what, self.write(&self.encoded.frame, masks, inputs), expected);
        refused(rows.into_iter().map(row).collect::<Vec<_>>())
    }
}

fn frames() -> Result<(), String> {
    let mut given = Given::new()?;
    let stale = given.encoded.frame.clone();
    let again = given.gpu.submit(|encoder| encode(&mut given.encoded.scene, encoder, &[given.world.camera]))?;
    given.encoded.frame = again;
    let other = given.gpu.submit(|encoder| given.world.encode(&given.gpu, encoder, SceneOptions::default()))?;
    given.encoded.scene.remove_light(given.encoded.lights[8]).map_err(text)?;
    let later = given.encoded.scene.add_light(given.world.lights[0]).map_err(text)?;
    let (good, foreign) = (given.good(), ShadowError::OtherScene { what: "light" });
    given.refused(vec![
        ("a view too many", MaskInputs { view: 1, ..good }, is(ShadowError::NoSuchView { view: 1, views: 1 })),
        ("a later light", MaskInputs { lights: &[later], ..good }, is(ShadowError::NotEncoded)),
        ("a foreign light", MaskInputs { lights: &other.lights, ..good }, is(foreign)),
    ])?;
    // On a device that is another, and then lost.
    let device = &given.other_device;
    let masks = &mut ShadowMasks::new(&given.gpu.pipelines).map_err(text)?;
    let theirs = &mut ShadowMasks::new(&device.pipelines).map_err(text)?;
    let lost = device.submit(|encoder| given.world.encode(device, encoder, SceneOptions::default()))?;
    let [depth, target] = [Depth24Plus, R8Uint].map(|format| PICTURE.texture(device, format, 1, 1));
    let of_lost = MaskInputs { lights: &lost.lights[..3], depth: &view(&depth), view: 0, target: &target };
    let foreign = given.write(&given.encoded.frame, theirs, good);
    device.device.destroy();
    refused([
        refusal("an earlier frame", given.write(&stale, masks, good), is(ShadowError::StaleFrame)),
        refusal("another device", foreign, shows(&["Device(OtherDevice {", "`ShadowMasks`"])),
        refusal("a lost device", given.write(&lost.frame, theirs, of_lost), is(ShadowError::Device(DeviceError::Lost))),
    ])
}

fn textures() -> Result<(), String> {
    let given = &Given::new()?;
    let (gpu, good) = (&given.gpu, given.good());
    let texture = |format, samples| PICTURE.texture(gpu, format, samples, 1);
    let (drawn, read) = (TextureUsages::RENDER_ATTACHMENT, TextureUsages::TEXTURE_BINDING);
    let [unread, layers] = [drawn, drawn | read].map(|usage| view(&odd(gpu, Depth24Plus, usage, TextureDimension::D2)));
    let [foreign_depth, foreign] =
        [Depth24Plus, R8Uint].map(|format| PICTURE.texture(&given.other_device, format, 1, 1));
    let [foreign_depth, mask] = [view(&foreign_depth), view(&texture(R8Unorm, 1))];
    let [float, with_stencil, sixteen] =
        [Depth32Float, Depth24PlusStencil8, Depth16Unorm].map(|format| view(&texture(format, 1)));
    let depth = |depth| MaskInputs { depth, ..good };
    let needed = wgpu::Features::DEPTH32FLOAT_STENCIL8;
    let no_feature = is(ShadowError::MaskFeature { format: Depth32Float, needed });
    let refused = || shows(&["Refused { what: \"the depth\""]);
    given.refused(vec![
        ("depth that is not read", depth(&unread), is(ShadowError::MaskDepth { format: Depth24Plus })),
        ("a colour for depth", depth(&mask), is(ShadowError::MaskDepth { format: R8Unorm })),
        ("floats without the feature", depth(&float), no_feature),
        ("depth with its stencil", depth(&with_stencil), refused()),
        ("layers of depth", depth(&layers), refused()),
        ("depth of another device", depth(&foreign_depth), refused()),
        ("16 bits", depth(&sixteen), Expected::Taken),
    ])?;
    let destroyed = texture(R8Uint, 1);
    destroyed.destroy();
    let [colored, shares, words] = [Rgba8Unorm, R8Unorm, R32Uint].map(|format| texture(format, 1));
    let sampled = texture(R8Unorm, 4);
    let solid = odd(gpu, R8Uint, drawn, TextureDimension::D3);
    let unwritten = odd(gpu, R8Uint, read, TextureDimension::D2);
    let small = Picture { size: [8, 8], ..PICTURE }.texture(gpu, R8Uint, 1, 1);
    let all = &given.encoded.lights;
    let refused = || shows(&["Refused { what: \"the target\""]);
    let too_many = |lights, needed, format| is(ShadowError::MaskLayers { lights, needed, format, layers: 1 });
    let target = |target| MaskInputs { target, ..good };
    given.refused(vec![
        ("a target of another device", target(&foreign), refused()),
        ("a target that is gone", target(&destroyed), refused()),
        ("a format of no masks", target(&colored), is(ShadowError::MaskFormat { format: Rgba8Unorm })),
        ("samples of a target", MaskInputs { lights: &all[..1], ..target(&sampled) }, shows(&["Target { samples: 4"])),
        ("a solid target", target(&solid), shows(&["Target { samples: 1, dimension: D3"])),
        ("a target that is not drawn", target(&unwritten), shows(&["Target {", "TEXTURE_BINDING"])),
        ("another size", target(&small), is(ShadowError::MaskSize { target: [8, 8], depth: [16, 8] })),
        ("shares without layers", MaskInputs { lights: &all[..8], ..target(&shares) }, too_many(8, 8, R8Unorm)),
        ("nine lights in a byte", MaskInputs { lights: all, ..good }, too_many(9, 2, R8Uint)),
        ("words", target(&words), Expected::Taken),
    ])
}

/// The first call took the textures, and may remember them.
fn destroyed() -> Result<(), String> {
    let given = &Given::new()?;
    let masks = &mut ShadowMasks::new(&given.gpu.pipelines).map_err(text)?;
    let [depth, target] = [Depth24Plus, R8Uint].map(|format| PICTURE.texture(&given.gpu, format, 1, 1));
    let seen = &view(&depth);
    let mut write = |inputs| given.write(&given.encoded.frame, masks, inputs);
    let both = write(MaskInputs { depth: seen, target: &target, ..given.good() });
    target.destroy();
    let without_target = write(MaskInputs { depth: seen, target: &target, ..given.good() });
    let another_target = write(MaskInputs { depth: seen, ..given.good() });
    depth.destroy();
    let without_depth = write(MaskInputs { depth: seen, ..given.good() });
    refused([
        refusal("both textures", both, Expected::Taken),
        refusal("a target that was destroyed", without_target, shows(&["Refused { what: \"the target\""])),
        refusal("another target", another_target, Expected::Taken),
        refusal("a depth that was destroyed", without_depth, shows(&["Refused { what: \"the depth\""])),
        refusal("all good", write(given.good()), Expected::Taken),
    ])
}

/// The volumes of a frame read the buffers of its casters.
fn buffers() -> Result<(), String> {
    let mut given = Given::new()?;
    let Encoded { scene, frame, .. } = &mut given.encoded;
    let Shape { positions, faces } = &given.world.casters[0];
    let buffer = given.gpu.storage(positions);
    let mesh = Mesh::new(positions, faces, Weld::Position).map_err(text)?;
    let mesh = scene.add_mesh(&mesh, positions).map_err(text)?;
    scene.insert(Caster::in_buffer(mesh, PositionBuffer { buffer: &buffer, offset: 0, stride: 12 })).map_err(text)?;
    *frame = given.gpu.submit(|encoder| encode(scene, encoder, &[given.world.camera]))?;
    let masks = &mut ShadowMasks::new(&given.gpu.pipelines).map_err(text)?;
    let before = given.write(&given.encoded.frame, masks, given.good());
    buffer.destroy();
    let after = given.write(&given.encoded.frame, masks, given.good());
    refused([
        refusal("a buffer", before, Expected::Taken),
        refusal("a destroyed buffer", after, shows(&["Device(BufferRefused"])),
    ])
}
