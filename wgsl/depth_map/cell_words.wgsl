// The layout in which decisions about cells, the squares between four samples, go from pass to pass. `depth_cells_count` or
// `depth_edges_count` writes it, `depth_cells_scan` scans the counts of blocks in place, `depth_cells_list` reads it. Only
// the stages `depth_cells` and `depth_edges` import it.
// A word has eight cells of a row, four bits each, from the lowest on. Bit 0: the cell is split from its sample (1, 0) to
// (0, 1). Bits 1 and 2: its first and its second triangle are drawn. Bit 3 is unused.
// A strip is four words below each other, decided by one invocation; a block is 64 strips. Strips follow each other row by
// row and, in a cube, map by map. At the right and at the bottom of a map they may have fewer cells.
// A pass that decides has workgroups of BLOCK_STRIPS. Each invocation calls `write_strip`, then all call
// `write_block_count`. The list of cells is in order of strips, then of rows of a strip, then of cells of a row: the same on
// every device. Keep this order.

#import depth_map/samples

// Three parts. A word for each block: its count of listed cells or, after `depth_cells_scan`, the count in all blocks
// before it. Then the count of each strip. Then four words for each strip, which are stale where its count is 0.
@group(0) @binding(2) var<storage, read_write> cell_words: array<u32>;

// Cells of a word.
const WORD_CELLS: u32 = 8u;
// Words of a strip.
const STRIP: u32 = 4u;
const BLOCK_STRIPS: u32 = 64u;
// Bit 0 of each cell of a word.
const BIT_0_OF_CELLS: u32 = 0x11111111u;

// The cells of a strip.
struct StripCells {
  // Columns and rows of cells: 0 if there is no such strip.
  count: vec2<u32>,
  // The first sample of the first cell: on the lattice, and in its map.
  first_sample: vec2<u32>,
  in_map: vec2<u32>,
  // The index of the first cell, and the number of cells in a row of the map.
  first_cell: u32,
  cells_per_row: u32,
}

// Finds the cells of a strip. Call it once a strip, because devices divide slowly.
fn cells_of_strip(strip: u32) -> StripCells {
  let is_cube = depth_map.faces > 1u;
  let cells = select(depth_map.size + 1u, depth_map.size - 1u, is_cube);
  let strips = (cells + vec2<u32>(WORD_CELLS, STRIP) - 1u) / vec2<u32>(WORD_CELLS, STRIP);
  let row = strip / strips.x;
  var face = 0u;
  if (is_cube) {
    face = row / strips.y;
  }
  let in_map = vec2<u32>(strip - row * strips.x, row - face * strips.y) * vec2<u32>(WORD_CELLS, STRIP);
  let exists = face < depth_map.faces && in_map.y < cells.y;
  let count = select(vec2<u32>(0u), min(vec2<u32>(WORD_CELLS, STRIP), cells - in_map), exists);
  let first_sample = vec2<u32>(face % 3u, face / 3u) * depth_map.size.x + in_map;
  return StripCells(count, first_sample, in_map, (face * cells.y + in_map.y) * cells.x + in_map.x, cells.x);
}

// The words of a strip, with 0 for cells that do not exist.
fn mask_existing_cells(cells: StripCells, words: vec4<u32>) -> vec4<u32> {
  let row_mask = select(0u, 0xffffffffu >> ((32u - 4u * cells.count.x) & 31u), cells.count.x > 0u);
  return select(vec4<u32>(0u), words & vec4<u32>(row_mask), vec4<u32>(0u, 1u, 2u, 3u) < vec4<u32>(cells.count.y));
}

// Bit 0 of each cell of a word that is listed, because one of its triangles is drawn.
fn listed_cells(word: u32) -> u32 {
  return ((word >> 1u) | (word >> 2u)) & BIT_0_OF_CELLS;
}

// The count of a block. Zero at the start, and after each `write_block_count`.
var<workgroup> block_count: atomic<u32>;

// Offsets in `cell_words` of the count of a strip (x) and of its first word (y).
fn strip_offsets(strip: u32) -> vec2<u32> {
  return vec2<u32>(depth_map.blocks + strip, depth_map.blocks * (1u + BLOCK_STRIPS) + strip * STRIP);
}

// Writes the words of a strip, and returns how many of its cells are listed.
fn write_strip(strip: u32, words: vec4<u32>) -> u32 {
  let offsets = strip_offsets(strip);
  let counts = countOneBits(vec4<u32>(
    listed_cells(words.x), listed_cells(words.y), listed_cells(words.z), listed_cells(words.w)));
  let count = counts.x + counts.y + counts.z + counts.w;
  cell_words[offsets.x] = count;
  if (count > 0u) {
    for (var row = 0u; row < STRIP; row++) {
      cell_words[offsets.y + row] = words[row];
    }
  }
  return count;
}

// Writes the count of a block: the sum of `count` over the workgroup. It has barriers, so all invocations must call it.
fn write_block_count(block: u32, lane: u32, count: u32) {
  atomicAdd(&block_count, count);
  workgroupBarrier();
  if (lane == 0u) {
    cell_words[block] = atomicExchange(&block_count, 0u);
  }
  workgroupBarrier();
}
