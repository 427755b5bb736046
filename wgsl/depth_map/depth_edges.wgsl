// Stage `depth_edges`: marks edges between neighbouring samples of a depth map, continues those that dangle (end in a cell
// without another marked edge), and decides about cells from the marks. It replaces `depth_cells_count` for detectors that
// look beside an edge or continue edges. First in an encode, but after `depth_cube`.
// `depth_edges_mark`, one invocation for 16 × 4 samples, reads depths and objects and writes `edges`, `faint_edges`,
// `sample_bits`. `depth_edges_continue`, one invocation a word of 16 samples, runs up to 64 times; two buffers of marks take
// turns. It adds marks only, so the order of cells does not matter. `depth_edges_count`, a workgroup for blocks of cells in
// turn, reads marks and `sample_bits` and writes `places` (cell_words.wgsl) for `depth_cells_places` and `depth_cells_list`.
// Marks are exact. A word of marks has a bit for the edge to the right of each of 16 samples of a row, and 16 bits higher one
// for the edge below it.

#import depth_map/cell_words
#import depth_map/edge_code
#import depth_map/samples

// The rule of detectors that look beside an edge (second differences) or continue edges.
// `told` decides by floats, only where rounding cannot matter: 0 or 1. Where it may, it gives 2, and the caller asks
// `exactly`, which decides by integers. So marks are exact and the same on every device. Only the two together may be changed.
// Level 0 is the detector's own rule. Level 1 has lower thresholds, for edges that continue one that dangles.

// How edges are marked. Pairs have a value for each level.
struct DepthEdgeRule {
  // Words of marks in a row of samples, and rows.
  words: vec2<u32>,
  // Blocks of 256 words.
  blocks: u32,
  // Bits of the threshold above which every difference is marked.
  high: u32,
  // Bits of the threshold up to which no difference is marked.
  low: vec2<u32>,
  // Bits of how many times the difference beside it a difference is.
  slopes: vec2<u32>,
  // Bits of what two differences may be off by: a constant, and the depth with so many exponents less. 0: no share of the
  // depth.
  noise: u32,
  noise_exponents: u32,
}

@group(0) @binding(6) var<uniform> edge_rule: DepthEdgeRule;

// How the differences beside an edge, in its row or column, count. 0: not, all above the threshold are marked. 1: a difference
// is marked that is larger than both beside it. 2: one that is larger than one of them, with no other threshold.
override SECOND: u32 = 0u;

// Words of an integer in units of 2⁻²⁹⁸, lowest first, negative as two's complement.
const WIDE: u32 = 14u;
// Products of a sum.
const TERMS: u32 = 5u;
const MINUS: u32 = 0x80000000u;

// The mantissa of a float that is 0 or normal, and how many places it is moved up, in units of 2⁻¹⁴⁹.
fn mantissa_and_places(bits: u32) -> vec2<u32> {
  let exponent = (bits >> 23u) & 0xffu;
  return vec2<u32>(select((bits & 0x7fffffu) | 0x800000u, 0u, exponent == 0u), max(exponent, 1u) - 1u);
}

// The product of two numbers below 2²⁴: low and high word.
fn wide_product(a: u32, b: u32) -> vec2<u32> {
  let low = (a & 0xffffu) * (b & 0xffffu);
  let middle = (a & 0xffffu) * (b >> 16u) + (a >> 16u) * (b & 0xffffu);
  let sum = low + (middle << 16u);
  return vec2<u32>(sum, (a >> 16u) * (b >> 16u) + (middle >> 16u) + select(0u, 1u, sum < low));
}

// Whether a sum of products of two floats is above 0.
fn is_positive(terms: array<vec2<u32>, TERMS>) -> bool {
  var factors = terms;
  var sum = array<u32, WIDE>();
  for (var term = 0u; term < opaque(TERMS); term++) {
    let own = factors[term];
    let a = mantissa_and_places(own.x);
    let b = mantissa_and_places(own.y);
    let mantissa = wide_product(a.x, b.x);
    let first = (a.y + b.y) >> 5u;
    let shift = (a.y + b.y) & 31u;
    let carried = vec2<u32>(32u - shift) & vec2<u32>(31u);
    let over = select(mantissa >> carried, vec2<u32>(0u), shift == 0u);
    let digits = vec3<u32>(mantissa.x << shift, (mantissa.y << shift) | over.x, over.y);
    // A negative product is added as the complement, and one.
    let sign = (own.x ^ own.y) >> 31u;
    var carry = sign;
    for (var word = 0u; word < opaque(WIDE); word++) {
      let at = word - first;
      let digit = select(select(select(0u, digits.z, at == 2u), digits.y, at == 1u), digits.x, at == 0u) ^ (0u - sign);
      let once = sum[word] + digit;
      let twice = once + carry;
      carry = select(0u, 1u, once < digit) | select(0u, 1u, twice < once);
      sum[word] = twice;
    }
  }
  var any = 0u;
  for (var word = 0u; word < opaque(WIDE); word++) {
    any |= sum[word];
  }
  return any != 0u && sum[WIDE - 1u] < MINUS;
}

