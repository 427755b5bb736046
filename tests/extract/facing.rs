//! Facing bits against exact arithmetic: right outside the error band that docs/numerics/facing.md derives, at all
//! scales.

use rimline::gpu::ExtractorOptions;
use rimline::internals::Method;
use rimline::internals::cpu::{self, Threads};
use rimline::internals::layout::EdgeMasks;
use rimline::mesh::Weld;
use rimline::{Light, Mesh, Predicate};
use rimline_testkit::shapes;

use rimline_testkit::band::{self, Bound, check_facing, check_facing_by};
use rimline_testkit::cases::{Case, hard_positions};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::{extract, text};
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, lights, must_fail, oracle, same};

pub(crate) const TESTS: &[Test] = &[
    ("facing_is_exact_outside_the_band", hard),
    ("non_finite_positions_face_no_light_and_are_counted", non_finite),
    ("per_edge_is_exact_outside_its_band", per_edge),
];

fn masks_only(max_lights: usize) -> ExtractorOptions {
    ExtractorOptions { max_lights, masks: true, predicate: Predicate::Fast, lists: None, ..Default::default() }
}

/// The forms of `f32`, each with the bound outside which its signs are right.
const FORMS: [(&str, Predicate, Bound); 2] =
    [("local form", Predicate::Fast, band::facing_bound), ("plane form", Predicate::Plane, band::per_edge_bound)];

fn hard() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let first = 21;
    println!("seeds from {first}");
    for seed in first..if is_long() { first + 20 } else { first + 1 } {
        let cases = hard_positions(&mut Random::new(seed)).into_iter().chain([subnormal()?]);
        for ((name, (_, positions, mesh), lights), (form, predicate, bound)) in
            cases.flat_map(|case| FORMS.map(|form| (case.clone(), form)))
        {
            let name = format!("{name}, {form}");
            let check = |facing: &[u32]| check_facing_by(bound, &name, facing, &positions, mesh.faces(), &lights);
            let mut found =
                extract(gpu, &positions, &mesh, &lights, ExtractorOptions { predicate, ..masks_only(lights.len()) })?;
            let on_gpu = check(&found.facing)?;
            same(&format!("{name}, unclosed"), &[oracle::unclosed(&mesh, &found.masks, lights.len())], &[0])?;
            let twin = cpu::facing(&positions, mesh.faces(), &lights, predicate, Threads::all());
            let on_cpu = check(&twin)?;
            // Both are right outside the band, so they can differ inside only.
            let differ = found.facing.iter().zip(&twin).map(|(a, b)| (a ^ b).count_ones() as usize);
            let differ: usize = differ.sum();
            println!("{name}: GPU {on_gpu:?}, twin {on_cpu:?}, {differ} bits differ");
            let is_outside = on_gpu.outside > 0 || !name.starts_with("subnormal, local");
            if differ > on_gpu.inside || !is_outside {
                return Err(format!("{name}: {differ} bits differ, {on_gpu:?}"));
            }
            if name.starts_with("unit") {
                found.facing[5] ^= 1 << 7;
                must_fail("a flipped facing bit", &check(&found.facing))?;
                found.facing[5] ^= 1 << 7;
                *found.facing.last_mut().ok_or("no faces")? |= 1 << 31;
                must_fail("a bit past the lights", &check(&found.facing))?;
            }
        }
    }
    Ok(())
}

/// Subnormal positions may be flushed by any operation; the underflow term covers it, and signs that normal factors
/// carry stay right.
fn subnormal() -> Result<(String, Case, Vec<Light>), String> {
    let tiny = 1e-40;
    let positions = vec![[tiny, 0.0, 0.0], [1e6, -tiny, 0.0], [0.0, 1e6, tiny], [0.0, 0.0, tiny]];
    let mesh = Mesh::new(&positions, &[[0, 1, 2], [2, 1, 0], [0, 1, 3]], Weld::Keep).map_err(text)?;
    let lights =
        [Light::directional([0.0, 0.0, 1.0]), Light::directional([0.0, tiny, -1.0]), Light::point([0.0, tiny, 1.0])];
    Ok(("subnormal".to_owned(), ("subnormal".to_owned(), positions, mesh), lights.to_vec()))
}

