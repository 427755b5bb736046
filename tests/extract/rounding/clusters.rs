//! The decision of clusters in any arithmetic that WGSL allows: no face of a decided cluster has another sign.
//! docs/numerics/clusters.md.

use rimline::Light;
use rimline::internals::clusters::{ClusterBound, WIDENING};
use rimline::internals::layout::LightBatch;
use rimline::internals::stages::CLUSTERS;
use rimline_testkit::band::{facing_bound, gamma};
use rimline_testkit::clusters::{LEAST, PRODUCT, height_and_spread};
use rimline_testkit::oracle::ExactFace;
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, must_fail};

use super::rounding_models::RoundingModels;
use super::wgsl_constant;
use rimline_testkit::cluster_cases::{Bounded, bounded};

type Outcome = Result<(), String>;

/// Terms of the bound for rounding and underflow.
#[derive(Clone, Copy)]
struct Terms {
    /// A part of the widening.
    widening: f32,
    product: f32,
    least: f32,
    /// Whether a tiny w counts as inexact.
    tiny_w: bool,
}

const USED: Terms = Terms { widening: 1.0, product: PRODUCT, least: LEAST, tiny_w: true };

/// The height and the spread of `wgsl/scene/clusters.wgsl`, in some arithmetic.
fn modelled(with: &mut RoundingModels, bound: &ClusterBound, light: Light, terms: Terms) -> [f32; 2] {
    let batch = LightBatch::new(&[light], 0, 3);
    let ([x, y, z, w], mut inexact_w) = (batch.lights[0], batch.inexact_w[0][0]);
    if !terms.tiny_w && w.abs() < 2.0_f32.powi(-60) {
        inexact_w = 0.0;
    }
    let ClusterBound { centre: c, middle, mut half, .. } = *bound;
    let l = [x, y, z];
    let t: [f32; 3] = std::array::from_fn(|i| with.product_sum(-w, c[i], l[i], f64::from(middle[i])));
    let mut height = with.product_sum(middle[3], w, 0.0, 1.0);
    for axis in with.axes() {
        height = with.product_sum(middle[axis], t[axis], height, 1.0);
    }
    // A cluster of one face has nothing else in its half.
    half = half.map(|half| half * terms.widening);
    let spread = with.as_bound(|with| {
        let mut spread = with.product(half[3], w.abs().max(inexact_w));
        for axis in with.axes() {
            spread = with.product_sum(half[axis], t[axis].abs(), spread, 1.0);
        }
        let factor = with.product(terms.product, inexact_w);
        let size = with.add(c[0].abs(), c[1].abs());
        let size = with.add(size, c[2].abs());
        let spread = with.product_sum(factor, size, spread, 1.0);
        with.add(spread, terms.least)
    });
    [height, spread]
}

/// Results of trials of the decision.
#[derive(Clone, Copy, Debug, Default)]
struct Trials {
    bounded: usize,
    decided: usize,
    /// Decided, and not the exact sign of some face.
    wrong: usize,
    /// Clusters of one face whose height or spread differs from that in `f64` by more than rounding and underflow.
    apart: usize,
    /// The largest distance of a face's height from that of its cluster beside the spread, where a cluster has one face.
    largest_error: f64,
}

fn trials(seed: u64, rounds: usize, terms: Terms) -> Result<Trials, String> {
    let mut random = Random::new(seed);
    let mut with = RoundingModels::new(seed + 1);
    let mut trials = Trials::default();
    for _ in 0..rounds {
        let Some(Bounded { faces, light, bound }) = bounded(&mut random)? else { continue };
        trials.bounded += 1;
        with.change();
        let [height, spread] = modelled(&mut with, &bound, light, terms);
        // With one face the halves are so small that rounding t does not show in the spread.
        let exact = height_and_spread(&bound, light);
        trials.apart += usize::from(faces.len() == 1 && is_apart([height, spread].map(f64::from), exact));
        let is_decided = height.abs() > spread;
        trials.decided += usize::from(is_decided);
        let mut is_wrong = false;
        let is_single = faces.len() == 1;
        for corners in faces {
            let exact = ExactFace::new(&corners, [0, 1, 2]).ok_or("no face")?;
            is_wrong |= is_decided && exact.sign(light) != if height > 0.0 { 1 } else { -1 };
            // Exact to 2⁻²⁹ of the light's distance, since the normal is at least 2⁻²⁰ of its terms.
            let height_of_face = facing_bound(corners, light).0 / largest_normal(corners);
            let error = (f64::from(height) - height_of_face).abs() / f64::from(spread);
            if is_single {
                trials.largest_error = trials.largest_error.max(error);
            }
        }
        trials.wrong += usize::from(is_wrong);
    }
    Ok(trials)
}

