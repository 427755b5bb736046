// Stage `contour_marks`: marks the edges between samples that a contour crosses: the samples at their ends are of different
// surfaces. First in an encode with contours. One invocation for each word of marks, 16 samples of a row. Reads depths and
// objects. Writes `marks`, which `contour_tiles`, `contour_places`, `contour_walls` and the near cap of `depth_walls` read.
// A slope is no jump, however steep: surfaces must have no walls within, or they would have specks of their own shadow.
// Integers decide, so marks are the same on every device. docs/numerics/contours.md, "Jumps and places".

#import depth_map/contour
#import depth_map/edge_code
#import depth_map/samples

// For each sample two bits, for the edges to its right and below it, 16 samples a word. A row has words of its own.
@group(0) @binding(2) var<storage, read_write> marks: array<u32>;

const BLOCK: u32 = 256u;
const WORD_SAMPLES: i32 = 16;
// A surface counts as round if a fifth sample is off the conic by at most the square of the last difference over this.
const NEAR_CONIC: i32 = 8;

// Whether there is a jump between two samples of distances `a` and `b`, as far as these tell: 0 or 1; 2: ask `is_jump`.
fn told(at: vec2<i32>, step: vec2<i32>, a: i32, b: i32) -> u32 {
  if (a == FAR || b == FAR) {
    return select(0u, 1u, a != b);
  }
  if (OBJECTS && depth_map.objects != 0u && differs(vec2<u32>(at), vec2<u32>(at + step))) {
    return 1u;
  }
  return select(0u, 2u, abs(b - a) > contour.threshold);
}

// Whether a difference above the threshold is a jump, and not only a slope: it is more than the threshold larger than what the
// slopes to both sides tell. Unless it is above `contour.sure`, it must be twice as large as the differences beside it, too.
// Three samples of a plane, and a round surface before its rim, are no jump.
fn is_jump(at: vec2<i32>, step: vec2<i32>) -> bool {
  let a = distance_at(at);
  let b = distance_at(at + step);
  let difference = b - a;
  // From the nearer sample to the farther one.
  let is_rising = difference > 0;
  let away = select(-step, step, is_rising);
  let near = select(at + step, at, is_rising);
  let jump = abs(difference);
  let first = distance_at(near - away);
  let second = distance_at(near + 2 * away);
  let before = select(min(a, b) - first, 0, first == FAR);
  let after = select(second - max(a, b), FAR, second == FAR);
  // Three samples of a plane.
  if (min(abs(jump - before), abs(jump - after)) <= contour.threshold) {
    return false;
  }
  // A round surface bends away on its way to a rim, and rises still more there.
  if (after > jump && conic_before(near + away, away, NEAR_CONIC).u != UNTOLD) {
    return false;
  }
  let is_alone = max(before, after) / 2 < jump / 4;
  let slopes = max(slope_to_step(near, away), -slope_to_step(near + away, -away));
  return (jump > contour.sure || is_alone) && jump - slopes > contour.threshold;
}

// A workgroup takes further blocks of words only where the device may not have a workgroup for each.
@compute @workgroup_size(BLOCK)
fn contour_marks(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(num_workgroups) groups: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let lattice = vec2<i32>(depth_map.size) + 2;
  let count = contour.words * u32(lattice.y);
  let blocks = (count + BLOCK - 1u) / BLOCK;
  // Turns: 1.
  for (var block = group.x + groups.x * group.y; block < blocks; block += groups.x * groups.y) {
    let word = block * BLOCK + local;
    if (word < count) {
      let first = vec2<i32>(i32(word % contour.words) * WORD_SAMPLES, i32(word / contour.words));
      var bits = 0u;
      var open = 0u;
      var own = distance_at(first);
      // Two edges of each sample in turn.
      var right = own;
      for (var number = 0; number < 2 * WORD_SAMPLES; number++) {
        let at = first + vec2<i32>(number / 2, 0);
        let axis = u32(number) & 1u;
        let step = step_along(axis);
        let other = distance_at(at + step);
        if (axis == 0u) {
          right = other;
        }
        if (all(at + step < lattice) && at.x < lattice.x) {
          let state = told(at, step, own, other);
          bits |= (state & 1u) << u32(number);
          open |= (state >> 1u) << u32(number);
        }
        if (axis == 1u) {
          own = right;
        }
      }
      // The edges for which `told` was 2, one after another: some devices execute a loop's body for all invocations if one
      // needs it.
      // Turns: 32.
      for (; open != 0u; open &= open - 1u) {
        let number = firstTrailingBit(open);
        let at = first + vec2<i32>(i32(number / 2u), 0);
        bits |= select(0u, 1u << number, is_jump(at, step_along(number & 1u)));
      }
      marks[word] = bits;
    }
  }
}