// Samples of the lattice across, and down.
fn lattice() -> vec2<u32> {
  return select(depth_map.size + 2u, vec2<u32>(3u, 2u) * depth_map.size, depth_map.faces > 1u);
}

// Whether a step to the right or down leads to another map of a cube.
fn leaves_map(at: vec2<u32>, by: vec2<u32>) -> bool {
  return depth_map.faces > 1u && any(at % depth_map.size + by >= depth_map.size);
}

// The samples before an edge, at its ends and after it, from left to right or from the top. Beside a map nothing casts.
fn keys_along(at: vec2<u32>, step: vec2<u32>) -> vec4<u32> {
  let before = select(load_key(at - step), FAR_KEY, depth_map.faces > 1u && any(at % depth_map.size < step));
  let after = select(load_key(at + 2u * step), FAR_KEY, leaves_map(at, 2u * step));
  return vec4<u32>(before, load_key(at), load_key(at + step), after);
}

// Bits of what the difference of two depths may be off by. `large`: bits of the larger.
fn noise_at(large: u32) -> u32 {
  let exponents = edge_rule.noise_exponents << 23u;
  let share = select(0u, large - exponents, exponents != 0u && large >= exponents + 0x00800000u);
  return max(edge_rule.noise, share);
}

// The two ends of the step before an edge, or after it. They are equal if it goes the other way than the edge, or a side is
// far.
fn step_beside(keys: vec4<u32>, is_after: bool) -> vec2<u32> {
  let beside = select(keys.xy, keys.zw, is_after);
  let same_way = (beside.x < beside.y) == (keys.y < keys.z);
  return select(vec2<u32>(0u), vec2<u32>(depth_bits(beside.x), depth_bits(beside.y)), same_way && max(beside.x, beside.y) != FAR_KEY);
}

fn float_distance(bits: vec2<u32>) -> f32 {
  return abs(bitcast<f32>(bits.x) - bitcast<f32>(bits.y));
}

// Whether the difference at an edge is larger than multiples of both beside it, or of one, and noise: 0 or 1; or 2, where
// floats do not tell.
fn bends_by_floats(keys: vec4<u32>, ends: vec2<u32>, slopes: u32) -> u32 {
  let before = float_distance(step_beside(keys, false));
  let after = float_distance(step_beside(keys, true));
  let step = float_distance(ends);
  let beside = select(max(before, after), min(before, after), SECOND == 2u);
  let most = bitcast<f32>(slopes) * beside + bitcast<f32>(noise_at(max(ends.x, ends.y)));
  let is_told = (step + most > 1e-30) & (abs(step - most) > 1e-5 * (step + most));
  return select(2u, select(0u, 1u, step > most), is_told);
}

// `bends_by_floats` for one side, exactly: bits of the ends of the edge, and of the step beside it.
fn bends(ends: vec2<u32>, beside: vec2<u32>, slopes: u32) -> bool {
  let noise = noise_at(max(ends.x, ends.y));
  return is_positive(array<vec2<u32>, TERMS>(
    vec2<u32>(ONE, max(ends.x, ends.y)), vec2<u32>(ONE, min(ends.x, ends.y) | MINUS),
    vec2<u32>(slopes, max(beside.x, beside.y) | MINUS), vec2<u32>(slopes, min(beside.x, beside.y)),
    vec2<u32>(ONE, noise | MINUS)));
}

