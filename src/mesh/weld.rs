//! Welding: one index for vertices that are the same point.

use std::hash::{BuildHasher, RandomState};

/// Which vertices become one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Weld {
    /// Equal position bits (−0 equals +0) and equal skin and morph data.
    #[default]
    Data,
    /// Equal position bits (−0 equals +0) alone: the lowest source index's skin and morph data hold for all.
    Position,
    /// None: vertices stay as given.
    Keep,
}

/// What welding did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WeldCounts {
    /// Vertices before.
    pub before: usize,
    /// Vertices after.
    pub after: usize,
    /// Of those, how many stayed apart from another at the same position, for their skin or morph data.
    pub apart: usize,
}

impl WeldCounts {
    /// Counts of a mesh whose vertices stay as they are.
    pub(crate) fn kept(vertices: usize) -> Self {
        Self { before: vertices, after: vertices, apart: 0 }
    }
}

/// For every vertex the lowest index of its group, by position alone, and the counts.
pub(super) fn weld_positions(positions: &[[f32; 3]], weld: Weld) -> (Vec<u32>, WeldCounts) {
    if weld == Weld::Keep {
        return (Vec::new(), WeldCounts::kept(positions.len()));
    }
    let keys = Keys::new(3);
    let groups =
        groups(positions.len(), |v| keys.hash(positions[v].map(bits)), |a, b| same_bits(positions[a], positions[b]));
    let after = count(&groups);
    (groups, WeldCounts { before: positions.len(), after, apart: 0 })
}

/// A float's bits, with one zero.
pub(crate) fn bits(value: f32) -> u32 {
    if value == 0.0 { 0 } else { value.to_bits() }
}

/// Equal bits, component by component, −0 like +0; so a NaN equals itself.
pub(crate) fn same_bits(a: [f32; 3], b: [f32; 3]) -> bool {
    a.map(bits) == b.map(bits)
}

/// Groups, of which each goes by its lowest member.
pub(crate) fn count(groups: &[u32]) -> usize {
    groups.iter().enumerate().filter(|&(v, &group)| v == group as usize).count()
}

/// Random numbers that a hash of words is made with, drawn anew each time, so that nobody can choose vertices that collide.
/// Results do not depend on them: a group goes by its lowest member whatever the hashes are.
pub(crate) struct Keys(Vec<u64>);

impl Keys {
    /// Keys for elements of at most so many words; further words are left out of the hash.
    pub(crate) fn new(words: usize) -> Self {
        let random = RandomState::new();
        Self((0..=words).map(|key| random.hash_one(key)).collect())
    }

    /// Multilinear hashing: its upper 32 bits are strongly universal, so any two elements of which one has a word that the
    /// other has not share them with a probability of 2⁻³² (Lemire and Kaser, "Strongly universal string hashing is
    /// fast", 2014).
    pub(crate) fn hash(&self, words: impl IntoIterator<Item = u32>) -> u64 {
        let products = words.into_iter().zip(&self.0[1..]).map(|(word, key)| key.wrapping_mul(u64::from(word)));
        products.fold(self.0[0], u64::wrapping_add)
    }
}

/// For each of `count` elements the lowest index of an equal one. Linear expected time, whatever the elements, if the upper
/// bits of `hash` are universal: chains, since open addressing asks more of a hash than that.
pub(crate) fn groups(count: usize, hash: impl Fn(usize) -> u64, equal: impl Fn(usize, usize) -> bool) -> Vec<u32> {
    const END: u32 = u32::MAX;
    let bits = (count.max(1) * 2).next_power_of_two().ilog2();
    let mut heads = vec![END; 1 << bits];
    let mut next = vec![END; count];
    (0..count)
        .map(|element| {
            let head = &mut heads[(hash(element) >> (u64::BITS - bits)) as usize];
            let mut at = *head;
            while at != END {
                if equal(at as usize, element) {
                    return at;
                }
                at = next[at as usize];
            }
            next[element] = std::mem::replace(head, element as u32);
            element as u32
        })
        .collect()
}

#[cfg(test)]
mod tests;
