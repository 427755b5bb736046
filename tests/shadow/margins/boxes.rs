//! Boxes that just touch: the caster's with the near rectangle's, and with the light. Where volumes end: beyond the
//! range, and not much farther; and which casters are out of range.
//!
//! The stage is `counting_methods`.

use glam::DVec3;
use rimline::Light;
use rimline::internals::layout::{ShadowLight, ShadowShape, ShadowView};
use rimline::internals::shadow::{
    self, CAST_BACK_FACING, CAST_EVERY, CAST_NOTHING, COUNT_AUTO, COUNT_Z_FAIL, COUNT_Z_PASS, COUNT_ZP_PLUS_2005,
};
use rimline::internals::stages::{CAP_FACES, COUNTING_METHODS};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::is_long;
use rimline_testkit::on_gpu::text;
use rimline_testkit::random::Random;
use rimline_testkit::same;
use rimline_testkit::scenes::{PROJECTIONS, Pose, direction};

use super::view::{Eye, around, box_of, chosen, options, stepped};
use rimline_testkit::stage_probe::Probe;

pub(super) const TESTS: &[Test] = &[
    ("casters_that_touch_the_near_rectangle_cast_with_every_face", touching_near_rectangle),
    ("lights_in_the_casters_box_make_every_face_cast", lights_in_box),
    ("the_published_frustum_begins_before_the_caster", published_frustum),
    ("the_published_frustum_of_numbers_that_overflow_is_defined", overflowing_frustum),
    ("volumes_end_beyond_the_range_and_hardly_later", volumes_end),
    ("receivers_limit_no_volume_whose_numbers_overflow", overflow),
    ("boxes_whose_numbers_overflow_may_have_the_light_and_the_camera", uncertain),
];

/// Or miss it by a few ulps: what is seen is decided by the rasteriser's near plane, which rounding moves that far.
fn touching_near_rectangle() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(201)?;
    let (mut touching, mut apart) = (0, 0);
    let (mut cases, mut expected) = (Vec::new(), Vec::new());
    for number in 0..if is_long() { 60_000 } else { 3000 } {
        let scale = [1.0, 0.01, 1e3][number % 3];
        let middle = direction(&mut random) * scale * [0.0, 10.0, 1e3][number / 3 % 3];
        let pose = Pose::random(&mut random, middle, scale);
        let camera = pose.camera(number % PROJECTIONS, random.below(2) == 0);
        let [near_low, near_high] = Eye::new(&camera).near_box();
        // Its near side is at the rectangle's, or some ulps off; along the other axes it is all around it.
        let (axis, is_below) = (random.below(3), random.below(2) == 0);
        let size = f64::from(random.between(0.5, 3.0)) * scale;
        let (mut low, mut high) = ((near_low - size).as_vec3().to_array(), (near_high + size).as_vec3().to_array());
        let touches = random.below(4) > 0;
        let coordinates = near_low.abs().max(near_high.abs());
        let ulps = f64::from(random.between(0.0, 4.0)) / 8_388_608.0;
        let distance = if touches { ulps * coordinates[axis] } else { 1e-3 * (scale + coordinates.max_element()) };
        if is_below {
            let [_, above] = around(near_low[axis] - distance);
            (low[axis], high[axis]) = (above - size as f32, above);
        } else {
            let [below, _] = around(near_high[axis] + distance);
            (low[axis], high[axis]) = (below, below + size as f32);
        }
        let light = Light::point((near_high + DVec3::splat(10.0 * scale + size)).as_vec3().to_array());
        cases.push((camera, light, vec![low, high]));
        expected.push((touches, [near_low, near_high]));
    }
    let found = chosen(&gpu, options(COUNT_AUTO, true), &cases)?;
    for (((_, light), (touches, near)), case) in found.iter().zip(expected).zip(&cases) {
        if touches {
            touching += 1;
            assert_eq!(light.casting, CAST_EVERY, "{:?}, near {near:?}", case.2);
        } else {
            apart += usize::from(light.casting == CAST_BACK_FACING);
        }
    }
    println!("{touching} touch; {apart} are apart and cast with their back-facing faces");
    assert!(touching > 1000 && apart > 500, "not vacuous");
    Ok(())
}