fn non_finite() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(23);
    let shape = shapes::torus(20, 14, 1.0, 0.4);
    let mesh = shape.mesh().map_err(text)?;
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
    let twin = cpu::extract(&positions, &mesh, &lights, Predicate::Exact, Threads::ONE);
    let twin = twin.map_err(text)?;
    same("the twin's count", &[twin.statistics.non_finite_faces as usize], &[poisoned])?;
    for (index, face) in mesh.faces().iter().enumerate() {
        let words = found.facing.iter().skip(index).step_by(mesh.faces().len());
        if is_poisoned(face) && words.into_iter().any(|&mask| mask != 0) {
            return Err(format!("face {index} has a non-finite vertex and faces a light"));
        }
    }
    same("unclosed", &[oracle::unclosed(&mesh, &found.masks, lights.len())], &[0])
}

/// The 2003 method decides a face's side at each edge; outside the bands of its forms these decisions are right too.
fn per_edge() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    for (name, (_, positions, mesh), lights) in hard_positions(&mut Random::new(24)) {
        let exact = oracle::facing(&positions, mesh.faces(), &lights);
        let right = cpu::edges(mesh.edges(), &exact, mesh.faces().len(), lights.len(), Threads::all());
        for (form, predicate, bound) in FORMS {
            let options = ExtractorOptions { method: Method::PerEdge, predicate, ..masks_only(lights.len()) };
            let mut found = extract(gpu, &positions, &mesh, &lights, options)?.masks;
            let twin = cpu::per_edge(&positions, &mesh, &lights, predicate, Threads::all());
            let inside = inside_at_edges(&positions, &mesh, &lights, bound);
            let what = format!("{name}, {form}");
            let count: u32 = inside.iter().map(|bits| bits.count_ones()).sum();
            println!("{what}: {count} edges inside");
            let check = |who: &str, masks: &[EdgeMasks]| {
                let outside = |masks: &[EdgeMasks]| -> Vec<[u32; 2]> {
                    let pairs = masks.iter().zip(&inside);
                    pairs.map(|(masks, inside)| [masks.silhouette & !inside, masks.winding & !inside]).collect()
                };
                same(&format!("{what}, {who}"), &outside(masks), &outside(&right))
            };
            check("twin", &twin)?;
            check("GPU", &found)?;
            if let Some(edge) = inside.iter().position(|bits| bits & 1 == 0) {
                found[edge].winding ^= 1;
                must_fail("a flipped winding bit", &check("GPU", &found))?;
            }
        }
    }
    Ok(())
}

/// For each batch of lights and edge record the lights for which one of its faces is in the band.
fn inside_at_edges(positions: &[[f32; 3]], mesh: &Mesh, lights: &[Light], bound: Bound) -> Vec<u32> {
    // The method takes the edge's vertex as the plane's origin, which may be any corner of the face.
    let is_inside = |face: &[u32; 3], light: Light| {
        let corners = face.map(|v| positions[v as usize]);
        !(0..3).all(|by| band::is_outside([0, 1, 2].map(|i| corners[(i + by) % 3]), light, bound))
    };
    let planes = lights.chunks(32).flat_map(|lights| {
        let of_face = |face: &[u32; 3]| {
            (0..).zip(lights).fold(0, |bits, (bit, &light)| bits | u32::from(is_inside(face, light)) << bit)
        };
        let faces: Vec<u32> = mesh.faces().iter().map(of_face).collect();
        let of = |face: u32| faces[face as usize];
        mesh.edges().iter().map(|edge| of(edge.face_0) | edge.face_1.map_or(0, of)).collect::<Vec<_>>()
    });
    planes.collect()
}
