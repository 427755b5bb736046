//! Exact facing against big integers: every bit, no band, on the GPU and on the CPU.

use rimline::gpu::{Extractor, ExtractorOptions, PositionBuffer};
use rimline::internals::cpu::{self, Threads};
use rimline::mesh::Weld;
use rimline::{Light, Mesh, Predicate};

use rimline_testkit::cases::hard_positions;
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::{extract, read, text};
use rimline_testkit::predicates::{FACES, LIGHTS, bits_of_pairs, for_every_class};
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, must_fail, oracle, same};

pub(crate) const TESTS: &[Test] = &[
    ("exact_facing_is_exact_on_hard_positions", hard),
    ("exact_facing_is_exact_about_the_window_of_fixed_point", window),
    ("exact_facing_ends_however_much_an_invocation_has_to_settle", full_invocations),
    ("exact_facing_is_exact_for_every_class_of_pairs", every_class),
];

fn exact(max_lights: usize) -> ExtractorOptions {
    ExtractorOptions { max_lights, masks: true, for_volumes: true, ..Default::default() }
}

/// Every facing and excluded bit of GPU and CPU reference is the oracle's, and the masks are those of these bits.
fn check(
    gpu: &Gpu,
    what: &str,
    positions: &[[f32; 3]],
    mesh: &Mesh,
    lights: &[Light],
    options: ExtractorOptions,
) -> Result<(), String> {
    let right = oracle::facing(positions, mesh.faces(), lights);
    let twin = cpu::facing(positions, mesh.faces(), lights, Predicate::Exact, Threads::all());
    same(&format!("{what}, twin"), &twin, &right)?;
    let found = extract(gpu, positions, mesh, lights, options)?;
    println!("{what}: {:?}", found.statistics);
    same(&format!("{what}, GPU"), &found.facing, &right)?;
    let masks = cpu::edges(mesh.edges(), &right, mesh.faces().len(), lights.len(), Threads::all());
    same(&format!("{what}, masks"), &found.masks, &masks)?;
    let in_plane = oracle::excluded(positions, mesh.faces(), lights);
    let twin = cpu::excluded(positions, mesh.faces(), lights);
    same(&format!("{what}, excluded, twin"), &twin, &in_plane)?;
    same(&format!("{what}, excluded, GPU"), &found.excluded, &in_plane)?;
    for (mut wrong, right) in [(found.facing, right), (found.excluded, in_plane)] {
        wrong[mesh.faces().len() / 2] ^= 1;
        must_fail("a flipped bit", &same(what, &wrong, &right))?;
    }
    Ok(())
}

/// The list of undecided faces has room for all, then for three.
fn hard() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let first = 41;
    println!("seeds from {first}");
    let seeds = first..first + if is_long() { 20 } else { 2 };
    for (seed, undecided_capacity) in seeds.zip([None, Some(3)].into_iter().cycle()) {
        for (name, (_, positions, mesh), lights) in hard_positions(&mut Random::new(seed)) {
            let options = ExtractorOptions { undecided_capacity, ..exact(lights.len()) };
            check(gpu, &name, &positions, &mesh, &lights, options)?;
        }
    }
    Ok(())
}

/// A point of a plane whose axes have scales of their own, so that coordinates span as many bits as these differ by and
/// 22 more; exactly on the plane, or a last bit beside it.
fn in_scaled_plane(random: &mut Random, scales: [f32; 3]) -> [f32; 3] {
    let bits = 1 + random.below(21);
    let [a, b] = [0; 2].map(|_| random.below(2 << bits) as f32 - (1 << bits) as f32);
    let [x, y, z] = scales;
    [a * x, b * y, (a - b) * z]
}

