//! Input that is refused, and the errors for it.

use rimline::gpu::depth_map::{
    DanglingEdges, DepthMap, DepthMapError, DepthMapMethod, DepthMapOptions, DepthMapPipelines, DepthMapVolumes,
};
use rimline::gpu::{DeviceError, ShadowError, ShadowFormat};
use rimline::{CameraError, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::passes::{self, depth_pass};
use rimline_testkit::refusals::{Expected, is, refusal, refused, shows};
use rimline_testkit::same;
use wgpu::TextureFormat;

use crate::picture::{REVERSED, STANDARD, by, contours};
use crate::stages::camera;
use rimline_testkit::textures::depth_view;

pub(crate) const TESTS: &[Test] = &[
    ("pipelines_and_volumes_that_cannot_be_made", making),
    ("maps_and_cameras_that_cannot_be_taken", encoding),
    ("objects_that_cannot_be_taken", objects_refused),
    ("frames_that_cannot_be_drawn", drawing),
    ("parities_of_bits_that_counts_own", beside_meshes),
    ("errors_tell_which_texture_is_wrong", sentences),
];

fn pipelines(gpu: &Gpu) -> Result<DepthMapPipelines, String> {
    DepthMapPipelines::new(&gpu.pipelines, &ShadowFormat::default(), 3).map_err(text)
}

fn making() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let no_stencil = ShadowFormat { depth_stencil: TextureFormat::Depth32Float, ..Default::default() };
    let stencil = DepthMapError::Shadow(ShadowError::NoStencil(TextureFormat::Depth32Float));
    let made = |format: ShadowFormat, bit| DepthMapPipelines::new(&gpu.pipelines, &format, bit);
    refused([
        refusal("bit", made(ShadowFormat::default(), 8), is(DepthMapError::Bits(8..9))),
        refusal(
            "no bits",
            DepthMapPipelines::antialiased(&gpu.pipelines, &ShadowFormat::default(), 3..3),
            is(DepthMapError::Bits(3..3)),
        ),
        refusal("stencil", made(no_stencil, 0), is(stencil)),
    ])?;
    let pipelines = pipelines(&gpu)?;
    let made = |size, options| DepthMapVolumes::new(&pipelines, size, options);
    for size in [[0, 5], [5, 0], [u32::MAX, u32::MAX], [1 << 15, 1 << 15]] {
        let expected = is(DepthMapError::Size(size[0], size[1]));
        refused([refusal("size", made(size, DepthMapOptions::default()), expected)])?;
    }
    let differences = |threshold, dangling| by(DepthMapMethod::Differences { threshold, dangling });
    let second = |low, high, dangling| by(DepthMapMethod::SecondDifferences { low, high, dangling });
    let biased = |slope_bias, options| DepthMapOptions { slope_bias, ..options };
    let walled = by(contours([1.0, 0.25, 0.01]));
    // The number that is refused, if one is.
    let mut rows = vec![
        (second(-0.1, 0.5, None), "low"),
        (second(0.5, 0.4, None), "low"),
        (second(0.5, 1.5, None), "high"),
        (second(f32::NAN, 0.5, None), "low"),
        (second(0.5, 0.5, None), ""),
        (by(contours([1.5, 0.25, 0.01])), "threshold"),
        (by(contours([0.01, 0.6, 0.01])), "sideways"),
        (by(contours([0.01, 0.25, 1.5])), "depth"),
        (by(contours([1.0, 0.5, 1.0])), ""),
        (biased(255.0, walled), ""),
        (biased(255.5, walled), "slope_bias"),
        (differences(1.5, None), "threshold"),
    ];
    for bad in [-0.1, f32::INFINITY, f32::NAN] {
        rows.extend([
            (differences(bad, None), "threshold"),
            (by(contours([bad, 0.25, 0.01])), "threshold"),
            (by(contours([0.01, bad, 0.01])), "sideways"),
            (by(contours([0.01, 0.25, bad])), "depth"),
            (biased(bad, DepthMapOptions::default()), "slope_bias"),
        ]);
    }
    for (share, cells, name) in
        [(-0.1, 1, "share"), (1.5, 1, "share"), (f32::NAN, 1, "share"), (0.5, 0, "cells"), (0.5, 65, "cells")]
    {
        let dangling = Some(DanglingEdges { share, cells });
        let automatic = by(DepthMapMethod::Automatic { dangling });
        rows.extend([automatic, differences(0.5, dangling), second(0.5, 0.5, dangling)].map(|options| (options, name)));
    }
    refused(rows.into_iter().map(|(options, name)| {
        let wrong = shows(&[&format!("Option {{ name: {name:?}")]);
        let expected = if name.is_empty() { Expected::Taken } else { wrong };
        refusal(format!("{options:?}"), made([4, 4], options), expected)
    }))?;
    let format = TextureFormat::Rgba8Unorm;
    let rounded = DepthMapOptions { rounded_to: Some(format), ..Default::default() };
    let two = DepthMapPipelines::antialiased(&gpu.pipelines, &ShadowFormat::default(), 6..8).map_err(text)?;
    refused([
        refusal("format", made([4, 4], rounded), is(DepthMapError::RoundedTo(format))),
        refusal("bits", DepthMapVolumes::new(&two, [8, 8], walled), is(DepthMapError::OneBit(2))),
    ])?;
    // Eight bytes for a sample, which one binding holds.
    let side = gpu.device.limits().max_texture_dimension_2d;
    let limit = gpu.device.limits().max_storage_buffer_binding_size / 256 * 256;
    let is_taken = 4 * (u64::from(side) + 2).pow(2) <= limit;
    let too_large = shows(&["BindingTooLarge {", &format!("limit: {limit}")]);
    let expected = if is_taken { Expected::Taken } else { too_large };
    refused([refusal("the largest map", made([side; 2], walled), expected)])?;
    // The limit of memory holds for all buffers together.
    let limited =
        |memory_limit, options| made([40, 40], DepthMapOptions { memory_limit: Some(memory_limit), ..options });
    let Some(DepthMapError::Device(DeviceError::MemoryLimit { bytes, .. })) = limited(1, walled).err() else {
        return Err("a byte is enough".to_owned());
    };
    let largest = made([40, 40], walled).map_err(text)?.cells().size();
    if bytes <= largest {
        return Err(format!("{bytes} bytes, {largest} of them for walls"));
    }
    refused([
        refusal("enough", limited(bytes, walled), Expected::Taken),
        refusal("a byte less", limited(bytes - 1, walled), shows(&["Device(MemoryLimit {"])),
        refusal("no memory", limited(0, walled), shows(&["Device(MemoryLimit {", "limit: 0"])),
        refusal("100 bytes", limited(100, DepthMapOptions::default()), shows(&["Device(MemoryLimit {", "limit: 100"])),
    ])
}

