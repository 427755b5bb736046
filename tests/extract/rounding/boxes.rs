//! The box test of queries of occluder counts, `misses_box` in `wgsl/query/shadow_segments.wgsl`, in any arithmetic
//! that WGSL allows: a box that the segment passes through is never left out. docs/numerics/query.md.

use rimline::Light;
use rimline::internals::layout::LightBatch;
use rimline::internals::stages::SHADOW_DEPTH;
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, must_fail};

use super::rounding_models::{RoundingModels, neighbours};
use super::wgsl_constant;

/// The shader's constants.
#[derive(Clone, Copy)]
struct Constants {
    margin: f32,
    tiny: f32,
    /// TINY, where it is the margin at the point.
    tiny_at_point: f32,
    underflow: f32,
}

struct Case {
    point: [f32; 3],
    light: Light,
    low: [f32; 3],
    high: [f32; 3],
}

/// A segment and a box around one of its points: as small as can be along some axes, of any size along the others.
fn case(random: &mut Random) -> Case {
    loop {
        let scale = [random.between(-145.0, -100.0), random.between(-30.0, 38.0)];
        let mut any = || -> [f32; 3] {
            std::array::from_fn(|_| {
                let size = random.between(-3.0, 1.0) + scale[random.below(2)];
                [random.between(-1.0, 1.0) * size.exp2(), 0.0][usize::from(random.below(4) == 0)]
            })
        };
        let (point, to) = (any(), any());
        let w = [1.0, 1.0, 0.5, random.between(0.5, 2.0)][random.below(4)];
        let light = Light::homogeneous([to[0] * w, to[1] * w, to[2] * w, w]);
        let [x, y, z, w] = light.to_array().map(f64::from);
        let t = match random.below(3) {
            0 => f64::from(random.between(-140.0, 0.0)).exp2(),
            _ => f64::from(random.between(0.01, 0.99)),
        };
        let (mut low, mut high) = ([0.0; 3], [0.0; 3]);
        for axis in 0..3 {
            let (p, end) = (f64::from(point[axis]), [x, y, z][axis] / w);
            let at = p + t * (end - p);
            // More than f64 rounds. Near its end the segment would else miss the box.
            let error = 2.0_f64.powi(-50) * (p.abs() + t * end.abs());
            let (below, above) = (neighbours(at - error)[0], neighbours(at + error)[1]);
            let room = match random.below(3) {
                0 => 0.0,
                1 => random.between(-149.0, -120.0).exp2(),
                _ => random.between(-20.0, 4.0).exp2() * at.abs() as f32,
            };
            (low[axis], high[axis]) =
                (below - random.between(0.0, 1.0) * room, above + random.between(0.0, 1.0) * room);
        }
        // The stages cull no box with a coordinate from 2⁴⁰ on, so such cases would test nothing.
        let all = [point, low, high];
        if all.as_flattened().iter().all(|c| c.abs() < 2.0_f32.powi(40)) {
            return Case { point, light, low, high };
        }
    }
}

fn misses(with: &mut RoundingModels, case: &Case, constants: Constants) -> bool {
    let Constants { margin, tiny, tiny_at_point, underflow } = constants;
    let batch = LightBatch::new(&[case.light], 0, 3);
    let ([x, y, z, w], inexact_w) = (batch.lights[0], batch.inexact_w[0][0]);
    let (l, p) = ([x, y, z], case.point);
    let w_size = w.abs().max(inexact_w);
    let d: [f32; 3] = std::array::from_fn(|i| with.product_sum(-w, p[i], l[i], 1.0));
    let sizes: [f32; 3] = std::array::from_fn(|i| with.product_sum(inexact_w, p[i].abs(), d[i].abs(), 1.0));
    let (mut middle, mut extent) = ([0.0; 3], [0.0; 3]);
    for i in 0..3 {
        let (to_low, to_high) = (with.sum(case.low[i], -p[i], 1.0), with.sum(case.high[i], -p[i], 1.0));
        let mut beyond = |corner: f32| {
            let difference = with.product_sum(w, corner, -l[i], 1.0);
            let size = with.product_sum(w_size, corner.abs(), l[i].abs(), 1.0);
            (difference, with.product_sum(margin, size, tiny, 1.0))
        };
        let (high, high_margin) = beyond(case.high[i]);
        let (low, low_margin) = beyond(case.low[i]);
        if (to_high < -tiny_at_point && high < -high_margin) || (to_low > tiny_at_point && low > low_margin) {
            return true;
        }
        let (sum, difference) = (with.sum(to_low, to_high, 1.0), with.sum(to_high, -to_low, 1.0));
        middle[i] = with.product_sum(0.5, sum, 0.0, 1.0);
        let half = with.product_sum(0.5, difference, 0.0, 1.0);
        let size = with.sum(half, middle[i].abs(), 1.0);
        let widened = with.product_sum(margin, size, half, 1.0);
        extent[i] = with.sum(widened, tiny, 1.0);
    }
    (0..3).any(|axis| {
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        let second = with.product_sum(-middle[j], d[i], 0.0, 1.0);
        let distance = with.product_sum(middle[i], d[j], second, 1.0).abs();
        let (size_i, size_j) = (with.sum(sizes[i], tiny, 1.0), with.sum(sizes[j], tiny, 1.0));
        let bound = with.product_sum(extent[j], size_i, underflow, 1.0);
        distance > with.product_sum(extent[i], size_j, bound, 1.0)
    })
}

fn nothing_is_left_out(constants: Constants) -> Result<(), String> {
    let seed = 105;
    let mut random = Random::new(seed);
    let mut rounding_models = RoundingModels::new(seed + 1);
    for round in 0..if is_long() { 10_000_000 } else { 200_000 } {
        let case = case(&mut random);
        rounding_models.change();
        if misses(&mut rounding_models, &case, constants) {
            let Case { point, light, low, high } = case;
            return Err(format!("round {round}: {point:?} to {light:?} is in the box {low:?} to {high:?}"));
        }
    }
    println!("seed {seed}: nothing left out");
    Ok(())
}

#[test]
fn no_box_is_left_out_for_any_rounding() -> Result<(), String> {
    let constant = |name| wgsl_constant(&SHADOW_DEPTH, name).ok_or_else(|| format!("no constant {name}"));
    let [margin, tiny, underflow] = [constant("MARGIN")?, constant("TINY")?, constant("UNDERFLOW")?];
    let constants = Constants { margin, tiny, tiny_at_point: tiny, underflow };
    nothing_is_left_out(constants)?;
    must_fail("no margin", &nothing_is_left_out(Constants { margin: 0.0, ..constants }))?;
    must_fail("no bound on underflow", &nothing_is_left_out(Constants { tiny: 0.0, ..constants }))?;
    must_fail("no bound at the point", &nothing_is_left_out(Constants { tiny_at_point: 0.0, ..constants }))
}
