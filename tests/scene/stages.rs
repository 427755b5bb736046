//! Every stage of the scene against its CPU twin.

use rimline::gpu::SceneOptions;
use rimline::reference::cpu::{self, SceneTable};
use rimline_measure::device::Gpu;
use rimline_measure::harness::Test;
use rimline_measure::on_gpu::text;
use rimline_measure::{must_fail, same};

use crate::random_scene::RandomScene;

pub(crate) const TESTS: &[Test] = &[("reach_and_chunks_equal_their_twins", twins)];

/// The table with all ranges times `factor`.
fn with_ranges(table: &[[u32; 4]], ranges_at: u32, batches: u32, factor: f32) -> Vec<[u32; 4]> {
    let mut table = table.to_vec();
    for part in &mut table[ranges_at as usize..(ranges_at + 8 * batches) as usize] {
        *part = part.map(|range| (f32::from_bits(range) * factor).to_bits());
    }
    table
}

/// Within a hair of the end of a range rounding may decide.
fn check_lit(lit: &[u32], [least, twin, most]: [&[u32]; 3]) -> Result<(), String> {
    same("pairs", &[lit.len()], &[twin.len()])?;
    for (pair, lit) in lit.iter().enumerate() {
        if least[pair] & !lit != 0 || lit & !most[pair] != 0 {
            return Err(format!("pair {pair}: {lit:b}, twin {:b}", twin[pair]));
        }
    }
    Ok(())
}

fn twins() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (mut partly, mut unlisted) = (0, 0);
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
        let results = frame.results().map_err(text)?;
        let first = results.groups.first().ok_or("no group")?.dispatch;
        let table: Vec<[u32; 4]> = gpu.read(results.table, usize::MAX)?;
        let lit: Vec<u32> = gpu.read(results.lit, (first.casters * first.batches) as usize)?;
        let twin =
            |factor| cpu::reach(SceneTable(&with_ranges(&table, first.ranges_at, first.batches, factor)), &first);
        let (least, exact, most) = (twin(0.9999), twin(1.0), twin(1.0001));
        check_lit(&lit, [&least, &exact, &most])?;
        if let Some(at) = lit.iter().position(|&lit| lit != 0) {
            let mut wrong = lit.clone();
            wrong[at] = 0;
            must_fail("a light that is left out", &check_lit(&wrong, [&exact, &exact, &exact]))?;
        }
        let work: Vec<u32> = gpu.read(results.work, usize::MAX)?;
        for group in &results.groups {
            let dispatch = group.dispatch;
            let expected = cpu::chunks(SceneTable(&table), &dispatch, &lit);
            for (kind, (expected, from)) in expected.iter().zip([dispatch.face_work, dispatch.edge_work]).enumerate() {
                let count = work[dispatch.work_count as usize + kind] as usize;
                let mut listed = work[from as usize..][..count].to_vec();
                listed.sort_unstable();
                let what = format!("chunks of kind {kind}, group {}, batch {}", group.group, group.batch);
                same(&what, &listed, expected)?;
                listed.pop();
                if count > 0 {
                    must_fail("a missing chunk", &same(&what, &listed, expected))?;
                }
                partly += usize::from(count > 0);
            }
            unlisted += (dispatch.face_chunks as usize).abs_diff(expected[0].len());
        }
    }
    if partly == 0 || unlisted == 0 { Err(format!("{partly} lists, {unlisted} chunks left out")) } else { Ok(()) }
}
