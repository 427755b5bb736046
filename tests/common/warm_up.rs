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
use rimline_testkit::passes::{CLEARED, depth_pass, texture};
use rimline_testkit::{IDENTITY, must_fail, same, shapes};

pub(crate) const TESTS: &[Test] = &[("frames_and_warm_ups_make_what_they_need_and_no_more", warm_up)];

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
        // The stages from `cull_lights` to `arguments`, then those from `relist` to `shadow_arguments`.
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
        let depth = gpu.device.create_texture(&texture([16; 2], ShadowFormat::default().depth_stencil));
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
            let mut pass = encoder.begin_render_pass(&depth_pass(&view, CLEARED));
            if self.has_camera { frame.draw(&mut pass, drawing, 0, light).map_err(text) } else { Ok(()) }
        })
    }
}

/// A first frame makes so many pipelines, a second one of the same kind none. A warm-up makes what the frame does, and leaves nothing for
/// it.
fn warm_up() -> Result<(), String> {
    let gpu = Gpu::with_limits(wgpu::Limits::default())?;
    for (what, frame, expected) in Frame::kinds() {
        for warm_ups in [0, 2] {
            let pipelines = Pipelines::new(&gpu.device);
            let drawing = frame.pipelines(&pipelines)?;
            let before = pipelines.len();
            for number in 1..=warm_ups {
                pipelines.warm_up(&frame.uses(&drawing)).map_err(text)?;
                same(&format!("{what}, pipelines of warm-up {number}"), &[pipelines.len() - before], &[expected])?;
            }
            for number in 1..=2 {
                frame.run(&gpu, &pipelines, &drawing)?;
                let what = format!("{what}, pipelines of frame {number} after {warm_ups} warm-ups");
                same(&what, &[pipelines.len() - before], &[expected])?;
            }
        }
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
