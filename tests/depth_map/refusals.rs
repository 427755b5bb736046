//! What is refused, and how the errors tell.

use rimline::gpu::{
    DanglingEdges, DepthEdges, DepthMap, DepthMapDrawError, DepthMapEncodeError, DepthMapOptions, DepthMapPipelines,
    DepthMapPipelinesError, DepthMapReconstruction, DepthMapTexture, DepthMapVolumes, DepthMapVolumesError,
    MemoryError, ShadowFormat, ShadowFormatError,
};
use rimline::{CameraError, DepthDirection, ShadowCamera};
use rimline_measure::device::Gpu;
use rimline_measure::harness::Test;
use rimline_measure::on_gpu::text;
use rimline_measure::same;
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
    same("bit", &[refused(ShadowFormat::default(), 8)], &[Some(DepthMapPipelinesError::Bit(8))])?;
    let no_stencil = ShadowFormatError::NoStencil(TextureFormat::Depth32Float).into();
    same("stencil", &[refused(format(TextureFormat::Depth32Float), 0)], &[Some(no_stencil)])?;
    let pipelines = pipelines(&gpu)?;
    let refused = |size, options| DepthMapVolumes::new(&pipelines, size, options).err();
    let with = |threshold| DepthMapOptions { edges: DepthEdges::Differences { threshold }, ..Default::default() };
    for size in [[0, 5], [5, 0], [u32::MAX, u32::MAX], [1 << 15, 1 << 15]] {
        let expected = DepthMapVolumesError::Size(size[0], size[1]);
        same("size", &[refused(size, DepthMapOptions::default())], &[Some(expected)])?;
    }
    for threshold in [-0.1, 1.5, f32::INFINITY] {
        let expected = DepthMapVolumesError::Threshold(threshold);
        same("threshold", &[refused([4, 4], with(threshold))], &[Some(expected)])?;
    }
    if !matches!(refused([4, 4], with(f32::NAN)), Some(DepthMapVolumesError::Threshold(_))) {
        return Err("NaN is no threshold".to_owned());
    }
    for threshold in [-0.1, f32::INFINITY] {
        let edges = DepthEdges::WorldDifferences { threshold };
        let expected = DepthMapVolumesError::WorldThreshold(threshold);
        same("distance", &[refused([4, 4], DepthMapOptions { edges, ..Default::default() })], &[Some(expected)])?;
    }
    for [low, high] in [[-0.1, 0.5], [0.5, 0.4], [0.5, 1.5]] {
        let edges = DepthEdges::SecondDifferences { low, high };
        let expected = DepthMapVolumesError::SecondThresholds { low, high };
        same("two", &[refused([4, 4], DepthMapOptions { edges, ..Default::default() })], &[Some(expected)])?;
    }
    let automatic = DepthMapOptions { edges: DepthEdges::Automatic, ..Default::default() };
    for (share, cells) in [(-0.1, 1), (1.5, 1), (0.5, 0), (0.5, 65)] {
        let dangling = Some(DanglingEdges { share, cells });
        let expected = DepthMapVolumesError::Dangling { share, cells };
        same("dangling", &[refused([4, 4], DepthMapOptions { dangling, ..automatic })], &[Some(expected)])?;
    }
    // Without effect.
    let dangling = Some(DanglingEdges::default());
    let every = DepthMapOptions { edges: DepthEdges::EveryCell, ..Default::default() };
    let of_every = [DepthMapOptions { objects: true, ..every }, DepthMapOptions { dangling, ..every }];
    let found = of_every.map(|options| refused([4, 4], options));
    let expected = ["objects", "dangling"].map(|name| Some(DepthMapVolumesError::EveryCell(name)));
    same("every cell", &found, &expected)?;
    let found = of_every.map(|options| refused([4, 4], DepthMapOptions { edges: DepthEdges::Automatic, ..options }));
    same("automatic", &found, &[None, None])?;
    for slope_bias in [-1.0, f32::INFINITY] {
        let options = DepthMapOptions { slope_bias, ..Default::default() };
        same("bias", &[refused([4, 4], options)], &[Some(DepthMapVolumesError::Bias(slope_bias))])?;
    }
    let contours = DepthMapReconstruction::Contours { sideways: 0.25, depth: 0.01 };
    let walled = DepthMapOptions { reconstruction: contours, edges: DepthEdges::Outlines, ..Default::default() };
    let biased = [255.0, 255.5].map(|slope_bias| refused([4, 4], DepthMapOptions { slope_bias, ..walled }));
    same("contours' bias", &biased, &[None, Some(DepthMapVolumesError::ContourBias(255.5))])?;
    // The limit of memory holds for all buffers together.
    let limited = |memory_limit| refused([40, 40], DepthMapOptions { memory_limit: Some(memory_limit), ..walled });
    let Some(DepthMapVolumesError::Memory(MemoryError::Total { bytes, .. })) = limited(1) else {
        return Err("a byte is enough".to_owned());
    };
    let largest = DepthMapVolumes::new(&pipelines, [40, 40], walled).map_err(text)?.cells().size();
    if limited(bytes).is_some() || limited(bytes - 1).is_none() || bytes <= largest {
        return Err(format!("{bytes} bytes, {largest} of them for walls"));
    }
    let options = DepthMapOptions { memory_limit: Some(100), ..Default::default() };
    match refused([40, 40], options) {
        Some(DepthMapVolumesError::Memory(MemoryError::Total { limit: 100, .. })) => Ok(()),
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
        gpu.submit(|encoder| Ok(volumes.encode(encoder, &DepthMap { texture, light }, &eye, None).err()))
    };
    let (depth, half, texture) = (TextureFormat::Depth32Float, TextureFormat::R16Float, DepthMapTexture::Map);
    for (format, side, samples, usage, expected) in [
        (depth, 8, 1, drawn | read, None),
        (half, 8, 1, drawn | read, Some(DepthMapEncodeError::Format { texture, format: half })),
        (depth, 9, 1, drawn | read, Some(DepthMapEncodeError::Size { texture, given: [9, 9], made: [8, 8] })),
        (depth, 8, 4, drawn | read, Some(DepthMapEncodeError::Samples { texture, samples: 4 })),
        (depth, 8, 1, drawn, Some(DepthMapEncodeError::Usage(texture))),
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
        let expected = DepthMapEncodeError::MipLevels { texture: DepthMapTexture::Map, levels: 2 };
        same("levels", &[found], &[Some(expected)])?;
    }
    let both = attachment(&gpu, TextureFormat::Depth24PlusStencil8, 8, 1, drawn | read);
    let found =
        refused(&both.create_view(&wgpu::TextureViewDescriptor::default()), camera(STANDARD), camera(REVERSED))?;
    if !matches!(found, Some(DepthMapEncodeError::Refused { .. })) {
        return Err(format!("two aspects: {found:?}"));
    }
    let view = depth_view(&both);
    let (good, singular) = (camera(REVERSED), ShadowCamera { view_projection: [[0.0; 4]; 4], ..camera(REVERSED) });
    let mismatch = DepthMapEncodeError::Depth { camera: STANDARD, pipelines: REVERSED };
    same("depth", &[refused(&view, good, camera(STANDARD))?], &[Some(mismatch)])?;
    same("eye", &[refused(&view, good, singular)?], &[Some(DepthMapEncodeError::Camera(CameraError::Singular))])?;
    same("light", &[refused(&view, singular, good)?], &[Some(DepthMapEncodeError::Light(CameraError::Singular))])?;
    // Near and far are told apart by the light's own depth: its w ends before its depth does.
    let rows = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, -0.999, -0.1], [0.0, 0.0, -1.0, 0.0]];
    let columns = std::array::from_fn(|column| rows.map(|row: [f32; 4]| row[column]));
    let behind = ShadowCamera { view_projection: columns, origin: [0.0; 3], depth: STANDARD };
    same("far plane", &[refused(&view, behind, good)?], &[Some(DepthMapEncodeError::FarPlane)])
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
    let counting = DepthMapPipelines::counting(&gpu.pipelines, &ShadowFormat::default()).map_err(text)?;
    let mut volumes = DepthMapVolumes::new(&pipelines, [8, 8], DepthMapOptions::default()).map_err(text)?;
    let options = DepthMapOptions {
        edges: DepthEdges::Outlines,
        reconstruction: DepthMapReconstruction::Contours { sideways: 0.25, depth: 0.001 },
        ..Default::default()
    };
    let mut walled = DepthMapVolumes::new(&pipelines, [8, 8], options).map_err(text)?;
    let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING;
    let texture = depth_view(&attachment(&gpu, TextureFormat::Depth32Float, 8, 1, usage));
    let target = attachment(&gpu, TextureFormat::Depth24PlusStencil8, 8, 1, usage);
    let view = target.create_view(&wgpu::TextureViewDescriptor::default());
    let found = gpu.submit(|encoder| {
        let map = DepthMap { texture: &texture, light: camera(REVERSED) };
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
        let drawn = [(&first, &pipelines), (&second, &standard), (&second, &pipelines), (&second, &counting)];
        let walls = [(&walls, &counting), (&walls, &pipelines)];
        let other = other.iter().map(|other| (&second, other));
        Ok(drawn
            .into_iter()
            .chain(walls)
            .chain(other)
            .map(|(frame, pipelines)| frame.draw(&mut pass, pipelines))
            .collect::<Vec<_>>())
    })?;
    let mismatch = DepthMapDrawError::Depth { volumes: REVERSED, pipelines: STANDARD };
    let walls = Err(DepthMapDrawError::CountedWalls);
    let mut expected = vec![Err(DepthMapDrawError::StaleFrame), Err(mismatch), Ok(()), Ok(()), walls, Ok(())];
    let [volumes, own] = [TextureFormat::Depth24PlusStencil8, TextureFormat::Depth32FloatStencil8];
    if has_other {
        expected.push(Err(DepthMapDrawError::DepthFormat { volumes, pipelines: own }));
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
    let [mut with, mut without] = [true, false].map(|objects| {
        let options = DepthMapOptions { objects, edges: DepthEdges::Outlines, ..Default::default() };
        DepthMapVolumes::new(&pipelines, [8, 8], options)
    });
    let (with, without) =
        (with.as_mut().map_err(|error| text(&*error))?, without.as_mut().map_err(|error| text(&*error))?);
    let map = DepthMap { texture: &map, light: camera(REVERSED) };
    let found = gpu.submit(|encoder| {
        let eye = camera(REVERSED);
        let none = [with.encode(encoder, &map, &eye, None).err(), without.encode(encoder, &map, &eye, None).err()];
        let unused = without.encode_objects(encoder, &map, &right, &eye, None).err();
        let found = [&right, &large, &unbound, &other, &many]
            .map(|objects| with.encode_objects(encoder, &map, objects, &eye, None).err());
        Ok([&none[..], &[unused], &found[..]].concat())
    })?;
    let texture = DepthMapTexture::Objects;
    let expected = [
        Some(DepthMapEncodeError::NoObjects { face: None }),
        None,
        Some(DepthMapEncodeError::UnusedObjects),
        None,
        Some(DepthMapEncodeError::Size { texture, given: [9, 9], made: [8, 8] }),
        Some(DepthMapEncodeError::Usage(texture)),
        Some(DepthMapEncodeError::Format { texture, format: TextureFormat::R32Sint }),
        Some(DepthMapEncodeError::MipLevels { texture, levels: 2 }),
    ];
    same("objects", &found, &expected)
}

