//! Passes that volumes are drawn into: formats that are made of them, and those that do not serve.

use rimline::gpu::{PositionBuffer, ShadowError, ShadowFormat, ShadowPipelines};
use rimline::{Counting, DepthDirection, Light, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::{one_caster, text};
use rimline_testkit::passes;
use rimline_testkit::pipelines::Drawing;
use rimline_testkit::refusals::{Expected, is, refusal, refused, shows};
use rimline_testkit::textures::texels;
use rimline_testkit::{OneFrame, made_anew, same, shapes};

pub(crate) const TESTS: &[Test] = &[
    ("formats_serve_for_their_passes_and_no_others", other_passes),
    ("light_is_added_where_the_stencil_is_0_at_any_depth", full_screen),
    ("light_is_compared_with_0_after_volumes", reference),
];

const DEPTH_STENCIL: wgpu::TextureFormat = wgpu::TextureFormat::Depth24PlusStencil8;

fn camera() -> ShadowCamera {
    let view_projection = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, -1.0], [0.0, 0.0, 0.1, 0.0]];
    ShadowCamera { view_projection, origin: [0.0, 0.0, 4.0], depth: DepthDirection::Reversed }
}

fn target(gpu: &Gpu, samples: u32, format: wgpu::TextureFormat) -> wgpu::TextureView {
    let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC;
    let descriptor = wgpu::TextureDescriptor { sample_count: samples, usage, ..passes::texture([64; 2], format) };
    gpu.device.create_texture(&descriptor).create_view(&wgpu::TextureViewDescriptor::default())
}

fn color(view: &wgpu::TextureView) -> wgpu::RenderPassColorAttachment<'_> {
    let ops = wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store };
    wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops }
}

/// Samples and colour attachments of the passes here: none, one, and several with a gap. Each differs from the next.
fn attachments() -> [(u32, Vec<Option<wgpu::TextureFormat>>); 5] {
    use wgpu::TextureFormat::{Bgra8UnormSrgb, Rgba8Unorm, Rgba16Float};
    let gap = || vec![Some(Rgba8Unorm), None, Some(Rgba16Float)];
    [(1, vec![]), (1, vec![Some(Rgba16Float)]), (1, vec![Some(Bgra8UnormSrgb)]), (1, gap()), (4, gap())]
}

/// Pipelines of a format, and volumes of a torus.
fn volumes(gpu: &Gpu, format: &ShadowFormat) -> Result<(ShadowPipelines, OneFrame), String> {
    let shape = shapes::torus(16, 8, 1.0, 0.4);
    let mesh = shape.mesh().map_err(text)?;
    let pipelines = ShadowPipelines::new(&gpu.pipelines, format, Counting::Auto).map_err(text)?;
    let mut caster = one_caster(gpu, &pipelines, &mesh, made_anew(32, Counting::Auto)).map_err(text)?;
    let buffer = gpu.storage(&shape.positions);
    let positions = PositionBuffer { buffer: &buffer, offset: 0, stride: 12 };
    let lights = [Light::point([0.0, 5.0, 2.0])];
    let encoded =
        gpu.submit(|encoder| caster.encode(encoder, positions, &lights, Some(&camera()), None).map_err(text))?;
    Ok((pipelines, encoded))
}

/// Draws volumes of a format into a pass that the format begins, or the encoder. Returns what the device says.
fn drawn(
    gpu: &Gpu,
    (format, (pipelines, shadows)): (&ShadowFormat, &(ShadowPipelines, OneFrame)),
    pass: &wgpu::RenderPassDescriptor<'_>,
    by_encoder: bool,
) -> Result<Option<wgpu::Error>, ShadowError> {
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
    let begun = if by_encoder { Ok(encoder.begin_render_pass(pass)) } else { format.begin_pass(&mut encoder, pass) };
    let begun = begun.map(|mut pass| shadows.draw(&mut pass, pipelines, 0));
    let finished = encoder.finish();
    let error = pollster::block_on(scope.pop());
    if error.is_none() {
        gpu.queue.submit([finished]);
    }
    begun?.map(|()| error)
}

