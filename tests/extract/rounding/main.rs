//! The band and the filter's bounds of docs/numerics hold for any arithmetic that WGSL allows: every rounding up, down,
//! towards zero, at random or against the result, subnormals flushed or not, products fused or not, sums in any order.

mod boxes;
mod clusters;
mod ranges;
mod rounding_models;

use rimline::Light;
use rimline::internals::cpu::{RELATIVE, UNDERFLOW};
use rimline::internals::stages::{EXACT_FACING, FACING, Stage};
use rimline_testkit::band::{Bound, facing_bound, facing_bound_without_q, is_outside, scaled};
use rimline_testkit::oracle::ExactFace;
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, must_fail, pairs};
use rounding_models::RoundingModels;

type Outcome = Result<(), String>;

fn certificates_hold(seed: u64, rounds: usize, bound: Bound) -> Result<usize, String> {
    let mut random = Random::new(seed);
    let mut rounding_models = RoundingModels::new(seed + 1);
    let mut outside = 0;
    for round in 0..rounds {
        let (corners, light) = pairs::hard(&mut random);
        if !is_outside(corners, light, bound) {
            continue;
        }
        outside += 1;
        let exact = ExactFace::new(&corners, [0, 1, 2]).ok_or("no face")?.sign(light);
        for _ in 0..4 {
            rounding_models.change();
            let determinant = rounding_models.determinant(corners, light);
            if (determinant > 0.0) != (exact > 0) {
                return Err(format!("round {round}: {corners:?}, {light:?}: {determinant:e}, exactly {exact}"));
            }
        }
    }
    Ok(outside)
}

#[test]
fn the_band_holds_for_any_rounding() -> Outcome {
    let seed = 101;
    let rounds = if is_long() { 5_000_000 } else { 60_000 };
    let outside = certificates_hold(seed, rounds, facing_bound)?;
    println!("{outside} of {rounds} pairs outside the band");
    if outside * 20 < rounds || outside > rounds / 20 * 19 {
        return Err(format!("{outside} of {rounds} outside: neither side of the band is tried enough"));
    }
    must_fail("a bound without the term in Q", &certificates_hold(seed, rounds, facing_bound_without_q))
}

/// A bound of the filter at a number of units of the last place.
type FilterBound = fn(&mut RoundingModels, [[f32; 3]; 3], Light, f32) -> f32;

/// Results of trials of a bound.
#[derive(Clone, Copy, Debug, Default)]
struct Trials {
    decided: usize,
    /// Decided, and not the exact sign.
    wrong: usize,
    /// The largest error of a determinant beside its bound.
    largest_error: f64,
}

/// Tries the filter at a relative bound of `units` of the last place.
fn try_filter(seed: u64, rounds: usize, units: f32, bound_of: FilterBound) -> Trials {
    let mut random = Random::new(seed);
    let mut rounding_models = RoundingModels::new(seed + 1);
    let mut trials = Trials::default();
    for _ in 0..rounds {
        let (corners, light) = pairs::any(&mut random);
        let is_large = corners.iter().flatten().any(|c| c.abs() >= 2.0_f32.powi(40));
        let Some(face) = ExactFace::new(&corners, [0, 1, 2]) else {
            continue;
        };
        // The stages leave faces with such coordinates undecided, for any bound.
        if is_large {
            continue;
        }
        rounding_models.change();
        let determinant = rounding_models.determinant(corners, light);
        let bound = rounding_models.as_bound(|with| bound_of(with, corners, light, units * f32::EPSILON));
        // In f64 it is exact to 2⁻⁴⁹ P, and the bound is more than 2⁻²⁴ P.
        let exact = facing_bound(corners, light).0;
        trials.largest_error = trials.largest_error.max((f64::from(determinant) - exact).abs() / f64::from(bound));
        if determinant.abs() > bound {
            trials.decided += 1;
            trials.wrong += usize::from((determinant > 0.0) != (face.sign(light) > 0));
        }
    }
    trials
}

