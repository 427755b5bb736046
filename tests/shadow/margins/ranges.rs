//! Boxes at the very end of a light's range: none that it reaches is out of it, however far light and box are from the
//! origin. And lights and boxes with numbers at the ends of what `f32` holds.
//!
//! The stages are `counting_methods` and `needs`.

use std::sync::Arc;

use glam::DVec3;
use rimline::Light;
use rimline::internals::layout::ShadowLight;
use rimline::internals::shadow;
use rimline::internals::stages::COUNTING_METHODS;
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::range_cases::RangeCase;
use rimline_testkit::scenes::Pose;
use rimline_testkit::stage_probe::Probe;
use rimline_testkit::{is_long, same};

pub(super) const TESTS: &[Test] = &[
    ("boxes_that_a_light_reaches_are_not_out_of_its_range", reached),
    ("ranges_of_extreme_lights_and_boxes_are_defined", extreme),
];

/// A light has the scale of its caster in `frustum_near`.
fn probe(gpu: &Gpu) -> Result<Arc<Probe>, String> {
    Probe::of(
        gpu,
        &COUNTING_METHODS,
        [2, 1],
        "let is_out = is_out_of_range(pair.light, pair.light.frustum_near, input_position(0u), input_position(1u));
    out[0].x = select(0.0, 1.0, is_out);",
    )
}

/// By the smallest range that reaches the box. With one that clearly does not, the box is out.
fn reached() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(214)?;
    let camera = Pose::random(&mut random, DVec3::ZERO, 1.0).camera(0, false);
    let view = shadow::view(&camera).map_err(text)?;
    let (mut seen, mut inputs, mut expected) = (Vec::new(), Vec::new(), Vec::new());
    let mut far = 0;
    for _ in 0..if is_long() { 40_000 } else { 4000 } {
        let case = RangeCase::random(&mut random, (&camera, &view), |x, y| x * y).ok_or("no inverse")?;
        far += usize::from(case.distance > 0.0 && case.size > 1e3 * case.distance);
        for (range, is_out) in [(Some(case.reaching()), false), (case.short(), true)] {
            let Some(range) = range else { continue };
            inputs.push((seen.len() as u32, [case.low, case.high]));
            seen.push((view, ShadowLight { range, frustum_near: case.scale, ..case.light }));
            expected.push(is_out);
        }
    }
    let found = probe(&gpu)?.run(&gpu, &[], &seen, &inputs)?;
    for (number, (found, &is_out)) in found.iter().zip(&expected).enumerate() {
        let ((_, light), (_, corners)) = (&seen[number], inputs[number]);
        let ShadowLight { light, range, frustum_near, .. } = light;
        let what = format!("{number}: {light:?}, range {range}, scale {frustum_near}, box {corners:?}");
        assert_eq!(found[0][0] == 1.0, is_out, "{what}");
    }
    let out = expected.iter().filter(|&&is_out| is_out).count();
    println!("{far} boxes reached that are far from the origin, {out} out of range");
    assert!(far.min(out) > 800, "not vacuous");
    Ok(())
}

/// Lights at infinity and lights without a range reach everything. So do lights in the box, and all where numbers overflow.
fn extreme() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(215)?;
    let camera = Pose::random(&mut random, DVec3::ZERO, 1.0).camera(0, false);
    let view = shadow::view(&camera).map_err(text)?;
    let (beside, around) = ([[5.0; 3], [6.0; 3]], [[-1.0; 3], [1.0; 3]]);
    let huge = [[f32::MAX, -1.0, -1.0], [f32::MAX, 1.0, 1.0]];
    let lamp = Light::point([0.0; 3]).with_range(1.0);
    let rows = [
        (lamp, 1.0, beside, 1.0),
        (lamp, 0.1, beside, 0.0),
        (lamp, 0.0, beside, 0.0),
        (lamp, f32::MAX, beside, 0.0),
        (lamp, 4.0, huge, 0.0),
        (lamp.with_range(f32::INFINITY), 1.0, beside, 0.0),
        (lamp.with_range(1e30), 1.0, beside, 0.0),
        (lamp.with_range(1e-30), 1.0, around, 0.0),
        (lamp.with_range(1e-30), 1.0, beside, 1.0),
        (Light::directional([1.0, 2.0, 3.0]).with_range(1.0), 1.0, beside, 0.0),
        (Light::homogeneous([3e30, 0.0, 0.0, 3.0]).with_range(1.0), 1.0, around, 1.0),
        (Light::homogeneous([3e-30, 0.0, 0.0, 3e-30]).with_range(3.0), 1.0, beside, 1.0),
        (Light::homogeneous([3e-30, 0.0, 0.0, 3e-30]).with_range(9.0), 1.0, beside, 0.0),
    ];
    let seen = rows.map(|(light, scale, ..)| {
        let light = ShadowLight { frustum_near: scale, ..shadow::light(&camera, &view, light) };
        (view, light)
    });
    let inputs: Vec<_> = (0..).zip(rows).map(|(number, (_, _, corners, _))| (number, corners)).collect();
    let found = probe(&gpu)?.run(&gpu, &[], &seen, &inputs)?;
    let found: Vec<_> = found.iter().map(|out| out[0][0]).collect();
    same("out of range", &found, &rows.map(|(.., is_out)| is_out))
}
