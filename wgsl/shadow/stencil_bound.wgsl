// Stage `stencil_bound`: computes an upper bound of the stencil counts of each light in each view. The caller learns from
// it where the counting bits of the stencil may wrap around.
// Dispatched last, if the caller asks for a bound: a workgroup for each light and view, an invocation a count batch. A
// count batch is casters that the stencil counts together.
// Reads: rows of bins (shadow/half_plane_bins.wgsl), from `stencil_pencil`, `stencil_crossings` and `piece_crossings`.
// Writes: statistics.
// A bound may be too large and, but for the rounding of keys, never too small. docs/numerics/receivers.md, "Bound on
// counts".

#import shadow/half_plane_bins
#import shadow/shadow

@group(0) @binding(0) var<uniform> shape: ShadowShape; // The first group's: read only what all share.
@group(0) @binding(1) var<uniform> draw: ShadowDraw;
@group(0) @binding(2) var<storage, read> bin_rows: array<u32>; // The rows of all pencils.
@group(0) @binding(3) var<storage, read_write> shadow_statistics: ShadowStatistics;
var<workgroup> largest_bound: atomic<u32>; // Over the count batches of the light.

// Adds four bins to a prefix sum. x: the sum of all words so far, which is the weight that crosses the half planes of the
// last bin. y: the largest of these sums.
fn add_four_bins(sums: vec2<u32>, offset: u32) -> vec2<u32> {
  let one = sums.x + bin_rows[offset];
  let two = one + bin_rows[offset + 1u];
  let three = two + bin_rows[offset + 2u];
  let four = three + bin_rows[offset + 3u];
  return vec2<u32>(four, max(max(sums.y, one), max(two, max(three, four))));
}

fn add_eight_bins(sums: vec2<u32>, offset: u32) -> vec2<u32> {
  return add_four_bins(add_four_bins(sums, offset), offset + 4u);
}

// The bound from a row of bins.
fn bound_of_row(row: u32) -> u32 {
  var crossing_weight = 0u;
  var largest_crossing_weight = 0u;
  // Sixteen bins an iteration: a loop of a thousand iterations for each count batch would be too long.
  for (var bin = 0u; bin < BINS; bin += 16u) {
    let sums = add_eight_bins(add_eight_bins(vec2<u32>(crossing_weight, largest_crossing_weight), row + bin), row + bin + 8u);
    crossing_weight = sums.x;
    largest_crossing_weight = sums.y;
  }
  return min(bin_rows[row + ALL_FACES], (largest_crossing_weight + 1u) / 2u + bin_rows[row + AXIS_FACES]);
}

@compute @workgroup_size(64)
fn stencil_bound(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
  // Turns: COUNT_BATCHES / 64.
  for (var count_batch = thread; count_batch < shape.count_batches; count_batch += 64u) {
    atomicMax(&largest_bound, bound_of_row(row_offset(draw.view, draw.first_light + group.x, count_batch)));
  }
  workgroupBarrier();
  let bound = atomicLoad(&largest_bound);
  if (thread == 0u && bound > 0u) {
    atomicMax(&shadow_statistics.count_bound, bound);
    if (bound > shape.largest_count) {
      atomicAdd(&shadow_statistics.may_wrap, 1u);
    }
  }
}
