// Stage `depth_cells`: lists the cells of a depth map (squares between four samples) that have a triangle to draw. After
// `depth_cube` and `depth_edges`, if these are dispatched; not with contours. In three passes:
// `depth_cells_count`, an invocation for a strip of 8 × 4 cells, reads depths and objects, decides, and writes `cell_words`
// (cell_words.wgsl). `depth_edges_count` may replace it. `depth_cells_scan`, one workgroup, scans the counts of blocks, and
// writes `draws` and the number of listed cells, the first word of `cells`. `depth_cells_list`, workgroups that loop over
// blocks, writes their entries after it (edge_code.wgsl). `depth_surface` reads `cells` and is drawn by `draws`.
// The list is exact and in the same order on every device: integers decide where floats might be wrong. If it overflows, its
// number says so and no entry is read: `depth_surface` takes every cell and decides about it by edge_code.wgsl, without the
// marks of `depth_edges`.

#import depth_map/cell_words
#import depth_map/edge_code
#import depth_map/samples
#import depth_map/scan

// The number of cells to list, then their entries: `depth_map.capacity` at most.
@group(0) @binding(3) var<storage, read_write> cells: array<u32>;
// The indirect draw.
@group(0) @binding(5) var<storage, read_write> draws: array<u32>;

// The shift of the three bits of an entry. They are in the order of cell_words.wgsl.
const ENTRY_BITS: u32 = 29u;

// `strip_words` with `depth_map.spread`, cell by cell, because edges out of a cell count, too.
fn strip_words_by_cell(cells: StripCells) -> vec4<u32> {
  var words = vec4<u32>(0u);
  // Turns: STRIP in all.
  for (var row = 0u; row < cells.count.y; row++) {
    // Turns: STRIP * WORD_CELLS in all.
    for (var column = 0u; column < cells.count.x; column++) {
      words[row] |= (cell_entry_bits(cells.first_sample + vec2<u32>(column, row)) >> ENTRY_BITS) << (4u * column);
    }
  }
  return words;
}

// Keys of five samples below each other, at the upper and lower corners of four cells.
struct Column {
  upper: vec4<u32>,
  lower: vec4<u32>,
}

fn load_column(sample: vec2<u32>) -> Column {
  let down = vec2<u32>(0u, 1u);
  let upper = vec4<u32>(load_key(sample), load_key(sample + down), load_key(sample + 2u * down), load_key(sample + 3u * down));
  return Column(upper, vec4<u32>(upper.yzw, load_key(sample + 4u * down)));
}

// `is_marked` for four edges: 0 or 1 each.
fn marked_edges(a: vec4<u32>, b: vec4<u32>) -> vec4<u32> {
  let marked = vec4<bool>(is_marked(a.x, b.x), is_marked(a.y, b.y), is_marked(a.z, b.z), is_marked(a.w, b.w));
  return select(vec4<u32>(0u), vec4<u32>(1u), marked);
}

// `object_edge_code_without_left` for the cells of four rows.
fn object_edge_codes_without_left(top_right: vec2<u32>, left: Column, right: Column) -> vec4<u32> {
  var codes = vec4<u32>(0u);
  for (var row = 0u; row < STRIP; row++) {
    codes[row] = object_edge_code_without_left(
      top_right + vec2<u32>(0u, row), vec2<u32>(left.upper[row], left.lower[row]),
      vec2<u32>(right.upper[row], right.lower[row]));
  }
  return codes;
}

// The words of a strip (cell_words.wgsl). It goes along four rows at once, so that few samples are loaded twice.
fn strip_words(strip: u32) -> vec4<u32> {
  let cells = cells_of_strip(strip);
  if (SPREADS) {
    return strip_words_by_cell(cells);
  }
  let far = Column(vec4<u32>(FAR_KEY), vec4<u32>(FAR_KEY));
  var left = load_column(cells.first_sample);
  // Four bits a cell: its edges at the top, right and bottom. Bit 3 of the first cell is its edge at the left.
  var marked = marked_edges(left.upper, left.lower) << vec4<u32>(3u);
  var splits = vec4<u32>(0u);
  if (OBJECTS) {
    marked |= (object_edge_codes_without_left(cells.first_sample, far, left) & vec4<u32>(2u)) << vec4<u32>(2u);
  }
  for (var column = 0u; column < WORD_CELLS; column++) {
    let top_right = cells.first_sample + vec2<u32>(column + 1u, 0u);
    let right = load_column(top_right);
    let top_edges = marked_edges(left.upper, right.upper);
    let right_edges = marked_edges(right.upper, right.lower);
    let bottom_edges = vec4<u32>(top_edges.yzw, select(0u, 1u, is_marked(left.lower.w, right.lower.w)));
    var codes = top_edges | (right_edges << vec4<u32>(1u)) | (bottom_edges << vec4<u32>(2u));
    if (OBJECTS) {
      codes |= object_edge_codes_without_left(top_right, left, right);
    }
    let split = vec4<bool>(
      is_split(vec4<u32>(left.upper.x, right.upper.x, left.lower.x, right.lower.x)),
      is_split(vec4<u32>(left.upper.y, right.upper.y, left.lower.y, right.lower.y)),
      is_split(vec4<u32>(left.upper.z, right.upper.z, left.lower.z, right.lower.z)),
      is_split(vec4<u32>(left.upper.w, right.upper.w, left.lower.w, right.lower.w)));
    let shift = vec4<u32>(4u * column);
    marked |= codes << shift;
    splits |= select(vec4<u32>(0u), vec4<u32>(1u), split) << shift;
    left = right;
  }
  return mask_existing_cells(cells, vec4<u32>(
    word_with_triangles(marked.x, splits.x), word_with_triangles(marked.y, splits.y),
    word_with_triangles(marked.z, splits.z), word_with_triangles(marked.w, splits.w)));
}