/// A texture of so many texels a side, samples and levels.
fn texture(
    gpu: &Gpu,
    (format, side): (TextureFormat, u32),
    [sample_count, mip_level_count]: [u32; 2],
    usage: wgpu::TextureUsages,
) -> wgpu::Texture {
    let plain = passes::texture([side; 2], format);
    gpu.device.create_texture(&wgpu::TextureDescriptor { sample_count, mip_level_count, usage, ..plain })
}

fn view(texture: &wgpu::Texture, base_mip_level: u32) -> wgpu::TextureView {
    let mip_level_count = Some(1);
    texture.create_view(&wgpu::TextureViewDescriptor { base_mip_level, mip_level_count, ..Default::default() })
}

const DRAWN: wgpu::TextureUsages = wgpu::TextureUsages::RENDER_ATTACHMENT;
const READ: wgpu::TextureUsages = wgpu::TextureUsages::TEXTURE_BINDING;

fn encoding() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let pipelines = pipelines(&gpu)?;
    let mut volumes = DepthMapVolumes::new(&pipelines, [8, 8], DepthMapOptions::default()).map_err(text)?;
    let mut encode = |texture: &wgpu::TextureView, light: ShadowCamera, eye: ShadowCamera| {
        gpu.submit(|encoder| Ok(volumes.encode(encoder, &DepthMap { texture, light, objects: None }, &eye)))
    };
    let accepted = "Depth16Unorm, Depth24Plus, Depth32Float, or R32Float";
    let (depth, half, map) = (TextureFormat::Depth32Float, TextureFormat::R16Float, || "the map".to_owned());
    let levels = || is(DepthMapError::MipLevels { map: map(), levels: 2 });
    let wrong_format = is(DepthMapError::MapFormat { map: map(), format: half, accepted });
    let wrong_size = is(DepthMapError::MapSize { map: map(), given: [9, 9], made: [8, 8] });
    for (what, format, counts, usage, level, expected) in [
        ("good", (depth, 8), [1, 1], DRAWN | READ, 0, Expected::Taken),
        ("format", (half, 8), [1, 1], DRAWN | READ, 0, wrong_format),
        ("size", (depth, 9), [1, 1], DRAWN | READ, 0, wrong_size),
        ("samples", (depth, 8), [4, 1], DRAWN | READ, 0, is(DepthMapError::Samples { map: map(), samples: 4 })),
        ("usage", (depth, 8), [1, 1], DRAWN, 0, is(DepthMapError::Usage(map()))),
        // The second level has the right size, and so has the first; the view does not say which is shown.
        ("the second level", (depth, 16), [1, 2], READ, 1, levels()),
        ("the first of two levels", (depth, 8), [1, 2], READ, 0, levels()),
        ("the second of two levels", (depth, 8), [1, 2], READ, 1, levels()),
    ] {
        let view = view(&texture(&gpu, format, counts, usage), level);
        refused([refusal(what, encode(&view, camera(STANDARD), camera(REVERSED))?, expected)])?;
    }
    let both = texture(&gpu, (TextureFormat::Depth24PlusStencil8, 8), [1, 1], DRAWN | READ);
    let (aspects, view) = (view(&both, 0), depth_view(&both));
    let (good, singular) = (camera(REVERSED), ShadowCamera { view_projection: [[0.0; 4]; 4], ..camera(REVERSED) });
    let mismatch = DepthMapError::Depth { what: "the eye", given: STANDARD, made: REVERSED };
    // The far plane is behind infinity by rounding: w is 0 before the depth is that of the far end.
    let rows = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, -0.999, -0.1], [0.0, 0.0, -1.0, 0.0]];
    let columns = std::array::from_fn(|column| rows.map(|row: [f32; 4]| row[column]));
    let behind = ShadowCamera { view_projection: columns, origin: [0.0; 3], depth: STANDARD };
    refused([
        refusal("two aspects", encode(&aspects, camera(STANDARD), good)?, shows(&["Refused {"])),
        refusal("depth", encode(&view, good, camera(STANDARD))?, is(mismatch)),
        refusal("eye", encode(&view, good, singular)?, is(DepthMapError::Camera(CameraError::Singular))),
        refusal("light", encode(&view, singular, good)?, is(DepthMapError::Light(CameraError::Singular))),
        refusal("far plane", encode(&view, behind, good)?, is(DepthMapError::FarPlane)),
    ])
}

