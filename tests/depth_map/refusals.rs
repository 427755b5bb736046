//! What is refused, and how the errors tell.

use rimline::gpu::{
    DanglingEdges, DepthEdges, DepthMap, DepthMapDrawError, DepthMapEncodeError, DepthMapOptions, DepthMapPipelines,
    DepthMapPipelinesError, DepthMapVolumes, DepthMapVolumesError, MemoryError, ShadowFormat, ShadowFormatError,
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
    for (share, cells) in [(-0.1, 1), (1.5, 1), (0.5, 0), (0.5, 65)] {
        let dangling = Some(DanglingEdges { share, cells });
        let expected = DepthMapVolumesError::Dangling { share, cells };
        same("dangling", &[refused([4, 4], DepthMapOptions { dangling, ..Default::default() })], &[Some(expected)])?;
    }
    for slope_bias in [-1.0, f32::INFINITY] {
        let options = DepthMapOptions { slope_bias, ..Default::default() };
        same("bias", &[refused([4, 4], options)], &[Some(DepthMapVolumesError::Bias(slope_bias))])?;
    }
    let options = DepthMapOptions { memory_limit: Some(100), ..Default::default() };
    match refused([40, 40], options) {
        Some(DepthMapVolumesError::Memory(MemoryError::Total { limit: 100, .. })) => Ok(()),
        other => Err(format!("{other:?}")),
    }
}

fn attachment(gpu: &Gpu, format: TextureFormat, side: u32, samples: u32, usage: wgpu::TextureUsages) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("map"),
        size: wgpu::Extent3d { width: side, height: side, depth_or_array_layers: 1 },
        mip_level_count: 1,
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
    let depth = TextureFormat::Depth32Float;
    for (format, side, samples, usage, expected) in [
        (depth, 8, 1, drawn | read, None),
        (TextureFormat::R16Float, 8, 1, drawn | read, Some(DepthMapEncodeError::Format(TextureFormat::R16Float))),
        (depth, 9, 1, drawn | read, Some(DepthMapEncodeError::Size { given: [9, 9], made: [8, 8] })),
        (depth, 8, 4, drawn | read, Some(DepthMapEncodeError::Samples(4))),
        (depth, 8, 1, drawn, Some(DepthMapEncodeError::Usage)),
    ] {
        let texture = attachment(&gpu, format, side, samples, usage);
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        same("texture", &[refused(&view, camera(STANDARD), camera(REVERSED))?], &[expected])?;
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
    let mut volumes = DepthMapVolumes::new(&pipelines, [8, 8], DepthMapOptions::default()).map_err(text)?;
    let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING;
    let texture = depth_view(&attachment(&gpu, TextureFormat::Depth32Float, 8, 1, usage));
    let target = attachment(&gpu, TextureFormat::Depth24PlusStencil8, 8, 1, usage);
    let view = target.create_view(&wgpu::TextureViewDescriptor::default());
    let found = gpu.submit(|encoder| {
        let map = DepthMap { texture: &texture, light: camera(REVERSED) };
        let first = volumes.encode(encoder, &map, &camera(REVERSED), None).map_err(text)?;
        let second = volumes.encode(encoder, &map, &camera(REVERSED), None).map_err(text)?;
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: None,
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &view,
                depth_ops: None,
                stencil_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store }),
            }),
            ..Default::default()
        });
        Ok([first.draw(&mut pass, &pipelines), second.draw(&mut pass, &standard), second.draw(&mut pass, &pipelines)])
    })?;
    let mismatch = DepthMapDrawError::Depth { volumes: REVERSED, pipelines: STANDARD };
    same("draws", &found, &[Err(DepthMapDrawError::StaleFrame), Err(mismatch), Ok(())])
}

fn objects_refused() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let pipelines = pipelines(&gpu)?;
    let (drawn, read) = (wgpu::TextureUsages::RENDER_ATTACHMENT, wgpu::TextureUsages::TEXTURE_BINDING);
    let view = |format, side, usage| {
        attachment(&gpu, format, side, 1, usage).create_view(&wgpu::TextureViewDescriptor::default())
    };
    let map = view(TextureFormat::Depth32Float, 8, drawn | read);
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
        let found = [&right, &large, &unbound, &other]
            .map(|objects| with.encode_objects(encoder, &map, objects, &eye, None).err());
        Ok([&none[..], &[unused], &found[..]].concat())
    })?;
    let expected = [
        Some(DepthMapEncodeError::NoObjects),
        None,
        Some(DepthMapEncodeError::UnusedObjects),
        None,
        Some(DepthMapEncodeError::Size { given: [9, 9], made: [8, 8] }),
        Some(DepthMapEncodeError::Usage),
        Some(DepthMapEncodeError::ObjectFormat(TextureFormat::R32Sint)),
    ];
    same("objects", &found, &expected)
}