// Whether an edge is marked, by the keys of `keys_along`: 0 or 1; or 2, where it is left to `exactly`.
fn told(keys: vec4<u32>, level: u32) -> u32 {
  let ends = vec2<u32>(depth_bits(keys.y), depth_bits(keys.z));
  let large = max(ends.x, ends.y);
  let small = min(ends.x, ends.y);
  var state = 2u;
  if (SECOND == 2u) {
    state = bends_by_floats(keys, ends, edge_rule.slopes[level]);
  } else {
    let is_step = exceeds(large, small, edge_rule.low[level]);
    state = select(0u, 1u, is_step);
    if (SECOND == 1u) {
      let is_sure = !is_step || exceeds(large, small, edge_rule.high);
      state = select(bends_by_floats(keys, ends, edge_rule.slopes[level]), state, is_sure);
    }
  }
  return select(state, select(0u, 1u, keys.y != keys.z), max(keys.y, keys.z) == FAR_KEY || keys.y == keys.z);
}

// Whether an edge is marked for which `told` gives 2. It is never asked for far samples or equal keys.
fn exactly(keys: vec4<u32>, level: u32) -> bool {
  let ends = vec2<u32>(depth_bits(keys.y), depth_bits(keys.z));
  var count = 0u;
  for (var side = 0u; side < opaque(2u); side++) {
    count += select(0u, 1u, bends(ends, step_beside(keys, side == 1u), edge_rule.slopes[level]));
  }
  return count >= select(1u, 2u, SECOND == 1u);
}

@group(0) @binding(8) var<storage, read_write> edges: array<u32>;
// Edges that are marked if they continue others.
@group(0) @binding(9) var<storage, read_write> faint_edges: array<u32>;

// Whether edges are continued.
override CONTINUES: bool = true;

const BLOCK: u32 = 256u;
const WORD_SAMPLES: u32 = 16u;
const MARKERS: u32 = 64u;

// To the right, or down.
fn step_of(axis: u32) -> vec2<u32> {
  return select(vec2<u32>(1u, 0u), vec2<u32>(0u, 1u), axis == 1u);
}

// The word that a strip of marks (not of cells) begins at: four words below each other, which an invocation walks along at
// once, so that few samples are loaded again.
fn strip_at(strip: u32) -> vec2<u32> {
  return vec2<u32>(strip % edge_rule.words.x, strip / edge_rule.words.x * STRIP);
}

// The keys of a strip's samples in a column, and of one above and two below them.
struct Column {
  own: vec4<u32>,
  beyond: vec3<u32>,
}

fn column_at(at: vec2<u32>) -> Column {
  let down = vec2<u32>(0u, 1u);
  return Column(
    vec4<u32>(load_key(at), load_key(at + down), load_key(at + 2u * down), load_key(at + 3u * down)),
    vec3<u32>(load_key(at - down), load_key(at + 4u * down), load_key(at + 5u * down)));
}

// Four edges beside each other, by the samples before them, at their ends and after them.
struct Edges {
  before: vec4<u32>,
  first: vec4<u32>,
  second: vec4<u32>,
  after: vec4<u32>,
}

// `told` for each of them.
fn told_each(line: Edges, level: u32) -> vec4<u32> {
  return vec4<u32>(
    told(vec4<u32>(line.before.x, line.first.x, line.second.x, line.after.x), level),
    told(vec4<u32>(line.before.y, line.first.y, line.second.y, line.after.y), level),
    told(vec4<u32>(line.before.z, line.first.z, line.second.z, line.after.z), level),
    told(vec4<u32>(line.before.w, line.first.w, line.second.w, line.after.w), level));
}

// Which of the edges lie between two objects. `at`: the first sample of the first.
fn differ(line: Edges, at: vec2<u32>, step: vec2<u32>) -> vec4<bool> {
  var result = vec4<bool>(false);
  if (OBJECTS && depth_map.objects != 0u) {
    // A loop that is not unrolled has one copy of what it loads.
    for (var row = 0u; row < opaque(STRIP); row++) {
      let first = at + vec2<u32>(0u, row);
      result[row] = max(line.first[row], line.second[row]) != FAR_KEY && is_object_edge(first, first + step);
    }
  }
  return result;
}

// Words of a strip: edges that are marked, and those that are left to `exactly`.
struct Marks {
  marked: vec4<u32>,
  open: vec4<u32>,
}

fn with_states(marks: Marks, states: vec4<u32>, place: u32) -> Marks {
  let places = vec4<u32>(place);
  return Marks(marks.marked | ((states & vec4<u32>(1u)) << places), marks.open | ((states >> vec4<u32>(1u)) << places));
}

