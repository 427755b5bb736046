// Cells of a depth map, eight in a word: those that follow each other in a row. A row's last word may have fewer. A block has 256
// words.

// For each block its listed cells, then those of all blocks before it. After them the words: for each cell three bits of its
// entry.
@group(0) @binding(2) var<storage, read_write> places: array<u32>;

const BLOCK: u32 = 256u;
const WORD_CELLS: u32 = 8u;
// A bit of each cell of a word.
const EACH: u32 = 0x11111111u;

// The first cell of a word, and how many cells it has.
fn cells_of_word(word: u32) -> vec2<u32> {
  let across = select(depth_map.size.x + 1u, depth_map.size.x - 1u, depth_map.faces > 1u);
  let words = (across + WORD_CELLS - 1u) / WORD_CELLS;
  let column = word % words * WORD_CELLS;
  let first = word / words * across + column;
  return vec2<u32>(first, select(0u, min(WORD_CELLS, across - column), first < depth_map.cells));
}

// The lowest bit of each cell of a word that is listed.
fn listed_cells(word: u32) -> u32 {
  return ((word >> 1u) | (word >> 2u)) & EACH;
}

// It begins with 0.
var<workgroup> total: atomic<u32>;

// Writes what is decided about the cells of a word, and how many of its block are listed.
fn write_word(block: u32, local: u32, word: u32) {
  places[depth_map.blocks + block * BLOCK + local] = word;
  atomicAdd(&total, countOneBits(listed_cells(word)));
  workgroupBarrier();
  if (local == 0u) {
    places[block] = atomicExchange(&total, 0u);
  }
  workgroupBarrier();
}
