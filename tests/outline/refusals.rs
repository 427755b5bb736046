//! Outlines that cannot be drawn are typed errors.

use rimline::gpu::{
    EdgeTopology, Extractor, ExtractorOptions, ListOptions, OutlineError, OutlineFormat, OutlineInputs,
    OutlinePipeline, OutlineSource, OutlineStyle, PositionBuffer,
};
use rimline::{DepthDirection, Light, ShadowCamera};
use rimline_testkit::cases::case;
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::passes;
use rimline_testkit::refusals::{Expected, refusal, refused as rows_refused, says, shows};
use rimline_testkit::{same, shapes};

use crate::rendered::draw_small;

pub(crate) const TESTS: &[Test] = &[
    ("outlines_that_cannot_be_drawn_are_typed_errors", refused),
    ("formats_of_passes_are_those_of_their_attachments", of_pass),
];

/// The format must be that of the pass, for each depth that is read.
fn of_pass() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let usage = wgpu::TextureUsages::TEXTURE_BINDING;
    let format = wgpu::TextureFormat::Rgba16Float;
    for samples in [1, 4] {
        let [color, attached, other] = [
            texture(gpu, samples, format, wgpu::TextureUsages::empty()),
            depth(gpu, samples, usage),
            depth(gpu, 5 - samples, usage),
        ];
        let attach = |view| {
            let (resolve_target, ops) = (None, wgpu::Operations::default());
            Some(wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target, ops })
        };
        let attachment =
            || wgpu::RenderPassDepthStencilAttachment { view: &attached, depth_ops: None, stencil_ops: None };
        let colors = [attach(&color)];
        for (read, depth_stencil_attachment) in [(&attached, Some(attachment())), (&attached, None), (&other, None)] {
            let depth_stencil = depth_stencil_attachment.is_some().then_some(wgpu::TextureFormat::Depth32Float);
            let pass = wgpu::RenderPassDescriptor {
                color_attachments: &colors,
                depth_stencil_attachment,
                ..Default::default()
            };
            let is_depth_multisampled = read.texture().sample_count() > 1;
            let expected = OutlineFormat { color: format, depth_stencil, samples, is_depth_multisampled };
            let found = OutlineFormat::of_pass(&pass, read).map_err(text)?;
            same("the format", &[&found], &[&expected])?;
            OutlinePipeline::new(&gpu.pipelines, &found).map_err(text)?;
            let depth_stencil = if depth_stencil.is_some() { None } else { Some(wgpu::TextureFormat::Depth32Float) };
            for (format, is_taken) in [
                (found.clone(), true),
                (OutlineFormat { is_depth_multisampled: !is_depth_multisampled, ..found.clone() }, true),
                (OutlineFormat { color: wgpu::TextureFormat::Bgra8Unorm, ..found.clone() }, false),
                (OutlineFormat { samples: 5 - samples, ..found.clone() }, false),
                (OutlineFormat { depth_stencil, ..found.clone() }, false),
            ] {
                let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                let begun = format.begin_pass(&mut encoder, &pass).map(drop);
                gpu.queue.submit([encoder.finish()]);
                let expected = if is_taken { Expected::Taken } else { shows(&["OtherAttachments"]) };
                rows_refused([refusal(format!("{format:?} for {found:?}"), begun, expected)])?;
            }
        }
        for (colors, given) in [(vec![], 0), (vec![None], 0), (vec![attach(&color), attach(&color)], 2)] {
            let pass = wgpu::RenderPassDescriptor { color_attachments: &colors, ..Default::default() };
            let found = OutlineFormat::of_pass(&pass, &attached);
            same("the refusal", &[found], &[Err(OutlineError::Colors { given })])?;
        }
    }
    Ok(())
}

fn depth(gpu: &Gpu, sample_count: u32, usage: wgpu::TextureUsages) -> wgpu::TextureView {
    texture(gpu, sample_count, wgpu::TextureFormat::Depth32Float, usage)
}

fn texture(gpu: &Gpu, sample_count: u32, format: wgpu::TextureFormat, usage: wgpu::TextureUsages) -> wgpu::TextureView {
    let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | usage;
    let descriptor = wgpu::TextureDescriptor { sample_count, usage, ..passes::texture([8; 2], format) };
    gpu.device.create_texture(&descriptor).create_view(&wgpu::TextureViewDescriptor::default())
}

