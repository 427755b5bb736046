// Stage `depth_edges`: marks edges between neighbouring samples of a depth map, continues edges that dangle, and decides
// about cells from the marks. An edge dangles if it ends in a cell without another marked edge. For detectors that look
// beside an edge or continue edges, it replaces `depth_cells_count`. After `depth_cube`, before `depth_cells`.
// `depth_edges_mark`, an invocation for 16 × 4 samples, reads depths and objects, and writes `edges`, `faint_edges` and
// `sample_bits`. `depth_edges_continue`, an invocation for a word of 16 samples, runs up to 64 times; two buffers of marks
// alternate. It reads only the marks of the pass before, so the order of cells does not matter. `depth_edges_count`,
// workgroups that loop over blocks of cells, reads marks and `sample_bits`. It writes `cell_words` (cell_words.wgsl) for the
// later passes of `depth_cells`. A word of marks has 16 samples of a row: in bits 0 to 15 the edges to their right, in bits
// 16 to 31 the edges below them. Marks are exact (docs/numerics/depth-maps.md, "Exact decisions").

#import depth_map/cell_words
#import depth_map/edge_code
#import depth_map/samples

// The rules of detectors that look beside an edge (second differences) or continue edges.
// `edge_state` uses floats, and decides only where their rounding cannot matter: 0 or 1. Elsewhere it returns 2, and
// `is_marked_exact` decides by integers. So marks are exact and the same on every device. Change both functions only
// together. Level 0 is the detector's own rule. Level 1 has lower thresholds, for edges that continue a dangling one.

// How edges are marked. Thresholds and factors in pairs have a value for each level.
struct DepthEdgeRule {
  // Words of marks in a row of samples, and rows.
  words: vec2<u32>,
  // Blocks of 256 words.
  blocks: u32,
  // Bits of the threshold above which every difference is marked.
  high_threshold: u32,
  // Bits of the threshold up to which no difference is marked.
  low_thresholds: vec2<u32>,
  // Bits of the factor by which a difference must be larger than the difference beside it.
  slopes: vec2<u32>,
  // A difference may be off by a constant or by a share of its larger depth, if that is more. The bits of the constant:
  noise: u32,
  // The share is this depth with its exponent lowered by so much. 0: there is only the constant.
  noise_exponents: u32,
}

@group(0) @binding(6) var<uniform> edge_rule: DepthEdgeRule;

// How the differences beside an edge count, those to the samples before and after it in its row or column. 0: not at all;
// the thresholds decide. 1: between both thresholds a difference must be larger than both beside it. 2: it must be larger
// than one of them, and there are no thresholds.
override SECOND: u32 = 0u;

// Words of a wide integer in units of 2⁻²⁹⁸, lowest first, in two's complement.
const WIDE: u32 = 14u;
// Products of a sum.
const TERMS: u32 = 5u;
// The sign bit.
const MINUS: u32 = 0x80000000u;

