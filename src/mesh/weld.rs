//! Welding: one index for vertices that are the same point.

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
    let groups =
        groups(positions.len(), |v| hash(positions[v].map(bits)), |a, b| same_bits(positions[a], positions[b]));
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

/// A hash of words; multiply and rotate, as in FxHash, with a final mix so that the low bits serve as a table index.
pub(crate) fn hash(words: impl IntoIterator<Item = u32>) -> u64 {
    let mixed = words
        .into_iter()
        .fold(0_u64, |hash, word| (hash.rotate_left(5) ^ u64::from(word)).wrapping_mul(0x517c_c1b7_2722_0a95));
    mixed ^ (mixed >> 32)
}

/// For each of `count` elements the lowest index of an equal one. Linear expected time.
pub(crate) fn groups(count: usize, hash: impl Fn(usize) -> u64, equal: impl Fn(usize, usize) -> bool) -> Vec<u32> {
    const EMPTY: u32 = u32::MAX;
    let mask = (count.max(1) * 2).next_power_of_two() - 1;
    let mut table = vec![EMPTY; mask + 1];
    (0..count)
        .map(|element| {
            let mut slot = hash(element) as usize & mask;
            loop {
                match table[slot] {
                    EMPTY => {
                        table[slot] = element as u32;
                        return element as u32;
                    }
                    first if equal(first as usize, element) => return first,
                    _ => slot = (slot + 1) & mask,
                }
            }
        })
        .collect()
}
