// Stencil bound: an upper bound of the stencil counts of each light in each view, so that a caller learns where the bits
// that count may not suffice. No count exceeds half of the weights that its half plane crosses, plus the faces of casters that the axis of
// the pencil may meet. A workgroup takes a light of a batch in a view.

@group(0) @binding(0) var<uniform> shape: ShadowShape;
// The first light of this batch, and the view.
@group(0) @binding(1) var<uniform> draw: ShadowDraw;
@group(0) @binding(2) var<storage, read> crossings: array<u32>;
@group(0) @binding(3) var<storage, read_write> shadow_statistics: ShadowStatistics;

// The largest bound of a batch of casters.
var<workgroup> largest: atomic<u32>;

fn bound_of_row(row: u32) -> u32 {
  var crossed = 0u;
  var most = 0u;
  for (var bin = 0u; bin < BINS; bin++) {
    crossed += crossings[row + bin];
    most = max(most, crossed);
  }
  return min(crossings[row + ALL_FACES], (most + 1u) / 2u + crossings[row + MET_FACES]);
}

@compute @workgroup_size(64)
fn stencil_bound(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
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
