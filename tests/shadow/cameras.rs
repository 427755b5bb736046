//! Other cameras than a perspective one with reversed depth and without a far plane.

use glam::{DQuat, DVec3, Vec3};
use rimline::{Counting, DepthDirection, Light};
use rimline_testkit::device::Gpu;
use rimline_testkit::frame_classes::CLASSES;
use rimline_testkit::frames::{Body, Eye, Frame, Rays, vector};
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, shapes};

use crate::compare::Compared;
use crate::rays::{Tracer, Truth};
use crate::render::{Counted, Placing, Renderer};
use crate::trials::{Test, Traced, every, seed};

pub(crate) const TESTS: &[Test] = &[
    ("cameras_with_standard_depth_far_planes_and_without_perspective", others),
    ("dark_caps_of_orthographic_cameras", dark_caps),
];

/// Depth directions and far planes of perspective cameras, then those of orthographic ones.
const CAMERAS: [(DepthDirection, Option<f64>, bool); 5] = [
    (DepthDirection::Standard, None, false),
    (DepthDirection::Standard, Some(60.0), false),
    (DepthDirection::Reversed, Some(60.0), false),
    (DepthDirection::Standard, Some(40.0), true),
    (DepthDirection::Reversed, Some(40.0), true),
];

/// Frames of the classes, each seen by some of these cameras, by each method that is right.
fn others() -> Result<(), String> {
    // z-fail needs depth to be unclipped where there is a far plane.
    let gpu = Gpu::shared_with_depth_features()?;
    for (first, (depth, far, is_orthographic)) in CAMERAS.into_iter().enumerate() {
        let (mut shadowed, mut cut, mut noticed, mut imprecise) = (0, 0, 0, 0);
        let float = wgpu::TextureFormat::Depth32FloatStencil8;
        let plain = Renderer::new(&gpu);
        let renderer = Renderer { format: if is_orthographic { plain.format } else { float }, ..plain };
        let (first, step) = if is_long() { (0, 1) } else { (first % 3, 3) };
        for (index, class) in CLASSES.iter().enumerate().skip(first).step_by(step) {
            for number in 90..if is_long() { 100 } else { 91 } {
                let seed = seed(class, number);
                let mut random = Random::new(seed);
                let mut frame = (class.frame)(&mut random);
                let half_width = is_orthographic.then(|| f64::from(random.between(0.3, 3.0)));
                // Nearer planes leave too little of standard depth's precision.
                let near = if is_orthographic { frame.eye.near } else { frame.eye.near.max(0.1) };
                frame.eye = Eye { near, depth, far, half_width, ..frame.eye };
                let traced = Traced::of(frame, seed);
                let what =
                    |error| format!("{depth:?}, far plane {far:?}, {half_width:?}, {}, {seed}: {error}", class.name);
                let counting = [Counting::Auto, Counting::ZpPlus][index / step % 2];
                traced.check(&renderer, counting, is_orthographic && !class.touches).map_err(what)?;
                let mut counted = renderer.count(&traced.frame, Counting::ZFail).map_err(what)?;
                let (wrong, specks) = wrong_pixels(&traced, &counted, !class.touches);
                if let Some(&pixel) = wrong.first() {
                    let is_alone = wrong.len() == 1 && depth == DepthDirection::Standard && !is_orthographic;
                    if !is_alone || !is_right_reversed(&renderer, &traced, pixel)? {
                        return Err(what(format!("{wrong:?} are wrong")));
                    }
                    imprecise += 1;
                }
                if far.is_none() && specks > 0 {
                    return Err(what(format!("{specks} wrong pixels")));
                }
                cut += specks;
                let in_shadow = traced.shadowed();
                shadowed += in_shadow;
                counted.stencils[0].fill(0);
                noticed += usize::from(in_shadow > 100 && !wrong_pixels(&traced, &counted, false).0.is_empty());
            }
        }
        println!(
            "{depth:?}, far plane {far:?}, orthographic {is_orthographic}: {shadowed} pixels in shadow, {cut} pixels of \
             cut faces wrong, {imprecise} by depth's precision"
        );
        if shadowed == 0 || noticed == 0 {
            return Err("negative control: light for shadow went unnoticed".to_owned());
        }
    }
    Ok(())
}

