//! Equality is tested about once a vertex, even for vertices that were chosen to collide.

use std::cell::Cell;

use super::*;

/// How often [`groups`] compares two of these elements.
fn comparisons(elements: &[[u32; 3]], hash: impl Fn([u32; 3]) -> u64) -> usize {
    let count = Cell::new(0);
    let equal = |a: usize, b: usize| {
        count.set(count.get() + 1);
        elements[a] == elements[b]
    };
    groups(elements.len(), |element| hash(elements[element]), equal);
    count.get()
}

/// Sixteen sets of keys for three words, always the same.
fn fixed_keys() -> Vec<Keys> {
    let mut state = 1_u64;
    let mut key = || {
        state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
        state ^ state >> 29
    };
    (0..16).map(|_| Keys((0..4).map(|_| key()).collect())).collect()
}

/// A hash that is not keyed collides with itself for elements that were chosen to; single keys may do badly, and several are
/// tried. The table has twice as many lists as elements: a quarter of a comparison an element is expected.
#[test]
fn chosen_collisions_cost_no_more_than_others() {
    // Rimline's hash until it was keyed: multiply and rotate.
    let unkeyed = |words: [u32; 3]| {
        let mix = |hash: u64, word| (hash.rotate_left(5) ^ u64::from(word)).wrapping_mul(0x517c_c1b7_2722_0a95);
        let mixed = words.into_iter().fold(0_u64, mix);
        mixed ^ (mixed >> 32)
    };
    let total = |elements: &[[u32; 3]], keys: &[Keys]| -> usize {
        keys.iter().map(|keys| comparisons(elements, |words| keys.hash(words))).sum()
    };
    let (keys, all) = (fixed_keys(), 1000 * 999 / 2);
    let chosen =
        (0..).map(|n: u32| [n, n ^ 0x5bd1, n.rotate_left(7)]).filter(|&words| unkeyed(words).trailing_zeros() >= 12);
    let chosen: Vec<_> = chosen.take(1000).collect();
    assert!(total(&chosen, &keys) < 16 * 1000);
    // The control: a table that takes the bits that collide compares each with each.
    assert_eq!(comparisons(&chosen, |words| unkeyed(words) << (64 - 12)), all);
    for word in 0..3 {
        let elements: Vec<[u32; 3]> =
            (0..1000).map(|n| std::array::from_fn(|w| if w == word { n } else { 7 })).collect();
        assert!(total(&elements, &keys) < 16 * 1000, "word {word}");
        // The control: a key of zero leaves the word out, and every element is compared with all before it.
        let without = Keys((0..4).map(|at| if at == word + 1 { 0 } else { keys[0].0[at] }).collect());
        assert_eq!(total(&elements, &[without]), all);
    }
    let hashes: Vec<u64> = (0..8).map(|_| Keys::new(3).hash([1, 2, 3])).collect();
    assert!(hashes.windows(2).any(|pair| pair[0] != pair[1]), "keys do not differ from run to run: {hashes:?}");
}
