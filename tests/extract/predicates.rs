//! Exact signs of 200,000 pairs of face and light, 10 million in the long run, against big integers. `tests/extract/exact.rs`
//! holds the GPU to the same pairs.

use rimline::Predicate;
use rimline::internals::cpu::{self, Threads};
use rimline_testkit::predicates::{Batch, bits_of_pairs, for_every_class};
use rimline_testkit::{must_fail, same};

/// Every way that the CPU has to a sign, against the oracle's.
fn check(what: &str, batch: &Batch, signs: &[i32]) -> Result<(), String> {
    let exact = |face| {
        let ([a, b, c], light) = batch.pair(face);
        cpu::exact_facing(a, b, c, light.to_array())
    };
    let integers: Vec<i32> = (0..batch.faces.len()).map(exact).collect();
    same(&format!("{what}, exact_facing"), &integers, signs)?;
    let right: Vec<bool> = signs.iter().map(|&sign| sign > 0).collect();
    let masks = cpu::facing(&batch.positions, &batch.faces, &batch.lights, Predicate::Exact, Threads::all());
    same(&format!("{what}, facing"), &bits_of_pairs(&masks), &right)?;
    // One light alone takes a way of its own.
    let alone = cpu::facing(&batch.positions, &batch.faces, &batch.lights[..1], Predicate::Exact, Threads::all());
    let first: Vec<u32> = masks.iter().map(|mask| mask & 1).collect();
    same(&format!("{what}, facing of one light"), &alone, &first)
}

/// The checks notice signs of `f32` arithmetic, too, and one wrong sign.
#[test]
fn every_class_of_pairs_is_exact() -> Result<(), String> {
    for_every_class(21, |what, batch, signs| {
        check(what, batch, signs)?;
        let fast = cpu::facing(&batch.positions, &batch.faces, &batch.lights, Predicate::Fast, Threads::ONE);
        if what.ends_with("batch 0") && !["random", "degenerate"].iter().any(|class| what.starts_with(class)) {
            let right: Vec<bool> = signs.iter().map(|&sign| sign > 0).collect();
            must_fail(&format!("{what}: f32 signs"), &same("f32", &bits_of_pairs(&fast), &right))?;
        }
        let mut wrong = signs.to_vec();
        wrong[7] = if wrong[7] == 0 { 1 } else { -wrong[7] };
        must_fail("a wrong sign", &check(what, batch, &wrong))
    })
}
