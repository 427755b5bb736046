//! Exact arguments: the dispatch over undecided faces.

/// Workgroups along x, y and z for `count` undecided faces of a chunk of `faces`, of which the list has room for
/// `capacity`; beyond that every face is taken. At most `most_workgroups` along x.
pub fn exact_arguments(count: u32, capacity: u32, faces: u32, most_workgroups: u32) -> [u32; 3] {
    let items = if count > capacity { faces } else { count };
    let groups = items.div_ceil(64);
    [groups.min(most_workgroups), groups.div_ceil(most_workgroups.max(1)), 1]
}