// Writes the marks of a strip, at both levels if edges are continued, and which of its samples cast and cells are split.
fn mark_strip(strip: u32) {
  let word = strip_at(strip);
  let corner = vec2<u32>(word.x * WORD_SAMPLES, word.y);
  let far = vec4<u32>(FAR_KEY);
  // Maps of a cube lie beside each other, and no edge leads from one to the next.
  let side = select(vec2<u32>(0x40000000u), depth_map.size, depth_map.faces > 1u);
  let rows = (corner.y + vec4<u32>(0u, 1u, 2u, 3u)) % side.y;
  let leaves_down = rows + 1u == vec4<u32>(side.y);
  // The column of `here` within its map.
  var column = corner.x % side.x;
  var here: Column;
  var next: Column;
  var after: Column;
  var own: Marks;
  var faint: Marks;
  var bits = vec4<u32>(0u);
  // It walks three columns ahead.
  for (var number = 0u; number < WORD_SAMPLES + 3u; number++) {
    let before = here.own;
    here = next;
    next = after;
    after = column_at(corner + vec2<u32>(number, 0u) - vec2<u32>(1u, 0u));
    if (number < 3u) {
      continue;
    }
    let place = number - 3u;
    let at = corner + vec2<u32>(place, 0u);
    let below = vec4<u32>(here.own.yzw, here.beyond.y);
    for (var turn = 0u; turn < 2u; turn++) {
      var line = Edges(select(before, far, column == 0u), here.own, next.own, select(after.own, far, column + 2u >= side.x));
      var never = vec4<bool>(column + 1u == side.x || at.x >= lattice().x);
      if (turn == 1u) {
        line.before = select(vec4<u32>(here.beyond.x, here.own.xyz), far, rows == vec4<u32>(0u));
        line.second = below;
        line.after = select(vec4<u32>(here.own.zw, here.beyond.yz), far, rows + 2u >= vec4<u32>(side.y));
        never = leaves_down | vec4<bool>(at.x >= lattice().x);
      }
      let always = differ(line, at, step_of(turn));
      let states = select(told_each(line, 0u), vec4<u32>(1u), always);
      own = with_states(own, select(states, vec4<u32>(0u), never), place + 16u * turn);
      if (CONTINUES) {
        let lower = select(told_each(line, 1u), vec4<u32>(1u), always);
        faint = with_states(faint, select(lower, vec4<u32>(0u), never), place + 16u * turn);
      }
    }
    let next_below = vec4<u32>(next.own.yzw, next.beyond.y);
    let split = vec4<bool>(
      is_split(vec4<u32>(here.own.x, next.own.x, below.x, next_below.x)),
      is_split(vec4<u32>(here.own.y, next.own.y, below.y, next_below.y)),
      is_split(vec4<u32>(here.own.z, next.own.z, below.z, next_below.z)),
      is_split(vec4<u32>(here.own.w, next.own.w, below.w, next_below.w)));
    let casts = select(vec4<u32>(1u), vec4<u32>(0u), here.own == far);
    bits |= (casts | select(vec4<u32>(0u), vec4<u32>(0x10000u), split)) << vec4<u32>(place);
    column = select(column + 1u, 0u, column + 1u == side.x);
  }
  own.marked |= settled(corner, own.open, 0u);
  if (CONTINUES) {
    faint.marked |= settled(corner, faint.open, 1u);
  }
  // Turns: STRIP.
  for (var row = 0u; row < min(STRIP, edge_rule.words.y - word.y); row++) {
    let index = (word.y + row) * edge_rule.words.x + word.x;
    edges[index] = own.marked[row];
    sample_bits[index] = bits[row];
    if (CONTINUES) {
      faint_edges[index] = faint.marked[row];
    }
  }
}

// The open edges of a strip that are marked. One after another, because some devices execute a loop's body for all invocations
// if one needs it.
fn settled(corner: vec2<u32>, open: vec4<u32>, level: u32) -> vec4<u32> {
  var marked = vec4<u32>(0u);
  var left = open;
  // Turns: 4 * 2 * WORD_SAMPLES.
  while (any(left != vec4<u32>(0u))) {
    let row = select(select(select(3u, 2u, left.z != 0u), 1u, left.y != 0u), 0u, left.x != 0u);
    let edge = firstTrailingBit(left[row]);
    let at = corner + vec2<u32>(edge % WORD_SAMPLES, row);
    marked[row] |= select(0u, 1u << edge, exactly(keys_along(at, step_of(edge / WORD_SAMPLES)), level));
    left[row] &= left[row] - 1u;
  }
  return marked;
}

