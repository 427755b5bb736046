//! Input that is refused, and the errors for it.

use rimline::gpu::{
    DanglingEdges, DepthMap, DepthMapError, DepthMapMethod, DepthMapOptions, DepthMapPipelines, DepthMapVolumes,
    MemoryError, ShadowFormat, ShadowFormatError,
};
use rimline::{CameraError, DepthDirection, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::same;
use wgpu::TextureFormat;

use crate::stages::camera;
use crate::textures::depth_view;

pub(crate) const TESTS: &[Test] = &[
    ("pipelines_and_volumes_that_cannot_be_made", making),
    ("maps_and_cameras_that_cannot_be_taken", encoding),
    ("objects_that_cannot_be_taken", objects_refused),
    ("frames_that_cannot_be_drawn", drawing),
    ("parities_of_bits_that_counts_own", beside_meshes),
    ("errors_tell_which_texture_is_wrong", sentences),
];

const REVERSED: DepthDirection = DepthDirection::Reversed;
const STANDARD: DepthDirection = DepthDirection::Standard;

fn pipelines(gpu: &Gpu) -> Result<DepthMapPipelines, String> {
    DepthMapPipelines::new(&gpu.pipelines, &ShadowFormat::default(), 3).map_err(text)
}

fn making() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let refused = |format: ShadowFormat, bit| DepthMapPipelines::new(&gpu.pipelines, &format, bit).err();
    let format = |depth_stencil| ShadowFormat { depth_stencil, ..Default::default() };
    same("bit", &[refused(ShadowFormat::default(), 8)], &[Some(DepthMapError::Bits(8..9))])?;
    let no_stencil = ShadowFormatError::NoStencil(TextureFormat::Depth32Float).into();
    same("stencil", &[refused(format(TextureFormat::Depth32Float), 0)], &[Some(no_stencil)])?;
    let pipelines = pipelines(&gpu)?;
    let refused = |size, options| DepthMapVolumes::new(&pipelines, size, options).err();
    for size in [[0, 5], [5, 0], [u32::MAX, u32::MAX], [1 << 15, 1 << 15]] {
        let expected = DepthMapError::Size(size[0], size[1]);
        same("size", &[refused(size, DepthMapOptions::default())], &[Some(expected)])?;
    }
    // The name of the number that is refused.
    let wrong = |options| match refused([4, 4], options) {
        Some(DepthMapError::Option { name, .. }) => Some(name),
        _ => None,
    };
    let with = |method| wrong(DepthMapOptions { method, ..Default::default() });
    for threshold in [-0.1, 1.5, f32::INFINITY, f32::NAN] {
        let found = with(DepthMapMethod::Differences { threshold, dangling: None });
        same("threshold", &[found], &[Some("threshold")])?;
    }
    let second = |low, high| with(DepthMapMethod::SecondDifferences { low, high, dangling: None });
    let found = [second(-0.1, 0.5), second(0.5, 0.4), second(0.5, 1.5), second(f32::NAN, 0.5), second(0.5, 0.5)];
    same("two", &found, &[Some("low"), Some("low"), Some("high"), Some("low"), None])?;
    for (share, cells, expected) in
        [(-0.1, 1, "share"), (1.5, 1, "share"), (f32::NAN, 1, "share"), (0.5, 0, "cells"), (0.5, 65, "cells")]
    {
        let dangling = Some(DanglingEdges { share, cells });
        for method in [
            DepthMapMethod::Automatic { dangling },
            DepthMapMethod::Differences { threshold: 0.5, dangling },
            DepthMapMethod::SecondDifferences { low: 0.5, high: 0.5, dangling },
        ] {
            same("dangling", &[with(method)], &[Some(expected)])?;
        }
    }
    for slope_bias in [-1.0, f32::INFINITY, f32::NAN] {
        let found = wrong(DepthMapOptions { slope_bias, ..Default::default() });
        same("bias", &[found], &[Some("slope_bias")])?;
    }
    let method = DepthMapMethod::Contours { threshold: 1.0, sideways: 0.25, depth: 0.01 };
    let walled = DepthMapOptions { method, ..Default::default() };
    let biased = [255.0, 255.5].map(|slope_bias| wrong(DepthMapOptions { slope_bias, ..walled }));
    same("contours' bias", &biased, &[None, Some("slope_bias")])?;
    // The limit of memory holds for all buffers together.
    let limited = |memory_limit| refused([40, 40], DepthMapOptions { memory_limit: Some(memory_limit), ..walled });
    let Some(DepthMapError::Memory(MemoryError::Total { bytes, .. })) = limited(1) else {
        return Err("a byte is enough".to_owned());
    };
    let largest = DepthMapVolumes::new(&pipelines, [40, 40], walled).map_err(text)?.cells().size();
    if limited(bytes).is_some() || limited(bytes - 1).is_none() || bytes <= largest {
        return Err(format!("{bytes} bytes, {largest} of them for walls"));
    }
    let options = DepthMapOptions { memory_limit: Some(100), ..Default::default() };
    match refused([40, 40], options) {
        Some(DepthMapError::Memory(MemoryError::Total { limit: 100, .. })) => Ok(()),
        other => Err(format!("{other:?}")),
    }
}

