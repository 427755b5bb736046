//! Volumes that no receiver can be in: without them every receiver has the same count.

use glam::DVec3;
use rimline::gpu::{FrameInputs, Receivers, Scene, SceneOptions, ShadowError, View};
use rimline::internals::shadow::CAST_NOTHING;
use rimline::{Counting, DepthDirection, Light, ShadowCamera};
use rimline_testkit::OneCasterOptions;
use rimline_testkit::device::Gpu;
use rimline_testkit::on_gpu::text;
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, must_fail, same, shapes};

use crate::classes::CLASSES;
use crate::rays::Truth;
use crate::render::{Counted, Placing, Renderer};
use crate::scene::{Body, Eye, Frame};
use crate::trials::{RIGHT, Test, Traced, rotated, seed};

pub(crate) const TESTS: &[Test] = &[
    ("hidden_volumes_change_no_receiver", classes),
    ("walls_hide_casters_and_their_shadows", walls),
    ("depth_that_comes_nearer_afterwards_is_right", nearer),
    ("receivers_that_cannot_be_read_are_refused", refused),
];

fn direction(random: &mut Random) -> DVec3 {
    DVec3::from(random.direction().map(f64::from))
}

/// Fails where a pixel with a surface, or any pixel if the sky receives, has another count than without knowing receivers.
/// Returns the pairs of caster and light that were hidden.
fn check(traced: &Traced, renderer: &Renderer<'_>, counting: Counting, sky: bool) -> Result<u32, String> {
    let without = Renderer { receivers: None, pipelines: renderer.pipelines.clone(), ..*renderer };
    let expected = without.count(&traced.frame, counting)?;
    let renderer = Renderer { receivers: Some(sky), pipelines: renderer.pipelines.clone(), ..*renderer };
    let found = renderer.count(&traced.frame, counting)?;
    let seen = |counted: &Counted| -> Vec<u8> {
        let pixels = counted.stencils[0].iter().zip(&traced.truths);
        pixels.map(|(&count, truths)| if sky || truths[0] != Truth::Background { count } else { 0 }).collect()
    };
    let what = format!("seed {}, {counting:?}, sky {sky}", traced.seed);
    let (found_seen, expected_seen) = (seen(&found), seen(&expected));
    same(&what, &found_seen, &expected_seen)?;
    let mut other = found_seen;
    let at = other.len() / 2;
    other[at] ^= 1;
    must_fail("one count", &same(&what, &other, &expected_seen))?;
    same("hidden without receivers", &[expected.statistics[0].culled_by_receivers], &[0])?;
    // Each pair of caster and light is as without receivers, or casts nothing, and then it is counted.
    let casting = |counted: &Counted| counted.chosen.concat().iter().map(|light| light.casting).collect::<Vec<_>>();
    let (found_casting, expected_casting) = (casting(&found), casting(&expected));
    let pairs = || found_casting.iter().zip(&expected_casting);
    if let Some((found, expected)) = pairs().find(|(found, expected)| found != expected && **found != CAST_NOTHING) {
        return Err(format!("{what}: a caster casts by {found}, without receivers by {expected}"));
    }
    let hidden = pairs().filter(|(found, expected)| found != expected).count();
    same(&format!("{what}: hidden"), &[found.statistics[0].culled_by_receivers as usize], &[hidden])?;
    Ok(found.statistics[0].culled_by_receivers)
}

