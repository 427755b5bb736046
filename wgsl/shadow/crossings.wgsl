// Rows of weights that cross the half planes of a pencil.

#import shadow/pencil

@group(0) @binding(8) var<storage, read_write> crossings: array<atomic<u32>>;

// Adds the weight to the bins from `first` to `last`.
fn cross_bins(row: u32, first: u32, last: u32, weight: u32) {
  atomicAdd(&crossings[row + first], weight);
  atomicSub(&crossings[row + last + 1u], weight);
}

fn bin(by: StencilPencil, at: f32) -> u32 {
  return u32(clamp((at - by.first) * by.scale, 0.0, f32(BINS - 1u)));
}

fn cross_edge(by: StencilPencil, row: u32, a: vec3<f32>, b: vec3<f32>, weight: u32) {
  let p = half_plane(by, a);
  let q = half_plane(by, b);
  let first = bin(by, min(p, q));
  let last = bin(by, max(p, q));
  // An edge that does not meet the axis goes the shorter way around it.
  if (by.kind == AROUND && abs(p - q) > 2.0) {
    cross_bins(row, 0u, first, weight);
    cross_bins(row, last, BINS - 1u, weight);
  } else {
    cross_bins(row, first, last, weight);
  }
}
