//! Facing bits against exact arithmetic: right outside the error band that NUMERICS.md derives, whatever the scale.

use rimline::cpu::{self, Threads};
use rimline::gpu::ExtractorOptions;
use rimline::mesh::Weld;
use rimline::{Light, Mesh, Predicate, shapes};

use crate::common::band::{self, check_facing};
use crate::common::cases::{case, hard_positions};
use crate::common::device::Gpu;
use crate::common::random::Random;
use crate::common::{is_long, lights, must_fail, oracle, same};
use crate::stages::extract;

pub(crate) const TESTS: &[crate::Test] = &[
    ("facing_is_exact_outside_the_band", hard),
    ("facing_of_a_thousand_lights_is_exact_outside_the_band", thousand_lights),
    ("subnormal_signs_follow_the_band", subnormal),
    ("non_finite_positions_face_no_light_and_are_counted", non_finite),
    ("per_edge_is_exact_outside_its_band", per_edge),
];

fn masks_only(max_lights: usize) -> ExtractorOptions {
    ExtractorOptions { max_lights, masks: true, predicate: Predicate::Fast, lists: None, ..Default::default() }
}

fn hard() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let first = 21;
    println!("seeds from {first}");
    for seed in first..if is_long() { first + 20 } else { first + 1 } {
        for (name, (_, positions, mesh), lights) in hard_positions(&mut Random::new(seed)) {
            let mut found = extract(gpu, &positions, &mesh, &lights, masks_only(lights.len()))?;
            let on_gpu = check_facing(&name, &found.facing, &positions, mesh.faces(), &lights)?;
            let twin = cpu::facing(&positions, mesh.faces(), &lights, Predicate::Fast, Threads::all());
            let on_cpu = check_facing(&name, &twin, &positions, mesh.faces(), &lights)?;
            // Both are right outside the band, so they can differ inside only.
            let differ = found.facing.iter().zip(&twin).map(|(a, b)| (a ^ b).count_ones() as usize);
            let differ: usize = differ.sum();
            println!("{name}: GPU {on_gpu:?}, twin {on_cpu:?}, {differ} bits differ");
            if differ > on_gpu.inside {
                return Err(format!("{name}: {differ} bits differ, {} lie in the band", on_gpu.inside));
            }
            if name == "unit" {
                found.facing[5] ^= 1 << 7;
                let outcome = check_facing(&name, &found.facing, &positions, mesh.faces(), &lights);
                must_fail("a flipped facing bit", &outcome)?;
            }
        }
    }
    Ok(())
}

fn thousand_lights() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (name, positions, mesh) = case("blob", shapes::blob(2, 0.4, 3));
    let lights = lights(&mut Random::new(22), 1024);
    let found = extract(gpu, &positions, &mesh, &lights, masks_only(1024))?;
    let checked = check_facing(&name, &found.facing, &positions, mesh.faces(), &lights)?;
    println!("{checked:?}");
    let masks = cpu::edges(mesh.edges(), &found.facing, mesh.faces().len(), 1024, Threads::all());
    same("masks", &found.masks, &masks)
}

/// Subnormal positions may be flushed by any operation; the underflow term covers it, and signs that normal factors
/// carry stay right.
fn subnormal() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let tiny = 1e-40;
    let positions = [[tiny, 0.0, 0.0], [1e6, -tiny, 0.0], [0.0, 1e6, tiny], [0.0, 0.0, tiny]];
    let mesh = Mesh::new(&positions, &[[0, 1, 2], [2, 1, 0], [0, 1, 3]], Weld::Keep).map_err(|e| e.to_string())?;
    let lights =
        [Light::directional([0.0, 0.0, 1.0]), Light::directional([0.0, tiny, -1.0]), Light::point([0.0, tiny, 1.0])];
    let found = extract(gpu, &positions, &mesh, &lights, masks_only(3))?;
    let checked = check_facing("subnormal", &found.facing, &positions, mesh.faces(), &lights)?;
    println!("{checked:?}");
    if checked.outside == 0 {
        return Err("nothing lies outside the band".to_owned());
    }
    Ok(())
}

