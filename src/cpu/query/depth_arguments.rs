//! Depth arguments: the indirect dispatch that counts pairs of point and light again.

/// The workgroups along x, y and z for `recounts` pairs over `groups` groups of faces, with at most `most_workgroups` along
/// x. One dispatch lists few enough pairs that `most_workgroups` along y suffice.
pub fn depth_arguments(recounts: u32, groups: u32, most_workgroups: u32) -> [u32; 3] {
    let all = recounts * groups;
    [all.min(most_workgroups), all.div_ceil(most_workgroups), 1]
}
