//! Exact arguments: the dispatch over undecided faces.

/// Workgroups along x, y and z for `count` undecided faces of a chunk of `faces`, of which the list has room for
/// `capacity`; beyond that every face is taken. At most `most_workgroups` along each axis.
pub fn exact_arguments(count: u32, capacity: u32, faces: u32, most_workgroups: u32) -> [u32; 3] {
    let most = most_workgroups.max(1);
    let items = if count > capacity { faces } else { count };
    let groups = items.div_ceil(64);
    let rows = groups.div_ceil(most);
    [groups.min(most), rows.min(most), rows.div_ceil(most)]
}
