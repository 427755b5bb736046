//! Outlines that cannot be drawn are typed errors.

use rimline::gpu::{
    EdgeTopology, Extractor, ExtractorOptions, FrameInputs, ListOptions, OutlineError, OutlineFormat, OutlineInputs,
    OutlinePipeline, OutlineSource, OutlineStyle, PositionBuffer, ShadowError,
};
use rimline::{DepthDirection, Light, Mesh, ShadowCamera};
use rimline_testkit::cases::{case, without_extent};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::passes;
use rimline_testkit::refusals::{Expected, is, refusal, refused as rows_refused, says, shows};
use rimline_testkit::{IDENTITY, same, shapes};

use crate::rendered::draw_small;
use crate::scenes::Outlined;

pub(crate) const TESTS: &[Test] = &[
    ("outlines_that_cannot_be_drawn_are_typed_errors", refused),
    ("outlines_of_scenes_that_cannot_be_drawn_are_typed_errors", of_scenes),
    ("formats_of_passes_are_those_of_their_attachments", of_pass),
];

/// The format must be that of the pass, for each depth that is read.
fn of_pass() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let usage = wgpu::TextureUsages::TEXTURE_BINDING;
    let format = wgpu::TextureFormat::Rgba16Float;
    for samples in [1, 4] {
        let color = texture(gpu, samples, format, wgpu::TextureUsages::empty());
        let [attached, other] = [samples, 5 - samples].map(|samples| depth(gpu, samples, usage));
        let (resolve_target, ops) = (None, wgpu::Operations::default());
        let of_color =
            || Some(wgpu::RenderPassColorAttachment { view: &color, depth_slice: None, resolve_target, ops });
        let of_depth = wgpu::RenderPassDepthStencilAttachment { view: &attached, depth_ops: None, stencil_ops: None };
        for (read, depth_stencil_attachment) in [(&attached, Some(of_depth.clone())), (&attached, None), (&other, None)]
        {
            let [depth_stencil, other_depth] = [true, false].map(|is_attached| {
                (is_attached == depth_stencil_attachment.is_some()).then_some(wgpu::TextureFormat::Depth32Float)
            });
            let colors = [of_color()];
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
            for (format, is_taken) in [
                (OutlineFormat { is_depth_multisampled: !is_depth_multisampled, ..found.clone() }, true),
                (OutlineFormat { color: wgpu::TextureFormat::Bgra8Unorm, ..found.clone() }, false),
                (OutlineFormat { samples: 5 - samples, ..found.clone() }, false),
                (OutlineFormat { depth_stencil: other_depth, ..found.clone() }, false),
                (found.clone(), true),
            ] {
                let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                let begun = format.begin_pass(&mut encoder, &pass).map(drop);
                gpu.queue.submit([encoder.finish()]);
                let expected = if is_taken { Expected::Taken } else { shows(&["OtherAttachments"]) };
                rows_refused([refusal(format!("{format:?} for {found:?}"), begun, expected)])?;
            }
        }
        for (colors, given) in [(vec![], 0), (vec![None], 0), (vec![of_color(), of_color()], 2)] {
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

fn outlines(gpu: &Gpu) -> Result<OutlinePipeline, String> {
    OutlinePipeline::new(&gpu.pipelines, &OutlineFormat::default()).map_err(text)
}

const CAMERA: ShadowCamera = ShadowCamera {
    view_projection: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]],
    origin: [0.0; 3],
    depth: DepthDirection::Standard,
};

const LIGHT: Light = Light::point([0.0, 0.0, 4.0]);

fn inputs<'a>(of: OutlineSource<'a>, depth: &'a wgpu::TextureView) -> OutlineInputs<'a> {
    OutlineInputs { of, camera: &CAMERA, depth, style: OutlineStyle::default(), marked: None }
}