/// Nothing is decided wrongly, and no error exceeds the bound, whether it would have mattered or not.
fn filter_holds(name: &str, seed: u64, rounds: usize, units: f32, bound_of: FilterBound) -> Outcome {
    let Trials { decided, wrong, largest_error } = try_filter(seed, rounds, units, bound_of);
    println!(
        "{name} bound at {units} units: {decided} of {rounds} pairs decided, {wrong} of them wrongly; the largest error \
         is {largest_error:.3} of it"
    );
    if decided * 20 < rounds || decided > rounds / 20 * 19 {
        return Err(format!("{name} bound: {decided} of {rounds} decided: neither side is tried enough"));
    }
    if wrong != 0 || largest_error > 1.0 {
        return Err(format!("{name} bound at {units} units: {wrong} wrong, the largest error {largest_error} of it"));
    }
    Ok(())
}

/// A light's bound that forgets what may be lost with a tiny w.
fn light_bound_without_tiny_w(with: &mut RoundingModels, corners: [[f32; 3]; 3], light: Light, relative: f32) -> f32 {
    let [x, y, z, w] = light.to_array();
    let is_tiny = scaled(light)[3].abs() < 2.0_f64.powi(-60);
    with.light_bound(corners, Light::homogeneous([x, y, z, if is_tiny { 0.0 } else { w }]), relative)
}

/// A constant of a stage's WGSL.
fn wgsl_constant(stage: &Stage, name: &str) -> Option<f32> {
    let module = naga::front::wgsl::parse_str(&stage.wgsl()).ok()?;
    let (_, constant) = module.constants.iter().find(|(_, constant)| constant.name.as_deref() == Some(name))?;
    match module.global_expressions[constant.init] {
        naga::Expression::Literal(naga::Literal::F32(value)) => Some(value),
        _ => None,
    }
}

/// The constants are what the derivation in docs/numerics/facing.md, "Filter", asks for, in shader and on the CPU, and
/// no more than a fifth above it. Trials cannot tell so small a change: rounding seldom does its worst.
#[test]
fn the_filters_constants_are_those_of_the_derivation() {
    for stage in [FACING, EXACT_FACING] {
        assert_eq!(wgsl_constant(&stage, "RELATIVE"), Some(RELATIVE), "{}", stage.name);
        assert_eq!(wgsl_constant(&stage, "UNDERFLOW"), Some(UNDERFLOW), "{}", stage.name);
    }
    let (u, relative) = (2.0_f64.powi(-23), f64::from(RELATIVE));
    let gamma = |roundings: f64| roundings * u / (1.0 - roundings * u);
    // A face's bound: P and Q are at most |u||v|R; it has twelve roundings of its own.
    let face = (gamma(8.0) + u * (1.0 + gamma(8.0))) / (1.0 - u).powi(12);
    // A light's: P with eleven roundings, Q with twelve.
    let p = gamma(8.0) / (1.0 - u).powi(11);
    let q = u * (1.0 + gamma(8.0)) / ((1.0 - u).powi(10) * (1.0 - 2.0 * u));
    let needed = face.max(p).max(q);
    assert!((needed..1.2 * needed).contains(&relative), "{relative:e}, {needed:e} are needed");
    // The error of the determinant and the loss of the bounds by flushing, twelvefold, in units of the smallest normal
    // number. The constant is the next power of two.
    let least = 12.0 * (81.0 + 24.0) * 2.0_f64.powi(-126);
    assert!((least..2.0 * least).contains(&f64::from(UNDERFLOW)), "{UNDERFLOW:e}, {least:e} are needed");
}

/// The crate's own constants and lights decide nothing wrongly; one unit does, and ten without a tiny w's share.
#[test]
fn the_filter_decides_rightly_for_any_rounding() -> Outcome {
    let seed = 103;
    let rounds = if is_long() { 10_000_000 } else { 200_000 };
    let bounds: [(&str, FilterBound); 2] =
        [("a light's", RoundingModels::light_bound), ("a face's", RoundingModels::face_bound)];
    for (name, bound_of) in bounds {
        filter_holds(name, seed, rounds, RELATIVE / f32::EPSILON, bound_of)?;
        let Trials { decided, wrong, .. } = try_filter(seed, 200_000, 1.0, bound_of);
        println!("negative control: {name} bound at 1 unit decides {wrong} of {decided} wrongly");
        if wrong == 0 {
            return Err(format!("negative control: {name} bound at a tenth decides as well"));
        }
        must_fail("a tenth of the bound", &filter_holds(name, seed, 200_000, 1.0, bound_of))?;
    }
    let without =
        filter_holds("a light's, no tiny w's,", seed, 200_000, RELATIVE / f32::EPSILON, light_bound_without_tiny_w);
    must_fail("a bound without the error of a tiny w", &without)
}
