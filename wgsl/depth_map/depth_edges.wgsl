// Depth edges: marks edges between samples, continues those that dangle, and decides about cells from the marks. It takes the
// place of the first pass of depth cells, for detectors that look farther than an edge. Words are those of edge_marks.wgsl.

@group(0) @binding(8) var<storage, read_write> edges: array<u32>;
// Edges that are marked if they continue others.
@group(0) @binding(9) var<storage, read_write> faint_edges: array<u32>;

// Whether edges are continued.
override CONTINUES: bool = true;

const WORD_SAMPLES: u32 = 16u;

// To the right, or down.
fn step_of(axis: u32) -> vec2<u32> {
  return select(vec2<u32>(1u, 0u), vec2<u32>(0u, 1u), axis == 1u);
}

// Workgroups take blocks in turn, where a dispatch may not have as many.
@compute @workgroup_size(BLOCK)
fn depth_edges_mark(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(num_workgroups) groups: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  for (var block = group.x + groups.x * group.y; block < edge_rule.blocks; block += groups.x * groups.y) {
    let word = block * BLOCK + local;
    if (word >= edge_rule.words.x * edge_rule.words.y) {
      continue;
    }
    let corner = vec2<u32>(word % edge_rule.words.x * WORD_SAMPLES, word / edge_rule.words.x);
    let levels = select(1u, 2u, CONTINUES);
    // For each level.
    var marked = vec2<u32>(0u);
    var open = vec2<u32>(0u);
    for (var number = 0u; number < 2u * WORD_SAMPLES; number++) {
      let at = corner + vec2<u32>(number % WORD_SAMPLES, 0u);
      let step = step_of(number / WORD_SAMPLES);
      if (any(at >= lattice()) || leaves_map(at, step)) {
        continue;
      }
      let keys = keys_along(at, step);
      var is_marked = false;
      if (OBJECTS && depth_map.objects != 0u && max(keys.y, keys.z) != FAR_KEY) {
        is_marked = differs(at, at + step);
      }
      for (var level = 0u; level < levels; level++) {
        let state = told(keys, level);
        marked[level] |= select(0u, 1u << number, is_marked || state == 1u);
        open[level] |= select(0u, 1u << number, !is_marked && state == 2u);
      }
    }
    for (var level = 0u; level < levels; level++) {
      for (var left = open[level]; left != 0u; left &= left - 1u) {
        let number = firstTrailingBit(left);
        let keys = keys_along(corner + vec2<u32>(number % WORD_SAMPLES, 0u), step_of(number / WORD_SAMPLES));
        marked[level] |= select(0u, 1u << number, exactly(keys, level));
      }
    }
    edges[word] = marked.x;
    if (CONTINUES) {
      faint_edges[word] = marked.y;
    }
  }
}

// Marks the faint edges of the cells that have one marked edge.
@compute @workgroup_size(BLOCK)
fn depth_edges_continue(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(num_workgroups) groups: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  for (var block = group.x + groups.x * group.y; block < edge_rule.blocks; block += groups.x * groups.y) {
    let word = block * BLOCK + local;
    if (word >= edge_rule.words.x * edge_rule.words.y) {
      continue;
    }
    let at = vec2<i32>(vec2<u32>(word % edge_rule.words.x * WORD_SAMPLES, word / edge_rule.words.x));
    // The cells below the samples and above them, from that on the left of the first.
    let below = dangling_from(at - vec2<i32>(1, 0));
    let above = dangling_from(at - vec2<i32>(1, 1));
    let across = ((below | above) >> 1u) & 0xffffu;
    let down = (below | (below >> 1u)) & 0xffffu;
    edges[word] = edges_before[word] | (faint_edges[word] & (across | (down << 16u)));
  }
}

// Each bit of eight is moved to a word's part of four.
fn apart(bits: u32) -> u32 {
  let pairs = (bits & 0x0fu) | ((bits & 0xf0u) << 12u);
  let twos = (pairs & 0x00030003u) | ((pairs & 0x000c000cu) << 6u);
  return (twos & 0x01010101u) | ((twos & 0x02020202u) << 3u);
}

// As `decided`, from marks.
fn decided_by_marks(word: u32) -> u32 {
  let own = cells_of_word(word);
  let corner = own.zw;
  let at = vec2<i32>(corner);
  let down = vec2<u32>(0u, 1u);
  var before = vec2<u32>(key_at(corner), key_at(corner + down));
  // A bit for each sample above and below, from that of the first cell on.
  var casts = vec2<u32>(select(0u, 1u, before.x != FAR_KEY), select(0u, 1u, before.y != FAR_KEY));
  var split = 0u;
  for (var cell = 0u; cell < WORD_CELLS; cell++) {
    let right = corner + vec2<u32>(cell + 1u, 0u);
    let keys = vec2<u32>(key_at(right), key_at(right + down));
    casts |= select(vec2<u32>(0u), vec2<u32>(2u << cell), keys != vec2<u32>(FAR_KEY));
    split |= select(0u, 1u << cell, is_split(vec4<u32>(before.x, keys.x, before.y, keys.y)));
    before = keys;
  }
  let upper = rings_from(at) & casts.x;
  let lower = rings_from(at + vec2<i32>(0, 1)) & casts.y;
  let left = marks_from(at, 1u);
  let right = marks_from(at + vec2<i32>(1, 0), 1u);
  let diagonal = select_bits(upper | (lower >> 1u), lower | (upper >> 1u), split);
  let first = marks_from(at, 0u) | diagonal | select_bits(right | (upper >> 1u), left | upper, split);
  let second = marks_from(at + vec2<i32>(0, 1), 0u) | diagonal | select_bits(left | lower, right | (lower >> 1u), split);
  let taken = (1u << own.y) - 1u;
  return apart(split & taken) | (apart(either(first, second) & taken) << 1u) | (apart(either(second, first) & taken) << 2u);
}

fn select_bits(otherwise: u32, taken: u32, bits: u32) -> u32 {
  return (otherwise & ~bits) | (taken & bits);
}

// As `depth_cells_count`.
@compute @workgroup_size(DECIDERS)
fn depth_edges_count(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(num_workgroups) groups: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  for (var block = group.x + groups.x * group.y; block < depth_map.blocks; block += groups.x * groups.y) {
    var listed = 0u;
    for (var number = local; number < BLOCK; number += DECIDERS) {
      listed += write_word(block, number, decided_by_marks(block * BLOCK + number));
    }
    write_total(block, local, listed);
  }
}
