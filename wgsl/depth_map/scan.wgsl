// The scan of one workgroup. Imported by `depth_cells_scan`, `contour_tiles_list` and `contour_walls_scan`: each invocation
// takes a range of counts, adds them up, and learns the sum over the ranges before it.

// Invocations of the workgroup.
const SCAN_LANES: u32 = 256u;
var<workgroup> prefix_sums: array<u32, SCAN_LANES>;

// The sum of `count` over the invocations before `lane`. It has barriers, so all invocations must call it.
fn sum_before(lane: u32, count: u32) -> u32 {
  prefix_sums[lane] = count;
  for (var stride = 1u; stride < SCAN_LANES; stride *= 2u) {
    workgroupBarrier();
    var before = 0u;
    if (lane >= stride) {
      before = prefix_sums[lane - stride];
    }
    workgroupBarrier();
    prefix_sums[lane] += before;
  }
  return prefix_sums[lane] - count;
}
