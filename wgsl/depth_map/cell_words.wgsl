// Cells of a depth map, eight in a word: those that follow each other in a row. Four words below each other are a strip. Strips
// follow each other row by row, and map by map in a cube; the last of a row, and those of the last row, may have fewer cells. A
// block has 64 strips.

#import depth_map/samples

// For each block its listed cells, then those of all blocks before it. After them those of each strip. After them the words of
// strips that have any: for each cell three bits of its entry.
@group(0) @binding(2) var<storage, read_write> places: array<u32>;

const WORD_CELLS: u32 = 8u;
// Words of a strip.
const STRIP: u32 = 4u;
const BLOCK_STRIPS: u32 = 64u;
// A bit of each cell of a word.
const EACH: u32 = 0x11111111u;

struct CellsOfStrip {
  // Across, and down: none, if there is no such strip.
  count: vec2<u32>,
  // Where the first is, on the lattice and in its map.
  corner: vec2<u32>,
  in_map: vec2<u32>,
  // The number of the first cell, and cells of a row.
  number: u32,
  row: u32,
}

// Devices divide slowly, so a strip is found once.
fn cells_of_strip(strip: u32) -> CellsOfStrip {
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
  let corner = vec2<u32>(face % 3u, face / 3u) * depth_map.size.x + in_map;
  return CellsOfStrip(count, corner, in_map, (face * cells.y + in_map.y) * cells.x + in_map.x, cells.x);
}

// A word for each row of a strip, without cells that do not exist.
fn taken_of(own: CellsOfStrip, words: vec4<u32>) -> vec4<u32> {
  let all = select(0u, 0xffffffffu >> ((32u - 4u * own.count.x) & 31u), own.count.x > 0u);
  return select(vec4<u32>(0u), words & vec4<u32>(all), vec4<u32>(0u, 1u, 2u, 3u) < vec4<u32>(own.count.y));
}

// The lowest bit of each cell of a word that is listed.
fn listed_cells(word: u32) -> u32 {
  return ((word >> 1u) | (word >> 2u)) & EACH;
}

// It begins with 0.
var<workgroup> total: atomic<u32>;

// Where the count of a strip is, and its first word.
fn places_of_strip(strip: u32) -> vec2<u32> {
  return vec2<u32>(depth_map.blocks + strip, depth_map.blocks * (1u + BLOCK_STRIPS) + strip * STRIP);
}

// Writes what is decided about the cells of a strip. How many of them are listed.
fn write_strip(strip: u32, words: vec4<u32>) -> u32 {
  let at = places_of_strip(strip);
  let each = countOneBits(vec4<u32>(
    listed_cells(words.x), listed_cells(words.y), listed_cells(words.z), listed_cells(words.w)));
  let listed = each.x + each.y + each.z + each.w;
  places[at.x] = listed;
  if (listed > 0u) {
    for (var row = 0u; row < STRIP; row++) {
      places[at.y + row] = words[row];
    }
  }
  return listed;
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