fn classes() -> Result<(), String> {
    let gpu = &*Gpu::shared_with_depth_features()?;
    let (mut hidden, mut with_sky) = (0, 0);
    for (index, class) in (0..).zip(CLASSES) {
        for number in if is_long() { 260..300 } else { 260 + index..261 + index } {
            let mut frame = (class.frame)(&mut Random::new(seed(class, number)));
            frame.size = 48;
            // Something in front, which hides the middle.
            let ahead = (8.0 * frame.eye.near + 0.3) * frame.eye.forward.normalize();
            let half = [0.35, 0.5, 0.65][number as usize % 3] * ahead.length() as f32;
            let front = Body { casts: false, ..Body::caster(shapes::cube()) };
            frame.bodies.push(front.scaled(half).moved((frame.eye.position + ahead).as_vec3().to_array()));
            let traced = Traced::of(frame, seed(class, number));
            for counting in [Counting::Auto, Counting::ZpPlus, Counting::ZFail] {
                let options = OneCasterOptions { end_at_range: number % 2 == 0, ..OneCasterOptions::default() };
                let samples = if number % 2 == 0 { 1 } else { 4 };
                let placing = if number % 4 < 2 { Placing::Scene } else { Placing::Busy(number) };
                let renderer = Renderer { placing, options, samples, range: 12.0, ..Renderer::new(gpu) };
                hidden +=
                    check(&traced, &renderer, counting, false).map_err(|error| format!("{}: {error}", class.name))?;
                if rotated(&RIGHT, index as usize).contains(&counting) {
                    with_sky += check(&traced, &renderer, counting, true)?;
                }
            }
        }
    }
    println!("{hidden} pairs hidden, {with_sky} where the sky receives");
    if hidden < 20 { Err("too few".to_owned()) } else { Ok(()) }
}

/// A wall before the eye, with a gap; casters on both sides of it, and a floor.
pub(crate) fn behind_walls(random: &mut Random) -> Frame {
    let flat = |half: [f32; 3]| {
        let mut shape = shapes::cube();
        shape.positions.iter_mut().for_each(|p| *p = std::array::from_fn(|axis| p[axis] * half[axis]));
        shape
    };
    let mut bodies = Vec::new();
    for side in [-1.0, 1.0] {
        let wall = Body { casts: random.below(2) == 0, ..Body::caster(flat([3.0, 3.0, 0.05])) };
        bodies.push(wall.moved([side * 3.2, 1.0, -4.0]));
    }
    let casts = random.below(2) == 0;
    bodies.push(Body { casts, ..Body::caster(flat([12.0, 0.1, 12.0])) }.moved([0.0, -2.0, -6.0]));
    for _ in 0..8 {
        let shape = [shapes::cube(), shapes::blob(6, 0.2, 3), shapes::torus(16, 8, 1.0, 0.4)][random.below(3)].clone();
        let at = [random.between(-6.0, 6.0), random.between(-1.5, 1.5), random.between(-14.0, -1.5)];
        bodies.push(Body::caster(shape).scaled(random.between(0.1, 0.5)).moved(at));
    }
    let light = match random.below(3) {
        0 => Light::directional([random.between(-1.0, 1.0), random.between(0.2, 1.0), random.between(-1.0, 1.0)]),
        1 => Light::point([random.between(-6.0, 6.0), random.between(2.0, 9.0), random.between(-12.0, 4.0)]),
        _ => Light::point([random.between(-3.0, 3.0), random.between(0.0, 3.0), random.between(-10.0, -5.0)]),
    };
    let position = DVec3::new(f64::from(random.between(-1.0, 1.0)), 0.0, 1.5);
    let forward = DVec3::NEG_Z + 0.3 * direction(random);
    let depth = [DepthDirection::Reversed, DepthDirection::Standard][random.below(2)];
    let eye = Eye { is_relative: true, depth, ..Eye::new(position, forward, 0.05) };
    Frame { bodies, eye, lights: vec![light], size: 64 }
}

/// A hidden face changes no receiver's count, and counts are what rays tell.
fn walls() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut hidden = 0;
    let frames = if is_long() { 300 } else { 40 };
    for seed in 5001..5001 + frames {
        let traced = Traced::of(behind_walls(&mut Random::new(seed)), seed);
        let counting = [Counting::Auto, Counting::ZpPlus, Counting::ZFail][seed as usize % 3];
        let renderer = Renderer { placing: Placing::Scene, ..Renderer::new(gpu) };
        hidden += check(&traced, &renderer, counting, false)?;
        let renderer = Renderer { receivers: Some(false), ..renderer };
        traced.check(&renderer, counting, true)?;
        if seed == 5001 {
            let other = Traced::of(behind_walls(&mut Random::new(seed + 1)), seed);
            let other = Traced { truths: other.truths, ..traced };
            must_fail("the rays of another frame", &other.check(&renderer, counting, true))?;
        }
    }
    println!("{hidden} of some {} pairs hidden", 9 * frames);
    if 4 * hidden < 9 * frames as u32 { Err("too few".to_owned()) } else { Ok(()) }
}

