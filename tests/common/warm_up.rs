//! Pipelines that are made before the first frame, and which a frame makes.

use rimline::gpu::{
    Caster, DeformerOptions, Extractor, ExtractorOptions, FrameInputs, Pipelines, PositionBuffer, Receivers, Scene,
    SceneOptions, ShadowFormat, ShadowPipelines, StencilCounts, Use, View,
};
use rimline::{Counting, Light};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::models::bending_tube;
use rimline_testkit::on_gpu::text;
use rimline_testkit::passes::{CLEARED, depth_pass, texture};
use rimline_testkit::{IDENTITY, must_fail, same, shapes};

use crate::watched::camera;
use Part::{Camera, Model, Proxy, Seen};

pub(crate) const TESTS: &[Test] = &[("frames_and_warm_ups_make_what_they_need_and_no_more", warm_up)];

/// A part of a frame of a scene.
#[derive(Clone, Copy, PartialEq)]
enum Part {
    Camera,
    /// Receivers are looked up.
    Seen,
    Model,
    /// The caster is not in the depth buffer.
    Proxy,
}

type Kind = (&'static str, SceneOptions, &'static [Part], usize);

/// Each kind of frame, and how many pipelines it makes after `ShadowPipelines`.
fn kinds() -> Vec<Kind> {
    let plain = SceneOptions::default();
    let bounded = StencilCounts { bound_counts: true, ..Default::default() };
    // The stages from `cull_lights` to `arguments`, then those from `relist` to `shadow_arguments`.
    vec![
        ("no camera", plain, &[], 7),
        ("a camera", plain, &[Camera], 13),
        ("z-pass", SceneOptions { counting: Counting::ZPass, ..plain }, &[Camera], 13),
        // The case of each side.
        ("zp+ of 2005", SceneOptions { counting: Counting::ZpPlus2005, ..plain }, &[Camera], 14),
        ("bounds of counts", SceneOptions { stencil: bounded, ..plain }, &[Camera], 16),
        ("receivers", plain, &[Camera, Seen], 15),
        // Needs and deform.
        ("a model", plain, &[Camera, Model], 15),
        // The dark caps of both lists, and the light caps.
        ("ended volumes", SceneOptions { end_at_range: true, ..plain }, &[Camera], 15),
        ("a proxy", plain, &[Camera, Proxy], 15),
    ]
}

fn uses<'a>((_, options, parts, _): &'a Kind, drawing: &'a ShadowPipelines) -> Vec<Use<'a>> {
    let has = |part| parts.contains(&part);
    let mut uses = vec![if has(Camera) { Use::SceneShadows(options) } else { Use::Scene(options) }];
    uses.extend(has(Seen).then_some(Use::Receivers { samples: 1 }));
    uses.extend(has(Model).then_some(Use::SceneModels));
    uses.extend(options.end_at_range.then_some(Use::EndedVolumes(drawing)));
    uses.extend(has(Proxy).then_some(Use::Proxies(drawing)));
    uses
}

/// Encodes and draws.
fn run(
    gpu: &Gpu,
    pipelines: &Pipelines,
    drawing: &ShadowPipelines,
    (_, options, parts, _): &Kind,
) -> Result<(), String> {
    let has = |part| parts.contains(&part);
    let depth = gpu.device.create_texture(&texture([16; 2], ShadowFormat::default().depth_stencil));
    let view = depth.create_view(&wgpu::TextureViewDescriptor::default());
    let aspect = wgpu::TextureAspect::DepthOnly;
    let read = depth.create_view(&wgpu::TextureViewDescriptor { aspect, ..Default::default() });
    let shape = shapes::cube();
    let mut scene = Scene::new(pipelines, &gpu.queue, *options).map_err(text)?;
    let mesh = scene.add_mesh(&shape.mesh().map_err(text)?, &shape.positions).map_err(text)?;
    scene.insert(Caster { in_depth: !has(Proxy), ..Caster::rigid(mesh, IDENTITY) }).map_err(text)?;
    if has(Model) {
        let (model, pose) = bending_tube();
        scene.insert_model(&model, &pose(0.0), DeformerOptions::default()).map_err(text)?;
    }
    let light = scene.add_light(Light::point([0.0, 5.0, 0.0]).with_range(9.0)).map_err(text)?;
    let receivers = Receivers { depth: &read, sky_receives: false, version: None };
    let seen = [View { depth: has(Seen).then_some(receivers), ..View::new(camera()) }];
    let views = if has(Camera) { &seen[..] } else { &[] };
    gpu.submit(|encoder| {
        let frame = scene.encode(encoder, FrameInputs::new(views)).map_err(text)?;
        let mut pass = encoder.begin_render_pass(&depth_pass(&view, CLEARED));
        if has(Camera) { frame.draw(&mut pass, drawing, 0, light).map_err(text) } else { Ok(()) }
    })
}

/// A first frame makes so many pipelines, a second one of the same kind none. A warm-up makes what the frame does, and leaves nothing for
/// it.
fn warm_up() -> Result<(), String> {
    let gpu = Gpu::with_limits(wgpu::Limits::default())?;
    for kind in kinds() {
        let (what, options, _, expected) = kind;
        for warm_ups in [0, 2] {
            let pipelines = Pipelines::new(&gpu.device);
            let drawing = ShadowPipelines::new(&pipelines, &ShadowFormat::default(), options.counting).map_err(text)?;
            let before = pipelines.len();
            for number in 1..=warm_ups {
                pipelines.warm_up(&uses(&kind, &drawing)).map_err(text)?;
                same(&format!("{what}, pipelines of warm-up {number}"), &[pipelines.len() - before], &[expected])?;
            }
            for number in 1..=2 {
                run(&gpu, &pipelines, &drawing, &kind)?;
                let what = format!("{what}, pipelines of frame {number} after {warm_ups} warm-ups");
                same(&what, &[pipelines.len() - before], &[expected])?;
            }
        }
    }
    let pipelines = Pipelines::new(&gpu.device);
    let shape = shapes::cube();
    let options = ExtractorOptions::default();
    pipelines.warm_up(&[Use::Extraction(&options)]).map_err(text)?;
    let made = pipelines.len();
    let buffer = gpu.storage(&shape.positions);
    let positions = PositionBuffer { buffer: &buffer, offset: 0, stride: 12 };
    let mut extractor = Extractor::new(&pipelines, &shape.mesh().map_err(text)?, options).map_err(text)?;
    gpu.submit(|encoder| extractor.encode(encoder, positions, &[Light::point([0.0, 5.0, 0.0])]).map_err(text))?;
    same("pipelines after the warm-up of extraction", &[pipelines.len()], &[made])?;
    must_fail("nothing made", &same("pipelines", &[made], &[0]))
}
