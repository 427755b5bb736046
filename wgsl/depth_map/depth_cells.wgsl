// Stage `depth_cells`: lists the cells of a depth map (each between four samples) that have a triangle to draw. After
// `depth_cube` and `depth_edges`, where these are; not with contours. Reads depths and objects. Three passes:
// `depth_cells_count`, an invocation for a strip of 8 × 4 cells, decides and writes `places` (cell_words.wgsl);
// `depth_edges_count` may replace it. `depth_cells_places`, one workgroup, scans the counts of blocks and writes `draws`.
// `depth_cells_list`, a workgroup for blocks in turn, writes `cells`: their number, then an entry each (edge_code.wgsl).
// `depth_surface` reads `cells` and is drawn by `draws`.
// The list is exact and has one order on every device (cell_words.wgsl). If it overflows, its number says so, and no entry is
// read: `depth_surface` then draws every cell, and decides about it by edge_code.wgsl. Integers decide where floats might be
// wrong.

#import depth_map/cell_words
#import depth_map/edge_code
#import depth_map/samples

// The number of cells, then their entries.
@group(0) @binding(3) var<storage, read_write> cells: array<u32>;
// The indirect draw.
@group(0) @binding(5) var<storage, read_write> draws: array<u32>;

// An entry has the three bits of a cell here.
const ENTRY_BITS: u32 = 29u;

// `decided` for each cell by itself, where edges out of the cell count, too.
fn decided_by_cells(own: CellsOfStrip) -> vec4<u32> {
  var words = vec4<u32>(0u);
  // Turns: STRIP in all.
  for (var row = 0u; row < own.count.y; row++) {
    // Turns: STRIP * WORD_CELLS in all.
    for (var cell = 0u; cell < own.count.x; cell++) {
      words[row] |= (cell_entry_bits(own.corner + vec2<u32>(cell, row)) >> ENTRY_BITS) << (4u * cell);
    }
  }
  return words;
}

// Keys of five samples below each other: the upper four of them, and the lower four.
struct Column {
  upper: vec4<u32>,
  lower: vec4<u32>,
}

fn column_at(at: vec2<u32>) -> Column {
  let down = vec2<u32>(0u, 1u);
  let upper = vec4<u32>(load_key(at), load_key(at + down), load_key(at + 2u * down), load_key(at + 3u * down));
  return Column(upper, vec4<u32>(upper.yzw, load_key(at + 4u * down)));
}

// Which of the edges between samples are marked.
fn marked_each(a: vec4<u32>, b: vec4<u32>) -> vec4<u32> {
  let marked = vec4<bool>(is_marked(a.x, b.x), is_marked(a.y, b.y), is_marked(a.z, b.z), is_marked(a.w, b.w));
  return select(vec4<u32>(0u), vec4<u32>(1u), marked);
}

// `object_edges` for the cells of four rows.
fn object_edges_each(at: vec2<u32>, before: Column, keys: Column) -> vec4<u32> {
  var edges = vec4<u32>(0u);
  for (var row = 0u; row < STRIP; row++) {
    edges[row] = object_edges(
      at + vec2<u32>(0u, row), vec2<u32>(before.upper[row], before.lower[row]), vec2<u32>(keys.upper[row], keys.lower[row]));
  }
  return edges;
}

// The words of a strip (cell_words.wgsl). It walks along its rows at once, so that few samples are loaded again.
fn decided(strip: u32) -> vec4<u32> {
  let own = cells_of_strip(strip);
  if (SPREADS) {
    return decided_by_cells(own);
  }
  let far = Column(vec4<u32>(FAR_KEY), vec4<u32>(FAR_KEY));
  var before = column_at(own.corner);
  // Four bits a cell: its edges at the top, right and bottom, and of the first cell that at the left.
  var marked = marked_each(before.upper, before.lower) << vec4<u32>(3u);
  var splits = vec4<u32>(0u);
  if (OBJECTS) {
    marked |= (object_edges_each(own.corner, far, before) & vec4<u32>(2u)) << vec4<u32>(2u);
  }
  for (var cell = 0u; cell < WORD_CELLS; cell++) {
    let at = own.corner + vec2<u32>(cell + 1u, 0u);
    let keys = column_at(at);
    let top = marked_each(before.upper, keys.upper);
    let right = marked_each(keys.upper, keys.lower);
    let bottom = vec4<u32>(top.yzw, select(0u, 1u, is_marked(before.lower.w, keys.lower.w)));
    var edges = top | (right << vec4<u32>(1u)) | (bottom << vec4<u32>(2u));
    if (OBJECTS) {
      edges |= object_edges_each(at, before, keys);
    }
    let split = vec4<bool>(
      is_split(vec4<u32>(before.upper.x, keys.upper.x, before.lower.x, keys.lower.x)),
      is_split(vec4<u32>(before.upper.y, keys.upper.y, before.lower.y, keys.lower.y)),
      is_split(vec4<u32>(before.upper.z, keys.upper.z, before.lower.z, keys.lower.z)),
      is_split(vec4<u32>(before.upper.w, keys.upper.w, before.lower.w, keys.lower.w)));
    let shift = vec4<u32>(4u * cell);
    marked |= edges << shift;
    splits |= select(vec4<u32>(0u), vec4<u32>(1u), split) << shift;
    before = keys;
  }
  return taken_of(own, vec4<u32>(
    triangles_of_word(marked.x, splits.x), triangles_of_word(marked.y, splits.y),
    triangles_of_word(marked.z, splits.z), triangles_of_word(marked.w, splits.w)));
}

