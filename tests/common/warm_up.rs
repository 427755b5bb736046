//! Pipelines that are made before the first frame, and which a frame makes.

use rimline::gpu::{
    Caster, DeformerOptions, Extractor, ExtractorOptions, FrameInputs, Measuring, Pipelines, PositionBuffer, Receivers,
    Scene, SceneOptions, ShadowFormat, ShadowPipelines, StencilCounts, Use, View,
};
use rimline::{Counting, DepthDirection, Light, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::models::bending_tube;
use rimline_testkit::on_gpu::text;
use rimline_testkit::{must_fail, same, shapes};

pub(crate) const TESTS: &[Test] =
    &[("frames_make_what_they_need_and_no_more", frames), ("a_warm_up_leaves_nothing_to_be_made", warm_up)];

const IDENTITY: rimline::Matrix3x4 = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

/// The parts of a frame of a scene.
#[derive(Clone, Copy)]
#[expect(clippy::struct_excessive_bools, reason = "parts that do not depend on each other")]
struct Frame {
    options: SceneOptions,
    has_camera: bool,
    has_receivers: bool,
    has_model: bool,
    /// The caster is in the depth buffer.
    in_depth: bool,
}

impl Frame {
    fn plain() -> Self {
        Self {
            options: SceneOptions::default(),
            has_camera: false,
            has_receivers: false,
            has_model: false,
            in_depth: true,
        }
    }

    fn seen() -> Self {
        Self { has_camera: true, ..Self::plain() }
    }

    /// Each kind, and how many pipelines the frame makes after `ShadowPipelines`.
    fn kinds() -> Vec<(&'static str, Self, usize)> {
        let plain = Self::plain().options;
        let seen = |options| Self { options, ..Self::seen() };
        // Reach, clusters, chunks, facing, exact facing, edges and arguments; then relist, bounds, choose, caps, sides and
        // arguments.
        vec![
            ("no camera", Self::plain(), 7),
            ("a camera", Self::seen(), 13),
            ("not exact", seen(SceneOptions { measuring: Measuring::FAST, clusters_from: None, ..plain }), 12),
            ("z-pass", seen(SceneOptions { counting: Counting::ZPass, ..plain }), 13),
            (
                "bounds of counts",
                seen(SceneOptions { stencil: StencilCounts { bound_counts: true, ..Default::default() }, ..plain }),
                16,
            ),
            ("receivers", Self { has_receivers: true, ..Self::seen() }, 15),
            // Needs and deform.
            ("a model", Self { has_model: true, ..Self::seen() }, 15),
            // The dark caps of both lists, and the light caps.
            ("ended volumes", seen(SceneOptions { end_at_range: true, ..plain }), 15),
            ("a proxy", Self { in_depth: false, ..Self::seen() }, 15),
        ]
    }

    fn pipelines(&self, pipelines: &Pipelines) -> Result<ShadowPipelines, String> {
        ShadowPipelines::new(pipelines, &ShadowFormat::default(), self.options.counting).map_err(text)
    }

    fn uses<'a>(&'a self, drawing: &'a ShadowPipelines) -> Vec<Use<'a>> {
        let mut uses = vec![if self.has_camera { Use::SceneShadows(&self.options) } else { Use::Scene(&self.options) }];
        uses.extend(self.has_receivers.then_some(Use::Receivers { samples: 1 }));
        uses.extend(self.has_model.then_some(Use::SceneModels));
        uses.extend(self.options.end_at_range.then_some(Use::EndedVolumes(drawing)));
        uses.extend((!self.in_depth).then_some(Use::Proxies(drawing)));
        uses
    }

    /// Encodes and draws.
    fn run(&self, gpu: &Gpu, pipelines: &Pipelines, drawing: &ShadowPipelines) -> Result<(), String> {
        let format = ShadowFormat::default();
        let depth = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("depth"),
            size: wgpu::Extent3d { width: 16, height: 16, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: format.depth_stencil,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        let view = depth.create_view(&wgpu::TextureViewDescriptor::default());
        let aspect = wgpu::TextureAspect::DepthOnly;
        let read = depth.create_view(&wgpu::TextureViewDescriptor { aspect, ..Default::default() });
        let shape = shapes::cube();
        let mut scene = Scene::new(pipelines, &gpu.queue, self.options).map_err(text)?;
        let mesh = scene.add_mesh(&shape.mesh().map_err(text)?, &shape.positions).map_err(text)?;
        scene.insert(Caster { in_depth: self.in_depth, ..Caster::rigid(mesh, IDENTITY) }).map_err(text)?;
        if self.has_model {
            let (model, pose) = bending_tube();
            scene.insert_model(&model, &pose(0.0), DeformerOptions::default()).map_err(text)?;
        }
        let light = scene.add_light(Light::point([0.0, 5.0, 0.0]).with_range(9.0)).map_err(text)?;
        let columns = [[-1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.1, 0.0]];
        let camera =
            ShadowCamera { view_projection: columns, origin: [0.0, 0.0, -6.0], depth: DepthDirection::Reversed };
        let receivers = Receivers { depth: &read, sky_receives: false, version: None };
        let seen = [View { depth: self.has_receivers.then_some(receivers), ..View::new(camera) }];
        let views = if self.has_camera { &seen[..] } else { &[] };
        gpu.submit(|encoder| {
            let frame = scene.encode(encoder, FrameInputs::new(views)).map_err(text)?;
            let (load, store) = (wgpu::LoadOp::Clear(0), wgpu::StoreOp::Store);
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &view,
                    depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store }),
                    stencil_ops: Some(wgpu::Operations { load, store }),
                }),
                ..Default::default()
            });
            if self.has_camera { frame.draw(&mut pass, drawing, 0, light).map_err(text) } else { Ok(()) }
        })
    }
}