// The mantissa of a float that is 0 or normal (x), and its shift up in units of 2⁻¹⁴⁹ (y).
fn mantissa_and_shift(bits: u32) -> vec2<u32> {
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

// Whether a sum of products of two floats is above 0, exactly. Products must be below 2^146, so that the sum fits WIDE words.
fn is_positive(terms: array<vec2<u32>, TERMS>) -> bool {
  var factors = terms;
  var sum = array<u32, WIDE>();
  for (var term = 0u; term < opaque(TERMS); term++) {
    let pair = factors[term];
    let a = mantissa_and_shift(pair.x);
    let b = mantissa_and_shift(pair.y);
    let mantissa = wide_product(a.x, b.x);
    let first_word = (a.y + b.y) >> 5u;
    let shift = (a.y + b.y) & 31u;
    let shift_of_carried = vec2<u32>(32u - shift) & vec2<u32>(31u);
    let carried = select(mantissa >> shift_of_carried, vec2<u32>(0u), shift == 0u);
    let digits = vec3<u32>(mantissa.x << shift, (mantissa.y << shift) | carried.x, carried.y);
    // A negative product is added as its complement and 1.
    let sign = (pair.x ^ pair.y) >> 31u;
    var carry = sign;
    for (var word = 0u; word < opaque(WIDE); word++) {
      let index = word - first_word;
      let digit =
        select(select(select(0u, digits.z, index == 2u), digits.y, index == 1u), digits.x, index == 0u) ^ (0u - sign);
      let with_digit = sum[word] + digit;
      let with_carry = with_digit + carry;
      carry = select(0u, 1u, with_digit < digit) | select(0u, 1u, with_carry < with_digit);
      sum[word] = with_carry;
    }
  }
  var any = 0u;
  for (var word = 0u; word < opaque(WIDE); word++) {
    any |= sum[word];
  }
  return any != 0u && sum[WIDE - 1u] < MINUS;
}

// Samples of the lattice, or of a cube's texture: columns and rows.
fn lattice_size() -> vec2<u32> {
  return select(depth_map.size + 2u, vec2<u32>(3u, 2u) * depth_map.size, depth_map.faces > 1u);
}

// Whether one or more steps to the right or down lead out of a map of a cube.
fn leaves_map(sample: vec2<u32>, step: vec2<u32>) -> bool {
  return depth_map.faces > 1u && any(sample % depth_map.size + step >= depth_map.size);
}

// Keys of the samples before an edge, at its two ends and after it. Beside a map of a cube nothing casts.
fn keys_along(sample: vec2<u32>, step: vec2<u32>) -> vec4<u32> {
  let before = select(load_key(sample - step), FAR_KEY, depth_map.faces > 1u && any(sample % depth_map.size < step));
  let after = select(load_key(sample + 2u * step), FAR_KEY, leaves_map(sample, 2u * step));
  return vec4<u32>(before, load_key(sample), load_key(sample + step), after);
}

// Bits of the error that the difference of two depths may have. `large`: bits of the larger depth.
fn noise_bits(large: u32) -> u32 {
  let exponents = edge_rule.noise_exponents << 23u;
  let share = select(0u, large - exponents, exponents != 0u && large >= exponents + 0x00800000u);
  return max(edge_rule.noise, share);
}

// Bits of the depths at both ends of the step before an edge, or after it, by `keys_along`. (0, 0) if the step rises the
// other way than the edge, or one of its ends is far.
fn adjacent_step(keys: vec4<u32>, is_after: bool) -> vec2<u32> {
  let beside = select(keys.xy, keys.zw, is_after);
  let same_way = (beside.x < beside.y) == (keys.y < keys.z);
  return select(
    vec2<u32>(0u), vec2<u32>(depth_bits(beside.x), depth_bits(beside.y)), same_way && max(beside.x, beside.y) != FAR_KEY);
}

fn float_difference(bits: vec2<u32>) -> f32 {
  return abs(bitcast<f32>(bits.x) - bitcast<f32>(bits.y));
}

// Whether the difference at an edge exceeds both differences beside it, or one of them, times a factor, and the noise. 0 no,
// 1 yes, 2 if float rounding might matter. `ends`: bits of the depths at the edge. `factor`: bits, too.
fn exceeds_slopes_by_floats(keys: vec4<u32>, ends: vec2<u32>, factor: u32) -> u32 {
  let before = float_difference(adjacent_step(keys, false));
  let after = float_difference(adjacent_step(keys, true));
  let difference = float_difference(ends);
  let beside = select(max(before, after), min(before, after), SECOND == 2u);
  let limit = bitcast<f32>(factor) * beside + bitcast<f32>(noise_bits(max(ends.x, ends.y)));
  let is_certain = (difference + limit > 1e-30) & (abs(difference - limit) > 1e-5 * (difference + limit));
  return select(2u, select(0u, 1u, difference > limit), is_certain);
}

// The same for the difference on one side, exactly. `beside`: bits of the depths at the ends of the step there.
fn exceeds_slope_exact(ends: vec2<u32>, beside: vec2<u32>, factor: u32) -> bool {
  let noise = noise_bits(max(ends.x, ends.y));
  return is_positive(array<vec2<u32>, TERMS>(
    vec2<u32>(ONE, max(ends.x, ends.y)), vec2<u32>(ONE, min(ends.x, ends.y) | MINUS),
    vec2<u32>(factor, max(beside.x, beside.y) | MINUS), vec2<u32>(factor, min(beside.x, beside.y)),
    vec2<u32>(ONE, noise | MINUS)));
}

// Whether an edge is marked, by `keys_along`: 0 no, 1 yes, 2 if only `is_marked_exact` can decide.
fn edge_state(keys: vec4<u32>, level: u32) -> u32 {
  let ends = vec2<u32>(depth_bits(keys.y), depth_bits(keys.z));
  let large = max(ends.x, ends.y);
  let small = min(ends.x, ends.y);
  var state = 2u;
  if (SECOND == 2u) {
    state = exceeds_slopes_by_floats(keys, ends, edge_rule.slopes[level]);
  } else {
    let is_step = exceeds(large, small, edge_rule.low_thresholds[level]);
    state = select(0u, 1u, is_step);
    if (SECOND == 1u) {
      let is_decided = !is_step || exceeds(large, small, edge_rule.high_threshold);
      state = select(exceeds_slopes_by_floats(keys, ends, edge_rule.slopes[level]), state, is_decided);
    }
  }
  return select(state, select(0u, 1u, keys.y != keys.z), max(keys.y, keys.z) == FAR_KEY || keys.y == keys.z);
}

// Whether an edge is marked for which `edge_state` is 2. So neither sample is far, and their keys differ.
fn is_marked_exact(keys: vec4<u32>, level: u32) -> bool {
  let ends = vec2<u32>(depth_bits(keys.y), depth_bits(keys.z));
  var exceeded_sides = 0u;
  for (var side = 0u; side < opaque(2u); side++) {
    exceeded_sides += select(0u, 1u, exceeds_slope_exact(ends, adjacent_step(keys, side == 1u), edge_rule.slopes[level]));
  }
  return exceeded_sides >= select(1u, 2u, SECOND == 1u);
}

@group(0) @binding(8) var<storage, read_write> edges: array<u32>;
// Edges of level 1, which are marked if they continue others.
@group(0) @binding(9) var<storage, read_write> faint_edges: array<u32>;

// Whether edges are continued.
override CONTINUES: bool = true;

const BLOCK: u32 = 256u;
const WORD_SAMPLES: u32 = 16u;
const MARKERS: u32 = 64u;

// The step along an axis: 0 to the right, 1 down.
fn step_along(axis: u32) -> vec2<u32> {
  return select(vec2<u32>(1u, 0u), vec2<u32>(0u, 1u), axis == 1u);
}

// The column and row of the first word of a strip of marks: four words below each other. (cell_words.wgsl has strips of
// cells.) An invocation goes along all four at once, so that few samples are loaded twice.
fn first_word_of_strip(strip: u32) -> vec2<u32> {
  return vec2<u32>(strip % edge_rule.words.x, strip / edge_rule.words.x * STRIP);
}

// Keys of a column of samples: those in the four rows of a strip; and one above (x) and two below it (y, z).
struct Column {
  keys: vec4<u32>,
  beyond: vec3<u32>,
}

fn load_column(sample: vec2<u32>) -> Column {
  let down = vec2<u32>(0u, 1u);
  return Column(
    vec4<u32>(load_key(sample), load_key(sample + down), load_key(sample + 2u * down), load_key(sample + 3u * down)),
    vec3<u32>(load_key(sample - down), load_key(sample + 4u * down), load_key(sample + 5u * down)));
}

// Keys of four edges in the rows of a strip: of the samples before them, at both ends, and after them.
struct FourEdges {
  before: vec4<u32>,
  first: vec4<u32>,
  second: vec4<u32>,
  after: vec4<u32>,
}

// `edge_state` of each edge.
fn edge_states(four: FourEdges, level: u32) -> vec4<u32> {
  return vec4<u32>(
    edge_state(vec4<u32>(four.before.x, four.first.x, four.second.x, four.after.x), level),
    edge_state(vec4<u32>(four.before.y, four.first.y, four.second.y, four.after.y), level),
    edge_state(vec4<u32>(four.before.z, four.first.z, four.second.z, four.after.z), level),
    edge_state(vec4<u32>(four.before.w, four.first.w, four.second.w, four.after.w), level));
}

// Which edges lie between two objects. `sample`: the first sample of the first edge.
fn are_object_edges(four: FourEdges, sample: vec2<u32>, step: vec2<u32>) -> vec4<bool> {
  var result = vec4<bool>(false);
  if (OBJECTS && depth_map.has_objects != 0u) {
    // A loop that is not unrolled has one copy of what it loads.
    for (var row = 0u; row < opaque(STRIP); row++) {
      let first = sample + vec2<u32>(0u, row);
      result[row] = max(four.first[row], four.second[row]) != FAR_KEY && is_object_edge(first, first + step);
    }
  }
  return result;
}

// The four words of a strip: edges that are marked, and those that are left to `is_marked_exact`.
struct Marks {
  marked: vec4<u32>,
  undecided: vec4<u32>,
}

// Sets a bit of each word by the state of its edge.
fn with_states(marks: Marks, states: vec4<u32>, bit: u32) -> Marks {
  let shift = vec4<u32>(bit);
  return Marks(
    marks.marked | ((states & vec4<u32>(1u)) << shift), marks.undecided | ((states >> vec4<u32>(1u)) << shift));
}

// Four columns of samples beside each other.
struct FourColumns {
  before: vec4<u32>, // Only the keys in the rows of the strip.
  current: Column,
  next: Column,
  after: Column,
}

// The columns one sample further on. `after` is the new last one.
fn shifted(columns: FourColumns, after: Column) -> FourColumns {
  return FourColumns(columns.current.keys, columns.next, columns.after, after);
}

// Where a column of samples is within its map. Maps of a cube lie beside each other, and no edge leads from one to the next.
struct MapPosition {
  size: vec2<u32>,
  rows: vec4<u32>,
  column: u32,
}

// The edges from the samples `columns.current` along an axis.
fn edges_along(columns: FourColumns, position: MapPosition, axis: u32) -> FourEdges {
  let far = vec4<u32>(FAR_KEY);
  let current = columns.current;
  if (axis == 1u) {
    return FourEdges(
      select(vec4<u32>(current.beyond.x, current.keys.xyz), far, position.rows == vec4<u32>(0u)),
      current.keys,
      vec4<u32>(current.keys.yzw, current.beyond.y),
      select(vec4<u32>(current.keys.zw, current.beyond.yz), far, position.rows + 2u >= vec4<u32>(position.size.y)));
  }
  return FourEdges(
    select(columns.before, far, position.column == 0u),
    current.keys,
    columns.next.keys,
    select(columns.after.keys, far, position.column + 2u >= position.size.x));
}

// Which edges along an axis lead out of the map or the lattice. `x` is the column of their samples in the lattice.
fn leads_out(position: MapPosition, x: u32, axis: u32) -> vec4<bool> {
  if (axis == 1u) {
    return (position.rows + 1u == vec4<u32>(position.size.y)) | vec4<bool>(x >= lattice_size().x);
  }
  return vec4<bool>(position.column + 1u == position.size.x || x >= lattice_size().x);
}

// The bits of `sample_bits` for a column of samples, shifted to bit 0 and 16: they cast; their cells are split.
fn bits_of_column(current: Column, next: Column) -> vec4<u32> {
  let below = vec4<u32>(current.keys.yzw, current.beyond.y);
  let next_below = vec4<u32>(next.keys.yzw, next.beyond.y);
  let split = vec4<bool>(
    is_split(vec4<u32>(current.keys.x, next.keys.x, below.x, next_below.x)),
    is_split(vec4<u32>(current.keys.y, next.keys.y, below.y, next_below.y)),
    is_split(vec4<u32>(current.keys.z, next.keys.z, below.z, next_below.z)),
    is_split(vec4<u32>(current.keys.w, next.keys.w, below.w, next_below.w)));
  let casts = select(vec4<u32>(1u), vec4<u32>(0u), current.keys == vec4<u32>(FAR_KEY));
  return casts | select(vec4<u32>(0u), vec4<u32>(0x10000u), split);
}

// Writes the words of a strip: marks, of both levels if edges are continued, and `sample_bits`.
fn mark_strip(strip: u32) {
  let word = first_word_of_strip(strip);
  let corner = vec2<u32>(word.x * WORD_SAMPLES, word.y);
  let map_size = select(vec2<u32>(0x40000000u), depth_map.size, depth_map.faces > 1u);
  var position = MapPosition(map_size, (corner.y + vec4<u32>(0u, 1u, 2u, 3u)) % map_size.y, corner.x % map_size.x);
  var columns: FourColumns;
  var marks: Marks;
  var faint_marks: Marks;
  var bits = vec4<u32>(0u);
  // The first three iterations fill `columns`.
  for (var index = 0u; index < WORD_SAMPLES + 3u; index++) {
    columns = shifted(columns, load_column(corner + vec2<u32>(index, 0u) - vec2<u32>(1u, 0u)));
    if (index < 3u) {
      continue;
    }
    let bit = index - 3u;
    let sample = corner + vec2<u32>(bit, 0u);
    for (var axis = 0u; axis < 2u; axis++) {
      let four = edges_along(columns, position, axis);
      let never_marked = leads_out(position, sample.x, axis);
      let always_marked = are_object_edges(four, sample, step_along(axis));
      let states = select(edge_states(four, 0u), vec4<u32>(1u), always_marked);
      marks = with_states(marks, select(states, vec4<u32>(0u), never_marked), bit + 16u * axis);
      if (CONTINUES) {
        let faint_states = select(edge_states(four, 1u), vec4<u32>(1u), always_marked);
        faint_marks = with_states(faint_marks, select(faint_states, vec4<u32>(0u), never_marked), bit + 16u * axis);
      }
    }
    bits |= bits_of_column(columns.current, columns.next) << vec4<u32>(bit);
    position.column = select(position.column + 1u, 0u, position.column + 1u == map_size.x);
  }
  marks.marked |= resolve_undecided(corner, marks.undecided, 0u);
  if (CONTINUES) {
    faint_marks.marked |= resolve_undecided(corner, faint_marks.undecided, 1u);
  }
  // Turns: STRIP.
  for (var row = 0u; row < min(STRIP, edge_rule.words.y - word.y); row++) {
    let index = (word.y + row) * edge_rule.words.x + word.x;
    edges[index] = marks.marked[row];
    sample_bits[index] = bits[row];
    if (CONTINUES) {
      faint_edges[index] = faint_marks.marked[row];
    }
  }
}

// The undecided edges of a strip that are marked. This loop is its own, because some devices
// execute a loop's body for all invocations if one needs it.
fn resolve_undecided(corner: vec2<u32>, undecided: vec4<u32>, level: u32) -> vec4<u32> {
  var marked = vec4<u32>(0u);
  var remaining = undecided;
  // Turns: 4 * 2 * WORD_SAMPLES.
  while (any(remaining != vec4<u32>(0u))) {
    let row = select(select(select(3u, 2u, remaining.z != 0u), 1u, remaining.y != 0u), 0u, remaining.x != 0u);
    let bit = firstTrailingBit(remaining[row]);
    let sample = corner + vec2<u32>(bit % WORD_SAMPLES, row);
    marked[row] |= select(0u, 1u << bit, is_marked_exact(keys_along(sample, step_along(bit / WORD_SAMPLES)), level));
    remaining[row] &= remaining[row] - 1u;
  }
  return marked;
}

@compute @workgroup_size(MARKERS)
fn depth_edges_mark(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) dispatch_size: vec3<u32>,
  @builtin(local_invocation_index) lane: u32,
) {
  let strips = edge_rule.words.x * ((edge_rule.words.y + STRIP - 1u) / STRIP);
  let first = (workgroup.x + dispatch_size.x * workgroup.y) * MARKERS + lane;
  // Turns: 1.
  for (var strip = first; strip < strips; strip += dispatch_size.x * dispatch_size.y * MARKERS) {
    mark_strip(strip);
  }
}

