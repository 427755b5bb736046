// Contour places: where on a marked edge the contour crosses it, from the run of edges that it crosses in a row.

// For each sample of the lattice the places on the edges to its right and below it, 16 bits each, in parts of 65,536 of a texel.
// 0: not marked.
@group(0) @binding(3) var<storage, read_write> places: array<u32>;

const BLOCK: u32 = 256u;
// Cells that a run is followed along, to each side.
const REACH: i32 = 32;
// Edges within which a run that turns to the same side at both ends leaves this side.
const RAMP: i32 = 4;

// Follows a run through its cells. Edges that it crosses further, and the place that it turns to: the first sample's, the
// second's, or the middle.
fn followed(start: vec2<i32>, out: u32) -> vec2<i32> {
  var cell = start;
  let first = select(3u, 0u, (out & 1u) == 1u);
  for (var crossed = 0; crossed < REACH; crossed++) {
    let others = code_of_cell(cell) & ~(1u << ((out + 2u) & 3u));
    if (others != (1u << out)) {
      let second = (first + 2u) & 3u;
      return vec2<i32>(crossed, select(select(TEXEL / 2, TEXEL, others == (1u << second)), 0, others == (1u << first)));
    }
    cell += out_of(out);
  }
  return vec2<i32>(REACH, TEXEL / 2);
}

fn place_on(at: vec2<i32>, axis: u32) -> i32 {
  // The cells to both sides: above and below, or to the left and right.
  var runs: array<vec2<i32>, 2>;
  for (var side = 0u; side < 2u; side++) {
    let out = select(2u * side, 3u - 2u * side, axis == 1u);
    runs[side] = followed(select(at + out_of(out), at, side == 1u), out);
  }
  let count = runs[0].x + runs[1].x + 1;
  let start = runs[0].y;
  let end = runs[1].y;
  let ramp = min(count, 2 * RAMP);
  let leaving = start + (TEXEL / 2 - start) * min(2 * min(runs[0].x, runs[1].x) + 1, ramp) / ramp;
  let crossing = start + (end - start) * (2 * runs[0].x + 1) / (2 * count);
  return clamp(select(crossing, leaving, start == end), LEAST, TEXEL - LEAST);
}

@compute @workgroup_size(BLOCK)
fn contour_places(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(num_workgroups) groups: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let lattice = depth_map.size + 2u;
  let count = lattice.x * lattice.y;
  let blocks = (count + BLOCK - 1u) / BLOCK;
  for (var block = group.x + groups.x * group.y; block < blocks; block += groups.x * groups.y) {
    let sample = block * BLOCK + local;
    if (sample < count) {
      let at = vec2<i32>(vec2<u32>(sample % lattice.x, sample / lattice.x));
      let marked = marks_at(at);
      var word = 0u;
      for (var axis = 0u; axis < 2u; axis++) {
        if (((marked >> axis) & 1u) == 1u) {
          word |= u32(place_on(at, axis)) << (16u * axis + 8u);
        }
      }
      places[sample] = word;
    }
  }
}