/// By products of two `f32`, which `f64` holds exactly.
fn lights_in_box() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(202)?;
    let (mut at_the_edge, mut apart) = (0, 0);
    let (mut cases, mut expected) = (Vec::new(), Vec::new());
    for number in 0..if is_long() { 60_000 } else { 3000 } {
        let scale = [1.0, 1e-3, 1e4][number % 3];
        let middle = direction(&mut random) * f64::from(scale) * [0.0, 1e3][number / 3 % 2];
        let corner = |random: &mut Random| middle + direction(random) * f64::from(scale);
        let (p, q) = (corner(&mut random), corner(&mut random));
        let [low, high] = [p.min(q), p.max(q)].map(|corner| corner.as_vec3().to_array());
        // From outside the box, far away.
        let pose = Pose::random(&mut random, middle + DVec3::splat(50.0 * f64::from(scale)), f64::from(scale));
        let camera = pose.camera(number % PROJECTIONS, random.below(2) == 0);
        let w = [1.0, 0.5, random.between(0.1, 5.0), 0.0][random.below(4)];
        // On a side, an edge or a corner, or an ulp off; of another w, what rounding makes of it.
        let mut at: [f32; 3] =
            std::array::from_fn(|axis| low[axis] + (high[axis] - low[axis]) * random.between(0.0, 1.0));
        let is_free = random.below(4) == 0;
        for (axis, at) in at.iter_mut().enumerate().take(1 + random.below(3)) {
            let side = [low, high][random.below(2)][axis];
            *at = if is_free {
                side + random.between(-1.0, 1.0) * scale
            } else {
                stepped(side, random.below(3) as i32 - 1)
            };
        }
        let weight = if w == 0.0 { 1.0 } else { w };
        let light = Light::homogeneous([at[0] * weight, at[1] * weight, at[2] * weight, w]);
        let product = |at: f32| f64::from(at) * f64::from(w);
        let xyz = light.xyz.map(f64::from);
        let is_within =
            w > 0.0 && (0..3).all(|axis| product(low[axis]) <= xyz[axis] && xyz[axis] <= product(high[axis]));
        cases.push((camera, light, vec![low, high]));
        expected.push((is_within, is_free));
    }
    let found = chosen(&gpu, options(COUNT_AUTO, true), &cases)?;
    for (((_, light), (is_within, is_free)), (_, given, corners)) in found.iter().zip(expected).zip(&cases) {
        if is_within {
            at_the_edge += usize::from(!is_free);
            assert_eq!(light.casting, CAST_EVERY, "{given:?}, {corners:?}");
        } else {
            apart += usize::from(light.casting == CAST_BACK_FACING);
        }
        if given.w == 0.0 {
            assert_eq!(light.casting, CAST_BACK_FACING, "a light at infinity is in no box");
        }
    }
    println!("{at_the_edge} within the box at its edge, {apart} apart");
    assert!(at_the_edge > 300 && apart > 500, "not vacuous");
    Ok(())
}

/// The published ZP+ clips nothing of the caster: the near end of the light's frustum is before it.
fn published_frustum() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(203)?;
    let (mut seen, mut near) = (0, 0);
    let mut cases = Vec::new();
    for number in 0..if is_long() { 60_000 } else { 3000 } {
        let pose = Pose::random(&mut random, DVec3::ZERO, 1.0);
        // Perspective, as the paper has it.
        let camera = pose.camera(number % 4, random.below(2) == 0);
        let eye = Eye::new(&camera);
        let light = (pose.eye + direction(&mut random) * f64::from(random.between(1.0, 9.0))).as_vec3();
        let given = light.as_dvec3();
        if eye.height(given).abs() < 0.05 {
            continue;
        }
        let through = eye.on_near_plane([0, 0].map(|_: i32| f64::from(random.between(-0.99, 0.99))));
        let part = 0.01 * 95_f64.powf(f64::from(random.between(0.0, 1.0)));
        let point = given + (through - given) * part;
        let size = 1e-3 * part;
        let corners = [0, 1, 2].map(|_: i32| (point + direction(&mut random) * size).as_vec3().to_array());
        cases.push((camera, Light::point(light.to_array()), corners.to_vec()));
    }
    let lights = chosen(&gpu, options(COUNT_ZP_PLUS_2005, false), &cases)?;
    let probe =
        Probe::of(&gpu, &CAP_FACES, [1, 1], "out[0] = frustum_to_clip(pair.view, pair.light, input_position(0u));")?;
    let corners = (0..).zip(&cases).flat_map(|(number, case)| case.2.iter().map(move |&corner| (number, [corner])));
    let corners: Vec<_> = corners.collect();
    for ((number, [corner]), clip) in corners.iter().zip(probe.run(&gpu, &[], &lights, &corners)?) {
        let (camera, light, _) = &cases[*number as usize];
        let given = DVec3::from(light.xyz.map(f64::from));
        let ([x, y], part) = Eye::new(camera).seen_from_light(given, DVec3::from(corner.map(f64::from)));
        let [_, _, z, w] = clip[0];
        if x.abs().max(y.abs()) < 0.999 && part > 0.005 && part < 0.99 {
            seen += 1;
            near += usize::from(part < 0.2);
            let rounding = 1e-4 * w;
            let begin = lights[*number as usize].1.frustum_near;
            assert!(
                w > 0.0 && z >= -rounding && z <= w + rounding,
                "{number}: {clip:?} at {part} of the way, the frustum begins at {begin}"
            );
        }
    }
    println!("{seen} corners between light and near rectangle, {near} of them near the light");
    assert!(near > 500, "not vacuous");
    Ok(())
}