fn drawing() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let pipelines = pipelines(&gpu)?;
    let standard = ShadowFormat { depth: STANDARD, ..Default::default() };
    let standard = DepthMapPipelines::new(&gpu.pipelines, &standard, 0).map_err(text)?;
    // Where the device has it, another format of the eye's depth.
    let other = TextureFormat::Depth32FloatStencil8;
    let has_other = gpu.device.features().contains(other.required_features());
    let other = ShadowFormat { depth_stencil: other, ..Default::default() };
    let other = has_other.then(|| DepthMapPipelines::new(&gpu.pipelines, &other, 0)).transpose().map_err(text)?;
    let mut volumes = DepthMapVolumes::new(&pipelines, [8, 8], DepthMapOptions::default()).map_err(text)?;
    let options = by(contours([1.0, 0.25, 0.001]));
    let mut walled = DepthMapVolumes::new(&pipelines, [8, 8], options).map_err(text)?;
    let map = depth_view(&texture(&gpu, (TextureFormat::Depth32Float, 8), [1, 1], DRAWN | READ));
    let view = view(&texture(&gpu, (TextureFormat::Depth24PlusStencil8, 8), [1, 1], DRAWN), 0);
    gpu.submit(|encoder| {
        let map = DepthMap { texture: &map, light: camera(REVERSED), objects: None };
        let first = volumes.encode(encoder, &map, &camera(REVERSED)).map_err(text)?;
        let second = volumes.encode(encoder, &map, &camera(REVERSED)).map_err(text)?;
        let walls = walled.encode(encoder, &map, &camera(REVERSED)).map_err(text)?;
        let mut pass = encoder.begin_render_pass(&depth_pass(&view, (None, Some(wgpu::LoadOp::Load))));
        let mismatch = DepthMapError::Depth { what: "the pipelines", given: STANDARD, made: REVERSED };
        refused([
            refusal("an earlier frame", first.draw(&mut pass, &pipelines), is(DepthMapError::StaleFrame)),
            refusal("depth", second.draw(&mut pass, &standard), is(mismatch)),
            refusal("the later frame", second.draw(&mut pass, &pipelines), Expected::Taken),
            refusal("walls", walls.draw(&mut pass, &pipelines), Expected::Taken),
        ])?;
        let [volumes, pipelines] = [TextureFormat::Depth24PlusStencil8, TextureFormat::Depth32FloatStencil8];
        let format = || is(DepthMapError::DepthFormat { volumes, pipelines });
        refused(other.iter().map(|other| refusal("format", second.draw(&mut pass, other), format())))
    })
}

