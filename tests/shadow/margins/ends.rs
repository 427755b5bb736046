//! Where volumes end: beyond the range, and not much farther.

use glam::{DVec3, DVec4};
use rimline::Light;
use rimline::internals::layout::{ShadowLight, ShadowShape};
use rimline::internals::shadow::{COUNT_Z_FAIL, COUNT_Z_PASS};
use rimline::internals::stages::SIDES;
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::is_long;
use rimline_testkit::random::Random;
use rimline_testkit::scenes::{Pose, direction};

use super::view::{Case, chosen, options};
use crate::sides::box_of;
use rimline_testkit::stage_probe::Probe;

pub(super) const TESTS: &[Test] = &[("volumes_end_beyond_the_range_and_hardly_later", volumes_end)];

fn volumes_end() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(211)?;
    let (mut ended, mut cases) = (0, [Vec::new(), Vec::new()]);
    for number in 0..if is_long() { 60_000 } else { 3000 } {
        let scale = [1.0, 1e-3, 1e4][number % 3];
        let corner = |random: &mut Random| (direction(random) * scale).as_vec3().to_array();
        let positions: [[f32; 3]; 3] = [0, 1, 2].map(|_: i32| corner(&mut random));
        let camera = Pose::random(&mut random, DVec3::ZERO, scale).camera(0, false);
        let light_position = (direction(&mut random) * scale * f64::from(random.between(1.0, 6.0))).as_vec3();
        let w = [1.0, random.between(0.1, 5.0)][random.below(2)];
        let light = Light::homogeneous([light_position.x * w, light_position.y * w, light_position.z * w, w]);
        let [x, y, z, w] = light.to_array().map(f64::from);
        let given = DVec3::new(x, y, z) / w;
        let (_, distance) = measured(given, &positions);
        let range = (distance + scale * f64::from(random.between(-0.5, 20.0))).max(0.1 * scale) as f32;
        cases[random.below(2)].push((camera, light.with_range(range), positions.to_vec()));
    }
    let probe = Probe::of(&gpu, &SIDES, [1, 1], "out[0] = far_vertex(pair.view, pair.light, input_position(0u));")?;
    for (cases, counting) in cases.iter().zip([COUNT_Z_PASS, COUNT_Z_FAIL]) {
        let lights = chosen(&gpu, ShadowShape { end_at_range: 1, ..options(counting, false) }, cases)?;
        let corners = (0..).zip(cases).flat_map(|(number, case)| case.2.iter().map(move |&corner| (number, [corner])));
        let corners: Vec<_> = corners.collect();
        let found = probe.run(&gpu, &[], &lights, &corners)?;
        for ((case, (_, light)), found) in cases.iter().zip(&lights).zip(found.chunks(3)) {
            ended += usize::from(check(case, light, found));
        }
    }
    println!("{ended} volumes end");
    assert!(ended > 1500, "not vacuous");
    Ok(())
}

/// A box, how far the light is from it, and the scale of both.
fn measured(given: DVec3, positions: &[[f32; 3]]) -> ([DVec3; 2], f64) {
    let [low, high] = box_of(positions.iter().copied()).map(|corner| DVec3::from(corner.map(f64::from)));
    ([low, high], (low - given).max(given - high).max(DVec3::ZERO).length())
}

/// Whether the volume ends.
fn check((camera, given, positions): &Case, light: &ShadowLight, found: &[Vec<[f32; 4]>]) -> bool {
    let [x, y, z, w] = given.to_array().map(f64::from);
    let (range, given) = (given.range, DVec3::new(x, y, z) / w);
    let ([low, high], distance) = measured(given, positions);
    let exact = distance / f64::from(range);
    let end = f64::from(light.end);
    if light.casting == 0 {
        assert!(exact > 1.0 - 1e-5, "skipped, {distance} away with a range of {range}");
        return false;
    }
    let size = low.abs().max(high.abs()).max(given.abs()).max_element();
    let slack = 2e-5 * (distance + size) / f64::from(range);
    assert!(end <= exact.min(1.0), "the end is {end}, beyond the range is {exact}");
    assert!(end >= exact.min(1.0) - slack, "the end is {end}, the range is at {exact}");
    if end == 0.0 {
        return false;
    }
    // Nothing of the far face, found from its vertices in clip space, is within the range.
    let inverse = glam::Mat4::from_cols_array_2d(&camera.view_projection).as_dmat4().inverse();
    for (position, clip) in positions.iter().zip(found) {
        let far = inverse * DVec4::from(clip[0].map(f64::from));
        let far = far.truncate() / far.w;
        let expected = given + (DVec3::from(position.map(f64::from)) - given) / end;
        let apart = far.distance(expected) / (size + expected.distance(given) + given.length());
        assert!(apart < 1e-3, "far vertex at {far}, expected {expected}");
    }
    assert!(distance / end >= f64::from(range));
    true
}