/// Fixed point takes faces of up to 46 bits and lights of up to 48 on the GPU and 96 on the CPU: spans on both sides.
fn window() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(45);
    for round in 0..if is_long() { 2000 } else { 40 } {
        let mut exponent = |from: i32, count: usize| 2.0_f32.powi(from + random.below(count) as i32);
        let base = exponent(-50, 60);
        let scales = [base, base * exponent(15, 14), base * exponent(0, 30)];
        let positions: Vec<_> = (0..40).map(|_| in_scaled_plane(&mut random, scales)).collect();
        let faces: Vec<[u32; 3]> = (0..200).map(|_| std::array::from_fn(|_| random.below(40) as u32)).collect();
        let mesh = Mesh::new(&positions, &faces, Weld::Keep).map_err(text)?;
        let mut lights: Vec<Light> = (0..33)
            .map(|index| {
                let w = [1.0, 0.0, 3.0, -1.0, random.between(0.5, 2.0), 1024.0, 1e-6][index % 7];
                let factor = if w == 0.0 { 1.0 } else { w };
                let mut light = in_scaled_plane(&mut random, scales).map(|c| c * factor);
                if index % 3 == 0 {
                    let axis = random.below(3);
                    light[axis] = if index % 2 == 0 { light[axis].next_up() } else { light[axis].next_down() };
                }
                Light::homogeneous([light[0], light[1], light[2], w])
            })
            .collect();
        lights.retain(|light| light.to_array().iter().any(|&c| c != 0.0));
        check(gpu, &format!("round {round}"), &positions, &mesh, &lights, exact(lights.len()))?;
    }
    Ok(())
}

/// A workgroup of 64 that each have 48 faces, as many as a CPU's have; see ARCHITECTURE.md, "Decisions".
const FULL: u32 = 64 * 48;

/// Every pair beyond `f32` and beyond fixed point, 32 lights, and as many faces as fill an invocation's turns: llvmpipe
/// ends an invocation's loops after 65,535 turns without a word.
fn full_invocations() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(47);
    let mut flat = || [random.between(-1.0, 1.0), random.between(-1.0, 1.0), random.between(-1.0, 1.0) * 1e-39];
    let positions: Vec<[f32; 3]> = (0..3 * FULL).map(|_| flat()).collect();
    let lights: Vec<Light> = (0..32).map(|_| Light::point(flat())).collect();
    let faces: Vec<[u32; 3]> = (0..FULL).map(|face| [3 * face, 3 * face + 1, 3 * face + 2]).collect();
    let mesh = Mesh::from_faces(positions.len(), faces).map_err(text)?;
    let found = extract(gpu, &positions, &mesh, &lights, exact(lights.len()))?;
    if found.statistics.undecided_pairs != 32 * FULL {
        return Err(format!("not every pair is undecided: {:?}", found.statistics));
    }
    check(gpu, "flat", &positions, &mesh, &lights, exact(lights.len()))
}

/// The pairs of `tests/extract/predicates.rs`: 200,000, 10 million in the long run. Each face's bit for the light that
/// it was made for against big integers, all others against the CPU reference.
fn every_class() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    // One mesh serves all batches: faces that share no vertex.
    let faces = (0..FACES as u32).map(|face| [0, 1, 2].map(|corner| 3 * face + corner)).collect();
    let mesh = Mesh::from_faces(3 * FACES, faces).map_err(text)?;
    let mut extractor = Extractor::new(&gpu.pipelines, &mesh, exact(LIGHTS)).map_err(text)?;
    for_every_class(45, |what, batch, signs| {
        let buffer = gpu.storage(&batch.positions);
        let positions = PositionBuffer { buffer: &buffer, offset: 0, stride: 12 };
        gpu.submit(|encoder| extractor.encode(encoder, positions, &batch.lights).map_err(text))?;
        let mut found = read(gpu, &extractor, &mesh, LIGHTS)?;
        let twin = cpu::facing(&batch.positions, &batch.faces, &batch.lights, Predicate::Exact, Threads::all());
        same(&format!("{what}, GPU and twin"), &found.facing, &twin)?;
        let right: Vec<bool> = signs.iter().map(|&sign| sign > 0).collect();
        let zero: Vec<bool> = signs.iter().map(|&sign| sign == 0).collect();
        same(&format!("{what}, GPU"), &bits_of_pairs(&found.facing), &right)?;
        same(&format!("{what}, excluded"), &bits_of_pairs(&found.excluded), &zero)?;
        found.facing[FACES / 2] ^= 1 << (FACES / 2 % LIGHTS);
        must_fail("a flipped facing bit", &same(what, &bits_of_pairs(&found.facing), &right))?;
        if found.statistics.undecided_pairs == 0 && !what.starts_with("random") {
            return Err(format!("{what}: the integers were never asked"));
        }
        Ok(())
    })
}
