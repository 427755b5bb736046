// The layout in which decisions about cells, each between four samples of a depth map, go from pass to pass: `depth_cells_count`
// or `depth_edges_count` writes it, `depth_cells_places` and `depth_cells_list` read it. No other stage imports it.
// A word has eight cells of a row, four bits each, from the lowest on: 1: it is split from its sample (1, 0) to (0, 1); 2 and 4:
// its first and its second triangle is drawn; 8: unused. A strip is four words below each other, decided by one invocation, and a
// block is 64 strips. Strips follow each other row by row, and map by map in a cube; at the right and at the bottom they may have
// fewer cells.
// A pass that decides has workgroups of BLOCK_STRIPS. Each invocation calls `write_strip`, then the whole workgroup
// `write_total`.
// The list of cells has this order, so it is the same on every device: strips, rows of a strip, cells of a row. Do not change it.

#import depth_map/samples

// First a word for each block: how many of its cells are listed; after `depth_cells_places`, how many are listed before it. Then
// the count of each strip. Then four words for each strip, which are written only where its count is not 0.
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

// The cells of a strip; none, if its number is past the last. Devices divide slowly, so call it once a strip.
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

// The words of a strip, with zeros for cells that do not exist.
fn taken_of(own: CellsOfStrip, words: vec4<u32>) -> vec4<u32> {
  let all = select(0u, 0xffffffffu >> ((32u - 4u * own.count.x) & 31u), own.count.x > 0u);
  return select(vec4<u32>(0u), words & vec4<u32>(all), vec4<u32>(0u, 1u, 2u, 3u) < vec4<u32>(own.count.y));
}

// The lowest bit of each cell that is listed, which is each that has a triangle to draw.
fn listed_cells(word: u32) -> u32 {
  return ((word >> 1u) | (word >> 2u)) & EACH;
}

// Zero at the start, and after each `write_total`.
var<workgroup> total: atomic<u32>;

// Offsets in `places` of the count of a strip, and of its first word.
fn places_of_strip(strip: u32) -> vec2<u32> {
  return vec2<u32>(depth_map.blocks + strip, depth_map.blocks * (1u + BLOCK_STRIPS) + strip * STRIP);
}

// Writes what is decided about the cells of a strip, and returns how many of them are listed.
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

// Writes how many cells of a block are listed: the sum over the workgroup. It has barriers, so all invocations call it.
fn write_total(block: u32, local: u32, listed: u32) {
  atomicAdd(&total, listed);
  workgroupBarrier();
  if (local == 0u) {
    places[block] = atomicExchange(&total, 0u);
  }
  workgroupBarrier();
}
