//! The decision of the stage `clusters`, called alone: no face of a decided cluster has another exact sign, and what `f64`
//! decides by more than rounding is decided. docs/numerics/clusters.md, "Bound on planes".

use rimline::Light;
use rimline::internals::clusters::ClusterBound;
use rimline::internals::layout::LightBatch;
use rimline::internals::stages::CLUSTERS;
use rimline_testkit::clusters::height_and_spread;
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::oracle::ExactFace;
use rimline_testkit::probe::{Bound, Probe};
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, must_fail};

use rimline_testkit::cluster_cases::{Bounded, bounded};

pub(crate) const TESTS: &[Test] = &[("decisions_hang_on_no_rounding", rounding)];

/// A bound, a light, and the exact signs of the cluster's faces: whether all are 1, whether all are -1.
struct Pair {
    bound: ClusterBound,
    light: Light,
    are_all: [bool; 2],
}

impl Pair {
    fn new(bound: ClusterBound, light: Light, signs: impl Iterator<Item = i32>) -> Self {
        let signs: Vec<i32> = signs.collect();
        Self { bound, light, are_all: [1, -1].map(|side| signs.iter().all(|&sign| sign == side)) }
    }
}

/// Whether the shader decides that the faces face the light, and that they do not, for each pair.
fn decisions(gpu: &Gpu, pairs: &[Pair]) -> Result<Vec<[bool; 2]>, String> {
    // A light of its own for each bound.
    let source = format!(
        "{}
fn probe_decide(index: u32) -> vec4<u32> {{
  active_mask = 1u;
  lights = CasterLights(1u, 2u * index, vec2<f32>());
  let found = decide_cluster(BOUND_WORDS * index);
  return vec4<u32>(found.decided, found.facing, 0u, 0u);
}}",
        CLUSTERS.wgsl()
    );
    let bounds: Vec<ClusterBound> = pairs.iter().map(|pair| pair.bound).collect();
    let of_light = |pair: &Pair| {
        let batch = LightBatch::new(&[pair.light], 0, 3);
        [batch.light_bits[0], batch.lights[0].map(f32::to_bits)]
    };
    let (table, words) = (gpu.storage(&pairs.iter().flat_map(of_light).collect::<Vec<_>>()), gpu.storage(&bounds));
    let bound = [(1, Bound::Storage(&table)), (9, Bound::Storage(&words))];
    let probe = Probe::new(gpu, &source, ("vec4<u32>", "probe_decide(index)"), &bound);
    let found = probe.run(gpu, &bound, &vec![[0.0; 4]; pairs.len()])?;
    Ok(found.iter().map(|&[decided, facing, ..]| [facing != 0, decided != 0 && facing == 0]).collect())
}

/// Decided pairs, and pairs that `f64` leaves open.
#[derive(Debug, Default)]
struct Counts {
    decided: usize,
    marginal: usize,
}

/// Decided pairs have the exact signs. Rounding takes less than half of the spread, so `f64` decides pairs farther away.
fn check(pairs: &[Pair], found: &[[bool; 2]]) -> Result<Counts, String> {
    let mut counts = Counts::default();
    for (number, (pair, found)) in pairs.iter().zip(found).enumerate() {
        let &Pair { bound, light, are_all } = pair;
        let what = || format!("pair {number}, {bound:?}, {light:?}: {found:?}, all {are_all:?}");
        if (0..2).any(|side| found[side] && !are_all[side]) {
            return Err(format!("another sign: {}", what()));
        }
        let [height, spread] = height_and_spread(&bound, light);
        let is_decided = found[0] || found[1];
        counts.decided += usize::from(is_decided);
        if bound.kind == 1 && height.abs() > 1.5 * spread && !is_decided {
            return Err(format!("left open at {height:e} and {spread:e}: {}", what()));
        }
        if bound.kind == 1 && height.abs() < 0.5 * spread && is_decided {
            return Err(format!("decided at {height:e} and {spread:e}: {}", what()));
        }
        counts.marginal += usize::from((0.5..1.5).contains(&(height.abs() / spread)));
    }
    Ok(counts)
}

/// Decides pairs on the GPU, and checks the decisions.
fn decided(gpu: &Gpu, pairs: &[Pair]) -> Result<Counts, String> {
    let found = decisions(gpu, pairs)?;
    let counts = check(pairs, &found)?;
    println!("{counts:?} of {}", pairs.len());
    check_controls(pairs, &found).map(|()| counts)
}

/// Negative controls: a decided pair with the opposite decision, and without one.
fn check_controls(pairs: &[Pair], found: &[[bool; 2]]) -> Result<(), String> {
    let index = (0..pairs.len()).find(|&index| {
        let [height, spread] = height_and_spread(&pairs[index].bound, pairs[index].light);
        pairs[index].bound.kind == 1 && found[index] != [false; 2] && height.abs() > 2.0 * spread
    });
    let index = index.ok_or("nothing is decided")?;
    for other in [[found[index][1], found[index][0]], [false; 2]] {
        let mut wrong = found.to_vec();
        wrong[index] = other;
        must_fail("another decision", &check(pairs, &wrong))?;
    }
    Ok(())
}

/// Faces far away, thin, tiny and nearly in the light's plane, where each term of the spread counts.
fn rounding() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(107);
    println!("seed 107");
    let (mut pairs, count) = (Vec::new(), if is_long() { 1_000_000 } else { 60_000 });
    for _ in 0..count {
        let Some(Bounded { faces, light, bound }) = bounded(&mut random)? else { continue };
        let signs = faces.iter().map(|face| ExactFace::new(face, [0, 1, 2]).map_or(0, |face| face.sign(light)));
        pairs.push(Pair::new(bound, light, signs));
    }
    let counts = decided(gpu, &pairs)?;
    if pairs.len() * 2 < count || counts.decided * 10 < pairs.len() || counts.decided * 10 > pairs.len() * 9 {
        return Err("neither side is tried enough".to_owned());
    }
    if counts.marginal < 500 { Err("too few are marginal".to_owned()) } else { Ok(()) }
}