fn attachment(gpu: &Gpu, format: TextureFormat, side: u32, samples: u32, usage: wgpu::TextureUsages) -> wgpu::Texture {
    with_levels(gpu, (format, side), (samples, 1), usage)
}

/// A texture of two levels.
fn levels(gpu: &Gpu, format: TextureFormat, side: u32) -> wgpu::Texture {
    with_levels(gpu, (format, side), (1, 2), wgpu::TextureUsages::TEXTURE_BINDING)
}

fn with_levels(
    gpu: &Gpu,
    (format, side): (TextureFormat, u32),
    (samples, levels): (u32, u32),
    usage: wgpu::TextureUsages,
) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("map"),
        size: wgpu::Extent3d { width: side, height: side, depth_or_array_layers: 1 },
        mip_level_count: levels,
        sample_count: samples,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}

fn encoding() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let pipelines = pipelines(&gpu)?;
    let mut volumes = DepthMapVolumes::new(&pipelines, [8, 8], DepthMapOptions::default()).map_err(text)?;
    let (drawn, read) = (wgpu::TextureUsages::RENDER_ATTACHMENT, wgpu::TextureUsages::TEXTURE_BINDING);
    let mut refused = |texture: &wgpu::TextureView, light: ShadowCamera, eye: ShadowCamera| {
        gpu.submit(|encoder| Ok(volumes.encode(encoder, &DepthMap { texture, light, objects: None }, &eye, None).err()))
    };
    let taken = "Depth16Unorm, Depth24Plus, Depth32Float, or R32Float";
    let (depth, half, name) = (TextureFormat::Depth32Float, TextureFormat::R16Float, || "the map".to_owned());
    for (format, side, samples, usage, expected) in [
        (depth, 8, 1, drawn | read, None),
        (half, 8, 1, drawn | read, Some(DepthMapError::MapFormat { map: name(), format: half, taken })),
        (depth, 9, 1, drawn | read, Some(DepthMapError::MapSize { map: name(), given: [9, 9], made: [8, 8] })),
        (depth, 8, 4, drawn | read, Some(DepthMapError::Samples { map: name(), samples: 4 })),
        (depth, 8, 1, drawn, Some(DepthMapError::Usage(name()))),
    ] {
        let texture = attachment(&gpu, format, side, samples, usage);
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        same("texture", &[refused(&view, camera(STANDARD), camera(REVERSED))?], &[expected])?;
    }
    // The second level has the right size, and so has the first; the view does not tell which is shown.
    for (side, level) in [(16, 1), (8, 0), (8, 1)] {
        let texture = levels(&gpu, depth, side);
        let descriptor =
            wgpu::TextureViewDescriptor { base_mip_level: level, mip_level_count: Some(1), ..Default::default() };
        let found = refused(&texture.create_view(&descriptor), camera(STANDARD), camera(REVERSED))?;
        let expected = DepthMapError::MipLevels { map: name(), levels: 2 };
        same("levels", &[found], &[Some(expected)])?;
    }
    let both = attachment(&gpu, TextureFormat::Depth24PlusStencil8, 8, 1, drawn | read);
    let found =
        refused(&both.create_view(&wgpu::TextureViewDescriptor::default()), camera(STANDARD), camera(REVERSED))?;
    if !matches!(found, Some(DepthMapError::Refused { .. })) {
        return Err(format!("two aspects: {found:?}"));
    }
    let view = depth_view(&both);
    let (good, singular) = (camera(REVERSED), ShadowCamera { view_projection: [[0.0; 4]; 4], ..camera(REVERSED) });
    let mismatch = DepthMapError::Depth { what: "the eye", given: STANDARD, made: REVERSED };
    same("depth", &[refused(&view, good, camera(STANDARD))?], &[Some(mismatch)])?;
    same("eye", &[refused(&view, good, singular)?], &[Some(DepthMapError::Camera(CameraError::Singular))])?;
    same("light", &[refused(&view, singular, good)?], &[Some(DepthMapError::Light(CameraError::Singular))])?;
    // Near and far are told apart by the light's own depth: its w ends before its depth does.
    let rows = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, -0.999, -0.1], [0.0, 0.0, -1.0, 0.0]];
    let columns = std::array::from_fn(|column| rows.map(|row: [f32; 4]| row[column]));
    let behind = ShadowCamera { view_projection: columns, origin: [0.0; 3], depth: STANDARD };
    same("far plane", &[refused(&view, behind, good)?], &[Some(DepthMapError::FarPlane)])
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
    let method = DepthMapMethod::Contours { threshold: 1.0, sideways: 0.25, depth: 0.001 };
    let options = DepthMapOptions { method, ..Default::default() };
    let mut walled = DepthMapVolumes::new(&pipelines, [8, 8], options).map_err(text)?;
    let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING;
    let texture = depth_view(&attachment(&gpu, TextureFormat::Depth32Float, 8, 1, usage));
    let target = attachment(&gpu, TextureFormat::Depth24PlusStencil8, 8, 1, usage);
    let view = target.create_view(&wgpu::TextureViewDescriptor::default());
    let found = gpu.submit(|encoder| {
        let map = DepthMap { texture: &texture, light: camera(REVERSED), objects: None };
        let first = volumes.encode(encoder, &map, &camera(REVERSED), None).map_err(text)?;
        let second = volumes.encode(encoder, &map, &camera(REVERSED), None).map_err(text)?;
        let walls = walled.encode(encoder, &map, &camera(REVERSED), None).map_err(text)?;
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: None,
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &view,
                depth_ops: None,
                stencil_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store }),
            }),
            ..Default::default()
        });
        let drawn = [(&first, &pipelines), (&second, &standard), (&second, &pipelines), (&walls, &pipelines)];
        let other = other.iter().map(|other| (&second, other));
        Ok(drawn
            .into_iter()
            .chain(other)
            .map(|(frame, pipelines)| frame.draw(&mut pass, pipelines))
            .collect::<Vec<_>>())
    })?;
    let mismatch = DepthMapError::Depth { what: "the pipelines", given: STANDARD, made: REVERSED };
    let mut expected = vec![Err(DepthMapError::StaleFrame), Err(mismatch), Ok(()), Ok(())];
    let [volumes, own] = [TextureFormat::Depth24PlusStencil8, TextureFormat::Depth32FloatStencil8];
    if has_other {
        expected.push(Err(DepthMapError::DepthFormat { volumes, pipelines: own }));
    }
    same("draws", &found, &expected)
}