/// Lights as a camera sees them, each of a caster that is moved along x.
fn seen<const N: usize>(
    random: &mut Random,
    lights: [(Light, f32); N],
) -> Result<Vec<(ShadowView, ShadowLight)>, String> {
    let camera = Pose::random(random, DVec3::ZERO, 1.0).camera(0, false);
    let view = shadow::view(&camera).map_err(text)?;
    let seen = |(light, x)| {
        let placement = [[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        (ShadowView { placement, ..view }, shadow::light(&camera, &view, light))
    };
    Ok(lights.map(seen).to_vec())
}

/// It begins as near to the light as any, where the caster may be anywhere.
fn overflowing_frustum() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(204)?;
    let probe = Probe::of(
        &gpu,
        &COUNTING_METHODS,
        [2, 1],
        "out[0].x = frustum_near_end(pair.view, pair.light, 1.0, input_position(0u), input_position(1u));",
    )?;
    let [near, far] = [Light::point([0.0; 3]), Light::point([1.5e38; 3])];
    let seen = seen(&mut random, [(near, 0.0), (far, 0.0), (Light::directional([0.0, 0.0, 1.0]), f32::MAX)])?;
    let inputs = [
        (0, [[100.0; 3], [101.0; 3]]),
        // Infinity over itself.
        (1, [[-3e38; 3], [-2e38; 3]]),
        // The height of infinity.
        (2, [[f32::MAX, -1.0, -5.0], [f32::MAX, 1.0, -4.0]]),
    ];
    let found = probe.run(&gpu, &[], &seen, &inputs)?;
    let found: Vec<_> = found.iter().map(|out| out[0][0]).collect();
    same("near ends", &found, &[0.99, 0.001, f32::MAX])
}

/// By either method whose volumes end. Casters that are clearly out of range are skipped, and none that is not.
fn volumes_end() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(211)?;
    let (mut ended, mut skipped, mut cases) = (0, 0, [Vec::new(), Vec::new()]);
    // The box of a caster and how far the light is from it.
    let measured = |light: Light, positions: &[[f32; 3]]| {
        let [x, y, z, w] = light.to_array().map(f64::from);
        let given = DVec3::new(x, y, z) / w;
        let [low, high] = box_of(positions.iter().copied()).map(|corner| DVec3::from(corner.map(f64::from)));
        let size = low.abs().max(high.abs()).max(given.abs()).max_element();
        ((low - given).max(given - high).max(DVec3::ZERO).length(), size)
    };
    for number in 0..if is_long() { 60_000 } else { 3000 } {
        let scale = [1.0, 1e-3, 1e4][number % 3];
        let corner = |random: &mut Random| (direction(random) * scale).as_vec3().to_array();
        let positions: [[f32; 3]; 3] = [0, 1, 2].map(|_: i32| corner(&mut random));
        let camera = Pose::random(&mut random, DVec3::ZERO, scale).camera(0, false);
        let [x, y, z] = (direction(&mut random) * scale * f64::from(random.between(1.0, 6.0))).as_vec3().to_array();
        let w = [1.0, random.between(0.1, 5.0)][random.below(2)];
        let light = Light::homogeneous([x * w, y * w, z * w, w]);
        let (distance, _) = measured(light, &positions);
        let range = (distance + scale * f64::from(random.between(-0.5, 20.0))).max(0.1 * scale) as f32;
        cases[random.below(2)].push((camera, light.with_range(range), positions.to_vec()));
    }
    for (cases, counting) in cases.iter().zip([COUNT_Z_PASS, COUNT_Z_FAIL]) {
        let lights = chosen(&gpu, ShadowShape { end_at_range: 1, ..options(counting, false) }, cases)?;
        for ((_, given, positions), (_, light)) in cases.iter().zip(&lights) {
            let (range, (distance, size)) = (f64::from(given.range), measured(*given, positions));
            let (exact, end) = (distance / range, f64::from(light.end));
            if light.casting == CAST_NOTHING {
                assert!(exact > 1.0 - 1e-12, "skipped, {distance} away with a range of {range}");
                skipped += 1;
                continue;
            }
            let reach = range * (1.0 + 1e-5) + 1e-6 * size;
            assert!(distance <= reach, "not skipped, {distance} away with a range of {range}");
            let slack = 2e-5 * (distance + size) / range;
            assert!(end <= exact.min(1.0), "the end is {end}, beyond the range is {exact}");
            assert!(end >= exact.min(1.0) - slack, "the end is {end}, the range is at {exact}");
            ended += usize::from(end > 0.0);
        }
    }
    println!("{ended} volumes end, {skipped} casters are out of range");
    assert!(ended > 1500 && skipped > 20, "not vacuous");
    Ok(())
}

