// Stage `depth_edges`: marks edges between neighbouring samples of a depth map, continues edges that dangle, and decides
// about cells from the marks. An edge dangles if it ends in a cell without another marked edge. For detectors that look
// beside an edge or continue edges, it replaces `depth_cells_count`. After `depth_cube`, before `depth_cells`.
// `depth_edges_mark`, an invocation for 16 × 4 samples, reads depths and objects, and writes `edges`, `faint_edges` and
// `sample_bits`. `depth_edges_continue`, an invocation for a word of 16 samples, runs up to 64 times; two buffers of marks
// alternate. It reads `faint_edges` and the marks of the pass before, so the order of cells does not matter.
// `depth_edges_count`, workgroups that loop over blocks of cells, reads marks and `sample_bits`. It writes `cell_words`
// (cell_words.wgsl) for the later passes of `depth_cells`. A word of marks has 16 samples of a row: in bits 0 to 15 the
// edges to their right, in bits 16 to 31 those below. Marks are exact (docs/numerics/depth-maps.md, "Exact decisions").

#import depth_map/cell_words
#import depth_map/edge_rule
#import depth_map/edge_strips
#import depth_map/samples

// The marks of the pass before, which is `depth_edges_mark` or `depth_edges_continue`.
@group(0) @binding(7) var<storage, read> edges_before: array<u32>;
@group(0) @binding(8) var<storage, read_write> edges: array<u32>;
// Edges of level 1 (edge_rule.wgsl), which become marked if they continue others. Without CONTINUES one unwritten word.
@group(0) @binding(9) var<storage, read_write> faint_edges: array<u32>;
// A word for 16 samples of a row. Bits 0 to 15: the sample casts. Bits 16 to 31: the cell to its right and below it is
// split.
@group(0) @binding(10) var<storage, read_write> sample_bits: array<u32>;

// 0: triangles with a marked edge are drawn. 1: also those with a sample that casts, at the end of a marked edge. 2: also
// those with a sample that casts, beside an end that need not cast. All samples on the border of a map of a cube are ends.
override RINGS: u32 = 2u;

const BLOCK: u32 = 256u;
const MARKERS: u32 = 64u;

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

// Where samples are on the border of a map of a cube. The next map may have marked edges there, so they count as ends.
struct Borders {
  // The position in the map of the sample of bit 0.
  in_map: vec2<i32>,
  // A bit for each sample of a row that is in the first or last column of the map, or outside it. 0 for a single map.
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

// Moves bit n of eight bits to bit 4 n.
fn spread_bits(bits: u32) -> u32 {
  let fours = (bits & 0x0fu) | ((bits & 0xf0u) << 12u);
  let pairs = (fours & 0x00030003u) | ((fours & 0x000c000cu) << 6u);
  return (pairs & 0x01010101u) | ((pairs & 0x02020202u) << 3u);
}

// Bits for a row of samples. Bit 0 is two samples to the left of the strip of cells.
struct RowOfSamples {
  // Marked edges to the right (x) and down (y).
  marks: vec2<u32>,
  // The result of `edge_ends_of_row`. 0 if RINGS is 0.
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