/// Whole sentences: what is wrong, where, and what to do.
fn sentences() -> Result<(), String> {
    use DepthMapTexture::{CubeMap, CubeObjects, Map, MergedMap, Objects};
    let size = |texture| DepthMapEncodeError::Size { texture, given: [9, 8], made: [4, 4] }.to_string();
    let found = [Map, Objects, CubeMap(3), CubeObjects(5), MergedMap(1)].map(size);
    let expected = [
        "the map has 9 × 8 texels, and 4 × 4 are needed; give a map of the size of `DepthMapVolumes::new`, or make volumes of \
         this one",
        "the texture of objects has 9 × 8 texels, and 4 × 4 are needed; give objects of the size of `DepthMapVolumes::new`, one \
         for each texel of the map",
        "map 3 of the cube has 9 × 8 texels, and 4 × 4 are needed; give six maps of the `side` of `DepthMapCube::new`, or make a \
         cube of this one",
        "the texture of objects of map 5 of the cube has 9 × 8 texels, and 4 × 4 are needed; give objects of the `side` of \
         `DepthMapCube::new`, one for each texel of the map",
        "map 1 of the merge has 9 × 8 texels, and 4 × 4 are needed; give two maps of the size of `DepthMapMerge::new`",
    ]
    .map(str::to_owned);
    same("sizes", &found, &expected)?;
    let found = [
        DepthMapEncodeError::Usage(MergedMap(0)),
        DepthMapEncodeError::Samples { texture: CubeMap(2), samples: 4 },
        DepthMapEncodeError::Format { texture: Objects, format: TextureFormat::R32Sint },
        DepthMapEncodeError::Format { texture: CubeMap(1), format: TextureFormat::R16Float },
        DepthMapEncodeError::MipLevels { texture: Map, levels: 3 },
        DepthMapEncodeError::NoObjects { face: None },
        DepthMapEncodeError::NoObjects { face: Some(4) },
    ]
    .map(|error| error.to_string());
    let expected = [
        "map 0 of the merge lacks usage TEXTURE_BINDING; make the texture with it",
        "map 2 of the cube has 4 samples a texel; resolve it, or render it with one",
        "the texture of objects has R32Sint, which is no format of objects; take R32Uint",
        "map 1 of the cube has R16Float, which is no format of a depth map; take Depth16Unorm, Depth24Plus, Depth32Float, or \
         R32Float",
        "the map has 3 mip levels; give a texture of one, for example a copy of that level",
        "the options say `objects`; give a texture of them (`encode_objects`, or `objects` of a caster)",
        "the options say `objects`; give a texture of them for map 4 of the cube, too",
    ]
    .map(str::to_owned);
    same("textures", &found, &expected)
}

/// Parity bits beside counts of meshes.
fn beside_meshes() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let made = |count_bits, bits| {
        let format = ShadowFormat { count_bits, ..Default::default() };
        DepthMapPipelines::beside_meshes(&gpu.pipelines, &format, bits)
    };
    let counted = |bit, count_bits| Some(DepthMapPipelinesError::Counted { bit, count_bits });
    let found =
        [made(8, 7..8).err(), made(8, 0..1).err(), made(7, 6..8).err(), made(7, 8..9).err(), made(4, 5..5).err()];
    let refused = |bits| Some(DepthMapPipelinesError::Bits(bits));
    same("beside", &found, &[counted(7, 8), counted(0, 8), counted(6, 7), refused(8..9), refused(5..5)])?;
    same("bits", &[made(7, 7..8).map_err(text)?.bits(), made(4, 4..8).map_err(text)?.bits()], &[7..8, 4..8])
}