/// A first frame makes so many pipelines, a second one of the same kind none.
fn frames() -> Result<(), String> {
    let gpu = Gpu::with_limits(wgpu::Limits::default())?;
    for (what, frame, expected) in Frame::kinds() {
        let pipelines = Pipelines::new(&gpu.device);
        let drawing = frame.pipelines(&pipelines)?;
        let before = pipelines.len();
        frame.run(&gpu, &pipelines, &drawing)?;
        same(&format!("{what}, pipelines of a frame"), &[pipelines.len() - before], &[expected])?;
        let before = pipelines.len();
        frame.run(&gpu, &pipelines, &drawing)?;
        same(&format!("{what}, pipelines of a second frame"), &[pipelines.len()], &[before])?;
    }
    Ok(())
}

/// A warm-up makes what the frame does, and leaves nothing for it.
fn warm_up() -> Result<(), String> {
    let gpu = Gpu::with_limits(wgpu::Limits::default())?;
    for (what, frame, expected) in Frame::kinds() {
        let pipelines = Pipelines::new(&gpu.device);
        let drawing = frame.pipelines(&pipelines)?;
        let before = pipelines.len();
        for made in [expected, 0] {
            let before = pipelines.len();
            pipelines.warm_up(&frame.uses(&drawing)).map_err(text)?;
            same(&format!("{what}, pipelines of a warm-up"), &[pipelines.len() - before], &[made])?;
        }
        frame.run(&gpu, &pipelines, &drawing)?;
        same(&format!("{what}, pipelines after it"), &[pipelines.len() - before], &[expected])?;
    }
    let pipelines = Pipelines::new(&gpu.device);
    let shape = shapes::cube();
    let mesh = shape.mesh().map_err(text)?;
    let options = ExtractorOptions::default();
    pipelines.warm_up(&[Use::Extraction(&options)]).map_err(text)?;
    let made = pipelines.len();
    let buffer = gpu.storage(&shape.positions);
    let positions = PositionBuffer { buffer: &buffer, offset: 0, stride: 12 };
    let mut extractor = Extractor::new(&pipelines, &mesh, options).map_err(text)?;
    gpu.submit(|encoder| extractor.encode(encoder, positions, &[Light::point([0.0, 5.0, 0.0])]).map_err(text))?;
    same("pipelines after the warm-up of extraction", &[pipelines.len()], &[made])?;
    must_fail("nothing made", &same("pipelines", &[made], &[0]))
}
