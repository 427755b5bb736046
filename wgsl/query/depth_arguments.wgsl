// Depth arguments: makes the indirect dispatch of `exact_shadow_depth_recount` from the number of pairs of point and light that
// `shadow_depth` listed: a workgroup for each pair and each group of 1,024 faces of the range. Then it empties the list for the
// next range; the entries stay, and `recounts` says how many. Dispatched as one invocation, after `exact_shadow_depth` for each
// range.

#import query/records

@group(0) @binding(0) var<uniform> range: FaceRange;
@group(0) @binding(1) var<storage, read_write> undecided_pairs: UndecidedPairs;
@group(0) @binding(2) var<storage, read_write> dispatch: array<u32, 3>;

// The largest number of workgroups of a dispatch along x or y.
override MOST_WORKGROUPS: u32 = 65535u;

@compute @workgroup_size(1)
fn depth_arguments() {
  let recounts = atomicExchange(&undecided_pairs.listed, 0u);
  undecided_pairs.recounts = recounts;
  let groups = recounts * ((range.end - range.first + CLUSTER - 1u) / CLUSTER);
  dispatch[0] = min(groups, MOST_WORKGROUPS);
  dispatch[1] = (groups + MOST_WORKGROUPS - 1u) / MOST_WORKGROUPS;
  dispatch[2] = 1u;
}