/// A caster behind all receivers has none, but one whose numbers are infinite or NaN may have any.
fn overflow() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(212)?;
    let probe = Probe::of(
        &gpu,
        &COUNTING_METHODS,
        [2, 1],
        "let extent = volume_extent(pair.view, pair.light, 1.0, input_position(0u), input_position(1u), 0u);
    out[0] = vec4<f32>(select(0.0, 1.0, extent.has_no_receiver), extent.factor, 0.0, 0.0);",
    )?;
    // The receivers have a box about the camera.
    let mut receivers = [0; 16];
    receivers[5] = 1;
    receivers[6..9].fill((-1.0_f32).to_bits());
    receivers[9..12].fill(1.0_f32.to_bits());
    let sun = Light::directional([0.0, 0.0, 1.0]);
    let seen = seen(&mut random, [(sun, 0.0), (sun, f32::MAX), (Light::point([-1e33, 0.0, 0.0]), 0.0)])?;
    let behind = [[-1.0, -1.0, -5.0], [1.0, 1.0, -4.0]];
    let huge = [[f32::MAX, -1.0, -5.0], [f32::MAX, 1.0, -4.0]];
    let found = probe.run(&gpu, &[(8, &gpu.storage(&receivers))], &seen, &[(0, behind), (1, huge), (2, huge)])?;
    let found: Vec<_> = found.iter().map(|out| [out[0][0], out[0][1]]).collect();
    same("no receiver, and the end", &found, &[[1.0, 0.0], [0.0, -1.0], [0.0, 0.0]])
}

/// Boxes far from camera and light, around them, and so large that numbers of an axis overflow. Another axis may be certain.
fn uncertain() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(213)?;
    let probe = Probe::of(
        &gpu,
        &COUNTING_METHODS,
        [2, 1],
        "let meets = can_meet_near_rectangle(pair.view, input_position(0u), input_position(1u));
    let has_light = can_contain_light(pair.light, input_position(0u), input_position(1u));
    out[0] = vec4<f32>(select(0.0, 1.0, meets), select(0.0, 1.0, has_light), 0.0, 0.0);",
    )?;
    let mut seen = seen(&mut random, [0.0, f32::MAX].map(|x| (Light::point([0.0; 3]), x)))?;
    seen[1].1.light[3] = 4.0;
    let rows = [
        ((0, [[100.0; 3], [101.0; 3]]), [0.0, 0.0]),
        ((0, [[-100.0; 3], [100.0; 3]]), [1.0, 1.0]),
        ((1, [[f32::MAX, -100.0, -100.0], [f32::MAX, 100.0, 100.0]]), [1.0, 1.0]),
        ((1, [[f32::MAX, 100.0, -100.0], [f32::MAX, 101.0, 100.0]]), [0.0, 0.0]),
    ];
    let found = probe.run(&gpu, &[], &seen, &rows.map(|(input, _)| input))?;
    let found: Vec<_> = found.iter().map(|out| [out[0][0], out[0][1]]).collect();
    same("near rectangle, and light", &found, &rows.map(|(_, expected)| expected))
}