/// The receivers are those of a frame that lacks a body in front of the others.
fn nearer() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut hidden = 0;
    for seed in 5501..5501 + if is_long() { 200 } else { 20 } {
        let mut random = Random::new(seed);
        let mut frame = behind_walls(&mut random);
        frame.eye.depth = DepthDirection::Reversed;
        // All around, so that there is no sky.
        frame.bodies.push(Body::room([0.0, 0.0, -5.0], 20.0));
        let at = frame.eye.position + 0.9 * frame.eye.forward.normalize();
        let near = Body { casts: false, ..Body::caster(shapes::cube()) };
        frame.bodies.push(near.scaled(0.1).moved(at.as_vec3().to_array()));
        let traced = Traced::of(frame, seed);
        let renderer = Renderer { placing: Placing::Scene, late_bodies: 1, ..Renderer::new(gpu) };
        hidden += check(&traced, &renderer, Counting::Auto, false)?;
    }
    println!("{hidden} pairs hidden");
    if hidden < 20 { Err("too few".to_owned()) } else { Ok(()) }
}

/// A texture that cannot be read gives a typed error. The next encode is as if nothing had been asked.
fn refused() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut scene = Scene::new(&gpu.pipelines, &gpu.queue, SceneOptions::default()).map_err(text)?;
    let shape = shapes::cube();
    let mesh = scene.add_mesh(&shape.mesh().map_err(text)?, &shape.positions).map_err(text)?;
    let rows = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    scene.insert(rimline::gpu::Caster::rigid(mesh, rows)).map_err(text)?;
    scene.add_light(Light::point([0.0, 5.0, 0.0])).map_err(text)?;
    let mut random = Random::new(1);
    let camera: ShadowCamera = behind_walls(&mut random).eye.camera();
    let texture = |format, usage, layers| {
        gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width: 20, height: 30, depth_or_array_layers: layers },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: usage | wgpu::TextureUsages::RENDER_ATTACHMENT,
            view_formats: &[],
        })
    };
    let (bound, depth) = (wgpu::TextureUsages::TEXTURE_BINDING, wgpu::TextureFormat::Depth24PlusStencil8);
    let colour = wgpu::TextureFormat::Rgba8Unorm;
    let only = wgpu::TextureViewDescriptor { aspect: wgpu::TextureAspect::DepthOnly, ..Default::default() };
    let views = [
        (texture(colour, bound, 1), wgpu::TextureViewDescriptor::default()),
        (texture(depth, wgpu::TextureUsages::empty(), 1), only.clone()),
        // Both aspects, and several layers.
        (texture(depth, bound, 1), wgpu::TextureViewDescriptor::default()),
        (texture(depth, bound, 2), only.clone()),
        (texture(depth, bound, 1), only),
    ];
    let mut errors = Vec::new();
    for (texture, descriptor) in &views {
        let view = texture.create_view(descriptor);
        let depth = Some(Receivers { depth: &view, sky_receives: false, version: None });
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        errors.push(match scene.encode(&mut encoder, FrameInputs::new(&[View { depth, ..View::new(camera) }])) {
            Ok(_) => "none",
            Err(ShadowError::ReceiversFormat { view: 0, format }) if format == colour => "format",
            Err(ShadowError::ReceiversUsage { view: 0 }) => "usage",
            Err(ShadowError::ReceiversRefused { view: 0, .. }) => "refused",
            Err(error) => return Err(error.to_string()),
        });
        scene.encode(&mut encoder, FrameInputs::new(&[camera.into()])).map_err(text)?;
        gpu.queue.submit([encoder.finish()]);
    }
    same("errors", &errors, &["format", "usage", "refused", "refused", "none"])
}
