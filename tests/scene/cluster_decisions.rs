//! The decision of the stage `clusters`, called alone: no face of a decided cluster has another exact sign, and what `f64`
//! decides by more than rounding is decided. docs/numerics/clusters.md, "Bound on planes".

use rimline::internals::clusters::ClusterBound;
use rimline::internals::layout::LightBatch;
use rimline::internals::stages::CLUSTERS;
use rimline_testkit::cluster_cases::{Bounded, bounded};
use rimline_testkit::clusters::height_and_spread;
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::oracle::ExactFace;
use rimline_testkit::probe::{Bound, Probe};
use rimline_testkit::{is_long, must_fail};

pub(crate) const TESTS: &[Test] = &[("decisions_hang_on_no_rounding", rounding)];

/// Whether the shader decides that the faces face the light, and that they do not, for each pair.
fn decisions(gpu: &Gpu, pairs: &[Bounded]) -> Result<Vec<[bool; 2]>, String> {
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
    let of_light = |pair: &Bounded| {
        let batch = LightBatch::new(&[pair.light], 0, 3);
        [batch.light_bits[0], batch.lights[0].map(f32::to_bits)]
    };
    let (table, words) = (gpu.storage(&pairs.iter().flat_map(of_light).collect::<Vec<_>>()), gpu.storage(&bounds));
    let bound = [(1, Bound::Storage(&table)), (9, Bound::Storage(&words))];
    let probe = Probe::new(gpu, &source, ("vec4<u32>", "probe_decide(index)"), &bound);
    let found = probe.run(gpu, &bound, &vec![[0.0; 4]; pairs.len()])?;
    Ok(found.iter().map(|&[decided, facing, ..]| [facing != 0, decided != 0 && facing == 0]).collect())
}

/// A decided pair has the exact signs. Rounding takes less than half of the spread, so `f64` decides pairs farther away.
fn check(Bounded { faces, light, bound }: &Bounded, found: [bool; 2]) -> Result<(), String> {
    let signs = faces.iter().map(|face| ExactFace::new(face, [0, 1, 2]).map_or(0, |face| face.sign(*light)));
    let signs: Vec<i32> = signs.collect();
    let [height, spread] = height_and_spread(bound, *light);
    let is_decided = found != [false; 2];
    let wrong = if [1, -1].into_iter().zip(found).any(|(side, found)| found && signs.iter().any(|&sign| sign != side)) {
        "another sign"
    } else if height.abs() > 1.5 * spread && !is_decided {
        "left open"
    } else if height.abs() < 0.5 * spread && is_decided {
        "decided"
    } else {
        return Ok(());
    };
    Err(format!("{wrong} at {height:e} and {spread:e}: {bound:?}, {light:?}, {found:?}, {signs:?}"))
}

/// Faces far away, thin, tiny and nearly in the light's plane, where each term of the spread counts.
fn rounding() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(107)?;
    let count = if is_long() { 1_000_000 } else { 60_000 };
    let mut pairs = Vec::new();
    for _ in 0..count {
        pairs.extend(bounded(&mut random)?);
    }
    let (mut decided, mut marginal, mut noticed) = (0, 0, 0);
    for (pair, found) in pairs.iter().zip(decisions(&gpu, &pairs)?) {
        check(pair, found)?;
        let [height, spread] = height_and_spread(&pair.bound, pair.light);
        decided += usize::from(found != [false; 2]);
        marginal += usize::from((0.5..1.5).contains(&(height.abs() / spread)));
        if found != [false; 2] && height.abs() > 2.0 * spread && noticed < 100 {
            must_fail("the opposite decision", &check(pair, [found[1], found[0]]))?;
            must_fail("no decision", &check(pair, [false; 2]))?;
            noticed += 1;
        }
    }
    println!("{decided} of {} decided, {marginal} marginal", pairs.len());
    let is_balanced = 2 * pairs.len() > count && (pairs.len()..9 * pairs.len()).contains(&(10 * decided));
    if is_balanced && marginal > 500 && noticed > 0 { Ok(()) } else { Err("neither side is tried enough".to_owned()) }
}
