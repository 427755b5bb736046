// Depth cells: lists the cells of a depth map that have a triangle to draw, in their order. It has three passes: decide about the
// cells and count those of each block, turn the counts into places, list them. Eight cells that follow each other in a row are
// one word.

// The number of cells, then their entries.
@group(0) @binding(3) var<storage, read_write> cells: array<u32>;
// The indirect draw.
@group(0) @binding(5) var<storage, read_write> draws: array<u32>;

// An entry has the three bits of a cell here.
const ENTRY_BITS: u32 = 29u;

// As `decided`, for each cell by itself.
fn decided_by_cells(own: CellsOfWord) -> u32 {
  var bits = 0u;
  for (var cell = 0u; cell < own.count; cell++) {
    bits |= (templates(own.corner + vec2<u32>(cell, 0u)) >> ENTRY_BITS) << (4u * cell);
  }
  return bits;
}

// Decides about the cells of a word. It walks along the samples above and below them.
fn decided(word: u32) -> u32 {
  let own = cells_of_word(word);
  if (SPREADS && depth_map.spread != 0u) {
    return decided_by_cells(own);
  }
  let corner = own.corner;
  let down = vec2<u32>(0u, 1u);
  var before = vec2<u32>(key_at(corner), key_at(corner + down));
  // Four bits a cell: its edges at the top, right and bottom, and of the first cell that at the left.
  var marked = select(0u, 8u, is_marked(before.x, before.y));
  var splits = 0u;
  if (OBJECTS) {
    marked |= (object_edges(corner, vec2<u32>(FAR_KEY), before) & 2u) << 2u;
  }
  for (var cell = 0u; cell < WORD_CELLS; cell++) {
    let at = corner + vec2<u32>(cell + 1u, 0u);
    let keys = vec2<u32>(key_at(at), key_at(at + down));
    marked |= edges_on_the_right(before, keys) << (4u * cell);
    if (OBJECTS) {
      marked |= object_edges(at, before, keys) << (4u * cell);
    }
    splits |= select(0u, 1u, is_split(vec4<u32>(before.x, keys.x, before.y, keys.y))) << (4u * cell);
    before = keys;
  }
  // The cells that are there.
  let taken = select(0u, 0xffffffffu >> ((32u - 4u * own.count) & 31u), own.count > 0u);
  return triangles_of_word(marked, splits) & taken;
}

// As `template_bits`, for all cells of a word.
fn triangles_of_word(marked: u32, splits: u32) -> u32 {
  let top = marked & EACH;
  let right = (marked >> 1u) & EACH;
  let bottom = (marked >> 2u) & EACH;
  let left = (right << 4u) | ((marked >> 3u) & 1u);
  let first = top | (splits & left) | (~splits & right);
  let second = bottom | (splits & right) | (~splits & left);
  return splits | (either(first, second) << 1u) | (either(second, first) << 2u);
}

// Workgroups take blocks in turn, where a dispatch may not have as many.
@compute @workgroup_size(DECIDERS)
fn depth_cells_count(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(num_workgroups) groups: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  for (var block = group.x + groups.x * group.y; block < depth_map.blocks; block += groups.x * groups.y) {
    var listed = 0u;
    for (var number = local; number < BLOCK; number += DECIDERS) {
      listed += write_word(block, number, decided(block * BLOCK + number));
    }
    write_total(block, local, listed);
  }
}

var<workgroup> sums: array<u32, BLOCK>;

// One workgroup. Each invocation takes a run of blocks. The sums of the runs are scanned, and then the runs are filled in.
@compute @workgroup_size(BLOCK)
fn depth_cells_places(@builtin(local_invocation_index) local: u32) {
  let run = (depth_map.blocks + BLOCK - 1u) / BLOCK;
  let begin = min(local * run, depth_map.blocks);
  let end = min(begin + run, depth_map.blocks);
  var total = 0u;
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

// Invocations that list a block. Each takes a run of words.
const LISTERS: u32 = 32u;
const RUN: u32 = BLOCK / LISTERS;
var<workgroup> before: array<u32, LISTERS>;

@compute @workgroup_size(LISTERS)
fn depth_cells_list(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(num_workgroups) groups: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  for (var block = group.x + groups.x * group.y; block < depth_map.blocks; block += groups.x * groups.y) {
    let begin = block * BLOCK + local * RUN;
    var own = 0u;
    for (var word = begin; word < begin + RUN; word++) {
      own += countOneBits(listed_cells(places[depth_map.blocks + word]));
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
    let row = row_of_cells();
    var column = begin % row.x;
    var first = begin / row.x * row.y + column * WORD_CELLS;
    // An invocation that has nothing to list ends at once.
    for (var word = select(begin + RUN, begin, own > 0u); word < begin + RUN; word++) {
      let bits = places[depth_map.blocks + word];
      for (var left = listed_cells(bits); left != 0u && place < depth_map.capacity; left &= left - 1u) {
        let shift = firstTrailingBit(left);
        cells[1u + place] = ((bits >> shift) << ENTRY_BITS) | (first + shift / 4u);
        place++;
      }
      column++;
      first += WORD_CELLS;
      if (column == row.x) {
        column = 0u;
        first += row.y - row.x * WORD_CELLS;
      }
    }
    workgroupBarrier();
  }
}
