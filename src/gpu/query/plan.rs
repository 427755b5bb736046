//! Cuts a query of occluder counts into dispatches.

use std::ops::Range;

use crate::cpu::query::shadow_boxes::CLUSTER;
use crate::gpu::common::device_error::DeviceError;
use crate::gpu::common::dispatch_limits::DispatchLimits;
use crate::layout::{FaceCluster, UndecidedFaces};
use crate::turns::QUERY_GROUPS;

/// The number of clusters in a group. Dispatches begin at whole groups, whose offset in bytes suits any binding.
pub(super) const GROUP: usize = 32;
/// The number of invocations in a workgroup.
const WORKGROUP: u64 = 64;
/// The largest number of pairs of point and light in one dispatch, where bindings allow it. It is enough for the
/// largest GPUs.
const MOST_QUERIES: u64 = 1 << 17;
/// The largest number of groups that one dispatch goes over, even for few points. A single invocation must end; `turns` says
/// how many turns its loops have. With 31 groups, a word of `UndecidedFaces` also has a bit for each and one more.
const MOST_GROUPS: u64 = QUERY_GROUPS as u64;
/// The number of points in a range is a multiple of this, so that the depths can be bound at its first point.
const POINTS: u64 = 64;
/// Bytes before the undecided pairs.
const UNDECIDED_HEAD: u64 = 8;
const UNDECIDED: u64 = size_of::<UndecidedFaces>() as u64;

/// The number of clusters that one binding and one dispatch of the boxes stage can hold: whole groups.
pub(super) fn cluster_range(split: &DispatchLimits) -> Result<usize, DeviceError> {
    let bytes = (GROUP * size_of::<FaceCluster>()) as u64;
    let groups = (split.binding / bytes).min(split.workgroups);
    if groups == 0 {
        return Err(DeviceError::BindingTooLarge { what: "a group of faces", bytes, limit: split.binding });
    }
    Ok(groups as usize * GROUP)
}

/// The ranges of clusters that one binding and one dispatch of the boxes stage can hold.
pub(super) fn cluster_chunks(split: &DispatchLimits, clusters: usize) -> Result<Vec<Range<usize>>, DeviceError> {
    let range = cluster_range(split)?;
    Ok((0..clusters).step_by(range).map(|first| first..(first + range).min(clusters)).collect())
}

/// The size of the undecided faces of `pairs` of point and light, in bytes.
pub(super) fn undecided_bytes(pairs: u64) -> u64 {
    UNDECIDED_HEAD + pairs.max(1) * UNDECIDED
}

/// The largest number of pairs of point and light in a dispatch whose undecided faces fit one binding.
pub(super) fn most_queries(split: &DispatchLimits, points: u32, lights: usize) -> u64 {
    let all = u64::from(points).next_multiple_of(POINTS) * lights.min(32) as u64;
    all.min(MOST_QUERIES).min((split.binding - UNDECIDED_HEAD) / UNDECIDED).min(split.workgroups * WORKGROUP)
}

/// The ranges of points for `lights` lights. `stride` is the bytes from one point to the next.
pub(super) fn point_chunks(
    split: &DispatchLimits,
    queries: u64,
    points: u32,
    lights: usize,
    stride: u64,
) -> Result<Vec<Range<u32>>, DeviceError> {
    let depths = 4 * lights as u64;
    let by_undecided = queries / lights.min(32) as u64;
    // The binding may begin a little before the first point.
    let by_points = split.binding.saturating_sub(256) / stride;
    let range = by_undecided.min(by_points).min(split.binding / depths) / POINTS * POINTS;
    if range == 0 {
        // A caller may give any stride for a single point.
        let bytes = POINTS.saturating_mul(depths.max(stride).max(UNDECIDED * lights.min(32) as u64));
        return Err(DeviceError::BindingTooLarge { what: "64 points", bytes, limit: split.binding });
    }
    Ok((0..points).step_by(range as usize).map(|first| first..first.saturating_add(range as u32).min(points)).collect())
}

/// The number of clusters that a dispatch of `queries` goes over, a multiple of a group.
pub(super) fn range_clusters(split: &DispatchLimits, work: u64, queries: u64) -> usize {
    let groups = work / (queries.max(1) * (GROUP * CLUSTER) as u64);
    // The recount may take a workgroup for each pair and group, in rows along x and y. Below 64 workgroups an axis, pairs of a
    // single group may need layers along z.
    let dispatched = split.workgroups * split.workgroups / queries.max(1);
    groups.min(dispatched).clamp(1, MOST_GROUPS) as usize * GROUP
}

/// The number of workgroups for `pairs` of point and light.
pub(super) fn workgroups(pairs: u64) -> u32 {
    pairs.div_ceil(WORKGROUP) as u32
}
