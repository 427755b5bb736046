//! Exact signs of 200,000 pairs of face and light, 10 million in the long run, against big integers and, where it
//! applies, against the crate `robust`. `tests/extract/exact.rs` holds the GPU to the same pairs.

use rimline::internals::cpu::{self, Threads};
use rimline::{Light, Predicate};
use rimline_testkit::predicates::{Batch, CLASSES, FACES, Signs};
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, must_fail, same};
use robust::{Coord3D, orient3d};

type Outcome = Result<(), String>;

/// `x + y` where no bit is lost.
fn exact_sum(x: f64, y: f64) -> Option<f64> {
    let sum = x + y;
    let y_virtual = sum - x;
    let is_exact = (x - (sum - y_virtual)) + (y - y_virtual) == 0.0;
    is_exact.then_some(sum)
}

/// The sign by `robust`, whose `orient3d` is positive where the last point lies below: so its negative. The light's
/// place is `(l / w)`, with w's sign for a factor, or `a + (l − w·a)`: whichever loses no bit, if one does not. Its
/// arithmetic cannot leave the range of `f64`, which no product of three such coordinates comes near.
fn sign_by_robust([a, b, c]: [[f32; 3]; 3], light: Light) -> Option<i32> {
    let [x, y, z, w] = light.to_array().map(f64::from);
    let [a, b, c] = [a, b, c].map(|corner| corner.map(f64::from));
    let divided = [x, y, z].map(|coordinate| coordinate / w);
    // `f64` holds the product of two numbers of 24 bits exactly.
    let is_exact = |(divided, given): (&f64, f64)| f64::from(*divided as f32) == *divided && divided * w == given;
    let (point, side) = if divided.iter().zip([x, y, z]).all(is_exact) {
        (divided, if w < 0.0 { -1 } else { 1 })
    } else {
        let mut point = [x, y, z];
        for (coordinate, a) in point.iter_mut().zip(a) {
            *coordinate = exact_sum(exact_sum(*coordinate, -(w * a))?, a)?;
        }
        (point, 1)
    };
    let [a, b, c, d] = [a, b, c, point].map(|[x, y, z]| Coord3D { x, y, z });
    let below = orient3d(a, b, c, d);
    Some(side * (i32::from(below < 0.0) - i32::from(below > 0.0)))
}

/// Facing bits of each face for its own light.
fn bits_of_pairs(batch: &Batch, masks: &[u32]) -> Vec<bool> {
    let bit = |(face, mask): (usize, &u32)| mask >> (face % batch.lights.len()) & 1 != 0;
    masks.iter().enumerate().map(bit).collect()
}

/// Every way that the CPU has to a sign, against the oracle's.
fn check(what: &str, batch: &Batch, signs: &[i32]) -> Outcome {
    let integers: Vec<i32> = (0..batch.faces.len())
        .map(|face| {
            let ([a, b, c], light) = batch.pair(face);
            cpu::exact_facing(a, b, c, light.to_array())
        })
        .collect();
    same(&format!("{what}, exact_facing"), &integers, signs)?;
    let right: Vec<bool> = signs.iter().map(|&sign| sign > 0).collect();
    let masks = cpu::facing(&batch.positions, &batch.faces, &batch.lights, Predicate::Exact, Threads::all());
    same(&format!("{what}, facing"), &bits_of_pairs(batch, &masks), &right)?;
    // One light alone takes a way of its own.
    let alone = cpu::facing(&batch.positions, &batch.faces, &batch.lights[..1], Predicate::Exact, Threads::all());
    let first: Vec<u32> = masks.iter().map(|mask| mask & 1).collect();
    same(&format!("{what}, facing of one light"), &alone, &first)
}

/// Pairs that `robust` can be asked about; fails where it says otherwise.
fn check_by_robust(what: &str, batch: &Batch, signs: &[i32]) -> Result<usize, String> {
    let mut asked = 0;
    for (face, &sign) in signs.iter().enumerate() {
        let (corners, light) = batch.pair(face);
        match sign_by_robust(corners, light) {
            Some(found) if found != sign => {
                return Err(format!("{what}: robust says {found}, big integers {sign}: {corners:?}, {light:?}"));
            }
            Some(_) => asked += 1,
            None => {}
        }
    }
    Ok(asked)
}

#[test]
fn every_class_of_pairs_is_exact() -> Outcome {
    let seed = 21;
    let cases = if is_long() { 10_000_000 } else { 200_000 };
    let batches = usize::div_ceil(cases, CLASSES.len() * FACES);
    println!("seed {seed}; {} cases", batches * CLASSES.len() * FACES);
    for (number, class) in (0..).zip(&CLASSES) {
        let mut random = Random::new(seed + 1000 * number);
        let (mut counts, mut asked) = (Signs::default(), 0);
        for index in 0..batches {
            let what = format!("{}, batch {index}", class.name);
            let batch = class.batch(&mut random);
            let signs = batch.signs();
            counts.count(&signs);
            check(&what, &batch, &signs)?;
            asked += check_by_robust(&what, &batch, &signs)?;
        }
        let Signs { positive, zero, negative } = counts;
        println!(
            "{}: {} cases, {positive} positive, {zero} zero, {negative} negative; {asked} of them by robust, too",
            class.name,
            batches * FACES
        );
        class.check(counts)?;
        if asked == 0 {
            return Err(format!("{}: robust was never asked", class.name));
        }
    }
    Ok(())
}

/// The checks notice signs of `f32` arithmetic, one wrong sign, and a class without its zeros.
#[test]
fn wrong_signs_are_noticed() -> Outcome {
    for class in &CLASSES {
        let batch = class.batch(&mut Random::new(22));
        let mut signs = batch.signs();
        let right: Vec<bool> = signs.iter().map(|&sign| sign > 0).collect();
        let fast = cpu::facing(&batch.positions, &batch.faces, &batch.lights, Predicate::Fast, Threads::ONE);
        if !["random", "degenerate"].contains(&class.name) {
            must_fail(&format!("{}: f32 signs", class.name), &same("f32", &bits_of_pairs(&batch, &fast), &right))?;
        }
        let mut counts = Signs::default();
        counts.count(&signs);
        must_fail("a class of one sign", &class.check(Signs { positive: FACES, ..Signs::default() }))?;
        let at = (0..FACES).find(|&face| {
            let (corners, light) = batch.pair(face);
            sign_by_robust(corners, light).is_some()
        });
        let at = at.ok_or("robust is never asked")?;
        signs[at] = if signs[at] == 0 { 1 } else { -signs[at] };
        must_fail("a wrong sign", &check(class.name, &batch, &signs))?;
        must_fail("a wrong sign, to robust", &check_by_robust(class.name, &batch, &signs))?;
    }
    Ok(())
}