// Marks the faint edges of cells with exactly one marked edge.
@compute @workgroup_size(BLOCK)
fn depth_edges_continue(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) dispatch_size: vec3<u32>,
  @builtin(local_invocation_index) lane: u32,
) {
  // Turns: 1.
  for (
    var block = workgroup.x + dispatch_size.x * workgroup.y;
    block < edge_rule.blocks;
    block += dispatch_size.x * dispatch_size.y
  ) {
    let word = block * BLOCK + lane;
    if (word >= edge_rule.words.x * edge_rule.words.y) {
      continue;
    }
    let sample = vec2<i32>(vec2<u32>(word % edge_rule.words.x * WORD_SAMPLES, word / edge_rule.words.x));
    // Cells below the samples and above them, from the one to the left of the first sample on.
    let below = dangling_from(sample - vec2<i32>(1, 0));
    let above = dangling_from(sample - vec2<i32>(1, 1));
    // Edges to the right have a cell above and one below; edges down have one to the left and one to the right.
    let across = ((below | above) >> 1u) & 0xffffu;
    let down = (below | (below >> 1u)) & 0xffffu;
    edges[word] = edges_before[word] | (faint_edges[word] & (across | (down << 16u)));
  }
}

// Moves each bit of eight to the lowest of four bits of its own.
fn spread_bits(bits: u32) -> u32 {
  let fours = (bits & 0x0fu) | ((bits & 0xf0u) << 12u);
  let pairs = (fours & 0x00030003u) | ((fours & 0x000c000cu) << 6u);
  return (pairs & 0x01010101u) | ((pairs & 0x02020202u) << 3u);
}

