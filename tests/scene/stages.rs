//! Stages of the scene, `reach` first, against what the test knows of it.

use glam::{DMat3, DVec3};
use rimline::gpu::SceneOptions;
use rimline::internals::cpu;
use rimline::internals::layout::SceneCaster;
use rimline::internals::scene::SceneTable;
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::random::Random;
use rimline_testkit::{must_fail, same};

use crate::found::{Found, Tally, check_frame};
use crate::lists::{Listed, listed};
use crate::random_scene::{Content, Own, Placed, RandomScene};

pub(crate) const TESTS: &[Test] =
    &[("lights_reach_and_chunks_are_listed", reach), ("the_table_holds_what_casters_are", casters)];

/// Lights of a first frame are those that may reach a caster, and all that are clearly out of range are culled. Lists
/// follow from them.
fn reach() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (mut sum, mut tally) = (Listed::default(), Tally::default());
    for seed in 2001..2031 {
        println!("seed {seed}");
        let mut scene = RandomScene::new(gpu, seed, SceneOptions { max_lights: 40, ..Default::default() })?;
        for _ in 0..=scene.random.below(40) {
            scene.add_light()?;
        }
        for _ in 0..=scene.random.below(20) {
            scene.insert(gpu)?;
        }
        let frame = gpu.submit(|encoder| scene.encode(encoder))?;
        let mut found = Found::read(gpu, &frame)?;
        tally.add(&check_frame(&scene.content, &frame, &found)?);
        // Nothing is kept in a first frame.
        let pairs = scene.content.casters.len() * frame.batches();
        same("pairs taken", &found.taken[..pairs], &found.lit[..pairs])?;
        sum.add(listed(gpu, &frame, &mut Vec::new())?);
        if let Some(lit) = found.lit[..pairs].iter_mut().find(|lit| **lit != u32::MAX) {
            *lit = u32::MAX;
            must_fail("lights that are not allowed, or beyond", &check_frame(&scene.content, &frame, &found))?;
        }
    }
    println!("{sum:?}, {tally:?}");
    let is_vacuous = sum.faces == 0 || sum.unlisted == 0 || tally.beyond < 100;
    if is_vacuous { Err("too few of a kind".to_owned()) } else { Ok(()) }
}

/// Checks a caster of the table against what the test knows of it.
fn check_caster(content: &Content, own: &Own, found: &SceneCaster, random: &mut Random) -> Result<(), String> {
    let (mesh, positions) = content.mesh_and_positions(own);
    let counts = [found.faces as usize, found.edges as usize];
    same("faces and edges", &counts, &[mesh.faces().len(), mesh.edges().len()])?;
    let is_closed = mesh.is_closed();
    let proxy = if own.in_depth { 0 } else { 128 };
    let Placed::Rigid(rows) = &own.placed else {
        // Positions in a buffer may change.
        let stated = own.bounds.unwrap_or([[f32::MAX; 3], [f32::MIN; 3]]);
        same("stated box", &[found.low, found.high], &stated)?;
        let bounded = if own.bounds.is_some() { 256 } else { 0 };
        return same("flags in world space", &[found.flags], &[u32::from(is_closed) | 32 | proxy | bounded]);
    };
    let is_finite = |face: &[u32; 3]| face.iter().all(|&vertex| cpu::is_finite(positions[vertex as usize]));
    let is_degenerate = |[a, b, c]: [u32; 3]| a == b || b == c || c == a;
    let is_holed = mesh.faces().iter().any(|face| !is_finite(face) && !is_degenerate(*face));
    let matrix = DMat3::from_cols_array_2d(&[0, 1, 2].map(|column| rows.map(|row| f64::from(row[column]))));
    let flags = [(is_closed, 1), (matrix.determinant() < 0.0, 2), (true, 4), (is_holed, 8), (!own.in_depth, 128)];
    let flags = flags.iter().filter(|(is_set, _)| *is_set).map(|(_, flag)| flag).sum();
    same("flags", &[found.flags], &[flags])?;
    let is_regular = rows.iter().flatten().all(|c| c.is_finite());
    let expected = if is_regular { *rows } else { [[0.0; 4]; 3] };
    same("rows", &[found.row_0, found.row_1, found.row_2], &expected)?;
    let vertices = mesh.faces().iter().filter(|face| is_finite(face)).flatten().map(|&v| positions[v as usize]);
    let corner = |of: fn(f32, f32) -> f32| vertices.clone().reduce(|p, q| [0, 1, 2].map(|axis| of(p[axis], q[axis])));
    if let (Some(low), Some(high)) = (corner(f32::min), corner(f32::max)) {
        same("box", &[found.low, found.high], &[low, high])?;
    } else if found.low[0] <= found.high[0] {
        return Err("a box of nothing".to_owned());
    }
    // No direction is scaled by less, and not all by much more.
    let lengths = (0..200).map(|_| (matrix * DVec3::from(random.direction().map(f64::from)).normalize()).length());
    let least = lengths.fold(f64::MAX, f64::min);
    if is_regular && f64::from(found.scale) > least {
        return Err(format!("scale {}, and a direction is scaled by {least}", found.scale));
    }
    let columns = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(DVec3::length);
    let is_equal = columns.iter().all(|length| (length / columns[0] - 1.0).abs() < 1e-5);
    if is_regular && is_equal && f64::from(found.scale) < 0.999 * least {
        return Err(format!("scale {}, and all directions are scaled by {least}", found.scale));
    }
    Ok(())
}

fn casters() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(5);
    for seed in 2701..2721 {
        println!("seed {seed}");
        let mut scene = RandomScene::new(gpu, seed, SceneOptions { max_lights: 40, ..Default::default() })?;
        scene.add_light()?;
        for _ in 0..=scene.random.below(12) {
            scene.insert(gpu)?;
        }
        for _ in 0..3 {
            let frame = gpu.submit(|encoder| scene.encode(encoder))?;
            let table: Vec<[u32; 4]> = gpu.read(frame.results().map_err(text)?.table, usize::MAX)?;
            for own in &scene.content.casters {
                let (index, _) = frame.locate(own.handle).ok_or("the frame lacks a caster")?;
                let found = SceneTable(&table).caster(index);
                check_caster(&scene.content, own, &found, &mut random)?;
                if matches!(own.placed, Placed::Rigid(_)) {
                    let wrong = SceneCaster { flags: found.flags ^ 2, ..found };
                    must_fail("a mirrored flag", &check_caster(&scene.content, own, &wrong, &mut random))?;
                    let wrong = SceneCaster { faces: found.faces + 1, ..found };
                    must_fail("a further face", &check_caster(&scene.content, own, &wrong, &mut random))?;
                }
            }
            scene.change(gpu)?;
            // Without lights the table is not uploaded. A further light would lay the scene out anew each time.
            if scene.content.lights.is_empty() {
                scene.add_light()?;
            }
        }
    }
    Ok(())
}