/// The camera's direction leads from most lights to a caster: to a vertex of a grid or the middle of an edge, without
/// rounding, so that products are zero and the order of the indices decides which one of the faces there has the
/// direction; or to anywhere on a grid or a ball. A dark cap too many or too few is wrong all over the picture. Then the
/// world is turned, the caster is mirrored, by itself or in a scene, and from half of the lights the opposite direction
/// leads to it.
fn dark_caps() -> Result<(), String> {
    use DepthDirection::{Reversed, Standard};
    let (gpu, mut random) = (Gpu::shared_with_depth_features()?, Random::new(106));
    let mut grid = shapes::plane_grid(8, 8);
    grid.positions.iter_mut().for_each(|position| *position = [position[0], position[2], -2.0]);
    let ball = shapes::blob(6, 0.3, 5).placed(|[x, y, z]| [x, y, z - 3.5]);
    let mut shadowed = 0;
    for (depth, is_turned) in [(Reversed, false), (Standard, false), (Reversed, true), (Standard, true)] {
        let turn = if is_turned {
            DQuat::from_axis_angle(vector(&mut random).normalize(), f64::from(random.between(0.5, 6.0)))
        } else {
            DQuat::IDENTITY
        };
        let turned = |p: [f32; 3]| (turn * DVec3::from(p.map(f64::from))).as_vec3().to_array();
        let mirror = is_turned.then_some(Vec3::new(1.0, -1.0, 1.0));
        let placing = if is_turned && depth == Standard { Placing::Scene } else { Placing::Alone };
        // Ties hold only where nothing is rounded.
        for (caster, is_tie) in [(&grid, true), (&grid, false), (&ball, false)].into_iter().skip(usize::from(is_turned))
        {
            let mut coordinate =
                || if is_tie { random.below(15) as f32 / 8.0 - 0.875 } else { random.between(-1.2, 1.2) };
            let light = |number: usize| {
                let z = if is_turned && number % 2 == 1 { -5.0 } else { -1.0 };
                Light::point(turned([coordinate(), coordinate(), z]))
            };
            let lights: Vec<Light> = (0..32).map(light).collect();
            let eye = Eye::new(DVec3::ZERO, turn * DVec3::NEG_Z, 0.125);
            let eye = Eye { depth, far: Some(40.0), half_width: Some(4.0), ..eye };
            let body = Body { mirror, ..Body::caster(caster.clone().placed(turned)) };
            let bodies = vec![body, Body::room([0.0; 3], 8.0)];
            let traced = Traced::of(Frame { bodies, eye, lights, size: 32 }, 106);
            for range in [f32::INFINITY, 20.0] {
                let mut renderer = Renderer { range, placing, ..Renderer::new(&gpu) };
                renderer.options.end_at_range = range < 40.0;
                let counted = renderer.count(&traced.frame, Counting::ZFail)?;
                for (light, stencil) in counted.stencils.iter().enumerate() {
                    let wrong = Compared { light, ..traced.compared() }.counts(stencil, &every(&counted, light));
                    if !wrong.pixels.is_empty() || wrong.compared < 100 {
                        let (count, at) = (wrong.pixels.len(), traced.frame.lights[light]);
                        let how = format!("{depth:?}, turned {is_turned}, tie {is_tie}, range {range}, {at:?}");
                        return Err(format!("{how}: {count} wrong pixels"));
                    }
                    shadowed += traced.truths.iter().filter(|truths| truths[light].is_shadowed()).count();
                }
            }
        }
    }
    println!("{shadowed} pixels in shadow");
    if shadowed > 100_000 { Ok(()) } else { Err("too few pixels in shadow".to_owned()) }
}

/// Whether a pixel has its count if nothing but depth is reversed, and so more precise: docs/numerics/rasterisers.md,
/// "Hairlines".
fn is_right_reversed(renderer: &Renderer<'_>, traced: &Traced, (x, y): (u32, u32)) -> Result<bool, String> {
    let mut frame = traced.frame.clone();
    frame.eye = Eye { depth: DepthDirection::Reversed, far: None, ..frame.eye };
    let counted = renderer.count(&frame, Counting::ZFail)?;
    let at = (y * frame.size + x) as usize;
    let every = every(&counted, 0);
    Ok(matches!(traced.truths[at][0], Truth::Surface(between)
        if between.count(&every) % 256 == u16::from(counted.stencils[0][at])))
}

/// Pixels that are wrong, and how many of cut faces are. With a far plane z-fail draws light caps unclipped, so where every
/// face casts, those that the near plane cuts need not have the bits of a depth pass that is clipped.
fn wrong_pixels(traced: &Traced, counted: &Counted, counts: bool) -> (Vec<(u32, u32)>, usize) {
    let every = every(counted, 0);
    let mut wrong = traced.compared().lit(&counted.stencils[0], &every);
    if counts {
        wrong.add(&traced.compared().counts(&counted.stencils[0], &every));
    }
    let camera = traced.frame.eye.camera();
    let (rays, tracer) = (Rays::new(&camera, traced.frame.size), Tracer::new(&traced.frame));
    let Eye { position, forward, near, .. } = traced.frame.eye;
    let is_before = |corner: DVec3| (corner - position).dot(forward.normalize()) < near;
    let is_cut = |&&(x, y): &&(u32, u32)| {
        let face = tracer.first(rays.ray(x, y)).map(|(_, face)| face);
        face.filter(|face| face.of.caster.is_some_and(|caster| every[caster])).is_some_and(|face| {
            let before = face.corners.map(is_before);
            before.contains(&true) && before.contains(&false)
        })
    };
    let (cut, mut others): (Vec<_>, Vec<_>) = wrong.pixels.iter().partition(|pixel| is_cut(pixel));
    // Both comparisons notice it.
    others.sort_unstable();
    others.dedup();
    (others, cut.len())
}