// `template_bits` for all cells of a word: from the edges of each at its top, right and bottom, and of the first at the left.
fn triangles_of_word(marked: u32, splits: u32) -> u32 {
  let top = marked & EACH;
  let right = (marked >> 1u) & EACH;
  let bottom = (marked >> 2u) & EACH;
  let left = (right << 4u) | ((marked >> 3u) & 1u);
  let first = top | (splits & left) | (~splits & right);
  let second = bottom | (splits & right) | (~splits & left);
  return splits | (first << 1u) | (second << 2u);
}

// An invocation decides about a strip; a workgroup takes blocks in turn.
@compute @workgroup_size(BLOCK_STRIPS)
fn depth_cells_count(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(num_workgroups) groups: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  // Turns: ITEMS.
  for (var block = group.x + groups.x * group.y; block < depth_map.blocks; block += groups.x * groups.y) {
    let strip = block * BLOCK_STRIPS + local;
    write_total(block, local, write_strip(strip, decided(strip)));
  }
}

const BLOCK: u32 = 256u;
var<workgroup> sums: array<u32, BLOCK>;

// One workgroup. Each invocation takes a run of blocks. The sums of the runs are scanned, and then the runs are filled in.
@compute @workgroup_size(BLOCK)
fn depth_cells_places(@builtin(local_invocation_index) local: u32) {
  let run = (depth_map.blocks + BLOCK - 1u) / BLOCK;
  let begin = min(local * run, depth_map.blocks);
  let end = min(begin + run, depth_map.blocks);
  var total = 0u;
  // Turns: MAP_BLOCKS / BLOCK.
  for (var block = begin; block < end; block++) {
    total += places[block];
  }
  sums[local] = total;
  for (var reach = 1u; reach < BLOCK; reach *= 2u) {
    workgroupBarrier();
    var before = 0u;
    if (local >= reach) {
      before = sums[local - reach];
    }
    workgroupBarrier();
    sums[local] += before;
  }
  var place = sums[local] - total;
  // Turns: MAP_BLOCKS / BLOCK.
  for (var block = begin; block < end; block++) {
    let count = places[block];
    places[block] = place;
    place += count;
  }
  if (local == BLOCK - 1u) {
    cells[0] = place;
    // A list that overflowed is not read: every cell is drawn, and the vertex shader decides.
    draws[0] = 6u * select(place, depth_map.cells, place > depth_map.capacity);
    draws[1] = 1u;
    draws[2] = 0u;
    draws[3] = 0u;
  }
}

// Invocations that list a block. Each takes a run of strips.
const LISTERS: u32 = 32u;
const RUN: u32 = BLOCK_STRIPS / LISTERS;
var<workgroup> before: array<u32, LISTERS>;

@compute @workgroup_size(LISTERS)
fn depth_cells_list(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(num_workgroups) groups: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  // Turns: ITEMS.
  for (var block = group.x + groups.x * group.y; block < depth_map.blocks; block += groups.x * groups.y) {
    let strips = block * BLOCK_STRIPS + local * RUN;
    var own = 0u;
    for (var number = 0u; number < RUN; number++) {
      own += places[places_of_strip(strips + number).x];
    }
    before[local] = own;
    workgroupBarrier();
    if (local == 0u) {
      var sum = places[block];
      for (var lister = 0u; lister < LISTERS; lister++) {
        let count = before[lister];
        before[lister] = sum;
        sum += count;
      }
    }
    workgroupBarrier();
    var place = before[local];
    // An invocation that has nothing to list ends at once.
    // Turns: RUN.
    for (var number = select(RUN, 0u, own > 0u); number < RUN; number++) {
      let at = places_of_strip(strips + number);
      let strip = cells_of_strip(strips + number);
      // Turns: STRIP.
      for (var row = select(STRIP, 0u, places[at.x] > 0u); row < STRIP; row++) {
        let bits = places[at.y + row];
        // Turns: WORD_CELLS.
        for (var left = listed_cells(bits); left != 0u && place < depth_map.capacity; left &= left - 1u) {
          let shift = firstTrailingBit(left);
          cells[1u + place] = ((bits >> shift) << ENTRY_BITS) | (strip.number + row * strip.row + shift / 4u);
          place++;
        }
      }
    }
    workgroupBarrier();
  }
}