fn refused() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (_, positions, mesh) = case("torus", shapes::torus(24, 16, 1.0, 0.4));
    let vertices = gpu.storage(&positions);
    let positions = PositionBuffer { buffer: &vertices, offset: 0, stride: 12 };
    let encoded = |mesh: &Mesh, topology| {
        let lists = Some(ListOptions { topology, ..ListOptions::default() });
        let options = ExtractorOptions { lists, ..ExtractorOptions::default() };
        let mut extractor = Extractor::new(&gpu.pipelines, mesh, options).map_err(text)?;
        let extraction = gpu.submit(|encoder| extractor.encode(encoder, positions, &[LIGHT]).map_err(text))?;
        Ok::<_, String>((extractor, extraction))
    };
    let (_, two) = encoded(&mesh, EdgeTopology::LineList)?;
    let (mut extractor, four) = encoded(&mesh, EdgeTopology::TriangleStrip)?;
    let [nothing, ..] = without_extent();
    let (_, without_edges) = encoded(&nothing, EdgeTopology::TriangleStrip)?;
    let pipeline = outlines(gpu)?;
    let usage = wgpu::TextureUsages::TEXTURE_BINDING;
    let [one, several] = [1, 4].map(|samples| depth(gpu, samples, usage));
    let unread = depth(gpu, 1, wgpu::TextureUsages::empty());
    let marks = gpu.storage(&[0_u32; 4]);
    let of = |extraction, light| inputs(OutlineSource::Extraction(extraction, light), &one);
    let good = of(&four, 0);
    let singular = ShadowCamera { view_projection: [[0.0; 4]; 4], ..CAMERA };
    let style = |style| OutlineInputs { style, ..good };
    let default = OutlineStyle::default();
    let made = pipeline.prepare(&good).map_err(text)?;
    // Marks may be longer than the edges, also by half a word.
    let usage = wgpu::BufferUsages::STORAGE;
    let descriptor = wgpu::BufferDescriptor { label: None, size: 146, usage, mapped_at_creation: false };
    let longer = gpu.device.create_buffer(&descriptor);
    pipeline.prepare(&OutlineInputs { marked: Some(&longer), ..good }).map_err(text)?;
    // No edges have marks of no bytes.
    let empty = gpu.device.create_buffer(&wgpu::BufferDescriptor { size: 0, ..descriptor });
    let style_of_marks = OutlineStyle { marked: Some([1.0; 4]), ..default };
    let no_marks = OutlineInputs { marked: Some(&empty), style: style_of_marks, ..of(&without_edges, 0) };
    draw_small(gpu, &pipeline.prepare(&no_marks).map_err(text)?)?.map_err(text)?;
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
    gpu.submit(|encoder| extractor.encode(encoder, positions, &[LIGHT]).map_err(text).map(drop))?;
    let integers = OutlineFormat { color: wgpu::TextureFormat::Rgba32Uint, ..OutlineFormat::default() };
    let integers = OutlinePipeline::new(&gpu.pipelines, &integers);
    let theirs = outlines(&gpu.another(wgpu::Features::empty(), wgpu::Limits::default())?)?;
    let foreign = says(&["the extraction is of another device than the outline's pipeline"]);
    rows_refused([
        refusal("an old extraction", pipeline.prepare(&good), says(&["out of date"])),
        refusal("an outline of an old extraction", draw_small(gpu, &made)?, says(&["out of date"])),
        refusal("integers", integers, says(&["the device refuses outlines"])),
        refusal("another device", theirs.prepare(&good), foreign),
    ])
}

fn of_scenes() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let [mut drawing, mut other] = [Outlined::new(gpu, LIGHT, 0, None)?, Outlined::new(gpu, LIGHT, 0, None)?];
    drawing.insert(&case("cube", shapes::cube()), IDENTITY)?;
    let encoded = |drawing: &mut Outlined| {
        gpu.submit(|encoder| drawing.scene.encode(encoder, FrameInputs::default()).map_err(text))
    };
    let (frame, empty) = (encoded(&mut drawing)?, encoded(&mut other)?);
    let pipeline = outlines(gpu)?;
    let depth = &depth(gpu, 1, wgpu::TextureUsages::TEXTURE_BINDING);
    let good = inputs(OutlineSource::Scene(&frame, drawing.eye), depth);
    let of = |frame, light| pipeline.prepare(&inputs(OutlineSource::Scene(frame, light), depth));
    let made = pipeline.prepare(&good).map_err(text)?;
    let marks = gpu.storage(&[0_u32; 4]);
    let marked = pipeline.prepare(&OutlineInputs { marked: Some(&marks), ..good });
    let theirs = outlines(&gpu.another(wgpu::Features::empty(), wgpu::Limits::default())?)?;
    let foreign = says(&["the scene is of another device than the outline's"]);
    drawing.scene.remove_light(drawing.eye).map_err(text)?;
    let new = drawing.scene.add_light(LIGHT).map_err(text)?;
    let scene = |error| is(OutlineError::Scene(error));
    rows_refused([
        refusal("a removed light of the frame", of(&frame, drawing.eye), Expected::Taken),
        refusal("no casters", of(&empty, other.eye), Expected::Taken),
        refusal("another scene's light", of(&frame, other.eye), scene(ShadowError::OtherScene { what: "light" })),
        refusal("a light after the encode", of(&frame, new), scene(ShadowError::NotEncoded)),
        refusal("marks", marked, is(OutlineError::MarkedScene)),
        refusal("another device", theirs.prepare(&good), foreign),
    ])?;
    encoded(&mut drawing)?;
    rows_refused([
        refusal("an old frame", pipeline.prepare(&good), scene(ShadowError::StaleFrame)),
        refusal("an outline of an old frame", draw_small(gpu, &made)?, scene(ShadowError::StaleFrame)),
    ])
}