/// Whether a height and a spread differ by more than rounding and underflow.
fn is_apart([height, spread]: [f64; 2], [other_height, other_spread]: [f64; 2]) -> bool {
    let least = 64.0 * f64::from(f32::MIN_POSITIVE);
    (height - other_height).abs() > spread.max(other_spread)
        || (spread - other_spread).abs() > 1e-5 * spread.max(other_spread) + least
}

fn largest_normal([a, b, c]: [[f32; 3]; 3]) -> f64 {
    let side = |to: [f32; 3]| [0, 1, 2].map(|i| f64::from(to[i]) - f64::from(a[i]));
    let (u, v) = (side(b), side(c));
    let component = |i: usize, j: usize| (u[i] * v[j] - u[j] * v[i]).abs();
    component(1, 2).max(component(2, 0)).max(component(0, 1))
}

fn holds(seed: u64, rounds: usize, terms: Terms) -> Outcome {
    let trials = trials(seed, rounds, terms)?;
    println!("seed {seed}: {trials:?} of {rounds}");
    let Trials { bounded, decided, wrong, apart, largest_error } = trials;
    if decided * 10 < bounded || decided * 10 > bounded * 9 || bounded * 2 < rounds {
        return Err(format!("{trials:?}: neither side is tried enough"));
    }
    if apart != 0 {
        return Err(format!("{apart} heights or spreads are not those in f64"));
    }
    if wrong != 0 || largest_error > 1.0 {
        return Err(format!("{wrong} wrong, the largest error is {largest_error} of the spread"));
    }
    Ok(())
}

#[test]
fn clusters_are_decided_rightly_for_any_rounding() -> Outcome {
    let (seed, rounds) = (107, if is_long() { 5_000_000 } else { 100_000 });
    holds(seed, rounds, USED)?;
    let is_wrong = |what: &str, terms| {
        let found = trials(seed, rounds, terms)?;
        println!("without {what}: {found:?}");
        if found.wrong == 0 || (found.apart == 0) { Err(format!("nothing is wrong without {what}")) } else { Ok(()) }
    };
    is_wrong("most of the widening", Terms { widening: 0.1, ..USED })?;
    is_wrong("the rounding of w·centre", Terms { product: 0.0, ..USED })?;
    is_wrong("underflow", Terms { least: 0.0, ..USED })?;
    is_wrong("what a tiny w loses", Terms { tiny_w: false, ..USED })?;
    must_fail("a tenth of the widening", &holds(seed, rounds, Terms { widening: 0.1, ..USED }))
}

/// The constants are what the derivation asks for, and no more than a quarter above it. The shader has them.
#[test]
fn the_constants_of_clusters_are_those_of_the_derivation() {
    let constants = ["PRODUCT_ERROR", "UNDERFLOW_ERROR"].map(|name| wgsl_constant(&CLUSTERS, name));
    assert_eq!(constants, [Some(PRODUCT), Some(LEAST)]);
    let u = 2.0_f64.powi(-23);
    // A plane in f32 and f64, as a part of the largest component: rounding to f32, and what f64 loses.
    let plane = u / 4.0 + 2.0_f64.powi(-29);
    // The middle has four roundings and that of the difference; the half has six of its own, and may be 1.
    let widening = (gamma(4) + 1.02 * u + 1.02 * u + plane + 6.0 * 1.01 * u) * (1.0 + 10.0 * u);
    assert!((widening..1.25 * widening).contains(&WIDENING), "{WIDENING:e}, {widening:e} are needed");
    let product = 2.06 * u / (1.0 - u).powi(9);
    assert!((product..1.25 * product).contains(&f64::from(PRODUCT)), "{PRODUCT:e}, {product:e} are needed");
    let least = 90.0 * 2.0_f64.powi(-126);
    assert!((least..4.0 * least).contains(&f64::from(LEAST)), "{LEAST:e}, {least:e} are needed");
}
