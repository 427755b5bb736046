// Cells of a depth map, eight in a word: those that follow each other in a row. A row's last word may have fewer. A block has 256
// words.

// For each block its listed cells, then those of all blocks before it. After them the words: for each cell three bits of its
// entry.
@group(0) @binding(2) var<storage, read_write> places: array<u32>;

const BLOCK: u32 = 256u;
const WORD_CELLS: u32 = 8u;
// A bit of each cell of a word.
const EACH: u32 = 0x11111111u;

// Words of a row of cells, and the cells.
fn row_of_cells() -> vec2<u32> {
  let across = select(depth_map.size.x + 1u, depth_map.size.x - 1u, depth_map.faces > 1u);
  return vec2<u32>((across + WORD_CELLS - 1u) / WORD_CELLS, across);
}

struct CellsOfWord {
  count: u32,
  // Where the first is, on the lattice and in its map.
  corner: vec2<u32>,
  in_map: vec2<u32>,
}

// Devices divide slowly, so rows are found once.
fn cells_of_word(word: u32) -> CellsOfWord {
  let cells = row_of_cells();
  let row = word / cells.x;
  let column = (word - row * cells.x) * WORD_CELLS;
  let count = select(0u, min(WORD_CELLS, cells.y - column), row * cells.y + column < depth_map.cells);
  var in_map = vec2<u32>(column, row);
  var corner = in_map;
  if (depth_map.faces > 1u) {
    let face = row / cells.y;
    in_map.y -= face * cells.y;
    corner = vec2<u32>(face % 3u, face / 3u) * depth_map.size.x + in_map;
  }
  return CellsOfWord(count, corner, in_map);
}

// The lowest bit of each cell of a word that is listed.
fn listed_cells(word: u32) -> u32 {
  return ((word >> 1u) | (word >> 2u)) & EACH;
}

// Invocations of a block. Each takes every so many words, so that few meet at a barrier.
const DECIDERS: u32 = 128u;

// It begins with 0.
var<workgroup> total: atomic<u32>;

// Writes what is decided about the cells of a word. How many of them are listed.
fn write_word(block: u32, number: u32, word: u32) -> u32 {
  places[depth_map.blocks + block * BLOCK + number] = word;
  return countOneBits(listed_cells(word));
}

// Writes how many cells of a block are listed, from what each invocation has listed.
fn write_total(block: u32, local: u32, listed: u32) {
  atomicAdd(&total, listed);
  workgroupBarrier();
  if (local == 0u) {
    places[block] = atomicExchange(&total, 0u);
  }
  workgroupBarrier();
}
