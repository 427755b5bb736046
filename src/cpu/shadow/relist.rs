//! Relist: finds the lights of a group of casters whose lists for a view are made anew.

/// The lights of a batch whose lists are made anew, as bits. `made_from` has for each light the encode that made the silhouettes
/// of the group, and the version of the camera; `listed` the same of the lists that are there. `keeps`: lists are kept at all.
pub fn relist(made_from: &[[u32; 2]], listed: &[[u32; 2]], keeps: bool) -> u32 {
    let is_fresh = |bit: usize| !keeps || made_from.get(bit) != listed.get(bit);
    (0..32).filter(|&bit| is_fresh(bit)).fold(0, |mask, bit| mask | 1 << bit)
}
