//! Volumes that no receiver can be in: without them every receiver has the same count.

use glam::DVec3;
use rimline::internals::shadow::CAST_NOTHING;
use rimline::{Counting, DepthDirection, Light};
use rimline_testkit::device::Gpu;
use rimline_testkit::frames::{Body, CENTRE, Eye, Frame, SAMPLES, vector};
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, must_fail, same, shapes};

use crate::compare::Compared;
use crate::rays::Truth;
use crate::render::{Counted, Placing, Renderer};
use crate::trials::{RIGHT, Test, Traced, every};

pub(crate) const TESTS: &[Test] =
    &[("walls_hide_casters_and_their_shadows", walls), ("depth_that_comes_nearer_afterwards_is_right", nearer)];

/// Fails where a pixel with a surface, or any pixel if the sky receives, has another count than without knowing receivers.
/// Returns the pairs of caster and light that were culled.
fn check(traced: &Traced, renderer: &Renderer<'_>, counting: Counting, sky: bool) -> Result<u32, String> {
    let without = Renderer { receivers: None, ..*renderer };
    let expected = without.count(&traced.frame, counting)?;
    let renderer = Renderer { receivers: Some(sky), ..*renderer };
    let found = renderer.count(&traced.frame, counting)?;
    let seen = |counted: &Counted| -> Vec<u8> {
        let pixels = counted.stencils[0].iter().zip(&traced.truths);
        pixels.map(|(&count, truths)| if sky || truths[0] != Truth::Background { count } else { 0 }).collect()
    };
    let what = format!("seed {}, {counting:?}, sky {sky}", traced.seed);
    let (found_seen, expected_seen) = (seen(&found), seen(&expected));
    let within_pixel = if renderer.samples > 1 { SAMPLES[0] } else { CENTRE };
    let compared = Compared { within_pixel, ..traced.compared() };
    compared.alike(&what, &found_seen, &expected_seen, &every(&expected, 0))?;
    // One count that is off by one is noticed, but where a border or a hairline is near.
    let is_noticed = |at: &u32| {
        let mut other = expected_seen.clone();
        other[(at / 5 * 12 + 7) as usize * traced.frame.size as usize + (at % 5 * 12 + 7) as usize] ^= 1;
        compared.alike("one count", &other, &expected_seen, &every(&expected, 0)).is_err()
    };
    if traced.seed == 5001 && (0..25).filter(is_noticed).count() < 20 {
        return Err(format!("{what}: counts that are off by one are not noticed"));
    }
    same("culled without receivers", &[expected.statistics[0].culled_by_receivers], &[0])?;
    // Each pair of caster and light is as without receivers, or casts nothing, and then it is counted.
    let casting = |counted: &Counted| counted.chosen.concat().iter().map(|light| light.casting).collect::<Vec<_>>();
    let (found_casting, expected_casting) = (casting(&found), casting(&expected));
    let pairs = || found_casting.iter().zip(&expected_casting);
    if let Some((found, expected)) = pairs().find(|(found, expected)| found != expected && **found != CAST_NOTHING) {
        return Err(format!("{what}: a caster casts by {found}, without receivers by {expected}"));
    }
    let culled = pairs().filter(|(found, expected)| found != expected).count();
    same(&format!("{what}: culled"), &[found.statistics[0].culled_by_receivers as usize], &[culled])?;
    Ok(found.statistics[0].culled_by_receivers)
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
    let forward = DVec3::NEG_Z + 0.3 * vector(random);
    let depth = [DepthDirection::Reversed, DepthDirection::Standard][random.below(2)];
    let eye = Eye { is_relative: true, depth, ..Eye::new(position, forward, 0.05) };
    Frame { bodies, eye, lights: vec![light], size: 64 }
}

/// A culled volume changes no receiver's count, and counts are what rays tell.
fn walls() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (mut culled, mut with_sky) = (0, 0);
    let frames = if is_long() { 300 } else { 40 };
    for seed in 5001..5001 + frames {
        let traced = Traced::of(behind_walls(&mut Random::new(seed)), seed);
        let counting = RIGHT[seed as usize % 3];
        let renderer = Renderer { placing: Placing::Scene, ..Renderer::new(gpu) };
        let mut ending = Renderer { range: 12.0, ..renderer };
        ending.options.end_at_range = seed % 2 == 0;
        culled += check(&traced, &ending, counting, false)?;
        with_sky += check(&traced, &ending, counting, true)?;
        let renderer = Renderer { receivers: Some(false), ..renderer };
        traced.check(&renderer, counting, true)?;
        if seed == 5001 {
            let other = Traced::of(behind_walls(&mut Random::new(seed + 1)), seed);
            let other = Traced { truths: other.truths, ..traced };
            must_fail("the rays of another frame", &other.check(&renderer, counting, true))?;
        }
    }
    println!("{culled} of some {} pairs culled, {with_sky} where the sky receives", 9 * frames);
    if 4 * culled < 9 * frames as u32 || with_sky == 0 { Err("too few".to_owned()) } else { Ok(()) }
}

/// The receivers are those of a frame that lacks a body in front of the others.
fn nearer() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut culled = 0;
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
        let samples = [1, 4][seed as usize % 2];
        let renderer = Renderer { placing: Placing::Scene, samples, late_bodies: 1, ..Renderer::new(gpu) };
        culled += check(&traced, &renderer, Counting::Auto, false)?;
    }
    println!("{culled} pairs culled");
    if culled < 20 { Err("too few".to_owned()) } else { Ok(()) }
}
