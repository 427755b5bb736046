//! Proxies: casters of a scene that are not in the depth buffer.

use glam::{DVec3, Vec3};
use rimline::{Counting, Light};
use rimline_testkit::device::Gpu;
use rimline_testkit::frames::{Body, Eye, Frame, vector};
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, must_fail, same, shapes};

use crate::render::{Placing, Renderer};
use crate::trials::{RIGHT, Test, Traced};

pub(crate) const TESTS: &[Test] = &[
    ("proxies_shadow_the_receivers_in_them", around_receivers),
    ("proxies_within_what_is_drawn_cast_by_every_method", within_hulls),
    ("only_proxies_of_a_group_have_light_caps_with_z_pass", mixed_group),
];

fn proxy(random: &mut Random) -> Body {
    let shape = [shapes::cube(), shapes::blob(6, 0.2, 3), shapes::torus(24, 12, 1.0, 0.5)][random.below(3)].clone();
    Body { is_drawn: false, in_depth: false, ..Body::caster(shape) }
}

fn frame(random: &mut Random, mut bodies: Vec<Body>, [position, light, at]: [DVec3; 3]) -> Frame {
    bodies.push(Body::caster(shapes::torus(24, 12, 1.0, 0.35)).moved([2.5, 0.5, 0.0]));
    bodies.push(Body::room([0.0; 3], 8.0));
    let forward = vector(random) * 0.3 + at - position;
    let near = f64::from(random.between(0.02, 0.3));
    let eye = Eye { is_relative: true, ..Eye::new(position, forward, near) };
    Frame { bodies, eye, lights: vec![Light::point(light.as_vec3().to_array())], size: 64 }
}

/// A receiver in a proxy, which may itself cast; and the eye or the light in the proxy, or outside.
fn around(random: &mut Random) -> Frame {
    let proxy = proxy(random);
    let offset = vector(random).as_vec3().to_array().map(|c| 0.3 * c);
    let within = Body::caster(shapes::blob(6, 0.3, 5)).scaled(0.3).moved(offset);
    let within = Body { casts: random.below(2) == 0, ..within };
    let far = |random: &mut Random| vector(random) * [0.9, 3.5, 6.0][random.below(3)];
    let (position, light) = (far(random), far(random));
    let mut frame = frame(random, vec![proxy, within], [position, light, DVec3::ZERO]);
    // Half of the pictures show little but the receiver.
    frame.eye.forward = if random.below(2) == 0 { -position } else { frame.eye.forward };
    frame
}

/// A proxy in a body that is drawn and casts nothing. The eye is outside of both.
fn within(random: &mut Random) -> Frame {
    let proxy = proxy(random).scaled(0.55);
    let hull = Body { casts: false, ..Body::caster(shapes::cube()) };
    let far = |random: &mut Random| vector(random) * [3.5, 6.0][random.below(2)];
    let (position, light) = (far(random), far(random));
    // Looking at the shadow.
    frame(random, vec![proxy, hull], [position, light, light.normalize() * -6.0])
}

/// Frames by each method, of casters in one scene and each with volumes of its own; with lists that fit or overflow, and
/// with volumes that end or do not.
fn check(first: u64, make: fn(&mut Random) -> Frame) -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (mut shadowed, mut noticed, mut ended) = (0, 0, 0);
    for seed in first..first + if is_long() { 300 } else { 30 } {
        let mut traced = Traced::of(make(&mut Random::new(seed)), seed);
        shadowed += traced.shadowed();
        let placing = if seed % 3 == 0 { Placing::Alone } else { Placing::Scene };
        let end_at_range = seed % 2 == 0;
        // Nothing of the room is out of range.
        let range = if end_at_range { 40.0 } else { f32::INFINITY };
        let mut renderer = Renderer { range, placing, ..Renderer::new(gpu) };
        renderer.options.end_at_range = end_at_range;
        renderer.options.capacities.caps = (seed % 5 == 0).then_some(5);
        for counting in RIGHT {
            let (_, counted) = traced.check(&renderer, counting, true)?;
            ended += counted.statistics.iter().map(|statistics| statistics.ended).sum::<u32>();
        }
        // The negative controls: a proxy that is not in the scene, and one whose surface would be in the depth buffer.
        let proxy = traced.frame.bodies[0].clone();
        traced.frame.bodies[0].in_depth = true;
        noticed += usize::from(traced.check(&renderer, Counting::ZpPlus, false).is_err());
        traced.frame.bodies.remove(0);
        let without = RIGHT.iter().any(|&counting| traced.check(&renderer, counting, false).is_err());
        noticed += usize::from(without);
        traced.frame.bodies.insert(0, proxy);
    }
    println!("{shadowed} pixels in shadow, {ended} volumes that end, {noticed} faults noticed");
    if shadowed < 10_000 || ended < 10 || noticed < 10 { Err("too few of a kind".to_owned()) } else { Ok(()) }
}

fn around_receivers() -> Result<(), String> {
    check(4001, around)
}

fn within_hulls() -> Result<(), String> {
    check(4501, within)
}

/// Two casters of one group whose volumes end, so that faces of both are listed, and the eye sees through both. The shadow of
/// one is wrong once the scene takes it to be in the depth buffer, for it then has no light caps.
fn mixed_group() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut renderer = Renderer { range: 40.0, placing: Placing::Scene, ..Renderer::new(gpu) };
    renderer.options.end_at_range = true;
    // Rigid casters read the positions of one page.
    let seen_through = |x: f32| {
        let body = Body::caster(shapes::cube()).moved([x, 0.0, 0.0]);
        Body { is_drawn: false, in_depth: false, mirror: Some(Vec3::new(-1.0, 1.0, 1.0)), ..body }
    };
    let bodies = vec![seen_through(-1.5), seen_through(1.5), Body::room([0.0; 3], 8.0)];
    let position = DVec3::new(0.0, 3.0, 7.0);
    let (eye, lights) = (Eye::new(position, -position, 0.1), vec![Light::point([0.1, 7.0, 0.5])]);
    let mut traced = Traced::of(Frame { bodies, eye, lights, size: 96 }, 4801);
    let (_, counted) = traced.check(&renderer, Counting::Auto, true)?;
    same("volumes that end", &[counted.statistics[0].ended], &[2])?;
    traced.frame.bodies[1].in_depth = true;
    must_fail("no light caps", &traced.check(&renderer, Counting::Auto, true))
}
