// Stage `contour_tiles`: lists the tiles of 16 × 16 cells that a contour (marked edges) crosses, in ascending order. Two passes
// after `contour_marks`: `contour_tiles_find`, one invocation a tile; `contour_tiles_list`, one workgroup.
// Reads `marks`. Writes the list and its length into `counts`, for `contour_places`, `contour_walls` and the near cap of
// `depth_walls`; and `workgroups`, the arguments of the indirect dispatches of `contour_places` and `contour_walls_take`.
// No tile with a marked edge on or within its border may be missing, and the order must stay: `depth_walls` searches the list by
// halves. `Turns:` is the most turns of the loop below it; a loop between constants needs none.

#import depth_map/contour
#import depth_map/contour_rim
#import depth_map/samples

// First a word for each tile, whether a contour crosses it. `contour_walls` overwrites the first of these words, now one for each
// number in the list: where the walls of that tile begin, which `depth_walls` reads. Then room for the counts of the WALKERS
// invocations of each listed tile; then the list, and its length.
@group(0) @binding(5) var<storage, read_write> counts: array<u32>;

// Arguments of the indirect dispatch of `contour_places`, then of `contour_walls_take`.
@group(0) @binding(10) var<storage, read_write> workgroups: array<u32>;

const BLOCK: u32 = 256u;
// Tiles of a workgroup of `contour_places`: it has an invocation for each of their rows.
const TILES_OF_ROWS: u32 = BLOCK / u32(TILE);
// Tiles of a workgroup of `contour_walls_take`. An invocation has up to some 25,000 loop turns for each, and may have 65,535 in
// all (src/turns.rs).
const TILES_OF_WALKERS: u32 = 2u;
// The most workgroups of a dispatch across, and down. If a list needs more than both together give, workgroups take further tiles
// in turn.
override MOST_WORKGROUPS: u32 = 65535u;

// A word has the marks of the 16 samples of a tile in a row, two bits each: the lower for the edge to the right, the upper for
// the edge down. Edges at the tile's right border go down from the first sample of the next word (mask 2); edges at its lower
// border go to the right from the samples of the row below (0x55555555). Samples have a border of one around the map: `size` + 2.
@compute @workgroup_size(BLOCK)
fn contour_tiles_find(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(num_workgroups) groups: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let tiles = contour.tiles.y;
  let blocks = (tiles + BLOCK - 1u) / BLOCK;
  // Turns: 1.
  for (var block = group.x + groups.x * group.y; block < blocks; block += groups.x * groups.y) {
    let tile = block * BLOCK + local;
    if (tile < tiles) {
      let column = tile % contour.tiles.x;
      let first = tile / contour.tiles.x * u32(TILE);
      let rows = min(u32(TILE), depth_map.size.y + 2u - first);
      var found = 0u;
      // Turns: TILE.
      for (var row = 0u; row < rows; row++) {
        let word = (first + row) * contour.words + column;
        found |= marks[word];
        if (column + 1u < contour.words) {
          found |= marks[word + 1u] & 2u;
        }
      }
      if (first + u32(TILE) < depth_map.size.y + 2u) {
        found |= marks[(first + u32(TILE)) * contour.words + column] & 0x55555555u;
      }
      counts[tile] = select(0u, 1u, found != 0u);
    }
  }
}

var<workgroup> sums: array<u32, BLOCK>;

// One workgroup. Each invocation takes a run of tiles. The sums of the runs are scanned, and then the list is filled in.
@compute @workgroup_size(BLOCK)
fn contour_tiles_list(@builtin(local_invocation_index) local: u32) {
  let tiles = contour.tiles.y;
  let run = (tiles + BLOCK - 1u) / BLOCK;
  let begin = min(local * run, tiles);
  let end = min(begin + run, tiles);
  var total = 0u;
  // Turns: MAP_TILES / BLOCK.
  for (var tile = begin; tile < end; tile++) {
    total += counts[tile];
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
  var next = sums[local] - total;
  let list = tiles * (1u + WALKERS);
  // Turns: MAP_TILES / BLOCK.
  for (var tile = begin; tile < end; tile++) {
    if (counts[tile] != 0u) {
      counts[list + next] = tile;
      next++;
    }
  }
  if (local == BLOCK - 1u) {
    counts[list + tiles] = next;
    for (var user = 0u; user < 2u; user++) {
      let of_each = select(TILES_OF_ROWS, TILES_OF_WALKERS, user == 1u);
      let all = (next + of_each - 1u) / of_each;
      let down = min((all + MOST_WORKGROUPS - 1u) / MOST_WORKGROUPS, MOST_WORKGROUPS);
      workgroups[3u * user] = min(all, MOST_WORKGROUPS);
      workgroups[3u * user + 1u] = down;
      workgroups[3u * user + 2u] = 1u;
    }
  }
}