fn refused() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (_, positions, mesh) = case("torus", shapes::torus(24, 16, 1.0, 0.4));
    let vertices = gpu.storage(&positions);
    let positions = PositionBuffer { buffer: &vertices, offset: 0, stride: 12 };
    let encoded = |gpu: &Gpu, topology| {
        let lists = Some(ListOptions { topology, ..ListOptions::default() });
        let options = ExtractorOptions { lists, ..ExtractorOptions::default() };
        let mut extractor = Extractor::new(&gpu.pipelines, &mesh, options).map_err(text)?;
        let lights = [Light::point([0.0, 0.0, 4.0])];
        let extraction = gpu.submit(|encoder| extractor.encode(encoder, positions, &lights).map_err(text))?;
        Ok::<_, String>((extractor, extraction))
    };
    let [(_, two), (mut extractor, four)] =
        [encoded(gpu, EdgeTopology::LineList)?, encoded(gpu, EdgeTopology::TriangleStrip)?];
    let pipeline = OutlinePipeline::new(&gpu.pipelines, &OutlineFormat::default()).map_err(text)?;
    let identity = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
    let camera = ShadowCamera { view_projection: identity, origin: [0.0; 3], depth: DepthDirection::Standard };
    let usage = wgpu::TextureUsages::TEXTURE_BINDING;
    let [one, several] = [1, 4].map(|samples| depth(gpu, samples, usage));
    let unread = depth(gpu, 1, wgpu::TextureUsages::empty());
    let marks = gpu.storage(&[0_u32; 4]);
    let good = OutlineInputs {
        of: OutlineSource::Extraction(&four, 0),
        camera: &camera,
        depth: &one,
        style: OutlineStyle::default(),
        marked: None,
    };
    let singular = ShadowCamera { view_projection: [[0.0; 4]; 4], ..camera };
    let style = |style| OutlineInputs { style, ..good };
    let default = OutlineStyle::default();
    let made = pipeline.prepare(&good).map_err(text)?;
    let of = |extraction, light| OutlineInputs { of: OutlineSource::Extraction(extraction, light), ..good };
    let rows = [
        ("lines", of(&two, 0), "draws 2 vertices for each edge, and outlines need 4"),
        ("no light", of(&four, 1), "light 1 asked for, and 1 lights were extracted"),
        ("no camera", OutlineInputs { camera: &singular, ..good }, "singular or not finite"),
        ("samples", OutlineInputs { depth: &several, ..good }, "has 4 samples a pixel, and the pipeline reads one"),
        ("unread depth", OutlineInputs { depth: &unread, ..good }, "of format Depth32Float, cannot be read"),
        ("marks", OutlineInputs { marked: Some(&marks), ..good }, "16 bytes, and 1152 edge records need 144"),
        ("width", style(OutlineStyle { width: -1.0, ..default }), "`width` of the style is -1"),
        ("angle", style(OutlineStyle { crease_angle: f32::NAN, ..default }), "`crease_angle` of the style is NaN"),
        ("bias", style(OutlineStyle { depth_bias: f32::INFINITY, ..default }), "`depth_bias` of the style is inf"),
    ];
    rows_refused(rows.map(|(what, inputs, expected)| refusal(what, pipeline.prepare(&inputs), says(&[expected]))))?;
    gpu.submit(|encoder| extractor.encode(encoder, positions, &[Light::point([4.0; 3])]).map_err(text).map(drop))?;
    let integers = OutlineFormat { color: wgpu::TextureFormat::Rgba32Uint, ..OutlineFormat::default() };
    let integers = OutlinePipeline::new(&gpu.pipelines, &integers);
    let other = gpu.another(wgpu::Features::empty(), wgpu::Limits::default())?;
    let theirs = OutlinePipeline::new(&other.pipelines, &OutlineFormat::default()).map_err(text)?;
    let foreign = says(&["the extraction is of another device than the outline's pipeline"]);
    rows_refused([
        refusal("an old extraction", pipeline.prepare(&good), says(&["out of date"])),
        refusal("an outline of an old extraction", draw_small(gpu, &made)?, says(&["out of date"])),
        refusal("integers", integers, says(&["the device refuses outlines"])),
        refusal("another device", theirs.prepare(&good), foreign),
    ])
}