// Bits for a row of samples. Bit 0 is two samples to the left of the strip of cells.
struct RowOfSamples {
  // Marked edges to the right (x) and down (y).
  marks: vec2<u32>,
  // Samples at the ends of marked edges.
  edge_ends: u32,
}

fn row_of_samples(first_sample: vec2<i32>, marks_above: vec2<u32>, borders: Borders, row: i32) -> RowOfSamples {
  let marks = marks_from(first_sample + vec2<i32>(0, row));
  var edge_ends = 0u;
  if (RINGS > 0u) {
    edge_ends = edge_ends_of_row(marks, marks_above.y, borders, row);
  }
  return RowOfSamples(marks, edge_ends);
}

// The words of a strip of cells (cell_words.wgsl), from marks. It goes down the rows of samples.
fn strip_words_from_marks(strip: u32) -> vec4<u32> {
  let cells = cells_of_strip(strip);
  let first_sample = vec2<i32>(cells.first_sample) - vec2<i32>(2, 0);
  let borders = borders_from(vec2<i32>(cells.in_map) - vec2<i32>(2, 0));
  var words = vec4<u32>(0u);
  // The rows above, at and below the current one.
  var upper: RowOfSamples;
  var lower: RowOfSamples;
  var next: RowOfSamples;
  if (RINGS > 1u) {
    lower = row_of_samples(first_sample, marks_from(first_sample - vec2<i32>(0, 2)), borders, -1);
  } else if (RINGS > 0u) {
    lower.marks = marks_from(first_sample - vec2<i32>(0, 1));
  }
  next = row_of_samples(first_sample, lower.marks, borders, 0);
  var ring_above = 0u;
  var split_above = 0u;
  for (var row = 0u; row <= opaque(STRIP); row++) {
    upper = lower;
    lower = next;
    if (RINGS > 1u || row < STRIP) {
      next = row_of_samples(first_sample, lower.marks, borders, i32(row) + 1);
    }
    let samples = samples_from(first_sample + vec2<i32>(0, i32(row)));
    // Samples that cast, and are the end of a marked edge or, if RINGS is 2, beside one.
    var ring = lower.edge_ends;
    if (RINGS > 1u) {
      ring |= (ring << 1u) | (ring >> 1u) | upper.edge_ends | next.edge_ends;
    }
    ring &= samples.x;
    if (row > 0u) {
      words[row - 1u] = word_of_row(upper.marks, lower.marks, vec2<u32>(ring_above, ring), split_above);
    }
    ring_above = ring;
    split_above = samples.y;
  }
  return mask_existing_cells(cells, words);
}