fn objects_refused() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let pipelines = pipelines(&gpu)?;
    let (drawn, read) = (wgpu::TextureUsages::RENDER_ATTACHMENT, wgpu::TextureUsages::TEXTURE_BINDING);
    let view = |format, side, usage| {
        attachment(&gpu, format, side, 1, usage).create_view(&wgpu::TextureViewDescriptor::default())
    };
    let map = view(TextureFormat::Depth32Float, 8, drawn | read);
    let many = levels(&gpu, TextureFormat::R32Uint, 8)
        .create_view(&wgpu::TextureViewDescriptor { mip_level_count: Some(1), ..Default::default() });
    let [right, large, unbound, other] = [
        view(TextureFormat::R32Uint, 8, read),
        view(TextureFormat::R32Uint, 9, read),
        view(TextureFormat::R32Uint, 8, wgpu::TextureUsages::COPY_DST),
        view(TextureFormat::R32Sint, 8, read),
    ];
    let mut volumes = DepthMapVolumes::new(&pipelines, [8, 8], DepthMapOptions::default()).map_err(text)?;
    let found = gpu.submit(|encoder| {
        let given = [None, Some(&right), Some(&large), Some(&unbound), Some(&other), Some(&many)];
        Ok(given.map(|objects| {
            let map = DepthMap { texture: &map, light: camera(REVERSED), objects };
            volumes.encode(encoder, &map, &camera(REVERSED), None).err()
        }))
    })?;
    let name = || "the texture of objects".to_owned();
    let expected = [
        None,
        None,
        Some(DepthMapError::MapSize { map: name(), given: [9, 9], made: [8, 8] }),
        Some(DepthMapError::Usage(name())),
        Some(DepthMapError::MapFormat { map: name(), format: TextureFormat::R32Sint, taken: "R32Uint" }),
        Some(DepthMapError::MipLevels { map: name(), levels: 2 }),
    ];
    same("objects", &found, &expected)
}

/// Whole sentences: what is wrong, where, and what to do.
fn sentences() -> Result<(), String> {
    let map = || "map 2 of the cube".to_owned();
    let found = [
        DepthMapError::MapSize { map: map(), given: [9, 8], made: [4, 4] },
        DepthMapError::Usage(map()),
        DepthMapError::Samples { map: map(), samples: 4 },
        DepthMapError::MapFormat { map: map(), format: TextureFormat::R32Sint, taken: "R32Uint" },
        DepthMapError::MipLevels { map: map(), levels: 3 },
        DepthMapError::NoObjects { face: 4 },
        DepthMapError::Option { name: "share", given: 1.5, range: "a share from 0 to 1" },
    ]
    .map(|error| error.to_string());
    let expected = [
        "map 2 of the cube has 9 × 8 texels, and 4 × 4 are needed; give textures of the size that `new` was given, or make it \
         anew",
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
    let counted = |bit, count_bits| Some(DepthMapError::Counted { bit, count_bits });
    let found =
        [made(8, 7..8).err(), made(8, 0..1).err(), made(7, 6..8).err(), made(7, 8..9).err(), made(4, 5..5).err()];
    let refused = |bits| Some(DepthMapError::Bits(bits));
    same("beside", &found, &[counted(7, 8), counted(0, 8), counted(6, 7), refused(8..9), refused(5..5)])?;
    same("bits", &[made(7, 7..8).map_err(text)?.bits(), made(4, 4..8).map_err(text)?.bits()], &[7..8, 4..8])
}
