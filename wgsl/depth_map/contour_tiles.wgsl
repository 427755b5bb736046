// Stage `contour_tiles`: lists the tiles of 16 × 16 cells that a contour crosses, in ascending order. A contour crosses
// marked edges. Two passes after `contour_marks`: `contour_tiles_find`, an invocation for each tile; `contour_tiles_list`,
// one workgroup.
// Reads `marks`. Writes the list into `counts`, for `contour_crossings`, `contour_walls` and the near cap of `depth_walls`.
// Writes into `workgroups` the arguments of the indirect dispatches of `contour_crossings` and `contour_walls_trace`.
// The list has each tile with a marked edge in it or on its border. It is sorted, so walls are in the same order on every
// device, and `depth_walls` searches it by bisection.

#import depth_map/contour
#import depth_map/contour_rim
#import depth_map/samples
#import depth_map/scan

// Four parts, with room for all tiles:
// 1. A word for each tile: whether a contour crosses it. Later, for each index of the list, the index of that tile's first
//    wall: `contour_walls` writes it and `depth_walls` reads it.
// 2. WALKERS words for each index of the list, for the counts of `contour_walls`.
// 3. The list of tiles.
// 4. Its length.
@group(0) @binding(5) var<storage, read_write> counts: array<u32>;

// Arguments of the indirect dispatch of `contour_crossings`, then of that of `contour_walls_trace`.
@group(0) @binding(10) var<storage, read_write> workgroups: array<u32>;

const BLOCK: u32 = 256u;
// Tiles of a workgroup of `contour_crossings`, which has BLOCK invocations, too, one for each row of a tile.
const TILES_PER_CROSSINGS_WORKGROUP: u32 = BLOCK / u32(TILE);
// Tiles of a workgroup of `contour_walls_trace`. Loops of an invocation have up to some 25,000 iterations a tile, and
// llvmpipe ends them after 65,535 (src/turns.rs). Bounds of turns are stated for two tiles, in contour_walls.wgsl and by
// WALKER_TILES and TILE_NODES in crates/rimline-testkit/src/turns/bounds.rs: change them together.
const TILES_PER_WALLS_WORKGROUP: u32 = 2u;
// The device's limit for workgroups of a dispatch, across and down. Where tiles need more workgroups, these loop over tiles.
override MAX_WORKGROUPS: u32 = 65535u;

// A word has the marks of the 16 samples of a tile in a row, in pairs: the lower bit for the edge to the right, the upper
// for the edge down. Edges on the tile's right border go down from the first sample of the next word (mask 2). Edges on its
// lower border go to the right from samples of the row below (0x55555555). The lattice has `size` + 2 samples a side.
@compute @workgroup_size(BLOCK)
fn contour_tiles_find(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) dispatch_size: vec3<u32>,
  @builtin(local_invocation_index) lane: u32,
) {
  let tiles = contour.tiles.y;
  let blocks = (tiles + BLOCK - 1u) / BLOCK;
  // Turns: 1.
  for (var block = workgroup.x + dispatch_size.x * workgroup.y; block < blocks; block += dispatch_size.x * dispatch_size.y) {
    let tile = block * BLOCK + lane;
    if (tile < tiles) {
      let column = tile % contour.tiles.x;
      let first_row = tile / contour.tiles.x * u32(TILE);
      let rows = min(u32(TILE), depth_map.size.y + 2u - first_row);
      var marked = 0u;
      // Turns: TILE.
      for (var row = 0u; row < rows; row++) {
        let word = (first_row + row) * contour.words + column;
        marked |= marks[word];
        if (column + 1u < contour.words) {
          marked |= marks[word + 1u] & 2u;
        }
      }
      if (first_row + u32(TILE) < depth_map.size.y + 2u) {
        marked |= marks[(first_row + u32(TILE)) * contour.words + column] & 0x55555555u;
      }
      counts[tile] = select(0u, 1u, marked != 0u);
    }
  }
}

// One workgroup. Each invocation takes a range of tiles: it counts those to list, the counts are scanned, and it lists them.
@compute @workgroup_size(SCAN_LANES)
fn contour_tiles_list(@builtin(local_invocation_index) lane: u32) {
  let tiles = contour.tiles.y;
  let range_length = (tiles + SCAN_LANES - 1u) / SCAN_LANES;
  let begin = min(lane * range_length, tiles);
  let end = min(begin + range_length, tiles);
  var lane_sum = 0u;
  // Turns: MAP_TILES / SCAN_LANES.
  for (var tile = begin; tile < end; tile++) {
    lane_sum += counts[tile];
  }
  var index = sum_before(lane, lane_sum);
  let list = tiles * (1u + WALKERS);
  // Turns: MAP_TILES / SCAN_LANES.
  for (var tile = begin; tile < end; tile++) {
    if (counts[tile] != 0u) {
      counts[list + index] = tile;
      index++;
    }
  }
  // The last invocation has the length of the list.
  if (lane == SCAN_LANES - 1u) {
    counts[list + tiles] = index;
    for (var dispatch = 0u; dispatch < 2u; dispatch++) {
      let tiles_per_workgroup = select(TILES_PER_CROSSINGS_WORKGROUP, TILES_PER_WALLS_WORKGROUP, dispatch == 1u);
      let count = (index + tiles_per_workgroup - 1u) / tiles_per_workgroup;
      // Rounded up without a sum that could wrap: a device without a limit has 2^32 - 1.
      let down = min(count / MAX_WORKGROUPS + min(count % MAX_WORKGROUPS, 1u), MAX_WORKGROUPS);
      workgroups[3u * dispatch] = min(count, MAX_WORKGROUPS);
      workgroups[3u * dispatch + 1u] = down;
      workgroups[3u * dispatch + 2u] = 1u;
    }
  }
}