// The word of the cells between two rows of samples. `rings`: samples of the upper and lower row at which triangles are
// drawn. `split`: cells that are split from sample (1, 0) to (0, 1).
fn word_of_row(upper: vec2<u32>, lower: vec2<u32>, rings: vec2<u32>, split: u32) -> u32 {
  let diagonal = select_bits(rings.x | (rings.y >> 1u), rings.y | (rings.x >> 1u), split);
  let first = upper.x | diagonal | select_bits((upper.y | rings.x) >> 1u, upper.y | rings.x, split);
  let second = lower.x | diagonal | select_bits(upper.y | rings.y, (upper.y | rings.y) >> 1u, split);
  let of_strip = vec3<u32>(split, first, second) >> vec3<u32>(2u);
  return spread_bits(of_strip.x & 255u) | (spread_bits(of_strip.y & 255u) << 1u) | (spread_bits(of_strip.z & 255u) << 2u);
}

// Bits of `if_set` where `mask` has ones, else of `if_clear`.
fn select_bits(if_clear: u32, if_set: u32, mask: u32) -> u32 {
  return (if_clear & ~mask) | (if_set & mask);
}

// Writes what `depth_cells_count` writes. An invocation decides about a strip of cells of each block that its workgroup
// takes.
@compute @workgroup_size(BLOCK_STRIPS)
fn depth_edges_count(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) dispatch_size: vec3<u32>,
  @builtin(local_invocation_index) lane: u32,
) {
  // Turns: ITEMS.
  for (
    var block = workgroup.x + dispatch_size.x * workgroup.y;
    block < depth_map.blocks;
    block += dispatch_size.x * dispatch_size.y
  ) {
    let strip = block * BLOCK_STRIPS + lane;
    write_block_count(block, lane, write_strip(strip, strip_words_from_marks(strip)));
  }
}

