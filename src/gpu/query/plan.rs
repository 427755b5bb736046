//! How a shadow depth query is cut into dispatches.

use std::ops::Range;

use crate::gpu::common::dispatch_limits::DispatchLimits;
use crate::gpu::common::memory::MemoryError;
use crate::layout::{FaceCluster, UndecidedFaces};

/// Clusters of a group; dispatches begin at whole groups, whose bytes any binding may begin at.
pub(super) const GROUP: usize = 32;
/// Faces of a cluster.
pub(super) const CLUSTER: usize = 32;
/// Invocations of a workgroup.
const WORKGROUP: u64 = 64;
/// Pairs of point and light that one dispatch takes, where bindings allow it: enough for the largest GPUs.
const MOST_QUERIES: u64 = 1 << 17;
/// Groups that one dispatch goes over, however few its points are: a single invocation must come to an end, too, and
/// llvmpipe takes one out of its loops after 65,535 turns, silently.
const MOST_GROUPS: u64 = 32;
/// Points of a run are a multiple of this, so that depths may be bound at the first of them.
const POINTS: u64 = 64;
/// Bytes before the undecided pairs, and of those of a pair of point and light.
const DOUBTS_HEAD: u64 = 8;
const DOUBT: u64 = size_of::<UndecidedFaces>() as u64;

/// Runs of clusters that one binding and one dispatch of the boxes stage can hold.
pub(super) fn cluster_chunks(split: &DispatchLimits, clusters: usize) -> Result<Vec<Range<usize>>, MemoryError> {
    let bytes = (GROUP * size_of::<FaceCluster>()) as u64;
    let groups = (split.binding / bytes).min(split.workgroups);
    if groups == 0 {
        return Err(MemoryError::Binding { what: "a group of faces", bytes, limit: split.binding });
    }
    let run = groups as usize * GROUP;
    Ok((0..clusters).step_by(run).map(|first| first..(first + run).min(clusters)).collect())
}

/// Bytes that the doubts of `pairs` of point and light take.
pub(super) fn doubt_bytes(pairs: u64) -> u64 {
    DOUBTS_HEAD + pairs.max(1) * DOUBT
}

/// Pairs of point and light that a dispatch may have, for doubts that fit one binding.
pub(super) fn most_queries(split: &DispatchLimits, points: u32, lights: usize) -> u64 {
    let all = u64::from(points).next_multiple_of(POINTS) * lights.min(32) as u64;
    all.min(MOST_QUERIES).min((split.binding - DOUBTS_HEAD) / DOUBT).min(split.workgroups * WORKGROUP)
}

/// Runs of points for `lights` lights, `stride` bytes from a point to the next.
pub(super) fn point_chunks(
    split: &DispatchLimits,
    queries: u64,
    points: u32,
    lights: usize,
    stride: u64,
) -> Result<Vec<Range<u32>>, MemoryError> {
    let depths = 4 * lights as u64;
    let by_doubts = queries / lights.min(32) as u64;
    // The binding may begin a little before the first point.
    let by_points = split.binding.saturating_sub(256) / stride;
    let run = by_doubts.min(by_points).min(split.binding / depths) / POINTS * POINTS;
    if run == 0 {
        let bytes = POINTS * depths.max(stride).max(DOUBT * lights.min(32) as u64);
        return Err(MemoryError::Binding { what: "64 points", bytes, limit: split.binding });
    }
    Ok((0..points).step_by(run as usize).map(|first| first..first.saturating_add(run as u32).min(points)).collect())
}

/// Clusters that a dispatch of `queries` goes over, a multiple of a group.
pub(super) fn range_clusters(split: &DispatchLimits, work: u64, queries: u64) -> usize {
    let groups = work / (queries.max(1) * (GROUP * CLUSTER) as u64);
    // Counting anew may take a workgroup for each pair and group.
    let dispatched = split.workgroups * split.workgroups / queries.max(1);
    groups.min(dispatched).clamp(1, MOST_GROUPS) as usize * GROUP
}

/// Workgroups for `pairs` of point and light.
pub(super) fn workgroups(pairs: u64) -> u32 {
    pairs.div_ceil(WORKGROUP) as u32
}
