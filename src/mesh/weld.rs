//! Welding: vertices that are the same point get one index.

mod cells;
mod distance;
mod near;

use std::hash::{BuildHasher, RandomState};

use super::topology::is_degenerate;
pub(super) use cells::root;
pub(crate) use cells::{NearGroups, near_groups};
pub use distance::WeldDistance;

/// Which vertices are welded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Weld {
    /// Vertices whose positions, skin and morph data have equal bits, where −0 equals +0.
    #[default]
    Data,
    /// Vertices with equal position bits (−0 equals +0). All of them take the skin and morph data of the lowest source
    /// index.
    Position,
    /// None. Vertices stay as given.
    Keep,
    /// Vertices that are near each other: the connected components of pairs at most a distance apart, compared exactly.
    /// Groups do not depend on the order of the vertices. The vertices of a pair have equal skin and morph data, unless
    /// the distance is [`WeldDistance::across_data`]; those that are infinite or NaN are joined if their bits are equal.
    /// Each group takes the lexicographically smallest of its positions, so chains of near vertices become one point,
    /// however long they are: see [`WeldCounts::wide`].
    Distance(WeldDistance),
}

/// Result of welding.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WeldCounts {
    /// The number of vertices before welding.
    pub before: usize,
    /// The number of vertices after welding.
    pub after: usize,
    /// How many vertices remained separate from another at the same position, because their skin or morph data differ.
    /// They are included in `after`. With [`Weld::Distance`]: how many more groups there are because of such data.
    pub apart: usize,
    /// How many faces welding made degenerate: their corners are fewer than three vertices now, or a polygon has no
    /// [boundary](super::Polygons::boundary) any more. They stay in the list, face no light and have no edge records.
    pub collapsed: usize,
    /// How many groups are wider than 10 times the distance of [`Weld::Distance`], from corner to corner of their box.
    pub wide: usize,
}

impl WeldCounts {
    /// The counts of a mesh whose vertices are not welded.
    pub(crate) fn unchanged(vertices: usize) -> Self {
        Self { before: vertices, after: vertices, ..Self::default() }
    }
}

/// The vertex that each vertex's group goes by, by position only, and the counts but that of collapsed faces. There are no
/// groups with [`Weld::Keep`].
pub(super) fn weld_positions(positions: &[[f32; 3]], weld: Weld) -> (Vec<u32>, WeldCounts) {
    let NearGroups { groups, wide } = match weld {
        Weld::Keep => return (Vec::new(), WeldCounts::unchanged(positions.len())),
        Weld::Distance(distance) => near_groups(positions, distance, |_| 0),
        Weld::Data | Weld::Position => {
            let keys = Keys::new(3);
            let hash = |v: usize| keys.hash(positions[v].map(bits));
            let groups = groups(positions.len(), hash, |a, b| same_bits(positions[a], positions[b]));
            NearGroups { groups, wide: 0 }
        }
    };
    let after = count(&groups);
    (groups, WeldCounts { before: positions.len(), after, wide, ..WeldCounts::default() })
}

/// How many faces are degenerate once their vertices are welded, and were not before.
pub(crate) fn collapsed(given: &[[u32; 3]], welded: &[[u32; 3]]) -> usize {
    let pairs = given.iter().zip(welded);
    pairs.filter(|(given, welded)| is_degenerate(**welded) && !is_degenerate(**given)).count()
}

/// The bits of a float, where −0 has those of +0.
pub(crate) fn bits(value: f32) -> u32 {
    if value == 0.0 { 0 } else { value.to_bits() }
}

/// Whether the bits of all components are equal, where −0 equals +0. So a NaN equals itself.
pub(crate) fn same_bits(a: [f32; 3], b: [f32; 3]) -> bool {
    a.map(bits) == b.map(bits)
}

/// The number of groups. Each goes by the index of a member.
pub(crate) fn count(groups: &[u32]) -> usize {
    groups.iter().enumerate().filter(|&(v, &group)| v == group as usize).count()
}

/// Random keys for hashing words. They are new each time, so that no input can choose vertices that collide.
/// Results do not depend on them, because a group has the index of its lowest member for any hashes.
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
/// the upper bits of `hash` are universal. It uses chaining, since open addressing needs a better hash.
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
