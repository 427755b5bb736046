// Stage `contour_places`: where on a marked edge a contour crosses it. At the rim of a smooth surface depths tell; elsewhere a
// line or parabola is fitted to the edges that the contour crosses before and after.
// After `contour_tiles`, which writes its indirect dispatch: one invocation for each row of 16 samples of a listed tile. Reads
// depths, `marks`, `counts`. Writes `places`, which `contour_walls` reads and moves, and then the near cap of `depth_walls`
// reads.
// An invocation writes the words of its own samples only. Integers, so places are the same on every device. A place is at least
// LEAST from both samples. docs/numerics/contours.md, "Jumps and places", shows that nothing overflows.

#import depth_map/contour
#import depth_map/contour_rim
#import depth_map/samples

// For each sample of the lattice the places on the edges to its right and below it, 16 bits each, in parts of 65,536 of a texel.
// Only those of marked edges are written.
@group(0) @binding(3) var<storage, read_write> places: array<u32>;
// From `contour_tiles`: the list of tiles that contours cross, behind the room for the counts of `contour_walls`, and its length.
@group(0) @binding(5) var<storage, read> counts: array<u32>;

const BLOCK: u32 = 256u;

// Edges that the contour is followed over to each side, for a line.
const REACH: i32 = 12;
// The same for a parabola.
const BENT: i32 = 8;
// Edges to each side from which on a line is tried first.
const LINE: i32 = 5;

// The edges that the contour crosses before (below REACH) and after (above) the one whose place is asked for, which is at REACH:
// the step from its middle to theirs, in half texels, and their axes.
var<private> crossed: array<vec3<i32>, 25>;

// Follows the contour from an edge into the cell `start` and on, and notes the edges that it crosses, on side -1 or 1 of the
// middle of `crossed`. Returns how many: it ends at REACH, or where the contour ends or meets another. `out`: the number of the
// edge in the cell on its other side, from which one goes out over it into `start`.
fn follow(edge: vec3<i32>, start: vec2<i32>, out: u32, side: i32) -> i32 {
  let origin = 2 * edge.xy + step_along(u32(edge.z));
  var cell = start;
  var back = (out + 2u) & 3u;
  for (var count = 0; count < REACH; count++) {
    let others = code_of_cell(cell) & ~(1u << back);
    if (countOneBits(others) != 1u) {
      return count;
    }
    let bit = countTrailingZeros(others);
    let axis = bit & 1u;
    crossed[REACH + side * (count + 1)] = vec3<i32>(2 * edge_of_cell(cell, bit) + step_along(axis) - origin, i32(axis));
    cell += out_of(bit);
    back = (bit + 2u) & 3u;
  }
  return REACH;
}

// The place where a curve crosses the edge, in parts of a texel: a line or a parabola by least squares through the middles of
// the edges, up to `count` of them on each side. UNTOLD if it does not cross each of these edges.
fn fitted_place(count: i32, is_line: bool, axis: u32) -> i32 {
  // Sums over the places, and those times the edges' numbers and their squares.
  var sums = vec2<i32>();
  var firsts = vec2<i32>();
  var seconds = vec2<i32>();
  // Turns: 2 * REACH + 1.
  for (var number = -count; number <= count; number++) {
    let own = crossed[REACH + number].xy;
    sums += own;
    firsts += number * own;
    seconds += number * number * own;
  }
  let edges = 2 * count + 1;
  let squares = count * (count + 1) * edges / 3;
  let fourths = squares * (3 * count * (count + 1) - 1) / 5;
  let whole = edges * fourths - squares * squares;
  var middle = sums * (TEXEL / 2) / edges;
  // 64 times as fine.
  var bend = vec2<i32>();
  if (!is_line) {
    middle = (fourths * sums - squares * seconds) * (TEXEL / 2) / whole;
    bend = (edges * seconds - squares * sums) * (TEXEL * 32) / whole;
  }
  let way = firsts * (TEXEL / 2) / squares;
  // Turns: 2 * REACH + 1.
  for (var number = -count; number <= count; number++) {
    let edge = crossed[REACH + number];
    let off = edge.xy * (TEXEL / 2) - middle - number * way - number * number * bend / 64;
    let along = way + number * bend / 32;
    let over = abs(along[1 - edge.z]);
    if (over == 0 || abs(off.x * along.y - off.y * along.x) > over * (TEXEL / 2)) {
      return UNTOLD;
    }
  }
  return TEXEL / 2 + middle[axis] - middle[1u - axis] * way[axis] / way[1u - axis];
}

// The place that the course of the contour over edges beside it tells: the middle of the edge, if no curve fits.
fn run_place(at: vec2<i32>, axis: u32) -> i32 {
  // The cells to both sides: above and below, or to the left and right.
  var counts: array<i32, 2>;
  for (var side = 0u; side < 2u; side++) {
    let out = select(2u * side, 3u - 2u * side, axis == 1u);
    let cell = select(at + out_of(out), at, side == 1u);
    counts[side] = follow(vec3<i32>(at, i32(axis)), cell, out, 2 * i32(side) - 1);
  }
  crossed[REACH] = vec3<i32>(0, 0, i32(axis));
  let most = min(counts[0], counts[1]);
  var place = UNTOLD;
  // First a line over all of them, then parabolas over fewer and fewer. Three edges have a line.
  let bent = min(most, BENT);
  // Turns: BENT + 1.
  for (var count = select(bent, bent + 1, most >= LINE); count > 0 && place == UNTOLD; count--) {
    let is_line = count > bent;
    place = fitted_place(select(count, most, is_line), is_line || count == 1, axis);
  }
  return select(place, TEXEL / 2, place == UNTOLD);
}

// Where the contour crosses a marked edge, from its first sample on.
fn place_on(at: vec2<i32>, axis: u32) -> i32 {
  let step = step_along(axis);
  // The surface that is nearer ends there.
  let is_first = distance_at(at) < distance_at(at + step);
  let rim = rim_beyond(select(at + step, at, is_first), select(-step, step, is_first));
  var place = select(TEXEL - rim, rim, is_first);
  if (rim == UNTOLD) {
    place = run_place(at, axis);
  }
  return clamp(place, LEAST, TEXEL - LEAST);
}

// An invocation takes a row of a tile, whose marks are one word.
@compute @workgroup_size(BLOCK)
fn contour_places(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(num_workgroups) groups: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let tiles = contour.tiles.y;
  let list = tiles * (1u + WALKERS);
  let rows = counts[list + tiles] * u32(TILE);
  let blocks = (rows + BLOCK - 1u) / BLOCK;
  // Turns: 1.
  for (var block = group.x + groups.x * group.y; block < blocks; block += groups.x * groups.y) {
    let row = block * BLOCK + local;
    if (row < rows) {
      let tile = counts[list + row / u32(TILE)];
      let first = vec2<u32>(tile % contour.tiles.x, tile / contour.tiles.x) * u32(TILE) + vec2<u32>(0u, row % u32(TILE));
      var left = 0u;
      if (first.y < depth_map.size.y + 2u) {
        left = marks[first.y * contour.words + first.x / u32(TILE)];
      }
      // Turns: 32.
      for (; left != 0u; left &= left - 1u) {
        let bit = countTrailingZeros(left);
        let at = first + vec2<u32>(bit / 2u, 0u);
        let axis = bit & 1u;
        let word = at.y * (depth_map.size.x + 2u) + at.x;
        let place = u32(place_on(vec2<i32>(at), axis)) << 8u;
        places[word] = (places[word] & ~(0xffffu << (16u * axis))) | (place << (16u * axis));
      }
    }
  }
}