// `entry_bits` for all cells of a word, from `marked` and `splits` of `strip_words`.
fn word_with_triangles(marked: u32, splits: u32) -> u32 {
  let top = marked & BIT_0_OF_CELLS;
  let right = (marked >> 1u) & BIT_0_OF_CELLS;
  let bottom = (marked >> 2u) & BIT_0_OF_CELLS;
  let left = (right << 4u) | ((marked >> 3u) & 1u);
  let first = top | (splits & left) | (~splits & right);
  let second = bottom | (splits & right) | (~splits & left);
  return splits | (first << 1u) | (second << 2u);
}

// An invocation decides about a strip of each block that its workgroup takes.
@compute @workgroup_size(BLOCK_STRIPS)
fn depth_cells_count(
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
    write_block_count(block, lane, write_strip(strip, strip_words(strip)));
  }
}

// One workgroup. Each invocation takes a range of blocks: it adds up their counts, the sums are scanned, and it writes
// prefix sums.
@compute @workgroup_size(SCAN_LANES)
fn depth_cells_scan(@builtin(local_invocation_index) lane: u32) {
  let range_length = (depth_map.blocks + SCAN_LANES - 1u) / SCAN_LANES;
  let begin = min(lane * range_length, depth_map.blocks);
  let end = min(begin + range_length, depth_map.blocks);
  var lane_sum = 0u;
  // Turns: MAP_BLOCKS / SCAN_LANES.
  for (var block = begin; block < end; block++) {
    lane_sum += cell_words[block];
  }
  var cells_before = sum_before(lane, lane_sum);
  // Turns: MAP_BLOCKS / SCAN_LANES.
  for (var block = begin; block < end; block++) {
    let count = cell_words[block];
    cell_words[block] = cells_before;
    cells_before += count;
  }
  // The last invocation has the sum over all blocks.
  if (lane == SCAN_LANES - 1u) {
    cells[0] = cells_before;
    // A list that overflowed is not read: every cell is drawn, and the vertex shader decides.
    draws[0] = 6u * select(cells_before, depth_map.cells, cells_before > depth_map.capacity);
    draws[1] = 1u;
    draws[2] = 0u;
    draws[3] = 0u;
  }
}

// Invocations that list a block. Each takes STRIPS_PER_LISTER strips.
const LISTERS: u32 = 32u;
const STRIPS_PER_LISTER: u32 = BLOCK_STRIPS / LISTERS;
// For each invocation the index in the list of its first cell.
var<workgroup> first_indices: array<u32, LISTERS>;

@compute @workgroup_size(LISTERS)
fn depth_cells_list(
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
    let first_strip = block * BLOCK_STRIPS + lane * STRIPS_PER_LISTER;
    var lane_count = 0u;
    for (var strip = 0u; strip < STRIPS_PER_LISTER; strip++) {
      lane_count += cell_words[strip_offsets(first_strip + strip).x];
    }
    first_indices[lane] = lane_count;
    workgroupBarrier();
    if (lane == 0u) {
      var sum = cell_words[block];
      for (var lister = 0u; lister < LISTERS; lister++) {
        let count = first_indices[lister];
        first_indices[lister] = sum;
        sum += count;
      }
    }
    workgroupBarrier();
    var index = first_indices[lane];
    // An invocation that has nothing to list skips the loops.
    // Turns: STRIPS_PER_LISTER.
    for (var strip = select(STRIPS_PER_LISTER, 0u, lane_count > 0u); strip < STRIPS_PER_LISTER; strip++) {
      let offsets = strip_offsets(first_strip + strip);
      let strip_cells = cells_of_strip(first_strip + strip);
      // Turns: STRIP.
      for (var row = select(STRIP, 0u, cell_words[offsets.x] > 0u); row < STRIP; row++) {
        let word = cell_words[offsets.y + row];
        // Turns: WORD_CELLS.
        for (
          var remaining = listed_cells(word);
          remaining != 0u && index < depth_map.capacity;
          remaining &= remaining - 1u
        ) {
          let shift = firstTrailingBit(remaining);
          cells[1u + index] =
            ((word >> shift) << ENTRY_BITS) | (strip_cells.first_cell + row * strip_cells.cells_per_row + shift / 4u);
          index++;
        }
      }
    }
    workgroupBarrier();
  }
}
