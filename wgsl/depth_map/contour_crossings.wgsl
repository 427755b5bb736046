// Stage `contour_crossings`: computes where contours cross marked edges. At the rim of a smooth surface depths say where.
// Elsewhere a line or parabola is fitted to the edges that the contour crosses before and after.
// After `contour_tiles`, which writes its indirect dispatch: an invocation for each row of 16 samples of a listed tile.
// Reads depths, `marks` and `counts`. Writes `crossings`. `contour_walls` reads them and moves them onto its segments. Then
// the near cap of `depth_walls` reads them.
// An invocation writes only the words of its samples. All is integer arithmetic, so crossings are the same on every device.
// A crossing is at least CROSSING_MARGIN from both samples. docs/numerics/contours.md, "Jumps and crossings".

#import depth_map/contour
#import depth_map/contour_rim
#import depth_map/samples

// Crossings of marked edges: a word for each sample of the lattice, in 1/65,536 texel from the sample. Lower 16 bits: on the
// edge to the right. Upper 16 bits: on the edge down. Bits of other edges are not written.
@group(0) @binding(3) var<storage, read_write> crossings: array<u32>;
// From `contour_tiles`: after the words for the counts of `contour_walls` the list of tiles that contours cross, and its
// length.
@group(0) @binding(5) var<storage, read> counts: array<u32>;

const BLOCK: u32 = 256u;

// Edges to each side that a line is fitted to, at most.
const MAX_LINE_EDGES: i32 = 12;
// Edges to each side that a parabola is fitted to, at most.
const MAX_PARABOLA_EDGES: i32 = 8;
// A line is tried first if there are so many edges to each side.
const MIN_LINE_EDGES: i32 = 5;

// Edges that the contour crosses: at MAX_LINE_EDGES the edge whose crossing is computed, below it the edges before, above
// it those after. x and y: from the middle of that edge to the middle of this one, in half texels. z: the axis of this
// edge.
var<private> crossed_edges: array<vec3<i32>, 25>;

// Follows the contour from an edge into the cell `start`. Puts the edges that it crosses into `crossed_edges`, on side -1
// or 1 of MAX_LINE_EDGES. Returns how many: up to MAX_LINE_EDGES, or to where the contour ends or meets another. `edge`:
// a sample and an axis. `exit_edge`: the number of that edge in the cell on its other side, out of which the contour
// leads into `start`.
fn follow_contour(edge: vec3<i32>, start: vec2<i32>, exit_edge: u32, side: i32) -> i32 {
  let origin = 2 * edge.xy + step_along(u32(edge.z));
  var cell = start;
  var entry_edge = (exit_edge + 2u) & 3u;
  for (var count = 0; count < MAX_LINE_EDGES; count++) {
    let other_edges = load_edge_code(cell) & ~(1u << entry_edge);
    if (countOneBits(other_edges) != 1u) {
      return count;
    }
    let next_edge = countTrailingZeros(other_edges);
    let axis = next_edge & 1u;
    crossed_edges[MAX_LINE_EDGES + side * (count + 1)] =
      vec3<i32>(2 * first_sample_of_edge(cell, next_edge) + step_along(axis) - origin, i32(axis));
    cell += step_across(next_edge);
    entry_edge = (next_edge + 2u) & 3u;
  }
  return MAX_LINE_EDGES;
}

// The crossing of a curve with the edge at MAX_LINE_EDGES, in 1/256 texel. The curve is a line or a parabola, fitted by
// least squares to the middles of `count` edges on each side and of this edge. UNKNOWN if the curve does not cross each
// of these edges.
fn fitted_crossing(count: i32, is_line: bool, axis: u32) -> i32 {
  // Sums over the edges with indices i from -count to count, of their middles m: of m, i · m and i² · m.
  var sums = vec2<i32>();
  var first_moments = vec2<i32>();
  var second_moments = vec2<i32>();
  // Turns: 2 * MAX_LINE_EDGES + 1.
  for (var index = -count; index <= count; index++) {
    let middle = crossed_edges[MAX_LINE_EDGES + index].xy;
    sums += middle;
    first_moments += index * middle;
    second_moments += index * index * middle;
  }
  let edge_count = 2 * count + 1;
  // Sums of i² and i⁴, and the determinant of the normal equations.
  let squares = count * (count + 1) * edge_count / 3;
  let fourths = squares * (3 * count * (count + 1) - 1) / 5;
  let determinant = edge_count * fourths - squares * squares;
  // The curve is `middle` + i · `slope` + i² · `bend` / 64, in 1/256 texel.
  var middle = sums * (TEXEL / 2) / edge_count;
  var bend = vec2<i32>();
  if (!is_line) {
    middle = (fourths * sums - squares * second_moments) * (TEXEL / 2) / determinant;
    bend = (edge_count * second_moments - squares * sums) * (TEXEL * 32) / determinant;
  }
  let slope = first_moments * (TEXEL / 2) / squares;
  // Turns: 2 * MAX_LINE_EDGES + 1.
  for (var index = -count; index <= count; index++) {
    let edge = crossed_edges[MAX_LINE_EDGES + index];
    let offset = edge.xy * (TEXEL / 2) - middle - index * slope - index * index * bend / 64;
    let direction = slope + index * bend / 32;
    // The component across the edge.
    let across = abs(direction[1 - edge.z]);
    if (across == 0 || abs(offset.x * direction.y - offset.y * direction.x) > across * (TEXEL / 2)) {
      return UNKNOWN;
    }
  }
  return TEXEL / 2 + middle[axis] - middle[1u - axis] * slope[axis] / slope[1u - axis];
}