// The marks of the pass before, which is `depth_edges_mark` or `depth_edges_continue`.
@group(0) @binding(7) var<storage, read> edges_before: array<u32>;

// A word for 16 samples, as marks have: whether each sample casts; and 16 bits higher whether the cell to its right and
// below it is split.
@group(0) @binding(10) var<storage, read_write> sample_bits: array<u32>;

// 0: triangles with a marked edge are drawn. 1: also those with a sample that casts, at the end of a marked edge. 2: also
// those with a sample that casts, beside such an end.
override RINGS: u32 = 2u;

// The index of a word, and whether the word exists.
struct WordIndex {
  index: u32,
  exists: bool,
}

fn word_index(column: i32, row: i32) -> WordIndex {
  let exists = all(vec2<i32>(column, row) >= vec2<i32>(0)) && all(vec2<i32>(column, row) < vec2<i32>(edge_rule.words));
  return WordIndex(select(0u, u32(row) * edge_rule.words.x + u32(column), exists), exists);
}

// The lower (x) and the upper halves (y) of two words, from a column on: 17 samples or more.
fn halves_from(first: u32, second: u32, column: i32) -> vec2<u32> {
  let joined = vec2<u32>((first & 0xffffu) | (second << 16u), (first >> 16u) | (second & 0xffff0000u));
  return joined >> vec2<u32>(u32(column & 15));
}