@compute @workgroup_size(MARKERS)
fn depth_edges_mark(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(num_workgroups) groups: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let strips = edge_rule.words.x * ((edge_rule.words.y + STRIP - 1u) / STRIP);
  let first = (group.x + groups.x * group.y) * MARKERS + local;
  // Turns: 1.
  for (var strip = first; strip < strips; strip += groups.x * groups.y * MARKERS) {
    mark_strip(strip);
  }
}

// Marks the faint edges, those of level 1, of cells that have one marked edge.
@compute @workgroup_size(BLOCK)
fn depth_edges_continue(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(num_workgroups) groups: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  // Turns: 1.
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

// Bits for a row of samples. Bit 0 is two samples to the left of the strip of cells.
struct RowOfSamples {
  // Edges across and down.
  marks: vec2<u32>,
  // Samples at the ends of marked edges.
  ends: u32,
}

fn row_of_samples(at: vec2<i32>, before: vec2<u32>, borders: Borders, row: i32) -> RowOfSamples {
  let marks = marks_from(at + vec2<i32>(0, row));
  var ends = 0u;
  if (RINGS > 0u) {
    ends = ends_of(marks, before.y, borders, row);
  }
  return RowOfSamples(marks, ends);
}

// The words of a strip of cells (cell_words.wgsl), from marks. It walks down the rows of samples.
fn decided_by_marks(strip: u32) -> vec4<u32> {
  let own = cells_of_strip(strip);
  let at = vec2<i32>(own.first_sample) - vec2<i32>(2, 0);
  let borders = borders_from(vec2<i32>(own.in_map) - vec2<i32>(2, 0));
  var words = vec4<u32>(0u);
  // The rows above, at and below the walk.
  var upper: RowOfSamples;
  var lower: RowOfSamples;
  var next: RowOfSamples;
  if (RINGS > 1u) {
    lower = row_of_samples(at, marks_from(at - vec2<i32>(0, 2)), borders, -1);
  } else if (RINGS > 0u) {
    lower.marks = marks_from(at - vec2<i32>(0, 1));
  }
  next = row_of_samples(at, lower.marks, borders, 0);
  var ring_before = 0u;
  var split_before = 0u;
  for (var row = 0u; row <= opaque(STRIP); row++) {
    upper = lower;
    lower = next;
    if (RINGS > 1u || row < STRIP) {
      next = row_of_samples(at, lower.marks, borders, i32(row) + 1);
    }
    let samples = samples_from(at + vec2<i32>(0, i32(row)));
    var ring = lower.ends;
    if (RINGS > 1u) {
      ring |= (ring << 1u) | (ring >> 1u) | upper.ends | next.ends;
    }
    ring &= samples.x;
    if (row > 0u) {
      words[row - 1u] = word_by_marks(upper.marks, lower.marks, vec2<u32>(ring_before, ring), split_before);
    }
    ring_before = ring;
    split_before = samples.y;
  }
  return mask_existing_cells(own, words);
}

// The cells between two rows of samples.
fn word_by_marks(upper: vec2<u32>, lower: vec2<u32>, rings: vec2<u32>, split: u32) -> u32 {
  let diagonal = select_bits(rings.x | (rings.y >> 1u), rings.y | (rings.x >> 1u), split);
  let first = upper.x | diagonal | select_bits((upper.y | rings.x) >> 1u, upper.y | rings.x, split);
  let second = lower.x | diagonal | select_bits(upper.y | rings.y, (upper.y | rings.y) >> 1u, split);
  let own = vec3<u32>(split, first, second) >> vec3<u32>(2u);
  return apart(own.x & 255u) | (apart(own.y & 255u) << 1u) | (apart(own.z & 255u) << 2u);
}

fn select_bits(otherwise: u32, taken: u32, bits: u32) -> u32 {
  return (otherwise & ~bits) | (taken & bits);
}

// Writes what `depth_cells_count` does. An invocation decides about a strip of cells; a workgroup takes blocks in turn.
@compute @workgroup_size(BLOCK_STRIPS)
fn depth_edges_count(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(num_workgroups) groups: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  // Turns: ITEMS.
  for (var block = group.x + groups.x * group.y; block < depth_map.blocks; block += groups.x * groups.y) {
    let strip = block * BLOCK_STRIPS + local;
    write_block_count(block, local, write_strip(strip, decided_by_marks(strip)));
  }
}

// The marks of the pass before: mark, or continue.
@group(0) @binding(7) var<storage, read> edges_before: array<u32>;

// For as many samples, whether each casts, and 16 bits higher whether the cell below it and on its right is split.
@group(0) @binding(10) var<storage, read_write> sample_bits: array<u32>;

// 0: triangles with a marked edge are drawn. Above 0: those, too, with a sample up to RINGS - 1 edges from the end of a marked
// one.
override RINGS: u32 = 2u;

// Where a word is, and whether there is one.
struct WordPlace {
  index: u32,
  exists: bool,
}

fn word_at(word: i32, row: i32) -> WordPlace {
  let exists = all(vec2<i32>(word, row) >= vec2<i32>(0)) && all(vec2<i32>(word, row) < vec2<i32>(edge_rule.words));
  return WordPlace(select(0u, u32(row) * edge_rule.words.x + u32(word), exists), exists);
}

// The lower and the higher halves of two words, from a place on: 17 samples or more.
fn halves_from(first: u32, second: u32, place: i32) -> vec2<u32> {
  let both = vec2<u32>((first & 0xffffu) | (second << 16u), (first >> 16u) | (second & 0xffff0000u));
  return both >> vec2<u32>(u32(place & 15));
}

// Marks of 17 samples or more from a place on: edges across, and down. Samples that do not exist have none.
fn marks_from(at: vec2<i32>) -> vec2<u32> {
  let first = word_at(at.x >> 4u, at.y);
  let second = word_at((at.x >> 4u) + 1, at.y);
  return halves_from(
    select(0u, edges_before[first.index], first.exists), select(0u, edges_before[second.index], second.exists), at.x);
}

// For 17 samples or more from a place on: which of them cast, and which cells are split.
fn samples_from(at: vec2<i32>) -> vec2<u32> {
  let first = word_at(at.x >> 4u, at.y);
  let second = word_at((at.x >> 4u) + 1, at.y);
  return halves_from(
    select(0u, sample_bits[first.index], first.exists), select(0u, sample_bits[second.index], second.exists), at.x);
}

// For 17 cells from a place on, whether exactly one of their edges is marked.
fn dangling_from(at: vec2<i32>) -> u32 {
  let own = marks_from(at);
  let bottom = marks_from(at + vec2<i32>(0, 1)).x;
  let right = marks_from(at + vec2<i32>(1, 0)).y;
  let two = (own.x & bottom) | (own.y & right) | ((own.x | bottom) & (own.y | right));
  var single = (own.x | bottom | own.y | right) & ~two;
  if (depth_map.faces > 1u) {
    // There are none between two maps.
    let side = i32(depth_map.size.x);
    for (var cell = 0; cell < 17; cell++) {
      let is_between = any((at + vec2<i32>(cell, 0) + side) % side == vec2<i32>(side - 1));
      single &= ~select(0u, 1u << u32(cell), is_between);
    }
  }
  return single;
}

// Samples on the borders of a map of a cube: other maps may have marked edges at them. `in_map`: a place in the map.
struct Borders {
  in_map: vec2<i32>,
  // From 13 samples from there on, those in its first or last column.
  columns: u32,
}

fn borders_from(in_map: vec2<i32>) -> Borders {
  let last = i32(depth_map.size.x) - 1 - in_map.x;
  let first_columns = select(0u, (2u << u32(-in_map.x)) - 1u, in_map.x <= 0);
  let last_columns = select(0u, 0xffffffffu << u32(last), last < 32);
  return Borders(in_map, select(0u, first_columns | last_columns, depth_map.faces > 1u));
}

// Samples of a row that are at the end of a marked edge, or on a border, but for the first. `marks` are those of the row,
// `down_before` those of the edges down from the row before. `row`: from the place of the borders on.
fn ends_of(marks: vec2<u32>, down_before: u32, borders: Borders, row: i32) -> u32 {
  let in_map = borders.in_map.y + row;
  let is_border = depth_map.faces > 1u && (in_map <= 0 || in_map >= i32(depth_map.size.y) - 1);
  return marks.x | (marks.x << 1u) | marks.y | down_before | select(borders.columns, 0xffffffffu, is_border);
}