/// A format that is made of a pass is that of its attachments, and serves for no others.
fn other_passes() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let all = attachments();
    for (number, (samples, colors)) in all.iter().enumerate() {
        let format = ShadowFormat { samples: *samples, colors: colors.clone(), ..ShadowFormat::default() };
        let of_format = (&format, &volumes(gpu, &format)?);
        for (others, other_colors) in [&all[number], &all[(number + 1) % all.len()]] {
            let depth_stencil = target(gpu, *others, DEPTH_STENCIL);
            let views = other_colors.iter().map(|format| format.map(|format| target(gpu, *others, format)));
            let views: Vec<_> = views.collect();
            let attachments: Vec<_> = views.iter().map(|view| view.as_ref().map(color)).collect();
            let pass = wgpu::RenderPassDescriptor {
                color_attachments: &attachments,
                depth_stencil_attachment: Some(ShadowFormat::attachment(&depth_stencil)),
                ..Default::default()
            };
            let what = format!("{samples} samples, {colors:?} into {others}, {other_colors:?}");
            let is_same = samples == others && colors == other_colors;
            let of_pass = ShadowFormat::of_pass(&pass, &camera()).map_err(text)?;
            same(&what, &[of_pass == format], &[is_same])?;
            let expected = if is_same { Expected::Taken } else { shows(&["OtherAttachments"]) };
            refused([refusal(&what, drawn(gpu, of_format, &pass, false), expected)])?;
            // Each refusal spares an error of wgpu, by default a panic.
            let found = drawn(gpu, of_format, &pass, true).map_err(text)?;
            if found.is_none() != is_same {
                return Err(format!("{what}: wgpu says {found:?}"));
            }
        }
    }
    let depth_stencil = target(gpu, 1, DEPTH_STENCIL);
    let format = ShadowFormat::default();
    let of_format = (&format, &volumes(gpu, &format)?);
    let nothing = wgpu::RenderPassDescriptor::default();
    let given = |stencil: Option<wgpu::LoadOp<u32>>, depth: wgpu::LoadOp<f32>| {
        let store = wgpu::StoreOp::Store;
        let attachment = wgpu::RenderPassDepthStencilAttachment {
            stencil_ops: stencil.map(|load| wgpu::Operations { load, store }),
            depth_ops: Some(wgpu::Operations { load: depth, store }),
            ..ShadowFormat::attachment(&depth_stencil)
        };
        let pass = wgpu::RenderPassDescriptor { depth_stencil_attachment: Some(attachment), ..Default::default() };
        drawn(gpu, of_format, &pass, false)
    };
    let cleared = Some(wgpu::LoadOp::Clear(0));
    let load = wgpu::LoadOp::Load;
    refused([
        refusal("no stencil", given(None, load), is(ShadowError::StencilNotCleared)),
        refusal("loaded", given(Some(wgpu::LoadOp::Load), load), is(ShadowError::StencilNotCleared)),
        refusal("one", given(Some(wgpu::LoadOp::Clear(1)), load), is(ShadowError::StencilNotCleared)),
        refusal("cleared", given(cleared, load), Expected::Taken),
        refusal("depth cleared", given(cleared, wgpu::LoadOp::Clear(0.0)), is(ShadowError::DepthCleared)),
        refusal("no depth", drawn(gpu, of_format, &nothing, false), is(ShadowError::NoDepthStencil)),
        refusal("no depth, of it", ShadowFormat::of_pass(&nothing, &camera()), is(ShadowError::NoDepthStencil)),
    ])
}

/// A triangle over the whole picture, at a depth of 0.5.
const WHOLE: &str = "
@vertex fn whole(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
  return vec4<f32>(select(-1.0, 3.0, vertex == 1u), select(-1.0, 3.0, vertex == 2u), 0.5, 1.0);
}
@fragment fn light() -> @location(0) vec4<f32> {
  return vec4<f32>(1.0);
}
";

/// Pixels that the triangle lights, of 4,096, in a pass of these depths and stencil values.
fn lit(
    gpu: &Gpu,
    state: &wgpu::DepthStencilState,
    depth: f32,
    stencil: u32,
    before: impl FnOnce(&mut wgpu::RenderPass<'_>) -> Result<(), String>,
) -> Result<usize, String> {
    let format = wgpu::TextureFormat::Rgba8Unorm;
    let pipeline = gpu.kept(&format!("lit {state:?}"), || {
        let depth_stencil = Some(state.clone());
        let drawing = Drawing { source: WHOLE, depth_stencil, targets: &[Some(format.into())], ..Drawing::default() };
        Ok(drawing.pipeline(&gpu.device))
    })?;
    let (view, depth_stencil) = (target(gpu, 1, format), target(gpu, 1, DEPTH_STENCIL));
    gpu.submit(|encoder| {
        let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT), ..color(&view).ops };
        let loads = (Some(wgpu::LoadOp::Clear(depth)), Some(wgpu::LoadOp::Clear(stencil)));
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment { ops, ..color(&view) })],
            ..passes::depth_pass(&depth_stencil, loads)
        });
        before(&mut pass)?;
        pass.set_pipeline(&pipeline);
        pass.draw(0..3, 0..1);
        Ok(())
    })?;
    Ok(texels(gpu, view.texture(), 0)?.chunks(4).filter(|pixel| **pixel != [0; 4]).count())
}

fn full_screen() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let format = ShadowFormat::default();
    let (surfaces, whole) = (format.light_pass_depth_stencil(), format.full_screen_depth_stencil());
    for (depth, stencil) in [(0.5, 0), (0.5, 1), (0.25, 0), (0.25, 1), (0.75, 0), (0.75, 128)] {
        let found = [lit(gpu, &surfaces, depth, stencil, |_| Ok(()))?, lit(gpu, &whole, depth, stencil, |_| Ok(()))?];
        let expected = [depth == 0.5 && stencil == 0, stencil == 0].map(|is_lit| if is_lit { 4096 } else { 0 });
        same(&format!("depth {depth}, stencil {stencil}"), &found, &expected)?;
    }
    Ok(())
}

/// A reference that the caller set before volumes were drawn does not change where light is added.
fn reference() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let format = ShadowFormat { colors: vec![Some(wgpu::TextureFormat::Rgba8Unorm)], ..ShadowFormat::default() };
    let (pipelines, shadows) = volumes(gpu, &format)?;
    let found = |reference| {
        // A surface that volumes pass behind and before.
        lit(gpu, &format.full_screen_depth_stencil(), 0.025, 0, |pass| {
            pass.set_stencil_reference(reference);
            shadows.draw(pass, &pipelines, 0).map_err(text)
        })
    };
    let expected = found(0)?;
    if !(1..4096).contains(&expected) {
        return Err(format!("{expected} pixels are lit"));
    }
    same("after another reference", &[found(1)?], &[expected])
}