// Marks of 17 samples or more from a sample on: edges to the right (x), and down (y). Samples that do not exist have none.
fn marks_from(sample: vec2<i32>) -> vec2<u32> {
  let first = word_index(sample.x >> 4u, sample.y);
  let second = word_index((sample.x >> 4u) + 1, sample.y);
  return halves_from(
    select(0u, edges_before[first.index], first.exists), select(0u, edges_before[second.index], second.exists), sample.x);
}

// `sample_bits` of 17 samples or more from a sample on: which cast (x), and which cells are split (y).
fn samples_from(sample: vec2<i32>) -> vec2<u32> {
  let first = word_index(sample.x >> 4u, sample.y);
  let second = word_index((sample.x >> 4u) + 1, sample.y);
  return halves_from(
    select(0u, sample_bits[first.index], first.exists), select(0u, sample_bits[second.index], second.exists), sample.x);
}

// A bit for each of 17 cells from a cell on: exactly one of its edges is marked.
fn dangling_from(cell: vec2<i32>) -> u32 {
  let top_and_left = marks_from(cell);
  let bottom = marks_from(cell + vec2<i32>(0, 1)).x;
  let right = marks_from(cell + vec2<i32>(1, 0)).y;
  let two_or_more =
    (top_and_left.x & bottom) | (top_and_left.y & right) | ((top_and_left.x | bottom) & (top_and_left.y | right));
  var dangling = (top_and_left.x | bottom | top_and_left.y | right) & ~two_or_more;
  if (depth_map.faces > 1u) {
    // There are no cells between two maps.
    let side = i32(depth_map.size.x);
    for (var column = 0; column < 17; column++) {
      let is_between = any((cell + vec2<i32>(column, 0) + side) % side == vec2<i32>(side - 1));
      dangling &= ~select(0u, 1u << u32(column), is_between);
    }
  }
  return dangling;
}

