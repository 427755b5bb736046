// Stage `contour_marks`: marks the edges that a contour crosses, which are those between two samples of different surfaces.
// First dispatch with contours, once the map is there: an invocation for each word of marks, which is 16 samples of a row.
// Reads depths and objects. Writes `marks` for `contour_tiles`, `contour_crossings`, `contour_walls` and the near cap of
// `depth_walls`.
// A slope is no jump, however steep it is: walls within a surface would put specks of its own shadow on it.
// Integers decide, so marks are the same on every device. docs/numerics/contours.md, "Jumps and crossings".

#import depth_map/contour
#import depth_map/edge_code
#import depth_map/samples

// Two bits for each sample, 16 samples in a word: whether the edge to its right and the edge below it are marked. Rows begin
// with a new word.
@group(0) @binding(2) var<storage, read_write> marks: array<u32>;

const BLOCK: u32 = 256u;
const WORD_SAMPLES: i32 = 16;
// The strictness of `fit_conic` for surfaces that count as round.
const ROUND_STRICTNESS: i32 = 8;

// Whether there is a jump between two samples of distances `a` and `b`: 0 no, 1 yes, 2 if only `is_jump` can decide.
fn jump_state(sample: vec2<i32>, step: vec2<i32>, a: i32, b: i32) -> u32 {
  if (a == FAR || b == FAR) {
    return select(0u, 1u, a != b);
  }
  if (OBJECTS && depth_map.has_objects != 0u && is_object_edge(vec2<u32>(sample), vec2<u32>(sample + step))) {
    return 1u;
  }
  return select(0u, 2u, abs(b - a) > contour.threshold);
}

// Whether a difference above the threshold is a jump, not only a slope. Neither sample may be far. A jump is larger than the
// slopes on both sides by more than the threshold. It is above `contour.certain_threshold`, or at least about twice as large as
// the differences beside it, which count in its direction: 0 if the sample before is far, FAR if the one after is.
// Three samples of a plane, and a round surface before its rim, have no jump.
fn is_jump(sample: vec2<i32>, step: vec2<i32>) -> bool {
  let a = load_distance(sample);
  let b = load_distance(sample + step);
  let difference = b - a;
  // `away` leads from the nearer sample, `near`, to the farther one.
  let is_rising = difference > 0;
  let away = select(-step, step, is_rising);
  let near = select(sample + step, sample, is_rising);
  let jump = abs(difference);
  let first = load_distance(near - away);
  let second = load_distance(near + 2 * away);
  let before = select(min(a, b) - first, 0, first == FAR);
  let after = select(second - max(a, b), FAR, second == FAR);
  // Three samples of a plane.
  if (min(abs(jump - before), abs(jump - after)) <= contour.threshold) {
    return false;
  }
  // A round surface bends away before its rim, so its differences grow.
  if (after > jump && fit_conic(near + away, away, ROUND_STRICTNESS).last_difference != UNKNOWN) {
    return false;
  }
  let is_twice_as_large = max(before, after) / 2 < jump / 4;
  let slopes = max(backward_slope(near, away), -backward_slope(near + away, -away));
  return (jump > contour.certain_threshold || is_twice_as_large) && jump - slopes > contour.threshold;
}

// A workgroup takes more than one block of words only where the device does not allow a workgroup for each.
@compute @workgroup_size(BLOCK)
fn contour_marks(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) dispatch_size: vec3<u32>,
  @builtin(local_invocation_index) lane: u32,
) {
  let lattice = vec2<i32>(depth_map.size) + 2;
  let word_count = contour.words * u32(lattice.y);
  let blocks = (word_count + BLOCK - 1u) / BLOCK;
  // Turns: 1.
  for (var block = workgroup.x + dispatch_size.x * workgroup.y; block < blocks; block += dispatch_size.x * dispatch_size.y) {
    let word = block * BLOCK + lane;
    if (word < word_count) {
      let first = vec2<i32>(i32(word % contour.words) * WORD_SAMPLES, i32(word / contour.words));
      var marked = 0u;
      var undecided = 0u;
      var distance = load_distance(first);
      // Even bits are edges to the right, odd ones edges down.
      var right = distance;
      for (var bit = 0; bit < 2 * WORD_SAMPLES; bit++) {
        let sample = first + vec2<i32>(bit / 2, 0);
        let axis = u32(bit) & 1u;
        let step = step_along(axis);
        let neighbour = load_distance(sample + step);
        if (axis == 0u) {
          right = neighbour;
        }
        if (all(sample + step < lattice)) {
          let state = jump_state(sample, step, distance, neighbour);
          marked |= (state & 1u) << u32(bit);
          undecided |= (state >> 1u) << u32(bit);
        }
        if (axis == 1u) {
          distance = right;
        }
      }
      // Undecided edges have a loop of their own, because some devices execute a loop's body for all invocations if one
      // needs it.
      // Turns: 32.
      for (; undecided != 0u; undecided &= undecided - 1u) {
        let bit = firstTrailingBit(undecided);
        let sample = first + vec2<i32>(i32(bit / 2u), 0);
        marked |= select(0u, 1u << bit, is_jump(sample, step_along(bit & 1u)));
      }
      marks[word] = marked;
    }
  }
}
