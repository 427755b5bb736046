// Contour marks: which edges of the lattice a contour crosses.

// For each sample two bits, for the edges to its right and below it, 16 samples a word. A row has words of its own.
@group(0) @binding(2) var<storage, read_write> marks: array<u32>;

const BLOCK: u32 = 256u;
const WORD_SAMPLES: i32 = 16;

// Whether there is a jump between two samples, and not only a slope. A jump that is not sure does not count beside one that is twice as large.
fn is_jump(at: vec2<i32>, step: vec2<i32>, a: i32, b: i32) -> bool {
  if (a == FAR || b == FAR) {
    return a != b;
  }
  if (OBJECTS && depth_map.objects != 0u && differs(vec2<u32>(at), vec2<u32>(at + step))) {
    return true;
  }
  let difference = b - a;
  if (abs(difference) <= contour.threshold) {
    return false;
  }
  let is_rising = difference > 0;
  let before = slope_to_step(at, step);
  let after = -slope_to_step(at + step, -step);
  let beyond = distance_at(select(at - step, at + 2 * step, is_rising));
  let next = select(beyond - max(a, b), FAR, beyond == FAR);
  let is_alone = abs(difference) > contour.sure || next / 2 < abs(difference);
  let over_before = select(before - difference, difference - before, is_rising);
  let over_after = select(after - difference, difference - after, is_rising);
  return is_alone && over_before > contour.threshold && over_after > contour.threshold;
}

// Workgroups take blocks of words in turn, where a dispatch may not have as many.
@compute @workgroup_size(BLOCK)
fn contour_marks(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(num_workgroups) groups: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let lattice = vec2<i32>(depth_map.size) + 2;
  let count = contour.words * u32(lattice.y);
  let blocks = (count + BLOCK - 1u) / BLOCK;
  for (var block = group.x + groups.x * group.y; block < blocks; block += groups.x * groups.y) {
    let word = block * BLOCK + local;
    if (word < count) {
      let first = vec2<i32>(i32(word % contour.words) * WORD_SAMPLES, i32(word / contour.words));
      var bits = 0u;
      var own = distance_at(first);
      // One copy of what decides: two edges of each sample in turn.
      var right = own;
      for (var number = 0; number < 2 * WORD_SAMPLES; number++) {
        let at = first + vec2<i32>(number / 2, 0);
        let axis = u32(number) & 1u;
        let step = step_along(axis);
        let other = distance_at(at + step);
        if (axis == 0u) {
          right = other;
        }
        if (all(at + step < lattice) && at.x < lattice.x && is_jump(at, step, own, other)) {
          bits |= 1u << u32(number);
        }
        if (axis == 1u) {
          own = right;
        }
      }
      marks[word] = bits;
    }
  }
}
