//! The range of lights, `is_out_of_range` in `wgsl/shadow/culling.wgsl`, in any arithmetic that WGSL allows: a box that the
//! range reaches is never out of it. docs/numerics/shadow-volumes.md.

use glam::DVec3;
use rimline::internals::shadow;
use rimline::internals::stages::COUNTING_METHODS;
use rimline_testkit::random::Random;
use rimline_testkit::range_cases::RangeCase;
use rimline_testkit::scenes::Pose;
use rimline_testkit::{is_long, must_fail};

use super::rounding_models::RoundingModels;
use super::wgsl_constant;

/// The shader's constants.
#[derive(Clone, Copy)]
struct Constants {
    light_error: f32,
    slack: f32,
}

fn is_out(with: &mut RoundingModels, case: &RangeCase, range: f32, constants: Constants) -> bool {
    let [x, y, z, w] = case.light.light;
    let position = [x, y, z];
    let range = with.product_sum(w, range, 0.0, -1.0);
    let largest = position.iter().fold(0.0_f32, |largest, c| largest.max(c.abs()));
    let error = with.product_sum(constants.light_error, largest, 0.0, -1.0);
    let reach = with.product_sum(case.scale, error, range, -1.0);
    let d: [f32; 3] = std::array::from_fn(|i| {
        let below = with.product_sum(w, case.low[i], -position[i], 1.0);
        let above = with.product_sum(-w, case.high[i], position[i], 1.0);
        with.product_sum(case.scale, below.max(above).max(0.0), 0.0, 1.0)
    });
    let size = d.into_iter().fold(reach, f32::max);
    let r = with.quotient(reach, size, -1.0);
    let e = d.map(|d| with.quotient(d, size, 1.0));
    let mut squares = 0.0;
    for axis in with.axes() {
        squares = with.product_sum(e[axis], e[axis], squares, 1.0);
    }
    let square = with.product_sum(r, r, 0.0, -1.0);
    let factor = with.sum(1.0, constants.slack, -1.0);
    range > 0.0 && squares > with.product_sum(square, factor, 0.0, -1.0)
}

fn ranges_hold(constants: Constants) -> Result<(), String> {
    let seed = 109;
    let mut random = Random::new(seed);
    let mut rounding_models = RoundingModels::new(seed + 1);
    let camera = Pose::random(&mut random, DVec3::ZERO, 1.0).camera(0, false);
    let view = shadow::view(&camera).map_err(|error| error.to_string())?;
    let (mut far, mut out) = (0, 0);
    let rounds = if is_long() { 5_000_000 } else { 100_000 };
    for round in 0..rounds {
        rounding_models.change();
        let effect = [1.0, -1.0][random.below(2)];
        let product = |x, y| rounding_models.product_sum(x, y, 0.0, effect);
        let case = RangeCase::random(&mut random, (&camera, &view), product).ok_or("no inverse")?;
        far += usize::from(case.distance > 0.0 && case.size > 1e3 * case.distance);
        let RangeCase { light, scale, low, high, .. } = &case;
        let what = || format!("round {round}: {:?}, scale {scale}, box {low:?} to {high:?}", light.light);
        if is_out(&mut rounding_models, &case, case.reaching(), constants) {
            return Err(format!("{}: in the range {} and out", what(), case.reaching()));
        }
        if let Some(short) = case.short() {
            out += 1;
            if !is_out(&mut rounding_models, &case, short, constants) {
                return Err(format!("{}: out of the range {short} and not found to be", what()));
            }
        }
    }
    println!("seed {seed}: {rounds} boxes reached, {far} far from the origin; {out} out of range");
    if 5 * far.min(out) < rounds { Err("neither kind is tried enough".to_owned()) } else { Ok(()) }
}

/// No box that a light reaches is out, and each that it clearly does not reach is.
#[test]
fn no_reached_box_is_out_of_range_for_any_rounding() -> Result<(), String> {
    let constant = |name| wgsl_constant(&COUNTING_METHODS, name).ok_or_else(|| format!("no constant {name}"));
    let constants = Constants { light_error: constant("LIGHT_ERROR")?, slack: constant("SLACK")? };
    ranges_hold(constants)?;
    must_fail("no error of the light", &ranges_hold(Constants { light_error: 0.0, ..constants }))?;
    must_fail("no slack", &ranges_hold(Constants { slack: 0.0, ..constants }))
}

/// The error of a light is what the derivation asks for, and no more than a quarter above it.
#[test]
fn the_error_of_a_light_is_that_of_the_derivation() {
    let u = 2.0_f64.powi(-23);
    // Roundings to nearest of the light in mesh space and of its factor; their product; ten of f64, times the largest
    // condition number. All are parts of the light's distance, which is at most √3 times its largest coordinate.
    let needed = 3.0_f64.sqrt() * (0.5 * u + 0.5 * u + u + 10.0 * 1e8 * 2.0_f64.powi(-53)) * (1.0 + 10.0 * u);
    let found = wgsl_constant(&COUNTING_METHODS, "LIGHT_ERROR").map(f64::from);
    assert!(found.is_some_and(|found| (needed..1.25 * needed).contains(&found)), "{found:?}, {needed:e} are needed");
}