// Where samples are on the border of a map of a cube. The next map may have marked edges there, so they count as ends.
struct Borders {
  // The position in the map of the sample of bit 0.
  in_map: vec2<i32>,
  // Samples of a row, 13 or more, that are in the first or last column of the map, or outside it.
  columns: u32,
}

fn borders_from(in_map: vec2<i32>) -> Borders {
  let to_last = i32(depth_map.size.x) - 1 - in_map.x;
  let first_column = select(0u, (2u << u32(-in_map.x)) - 1u, in_map.x <= 0);
  let last_column = select(0u, 0xffffffffu << u32(to_last), to_last < 32);
  return Borders(in_map, select(0u, first_column | last_column, depth_map.faces > 1u));
}

// Samples of a row that are at the end of a marked edge, or on a border of a map of a cube. The first bit has no meaning.
// `row` counts from `borders.in_map` on. `down_above`: edges down from the row above.
fn edge_ends_of_row(marks: vec2<u32>, down_above: u32, borders: Borders, row: i32) -> u32 {
  let row_in_map = borders.in_map.y + row;
  let is_border = depth_map.faces > 1u && (row_in_map <= 0 || row_in_map >= i32(depth_map.size.y) - 1);
  return marks.x | (marks.x << 1u) | marks.y | down_above | select(borders.columns, 0xffffffffu, is_border);
}
