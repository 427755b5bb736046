//! Where volumes end: beyond the range, and not much farther.

use glam::DVec3;
use rimline::Light;
use rimline::reference::cpu;
use rimline::reference::layout::ShadowShape;
use rimline::reference::shadow::{COUNT_Z_FAIL, COUNT_Z_PASS};

use crate::view::chosen;
use rimline_testkit::is_long;
use rimline_testkit::random::Random;
use rimline_testkit::scenes::{Pose, direction};

#[test]
fn volumes_end_beyond_the_range_and_hardly_later() {
    let seed = 211;
    println!("seed {seed}");
    let mut random = Random::new(seed);
    let mut ended = 0;
    for number in 0..if is_long() { 60_000 } else { 3000 } {
        let scale = [1.0, 1e-3, 1e4][number % 3];
        let corner = |random: &mut Random| (direction(random) * scale).as_vec3().to_array();
        let positions: [[f32; 3]; 3] = [0, 1, 2].map(|_: i32| corner(&mut random));
        let camera = Pose::random(&mut random, DVec3::ZERO, scale).camera(0, false);
        let place = (direction(&mut random) * scale * f64::from(random.between(1.0, 6.0))).as_vec3();
        let w = [1.0, random.between(0.1, 5.0)][random.below(2)];
        let light = Light::homogeneous([place.x * w, place.y * w, place.z * w, w]);
        let [x, y, z, w] = light.to_array().map(f64::from);
        let given = DVec3::new(x, y, z) / w;
        let corners = positions.map(|position| DVec3::from(position.map(f64::from)));
        let (low, high) = (corners[0].min(corners[1]).min(corners[2]), corners[0].max(corners[1]).max(corners[2]));
        let distance = (low - given).max(given - high).max(DVec3::ZERO).length();
        let range = (distance + scale * f64::from(random.between(-0.5, 20.0))).max(0.1 * scale) as f32;
        let counting = [COUNT_Z_PASS, COUNT_Z_FAIL][random.below(2)];
        let shape = ShadowShape { counting, end_at_range: 1, ..bytemuck::Zeroable::zeroed() };
        let (view, light) = chosen(&camera, light.with_range(range), shape, &positions, &[[0, 1, 2]]);
        let exact = distance / f64::from(range);
        let end = f64::from(light.end);
        if light.casting == 0 {
            assert!(exact > 1.0 - 1e-5, "{number}: skipped, {distance} away with a range of {range}");
            continue;
        }
        let slack = 2e-5 * (distance + low.abs().max(high.abs()).max(given.abs()).max_element()) / f64::from(range);
        assert!(end <= exact.min(1.0), "{number}: the end is {end}, beyond the range is {exact}");
        assert!(end >= exact.min(1.0) - slack, "{number}: the end is {end}, the range is at {exact}");
        if end == 0.0 {
            continue;
        }
        // Nothing of the far face, found from its vertices in clip space, is within the range.
        ended += 1;
        let inverse = glam::Mat4::from_cols_array_2d(&camera.view_projection).as_dmat4().inverse();
        for position in positions {
            let clip = cpu::far_end(&view, &light, position).as_dvec4();
            let far = inverse * clip;
            let far = far.truncate() / far.w;
            let expected = given + (DVec3::from(position.map(f64::from)) - given) / end;
            let apart = far.distance(expected) / (scale + expected.distance(given) + given.length());
            assert!(apart < 1e-3, "{number}: far vertex at {far}, expected {expected}");
        }
        assert!(distance / end >= f64::from(range), "{number}");
    }
    println!("{ended} volumes end");
    assert!(ended > 1500, "not vacuous");
}
