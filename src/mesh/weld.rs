//! Welding: vertices that are the same point get one index.

use std::hash::{BuildHasher, RandomState};

/// Which vertices are welded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Weld {
    /// Those with equal position bits (−0 equals +0) and equal skin and morph data.
    #[default]
    Data,
    /// Those with equal position bits (−0 equals +0). All of them take the skin and morph data of the lowest source
    /// index.
    Position,
    /// None. Vertices stay as given.
    Keep,
}

/// What welding did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WeldCounts {
    /// The number of vertices before welding.
    pub before: usize,
    /// The number of vertices after welding.
    pub after: usize,
    /// How many vertices remained separate from another at the same position, because their skin or morph data differ.
    /// They are included in `after`.
    pub apart: usize,
}

impl WeldCounts {
    /// The counts of a mesh whose vertices are not welded.
    pub(crate) fn kept(vertices: usize) -> Self {
        Self { before: vertices, after: vertices, apart: 0 }
    }
}

/// The lowest index of each vertex's group, by position only, and the counts.
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

/// The bits of a float, where −0 has those of +0.
pub(crate) fn bits(value: f32) -> u32 {
    if value == 0.0 { 0 } else { value.to_bits() }
}

/// Whether the bits of all components are equal, where −0 equals +0. So a NaN equals itself.
pub(crate) fn same_bits(a: [f32; 3], b: [f32; 3]) -> bool {
    a.map(bits) == b.map(bits)
}

/// The number of groups. Each has the index of its lowest member.
pub(crate) fn count(groups: &[u32]) -> usize {
    groups.iter().enumerate().filter(|&(v, &group)| v == group as usize).count()
}

/// Random keys for hashing words. They are drawn anew each time, so that nobody can choose vertices that collide.
/// Results do not depend on them, because a group has the index of its lowest member whatever the hashes are.
pub(crate) struct Keys(Vec<u64>);

impl Keys {
    /// Keys for elements of at most `words` words. The hash ignores further words.
    pub(crate) fn new(words: usize) -> Self {
        let random = RandomState::new();
        Self((0..=words).map(|key| random.hash_one(key)).collect())
    }

    /// Multilinear hashing. Its upper 32 bits are strongly universal: two elements with a word that differs have equal
    /// bits with a probability of 2⁻³² (Lemire and Kaser, "Strongly universal string hashing is fast", 2014).
    pub(crate) fn hash(&self, words: impl IntoIterator<Item = u32>) -> u64 {
        let products = words.into_iter().zip(&self.0[1..]).map(|(word, key)| key.wrapping_mul(u64::from(word)));
        products.fold(self.0[0], u64::wrapping_add)
    }
}

/// For each of `count` elements, the lowest index of an equal element. The expected time is linear for any elements, if
/// the upper bits of `hash` are universal. It uses chaining, since open addressing asks more of a hash.
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
