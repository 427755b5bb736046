//! Other cameras than a perspective one with reversed depth and without a far plane.

use glam::DVec3;
use rimline::{Counting, DepthDirection};

use crate::classes::{CLASSES, Class};
use crate::rays::{Tracer, Truth};
use crate::render::{Counted, Renderer};
use crate::scene::{Eye, Rays};
use crate::trials::{Tally, Test, Traced, every, seed};
use rimline_testkit::device::Gpu;
use rimline_testkit::is_long;
use rimline_testkit::random::Random;

pub(crate) const TESTS: &[Test] = &[
    ("standard_depth", standard_depth),
    ("z_fail_with_standard_depth_and_far_planes", z_fail),
    ("orthographic_cameras", orthographic),
];

/// A frame of a class, seen by another camera.
fn seen(class: &Class, number: u64, change: impl FnOnce(&mut Eye, &mut Random)) -> Traced {
    let seed = seed(class, number);
    let mut random = Random::new(seed);
    let mut frame = (class.frame)(&mut random);
    change(&mut frame.eye, &mut random);
    Traced::of(frame, seed)
}

/// Depth from 0 to 1, with a far plane and without.
fn standard_depth() -> Result<(), String> {
    let gpu = Gpu::shared_with_depth_features()?;
    let format = wgpu::TextureFormat::Depth32FloatStencil8;
    for far in [None, Some(100.0)] {
        let renderer = Renderer { format, ..Renderer::new(&gpu) };
        for class in CLASSES.iter().filter(|class| class.name.contains("near")) {
            let traced = seen(class, 3, |eye, _| {
                // Nearer planes leave too little of standard depth's precision.
                *eye = Eye { depth: DepthDirection::Standard, far, near: eye.near.max(0.1), ..*eye };
            });
            traced.check(&renderer, Counting::Auto, false).map_err(|error| format!("{}: {error}", class.name))?;
        }
    }
    Ok(())
}

/// z-fail from perspective cameras: with standard depth, with a far plane, and with both.
fn z_fail() -> Result<(), String> {
    let gpu = Gpu::shared_with_depth_features()?;
    let renderer = Renderer { format: wgpu::TextureFormat::Depth32FloatStencil8, ..Renderer::new(&gpu) };
    let all = [
        (DepthDirection::Standard, None),
        (DepthDirection::Standard, Some(60.0)),
        (DepthDirection::Reversed, Some(60.0)),
    ];
    for (first, (depth, far)) in all.into_iter().enumerate() {
        let (mut shadowed, mut cut, mut noticed, mut imprecise) = (0, 0, 0, 0);
        let (first, step) = if is_long() { (0, 1) } else { (first, all.len()) };
        for class in CLASSES.iter().skip(first).step_by(step) {
            for number in 90..if is_long() { 100 } else { 91 } {
                let traced = seen(class, number, |eye, _| {
                    *eye = Eye { depth, far, near: eye.near.max(0.1), ..*eye };
                });
                let what =
                    |error| format!("{depth:?}, far plane {far:?}, {}, seed {}: {error}", class.name, traced.seed);
                let mut counted = renderer.count(&traced.frame, Counting::ZFail).map_err(what)?;
                let (wrong, specks) = wrong_pixels(&traced, &counted, !class.touches);
                if let Some(&pixel) = wrong.first() {
                    let is_alone = wrong.len() == 1 && depth == DepthDirection::Standard;
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
                noticed += usize::from(in_shadow > 100 && unequal(&traced, &counted, false).is_err());
            }
        }
        println!(
            "{depth:?}, far plane {far:?}: {shadowed} pixels in shadow, {cut} pixels of cut faces wrong, {imprecise} by depth's \
             precision"
        );
        if shadowed == 0 || noticed == 0 {
            return Err("negative control: light for shadow went unnoticed".to_owned());
        }
    }
    Ok(())
}

/// Orthographic cameras of both depth directions.
fn orthographic() -> Result<(), String> {
    // z-fail needs depth to be unclipped here, for there is a far plane.
    let gpu = Gpu::shared_with_depth_features()?;
    let renderer = Renderer::new(&gpu);
    let (mut tally, mut cut) = (Tally::default(), 0);
    let directions = [DepthDirection::Reversed, DepthDirection::Standard];
    let classes = CLASSES.iter().zip(directions.iter().cycle()).skip(1);
    for (class, direction) in classes.step_by(if is_long() { 1 } else { 3 }) {
        for number in 60..if is_long() { 65 } else { 61 } {
            let traced = seen(class, number, |eye, random| {
                let half_width = Some(f64::from(random.between(0.3, 3.0)));
                *eye = Eye { depth: *direction, far: Some(40.0), half_width, ..*eye };
            });
            tally.add(&traced, &renderer, &[Counting::Auto, Counting::ZpPlus], !class.touches);
            let what = |error| format!("{}, seed {}: {error}", class.name, traced.seed);
            let counted = renderer.count(&traced.frame, Counting::ZFail)?;
            cut += unequal(&traced, &counted, !class.touches).map_err(what)?;
        }
    }
    println!("{cut} pixels of cut faces wrong by z-fail");
    tally.result("orthographic cameras")
}

/// With a far plane z-fail draws light caps unclipped, so where every face casts, those that the near plane cuts need
/// not have the bits of a depth pass that is clipped. Fails where another pixel is wrong; returns how many of these
/// are.
fn unequal(traced: &Traced, counted: &Counted, counts: bool) -> Result<usize, String> {
    match wrong_pixels(traced, counted, counts) {
        (wrong, cut) if wrong.is_empty() => Ok(cut),
        (wrong, _) => Err(format!("z-fail: {:?} is wrong", wrong[0])),
    }
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

/// Pixels that are wrong, and how many of cut faces are, likewise.
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
    // Told by both comparisons.
    others.sort_unstable();
    others.dedup();
    (others, cut.len())
}