// The crossing of a contour with an edge, by the edges that the contour crosses before and after. The middle of the edge if
// no curve fits.
fn crossing_by_neighbours(sample: vec2<i32>, axis: u32) -> i32 {
  // The cells on both sides of the edge: above and below it, or to its left and right.
  var counts: array<i32, 2>;
  for (var side = 0u; side < 2u; side++) {
    let exit_edge = select(2u * side, 3u - 2u * side, axis == 1u);
    let cell = select(sample + step_across(exit_edge), sample, side == 1u);
    counts[side] = follow_contour(vec3<i32>(sample, i32(axis)), cell, exit_edge, 2 * i32(side) - 1);
  }
  crossed_edges[MAX_LINE_EDGES] = vec3<i32>(0, 0, i32(axis));
  let max_count = min(counts[0], counts[1]);
  var crossing = UNKNOWN;
  // First a line through all edges, then parabolas through fewer and fewer. With one edge to each side it is a line again.
  let max_parabola_count = min(max_count, MAX_PARABOLA_EDGES);
  // Turns: MAX_PARABOLA_EDGES + 1.
  for (
    var count = select(max_parabola_count, max_parabola_count + 1, max_count >= MIN_LINE_EDGES);
    count > 0 && crossing == UNKNOWN;
    count--
  ) {
    let is_line = count > max_parabola_count;
    crossing = fitted_crossing(select(count, max_count, is_line), is_line || count == 1, axis);
  }
  return select(crossing, TEXEL / 2, crossing == UNKNOWN);
}

// The crossing of a contour with a marked edge, in 1/256 texel from the edge's first sample.
fn crossing_on_edge(sample: vec2<i32>, axis: u32) -> i32 {
  let step = step_along(axis);
  // The nearer surface is the one that ends at the contour.
  let is_first_nearer = load_distance(sample) < load_distance(sample + step);
  let rim = rim_offset(select(sample + step, sample, is_first_nearer), select(-step, step, is_first_nearer));
  var crossing = select(TEXEL - rim, rim, is_first_nearer);
  if (rim == UNKNOWN) {
    crossing = crossing_by_neighbours(sample, axis);
  }
  return clamp(crossing, CROSSING_MARGIN, TEXEL - CROSSING_MARGIN);
}

// An invocation takes a row of a tile, whose marks are one word.
@compute @workgroup_size(BLOCK)
fn contour_crossings(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) dispatch_size: vec3<u32>,
  @builtin(local_invocation_index) lane: u32,
) {
  let tiles = contour.tiles.y;
  // Offset of the list of tiles.
  let list = tiles * (1u + WALKERS);
  let rows = counts[list + tiles] * u32(TILE);
  let blocks = (rows + BLOCK - 1u) / BLOCK;
  // Turns: 1.
  for (var block = workgroup.x + dispatch_size.x * workgroup.y; block < blocks; block += dispatch_size.x * dispatch_size.y) {
    let row = block * BLOCK + lane;
    if (row < rows) {
      let tile = counts[list + row / u32(TILE)];
      let first = vec2<u32>(tile % contour.tiles.x, tile / contour.tiles.x) * u32(TILE) + vec2<u32>(0u, row % u32(TILE));
      var remaining = 0u;
      if (first.y < depth_map.size.y + 2u) {
        remaining = marks[first.y * contour.words + first.x / u32(TILE)];
      }
      // Turns: 32.
      for (; remaining != 0u; remaining &= remaining - 1u) {
        let bit = countTrailingZeros(remaining);
        let sample = first + vec2<u32>(bit / 2u, 0u);
        let axis = bit & 1u;
        let word = sample.y * (depth_map.size.x + 2u) + sample.x;
        let crossing = u32(crossing_on_edge(vec2<i32>(sample), axis)) << 8u;
        crossings[word] = (crossings[word] & ~(0xffffu << (16u * axis))) | (crossing << (16u * axis));
      }
    }
  }
}