fn non_finite() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let seed = 23;
    println!("seed {seed}");
    let mut random = Random::new(seed);
    let shape = shapes::torus(20, 14, 1.0, 0.4);
    let mesh = shape.mesh().map_err(|e| e.to_string())?;
    let lights = lights(&mut random, 70);
    let poison = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::from_bits(0xffff_ffff), f32::from_bits(0x7f80_0001)];
    let mut positions = shape.positions;
    for value in poison {
        let vertex = random.below(positions.len());
        positions[vertex][random.below(3)] = value;
    }
    // The largest finite number is finite, though its products overflow.
    let largest = random.below(positions.len());
    if positions[largest].iter().all(|c| c.is_finite()) {
        positions[largest][0] = f32::MAX;
    }
    let is_poisoned = |face: &[u32; 3]| face.iter().any(|&v| positions[v as usize].iter().any(|c| !c.is_finite()));
    let poisoned = mesh.faces().iter().filter(|face| is_poisoned(face)).count();
    let found = extract(gpu, &positions, &mesh, &lights, masks_only(70))?;
    check_facing("poisoned", &found.facing, &positions, mesh.faces(), &lights)?;
    let counted = [found.statistics.non_finite_faces as usize];
    same("non-finite faces", &counted, &[poisoned])?;
    let twin = cpu::extract(&positions, &mesh, &lights, rimline::Method::FaceMask, Predicate::Exact, Threads::ONE);
    let twin = twin.map_err(|e| e.to_string())?;
    same("the twin's count", &[twin.counts.non_finite_faces as usize], &[poisoned])?;
    for (index, face) in mesh.faces().iter().enumerate() {
        let words = found.facing.iter().skip(index).step_by(mesh.faces().len());
        if is_poisoned(face) && words.into_iter().any(|&mask| mask != 0) {
            return Err(format!("face {index} has a non-finite vertex and faces a light"));
        }
    }
    match oracle::unclosed(&mesh, &found.masks, lights.len()) {
        0 => Ok(()),
        open => Err(format!("{open} vertices unclosed")),
    }
}

/// The 2003 method decides a face's side at each edge; outside its own, wider band these decisions are right too.
fn per_edge() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    for (name, (_, positions, mesh), lights) in hard_positions(&mut Random::new(24)) {
        let options = ExtractorOptions { method: rimline::Method::PerEdge, ..masks_only(lights.len()) };
        let found = extract(gpu, &positions, &mesh, &lights, options)?;
        let exact = oracle::facing(&positions, mesh.faces(), &lights);
        let expected = cpu::edges(mesh.edges(), &exact, mesh.faces().len(), lights.len(), Threads::all());
        let (mut outside, mut inside) = (0, 0);
        for (number, &light) in lights.iter().enumerate() {
            let at = number / 32 * mesh.edges().len();
            for (index, edge) in mesh.edges().iter().enumerate() {
                let is_decided = |face: u32| {
                    let corners = mesh.faces()[face as usize].map(|v| positions[v as usize]);
                    // The method takes the edge's vertex as the plane's origin, which may be any corner of the face.
                    let turned = |by: usize| std::array::from_fn(|i| corners[(i + by) % 3]);
                    (0..3).all(|by| band::is_outside(turned(by), light, band::per_edge_bound))
                };
                if !is_decided(edge.face_0) || edge.face_1.is_some_and(|face| !is_decided(face)) {
                    inside += 1;
                    continue;
                }
                outside += 1;
                let bits = |masks: rimline::layout::Masks| {
                    (masks.silhouette >> (number % 32) & 1, masks.winding >> (number % 32) & 1)
                };
                let (got, right) = (bits(found.masks[at + index]), bits(expected[at + index]));
                if got != right {
                    return Err(format!("{name}, light {number}, edge {index}: {got:?}, exactly {right:?}"));
                }
            }
        }
        println!("{name}: {outside} edges outside, {inside} inside");
    }
    Ok(())
}
