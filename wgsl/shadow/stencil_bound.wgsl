// Stencil bound: a compute stage that bounds the stencil counts of each light in each view from above, so that a caller learns
// where the bits that count may not suffice. Dispatched last, if the caller asks for a bound, one workgroup for each light and
// view, an invocation a batch of casters that count together. It reads the rows that `stencil_pencil`, `stencil_crossings` and
// `piece_crossings` made (shadow/pencil.wgsl), and writes statistics, which the caller reads. No count exceeds half of the
// weights that its half plane crosses, plus the faces of casters that the line of the pencil may meet: a bound may be too large,
// never too small. docs/numerics/receivers.md, "Bound on counts".

#import shadow/pencil
#import shadow/shadow

@group(0) @binding(0) var<uniform> shape: ShadowShape;
@group(0) @binding(1) var<uniform> draw: ShadowDraw;
@group(0) @binding(2) var<storage, read> crossings: array<u32>;
@group(0) @binding(3) var<storage, read_write> shadow_statistics: ShadowStatistics;
// The largest bound of a batch of casters.
var<workgroup> largest: atomic<u32>;

// `sums`: the sum of the words up to a bin, which is the weight that crosses it, and the largest so far; here after four more
// bins.
fn after_four(sums: vec2<u32>, at: u32) -> vec2<u32> {
  let one = sums.x + crossings[at];
  let two = one + crossings[at + 1u];
  let three = two + crossings[at + 2u];
  let four = three + crossings[at + 3u];
  return vec2<u32>(four, max(max(sums.y, one), max(two, max(three, four))));
}

fn after_eight(sums: vec2<u32>, at: u32) -> vec2<u32> { return after_four(after_four(sums, at), at + 4u); }

// The bound of a row: the largest sum up to any bin.
fn bound_of_row(row: u32) -> u32 {
  var crossed = 0u;
  var most = 0u;
  // Sixteen at a time, since a loop of a thousand turns for each batch would be long.
  for (var bin = 0u; bin < BINS; bin += 16u) {
    let sums = after_eight(after_eight(vec2<u32>(crossed, most), row + bin), row + bin + 8u);
    crossed = sums.x;
    most = sums.y;
  }
  return min(crossings[row + ALL_FACES], (most + 1u) / 2u + crossings[row + MET_FACES]);
}

@compute @workgroup_size(64)
fn stencil_bound(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
  // Turns: COUNT_BATCHES / 64.
  for (var count_batch = thread; count_batch < shape.count_batches; count_batch += 64u) {
    atomicMax(&largest, bound_of_row(row_of(draw.view, draw.first_light + group.x, count_batch)));
  }
  workgroupBarrier();
  let bound = atomicLoad(&largest);
  if (thread == 0u && bound > 0u) {
    atomicMax(&shadow_statistics.count_bound, bound);
    if (bound > shape.most_count) {
      atomicAdd(&shadow_statistics.may_wrap, 1u);
    }
  }
}