fn objects_refused() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let pipelines = pipelines(&gpu)?;
    let of = |format, side, levels, usage| view(&texture(&gpu, (format, side), [1, levels], usage), 0);
    let map = of(TextureFormat::Depth32Float, 8, 1, DRAWN | READ);
    let right = of(TextureFormat::R32Uint, 8, 1, READ);
    let large = of(TextureFormat::R32Uint, 9, 1, READ);
    let unbound = of(TextureFormat::R32Uint, 8, 1, wgpu::TextureUsages::COPY_DST);
    let other = of(TextureFormat::R32Sint, 8, 1, READ);
    let many = of(TextureFormat::R32Uint, 8, 2, READ);
    let mut volumes = DepthMapVolumes::new(&pipelines, [8, 8], DepthMapOptions::default()).map_err(text)?;
    let name = || "the texture of objects".to_owned();
    let format = DepthMapError::MapFormat { map: name(), format: TextureFormat::R32Sint, accepted: "R32Uint" };
    gpu.submit(|encoder| {
        let mut encode = |objects| {
            let map = DepthMap { texture: &map, light: camera(REVERSED), objects };
            volumes.encode(encoder, &map, &camera(REVERSED))
        };
        refused([
            refusal("none", encode(None), Expected::Taken),
            refusal("right", encode(Some(&right)), Expected::Taken),
            refusal(
                "size",
                encode(Some(&large)),
                is(DepthMapError::MapSize { map: name(), given: [9, 9], made: [8, 8] }),
            ),
            refusal("usage", encode(Some(&unbound)), is(DepthMapError::Usage(name()))),
            refusal("format", encode(Some(&other)), is(format)),
            refusal("levels", encode(Some(&many)), is(DepthMapError::MipLevels { map: name(), levels: 2 })),
        ])
    })
}

/// Whole sentences: what is wrong, where, and what to do.
fn sentences() -> Result<(), String> {
    let map = || "map 2 of the cube".to_owned();
    let found = [
        DepthMapError::MapSize { map: map(), given: [9, 8], made: [4, 4] },
        DepthMapError::Usage(map()),
        DepthMapError::Samples { map: map(), samples: 4 },
        DepthMapError::MapFormat { map: map(), format: TextureFormat::R32Sint, accepted: "R32Uint" },
        DepthMapError::MipLevels { map: map(), levels: 3 },
        DepthMapError::NoObjects { face: 4 },
        DepthMapError::Option { name: "share", given: 1.5, range: "a share from 0 to 1" },
    ]
    .map(|error| error.to_string());
    let expected = [
        "map 2 of the cube has 9 × 8 texels, and 4 × 4 are needed; give textures of the size that was given to \
         `new`, or call `new` again",
        "map 2 of the cube lacks usage TEXTURE_BINDING; make the texture with it",
        "map 2 of the cube has 4 samples a texel; resolve it, or render it with one",
        "map 2 of the cube has R32Sint; take R32Uint",
        "map 2 of the cube has 3 mip levels; give a texture of one, for example a copy of that level",
        "map 4 of the cube has no texture of objects; give one for each map that is there, or none",
        "`share` is 1.5; take a share from 0 to 1",
    ]
    .map(str::to_owned);
    same("sentences", &found, &expected)
}

/// Parity bits beside counts of meshes.
fn beside_meshes() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let made = |count_bits, bits| {
        let format = ShadowFormat { count_bits, ..Default::default() };
        DepthMapPipelines::beside_meshes(&gpu.pipelines, &format, bits)
    };
    let counted = |bit, count_bits| is(DepthMapError::Counted { bit, count_bits });
    refused([
        refusal("all bits count", made(8, 7..8), counted(7, 8)),
        refusal("the lowest", made(8, 0..1), counted(0, 8)),
        refusal("one of two", made(7, 6..8), counted(6, 7)),
        refusal("no bit of the stencil", made(7, 8..9), is(DepthMapError::Bits(8..9))),
        refusal("no bit", made(4, 5..5), is(DepthMapError::Bits(5..5))),
    ])?;
    same("bits", &[made(7, 7..8).map_err(text)?.bits(), made(4, 4..8).map_err(text)?.bits()], &[7..8, 4..8])
}
