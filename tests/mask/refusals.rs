//! Masks that cannot be written are typed errors, and nothing of them reaches the caller's encoder.

use rimline::gpu::{DeviceError, MaskError, MaskInputs, SceneOptions, ShadowError, ShadowMasks};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::refusals::{Expected, is, refusal, refused, shows};
use wgpu::TextureFormat::{Depth16Unorm, Depth24Plus, Depth32Float, R8Uint, R8Unorm, R32Uint, Rgba8Unorm};

use crate::drawn::Picture;
use crate::world::{World, encode};

pub(crate) const TESTS: &[Test] = &[("masks_that_cannot_be_written_are_typed_errors", errors)];

const PICTURE: Picture = Picture { size: [16, 8], depth: Depth24Plus, samples: 1, target: R8Uint };

fn depth_view(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// A texture of the picture's size in other usages or dimensions.
fn odd(
    gpu: &Gpu,
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
    dimension: wgpu::TextureDimension,
) -> wgpu::Texture {
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

fn errors() -> Result<(), String> {
    use wgpu::TextureUsages as Usages;
    let gpu = &*Gpu::shared()?;
    let other_device = gpu.another(wgpu::Features::empty(), wgpu::Limits::default())?;
    let masks = &mut ShadowMasks::new(&gpu.pipelines).map_err(text)?;
    let foreign_masks = &mut ShadowMasks::new(&other_device.pipelines).map_err(text)?;
    let world = World::new(1, 0, 9);
    let (mut encoded, stale) = gpu.submit(|encoder| {
        let mut encoded = world.encode(gpu, encoder, SceneOptions::default())?;
        let stale = encoded.frame.clone();
        encoded.frame = encode(&mut encoded.scene, encoder, &[world.camera])?;
        Ok((encoded, stale))
    })?;
    let other = gpu.submit(|encoder| world.encode(gpu, encoder, SceneOptions::default()))?;
    let later = {
        encoded.scene.remove_light(encoded.lights[8]).map_err(text)?;
        encoded.scene.add_light(world.lights[0]).map_err(text)?
    };
    let frame = &encoded.frame;
    let lights = &encoded.lights[..3];
    let attachment = Usages::RENDER_ATTACHMENT;
    let two = wgpu::TextureDimension::D2;
    let texture = |format, samples| PICTURE.texture(gpu, format, samples, 1);
    let depth_map = texture(Depth24Plus, 1);
    let (depth, target) = (&depth_view(&depth_map), &texture(R8Uint, 1));
    let good = MaskInputs { depth, view: 0, lights, target };
    let write = |frame: &rimline::gpu::SceneFrame, masks: &mut ShadowMasks, inputs: MaskInputs<'_>| {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let written = frame.write_masks(&mut encoder, masks, &inputs);
        // What is wrong in the encoder would end the test here.
        gpu.queue.submit([encoder.finish()]);
        written
    };
    let shadow = |error| is(MaskError::Shadow(error));
    let unread = depth_view(&odd(gpu, Depth24Plus, attachment, two));
    let colored = depth_view(&texture(R8Unorm, 1));
    let float = depth_view(&texture(Depth32Float, 1));
    let small = Picture { size: [8, 8], ..PICTURE };
    let small = small.texture(gpu, R8Uint, 1, 1);
    let foreign = PICTURE.texture(&other_device, R8Uint, 1, 1);
    let foreign_depth = depth_view(&PICTURE.texture(&other_device, Depth24Plus, 1, 1));
    let array = depth_view(&odd(gpu, Depth24Plus, attachment | Usages::TEXTURE_BINDING, two));
    let with_stencil = depth_view(&texture(wgpu::TextureFormat::Depth24PlusStencil8, 1));
    let destroyed = texture(R8Uint, 1);
    destroyed.destroy();
    let solid = odd(gpu, R8Uint, attachment, wgpu::TextureDimension::D3);
    let unwritten = odd(gpu, R8Uint, Usages::TEXTURE_BINDING, two);
    let needed = wgpu::Features::DEPTH32FLOAT_STENCIL8;
    let sized = MaskError::Size { target: [8, 8], depth: [16, 8] };
    let many = MaskError::TooManyLights { lights: 8, needed: 8, format: R8Unorm, layers: 1 };
    let mut rows = vec![
        refusal("all good", write(frame, masks, good), Expected::Taken),
        refusal("an earlier frame", write(&stale, masks, good), shadow(ShadowError::StaleFrame)),
        refusal(
            "a view too many",
            write(frame, masks, MaskInputs { view: 1, ..good }),
            shadow(ShadowError::NoSuchView { view: 1, views: 1 }),
        ),
        refusal(
            "a later light",
            write(frame, masks, MaskInputs { lights: &[later], ..good }),
            shadow(ShadowError::NotEncoded),
        ),
        refusal(
            "a foreign light",
            write(frame, masks, MaskInputs { lights: &other.lights, ..good }),
            shadow(ShadowError::OtherScene { what: "light" }),
        ),
        refusal("another device", write(frame, foreign_masks, good), shows(&["Device(OtherDevice {", "the masks"])),
        refusal(
            "depth that is not read",
            write(frame, masks, MaskInputs { depth: &unread, ..good }),
            is(MaskError::Depth { format: Depth24Plus }),
        ),
        refusal(
            "a colour for depth",
            write(frame, masks, MaskInputs { depth: &colored, ..good }),
            is(MaskError::Depth { format: R8Unorm }),
        ),
        refusal(
            "floats without the feature",
            write(frame, masks, MaskInputs { depth: &float, ..good }),
            is(MaskError::Feature { format: Depth32Float, needed }),
        ),
        refusal(
            "depth with its stencil",
            write(frame, masks, MaskInputs { depth: &with_stencil, ..good }),
            shows(&["Refused { what: \"the depth\""]),
        ),
        refusal(
            "layers of depth",
            write(frame, masks, MaskInputs { depth: &array, ..good }),
            shows(&["Refused { what: \"the depth\""]),
        ),
        refusal(
            "depth of another device",
            write(frame, masks, MaskInputs { depth: &foreign_depth, ..good }),
            shows(&["Refused { what: \"the depth\""]),
        ),
        refusal(
            "a target of another device",
            write(frame, masks, MaskInputs { target: &foreign, ..good }),
            shows(&["Refused { what: \"the target\""]),
        ),
        refusal(
            "a target that is gone",
            write(frame, masks, MaskInputs { target: &destroyed, ..good }),
            shows(&["Refused { what: \"the target\""]),
        ),
        refusal(
            "a format of no masks",
            write(frame, masks, MaskInputs { target: &texture(Rgba8Unorm, 1), ..good }),
            is(MaskError::TargetFormat { format: Rgba8Unorm }),
        ),
        refusal(
            "samples of a target",
            write(frame, masks, MaskInputs { target: &texture(R8Unorm, 4), lights: &lights[..1], ..good }),
            shows(&["Target { samples: 4"]),
        ),
        refusal(
            "a solid target",
            write(frame, masks, MaskInputs { target: &solid, ..good }),
            shows(&["Target { samples: 1, dimension: D3"]),
        ),
        refusal(
            "a target that is not drawn",
            write(frame, masks, MaskInputs { target: &unwritten, ..good }),
            shows(&["Target {", "TEXTURE_BINDING"]),
        ),
        refusal("another size", write(frame, masks, MaskInputs { target: &small, ..good }), is(sized)),
        refusal(
            "shares without layers",
            write(frame, masks, MaskInputs { target: &texture(R8Unorm, 1), lights: &encoded.lights[..8], ..good }),
            is(many),
        ),
        refusal(
            "nine lights in a byte",
            write(frame, masks, MaskInputs { lights: &encoded.lights, ..good }),
            is(MaskError::TooManyLights { lights: 9, needed: 2, format: R8Uint, layers: 1 }),
        ),
        refusal(
            "16 bits",
            write(frame, masks, MaskInputs { depth: &depth_view(&texture(Depth16Unorm, 1)), ..good }),
            Expected::Taken,
        ),
        refusal("words", write(frame, masks, MaskInputs { target: &texture(R32Uint, 1), ..good }), Expected::Taken),
    ];
    let lost = other_device.submit(|encoder| world.encode(&other_device, encoder, SceneOptions::default()))?;
    let lost_inputs = MaskInputs { lights: &lost.lights[..3], depth: &foreign_depth, view: 0, target: &foreign };
    other_device.device.destroy();
    let lost = write(&lost.frame, foreign_masks, lost_inputs);
    rows.push(refusal("a device that is lost", lost, is(MaskError::Device(DeviceError::Lost))));
    rows.push(refusal("all good again", write(frame, masks, good), Expected::Taken));
    refused(rows)
}
