// Stage `contour_walls`: walks along the contours of each tile, fits segments to their crossings, and lists a wall over each
// segment. A wall is a quadrilateral along rays of the light, from the nearer surface to the farther one. The stage lists
// flaps, too: they join the top of a wall, its end nearer to the light, to samples of the nearer surface. Where walls are
// counted and listed, flaps are among them. After `contour_crossings`, in three passes.
// `contour_walls_trace` counts walls: a workgroup for up to two listed tiles, an invocation for four cells, by the dispatch
// that `contour_tiles` wrote. `contour_walls_scan`, one workgroup, scans the counts. `contour_walls_trace` with LISTS
// lists. Reads depths, `marks`, tiles, `crossings`. Writes `walls` and `draws`, and for the near cap `counts` and moved
// `crossings`.
// Walls are in order of tiles, invocations, cells and edges, the same on every device. Each marked edge is crossed by one
// wall, no other edge by any. The positions and distances of a node do not depend on the direction of a walk, so walls close
// where they meet (docs/numerics/contours.md, "Closed walls").

#import depth_map/contour
#import depth_map/contour_rim
#import depth_map/samples
#import depth_map/scan

// Crossings, from `contour_crossings`. The listing pass moves those between the ends of a segment onto it, after its walk
// has read them. Within a tile only one invocation has an edge, but edges of two tiles may share a word.
@group(0) @binding(3) var<storage, read_write> crossings: array<atomic<u32>>;
// Four parts (contour_tiles.wgsl): for each index of the list of tiles the count of its walls, which the scan replaces by
// the index of its first wall; for each index the counts of its WALKERS invocations; the list of tiles; its length.
@group(0) @binding(5) var<storage, read_write> counts: array<u32>;
// The number of walls, of which more may be found than listed, and three words of 0, which nothing writes. Then 12 words a
// wall: four vertices of x and y on the lattice, in 1/256 texel, and a distance with the bias, or FAR.
@group(0) @binding(7) var<storage, read_write> walls: array<u32>;
// The indirect draw of the walls, then that of all cells.
@group(0) @binding(9) var<storage, read_write> draws: array<u32>;

// Whether walls are listed, not only counted.
override LISTS: bool = false;

// Cells of an invocation, and of a tile.
const WALKER_CELLS: u32 = 4u;
const TILE_CELLS: u32 = 256u;
// Nodes that a segment may have, with its ends. A power of two. The factors of TILE_NODES in comments of turns follow from
// it and from TRIES.
const WINDOW: u32 = 32u;
// Nodes beyond the longest segment so far that are tried as its end.
const TRIES: u32 = 8u;

// From its last sample to the wall, the nearer surface goes away from the light by at least so many times the last
// difference of its distances. A steep side of a body, narrower than a texel, has no sample.
const STEEP: i32 = 4;

// A way out of a cell over one of its edges: 0 top, 1 right, 2 bottom, 3 left.
struct CellExit {
  cell: vec2<i32>,
  edge: u32,
}

// Kinds of nodes. A node is a marked edge that a walk crosses, or the middle of a junction at its end. A junction is a cell
// in which contours end or meet.
const NODE_NONE: u32 = 0u;
const NODE_EDGE: u32 = 1u;
const NODE_JUNCTION_START: u32 = 2u;
const NODE_JUNCTION_END: u32 = 3u;

// The last nodes of a walk, in a ring. Positions are on the lattice, in 1/256 texel.
// x and y: the crossing, or the middle of the junction. z and w: the distances there of the surfaces to the left and right.
var<private> node_points: array<vec4<i32>, WINDOW>;
// Positions on the edge between which a segment must pass. x and y: the left one. z and w: the right one. Not written at a
// junction, which only ends segments.
var<private> node_limits: array<vec4<i32>, WINDOW>;
// The sample that a flap joins to the wall. x, y, z: its position and distance. w: the side of the nearer surface, 0 left, 1
// right; 2 at a junction, which has no flap.
var<private> node_samples: array<vec4<i32>, WINDOW>;
// x and y: the first sample of the edge. z: its axis. w: the distance of the nearer surface, without STEEP. At a junction x
// and y are the cell, and z is 2.
var<private> node_edges: array<vec4<i32>, WINDOW>;
// The index in the rings of the first node of the window.
var<private> window_start: u32;
// The index of the next wall in the list, or the count of walls.
var<private> next_wall: u32;

// The index in the rings of a node of the window.
fn ring_index(node: u32) -> u32 {
  return (window_start + node) & (WINDOW - 1u);
}

fn cross_product(a: vec2<i32>, b: vec2<i32>) -> i32 {
  return a.x * b.y - a.y * b.x;
}

// Whether the edge of an exit is on the border of a tile, where walks end.
fn is_on_tile_border(exit: CellExit) -> bool {
  let sample = first_sample_of_edge(exit.cell, exit.edge);
  return select(sample.y, sample.x, (exit.edge & 1u) == 1u) % TILE == 0;
}

// Whether contours end or meet in a cell: one, three or four of its edges are marked.
fn is_junction(cell: vec2<i32>) -> bool {
  let edge_count = countOneBits(load_edge_code(cell));
  return edge_count != 0u && edge_count != 2u;
}

// The cell that an exit leads to, with its other marked edge as the exit, if it is no junction.
fn next_exit(exit: CellExit) -> CellExit {
  let next_cell = exit.cell + step_across(exit.edge);
  let other_edges = load_edge_code(next_cell) & ~(1u << ((exit.edge + 2u) & 3u));
  return CellExit(next_cell, countTrailingZeros(other_edges) & 3u);
}

// The rank of an end of walks within a tile: by row, column, edge, and whether it is a junction.
fn end_rank(cell: vec2<i32>, edge: u32, is_of_junction: bool) -> u32 {
  let cell_in_tile = vec2<u32>(cell) % u32(TILE);
  return ((cell_in_tile.y * u32(TILE) + cell_in_tile.x) * 4u + edge) * 2u + select(0u, 1u, is_of_junction);
}

// The result of `find_walk_end` if it looks for a loop and finds none.
const NO_RANK: u32 = 0xffffffffu;

// Walks to the next tile border or junction, and returns the rank of that end. 0 is a rank, too: a walk that begins at a
// border or junction is no loop. With `finds_loop` it returns 0 if the walk is a loop of which `start` has the first cell,
// and NO_RANK otherwise.
fn find_walk_end(start: CellExit, finds_loop: bool) -> u32 {
  var exit = start;
  // Turns: TILE_CELLS + 1.
  for (var cells = 0u; cells <= TILE_CELLS; cells++) {
    if (is_on_tile_border(exit)) {
      return select(end_rank(exit.cell, exit.edge, false), NO_RANK, finds_loop);
    }
    let entry_edge = (exit.edge + 2u) & 3u;
    exit = next_exit(exit);
    if (is_junction(exit.cell)) {
      return select(end_rank(exit.cell, entry_edge, true), NO_RANK, finds_loop);
    }
    if (all(exit.cell == start.cell) && finds_loop) {
      return 0u;
    }
    if (finds_loop && end_rank(exit.cell, 0u, false) < end_rank(start.cell, 0u, false)) {
      return NO_RANK;
    }
    if (all(exit.cell == start.cell) && exit.edge == start.edge) {
      return 0u;
    }
  }
  return 0u;
}

// A set of corners of a cell, a bit each, with their neighbours over edges that are not marked, which are of the same
// surface.
fn add_connected_corners(corners: u32, edge_code: u32) -> u32 {
  let after = ((corners & ~edge_code) << 1u) & 15u;
  let first = select(0u, 1u, (corners & ~edge_code & 8u) != 0u);
  let before = ((corners >> 1u) & ~edge_code) & 7u;
  let last = select(0u, 8u, (corners & 1u) != 0u && (edge_code & 8u) == 0u);
  return corners | after | first | before | last;
}

// Adds the distance of a corner, shifted down, to a sum if its bit is in `corners`. The result is FAR if either is.
fn add_corner_distance(sum: i32, cell: vec2<i32>, corner: u32, corners: u32, shift: u32) -> i32 {
  if (((corners >> corner) & 1u) == 0u) {
    return sum;
  }
  let distance = biased_distance(cell + corner_offset(corner));
  return select(sum + (distance >> shift), FAR, sum == FAR || distance == FAR);
}

// The distance of a corner's surface in the middle of a junction: the mean over the corners of the same surface, which are
// one, two or four. Without loops, because their iterations (src/turns.rs) would count for every node and segment.
fn junction_distance(cell: vec2<i32>, edge_code: u32, corner: u32) -> i32 {
  let corners = add_connected_corners(
    add_connected_corners(add_connected_corners(1u << (corner & 3u), edge_code), edge_code), edge_code);
  let shift = countOneBits(corners) / 2u;
  let sum_of_two =
    add_corner_distance(add_corner_distance(0, cell, 0u, corners, shift), cell, 1u, corners, shift);
  return add_corner_distance(add_corner_distance(sum_of_two, cell, 2u, corners, shift), cell, 3u, corners, shift);
}

// In the middle of a junction: the distance of a corner's surface if it is strictly between `from_distance` and `next`, else
// `next`.
fn closer_distance(cell: vec2<i32>, edge_code: u32, corner: u32, from_distance: i32, next: i32) -> i32 {
  let distance = junction_distance(cell, edge_code, corner);
  return select(next, distance, min(from_distance, next) < distance && distance < max(from_distance, next));
}

// Where a wall at a node from `from_distance` to `to_distance` is split: in a junction at the first surface on the way, else
// at `to_distance`. `node_edge`: an element of `node_edges`.
fn next_split(node_edge: vec3<i32>, from_distance: i32, to_distance: i32) -> i32 {
  if (node_edge.z != 2) {
    return to_distance;
  }
  let edge_code = load_edge_code(node_edge.xy);
  let after_0 = closer_distance(node_edge.xy, edge_code, 0u, from_distance, to_distance);
  let after_1 = closer_distance(node_edge.xy, edge_code, 1u, from_distance, after_0);
  let after_2 = closer_distance(node_edge.xy, edge_code, 2u, from_distance, after_1);
  return closer_distance(node_edge.xy, edge_code, 3u, from_distance, after_2);
}

// Adds a node to the window, which has `count` nodes. `exit` crosses the edge of the node; at a junction it has the edge
// over which the walk leaves or enters the cell.
fn add_node(count: u32, kind: u32, exit: CellExit) {
  let index = ring_index(count);
  let is_edge = kind == NODE_EDGE;
  let first = first_sample_of_edge(exit.cell, exit.edge);
  let axis = exit.edge & 1u;
  if (!is_edge) {
    let edge_code = load_edge_code(exit.cell);
    let distances = vec2<i32>(
      junction_distance(exit.cell, edge_code, exit.edge), junction_distance(exit.cell, edge_code, exit.edge + 1u));
    node_points[index] =
      vec4<i32>(exit.cell * TEXEL + TEXEL / 2, select(distances, distances.yx, kind == NODE_JUNCTION_END));
    node_edges[index] = vec4<i32>(exit.cell, 2, 0);
    node_samples[index] = vec4<i32>(0, 0, 0, 2);
    return;
  }
  let lattice_width = i32(depth_map.size.x) + 2;
  let crossing = (atomicLoad(&crossings[u32(first.y * lattice_width + first.x)]) >> (16u * axis + 8u)) & 255u;
  let left = exit.cell + corner_offset(exit.edge);
  let right = exit.cell + corner_offset(exit.edge + 1u);
  let left_to_right = right - left;
  let offset_from_left = select(TEXEL - i32(crossing), i32(crossing), all(left == first));
  // The first sample of the edge counts as the nearer one of two equal ones, so that walks in both directions agree.
  let distances = vec2<i32>(load_distance(left), load_distance(right));
  let is_right_nearer = distances.y < distances.x || (distances.y == distances.x && all(right == first));
  var surfaces = vec2<i32>();
  var nearer_without_steep = 0;
  // The left surface, the right one, and the nearer one again, with STEEP.
  for (var iteration = 0u; iteration < opaque(3u); iteration++) {
    let is_right = select(iteration == 1u, is_right_nearer, iteration == 2u);
    let distance = surface_distance(
      select(left, right, is_right), select(left_to_right, -left_to_right, is_right),
      select(offset_from_left, TEXEL - offset_from_left, is_right), select(0, STEEP, iteration == 2u));
    nearer_without_steep = select(nearer_without_steep, distance, iteration < 2u && is_right == is_right_nearer);
    surfaces[u32(is_right)] = distance;
  }
  // At the wall the nearer surface is not behind the other one.
  let nearer = u32(is_right_nearer);
  surfaces[nearer] = min(surfaces[nearer], surfaces[1u - nearer]);
  node_points[index] = vec4<i32>(left * TEXEL + left_to_right * offset_from_left, surfaces);
  let low = clamp(offset_from_left - contour.sideways, CROSSING_MARGIN, TEXEL - CROSSING_MARGIN);
  let high = clamp(offset_from_left + contour.sideways, CROSSING_MARGIN, TEXEL - CROSSING_MARGIN);
  node_limits[index] = vec4<i32>(left * TEXEL + left_to_right * low, left * TEXEL + left_to_right * high);
  node_edges[index] = vec4<i32>(first, i32(axis), nearer_without_steep);
  var sample = select(left, right, is_right_nearer);
  // The flap begins one sample further back, if the surface has one there.
  let away = select(left_to_right, -left_to_right, is_right_nearer);
  let before = sample - away;
  if (((load_marks(min(sample, before)) >> axis) & 1u) == 0u) {
    sample = before;
  }
  node_samples[index] = vec4<i32>(sample * TEXEL, biased_distance(sample), select(0, 1, is_right_nearer));
}

// The distances of a surface over a segment: a line from the first to the last.
struct SurfaceLine {
  first: i32,
  last: i32,
  length: i32, // The segment's length along its longer axis.
}

// Whether `distance`, at `position` from 0 to `line.length`, is within the tolerance of the line.
fn is_near_line(line: SurfaceLine, distance: i32, position: i32) -> bool {
  if (line.first == FAR || distance == FAR || line.last == FAR) {
    return line.first == distance && distance == line.last;
  }
  let rise = (distance - line.first) >> contour.shift;
  let total_rise = (line.last - line.first) >> contour.shift;
  return abs(rise) <= 65536 && abs(total_rise) <= 65536
    && abs(rise * line.length - total_rise * position) <= contour.tolerance * line.length;
}

// The distances of the surfaces to the left and right of a node, without STEEP.
fn surfaces_without_steep(node: u32) -> vec2<i32> {
  let index = ring_index(node);
  var distances = node_points[index].zw;
  if (node_samples[index].w < 2) {
    distances[node_samples[index].w] = node_edges[index].w;
  }
  return distances;
}

// Whether a segment from the first node of the window to node `last` is near enough to the nodes between them.
fn segment_fits(last: u32) -> bool {
  let start = node_points[window_start];
  let segment = node_points[ring_index(last)].xy - start.xy;
  let axis = select(0u, 1u, abs(segment.y) > abs(segment.x));
  let length = abs(segment[axis]);
  let first_surfaces = surfaces_without_steep(0u);
  let last_surfaces = surfaces_without_steep(last);
  let left_line = SurfaceLine(first_surfaces.x, last_surfaces.x, length);
  let right_line = SurfaceLine(first_surfaces.y, last_surfaces.y, length);
  // Turns: 36 * TILE_NODES in all.
  for (var node = 1u; node < last; node++) {
    let index = ring_index(node);
    let left = node_limits[index].xy - start.xy;
    let right = node_limits[index].zw - start.xy;
    let passes_between = cross_product(left, right) > 0 && cross_product(left, segment) >= 0
      && cross_product(segment, right) >= 0 && cross_product(left - segment, right - segment) <= 0;
    let surfaces = surfaces_without_steep(node);
    let position = clamp((node_points[index][axis] - start[axis]) * sign(segment[axis]), 0, length);
    if (!passes_between || !is_near_line(left_line, surfaces.x, position)
      || !is_near_line(right_line, surfaces.y, position)) {
      return false;
    }
  }
  return true;
}

fn write_vertex(offset: u32, vertex: vec3<i32>) {
  walls[offset] = bitcast<u32>(vertex.x);
  walls[offset + 1u] = bitcast<u32>(vertex.y);
  walls[offset + 2u] = bitcast<u32>(vertex.z);
}

// A wall or flap over a segment from node a to node b: its edges at both, from `begin` to `end`.
struct Wall {
  a_begin: vec3<i32>,
  a_end: vec3<i32>,
  b_begin: vec3<i32>,
  b_end: vec3<i32>,
}

// Counts a wall or flap, and lists its vertices around it if there is room.
fn add_wall(wall: Wall) {
  if (LISTS && next_wall < contour.capacity) {
    let offset = 4u + 12u * next_wall;
    write_vertex(offset, wall.a_begin);
    write_vertex(offset + 3u, wall.a_end);
    write_vertex(offset + 6u, wall.b_end);
    write_vertex(offset + 9u, wall.b_begin);
  }
  next_wall++;
}

// Adds the walls over the segment from the first node of the window to node `last`. In a junction a wall is split at each
// surface that ends there. Then adds flaps, up to one on each side, from the tops of walls to samples of the nearer
// surfaces.
fn add_segment_walls(last: u32) {
  let end = ring_index(last);
  let a = node_points[window_start];
  let b = node_points[end];
  // The distances between which a wall lies at nodes a and b. They advance at both nodes first, then at a up to its last
  // distance, then at b.
  var range_a = vec2<i32>(a.z, a.z);
  var range_b = vec2<i32>(b.z, b.z);
  // More than one only where a walk ends in a junction: for two tiles, at both ends of 16 walks of each lane, which lanes
  // begin together.
  // Turns: TILE_NODES + 5 * 64 in all.
  for (var index = 0u; index < 6u; index++) {
    let is_first = index == 0u;
    let advances_a = is_first || range_a.y != a.w;
    let advances_b = is_first || !advances_a;
    if (!is_first && advances_b && range_b.y == b.w) {
      break;
    }
    range_a = select(
      range_a.yy, vec2<i32>(range_a.y, next_split(node_edges[window_start].xyz, range_a.y, a.w)), advances_a);
    range_b = select(range_b.yy, vec2<i32>(range_b.y, next_split(node_edges[end].xyz, range_b.y, b.w)), advances_b);
    add_wall(Wall(
      vec3<i32>(a.xy, range_a.x), vec3<i32>(a.xy, range_a.y), vec3<i32>(b.xy, range_b.x), vec3<i32>(b.xy, range_b.y)));
  }
  for (var side = 0; side < 2; side++) {
    let has_flap_a = node_samples[window_start].w == side;
    let has_flap_b = node_samples[end].w == side;
    if (has_flap_a || has_flap_b) {
      let top_a = vec3<i32>(a.xy, a[2 + side]);
      let top_b = vec3<i32>(b.xy, b[2 + side]);
      let begin_a = select(top_a, node_samples[window_start].xyz, has_flap_a);
      let begin_b = select(top_b, node_samples[end].xyz, has_flap_b);
      add_wall(Wall(begin_a, top_a, begin_b, top_b));
    }
  }
}

// Moves the crossings between the ends of a segment onto it.
fn move_crossings(last: u32) {
  let start = node_points[window_start].xy;
  let end = node_points[ring_index(last)].xy;
  // Turns: TILE_NODES in all.
  for (var node = 1u; node < last; node++) {
    let edge = node_edges[ring_index(node)];
    let first = edge.xy;
    let axis = u32(edge.z);
    var segment = end - start;
    segment = select(segment, -segment, segment[1u - axis] < 0);
    // The edge's line meets the segment's line at start[axis] + numerator / divisor.
    let divisor = max(segment[1u - axis], 1);
    let numerator = segment[axis] * (first[1u - axis] * TEXEL - start[1u - axis]);
    let quotient = select(numerator, numerator - divisor + 1, numerator < 0) / divisor;
    let remainder = numerator - quotient * divisor;
    let crossing =
      clamp((start[axis] + quotient - first[axis] * TEXEL) * 256 + remainder * 256 / divisor, 1, 65535);
    let lattice_width = i32(depth_map.size.x) + 2;
    let word = u32(first.y * lattice_width + first.x);
    // No other invocation changes these bits.
    atomicAnd(&crossings[word], ~(0xffffu << (16u * axis)));
    atomicOr(&crossings[word], u32(crossing) << (16u * axis));
  }
}

// Walks along a contour in the tile and adds the walls of each segment. The first node is at `start`, the second at the exit
// `first`. A segment ends at the last node that fits; up to TRIES nodes beyond that are tried.
fn trace_walk(start_kind: u32, start: CellExit, first: CellExit, is_loop: bool) {
  var kind = start_kind;
  var exit = start;
  var is_start = true;
  var count = 0u;
  // A walk has at most two nodes more than a tile has cells.
  // Turns: TILE_NODES in all.
  for (var segments = 0u; segments < TILE_CELLS + 2u; segments++) {
    // Turns: TILE_NODES in all.
    while (count < WINDOW && kind != NODE_NONE) {
      add_node(count, kind, exit);
      count++;
      if (is_start) {
        is_start = false;
        kind = NODE_EDGE;
        exit = first;
      } else if (kind == NODE_JUNCTION_END || is_on_tile_border(exit)) {
        kind = NODE_NONE;
      } else {
        let next = next_exit(exit);
        if (is_junction(next.cell)) {
          kind = NODE_JUNCTION_END;
          exit = CellExit(next.cell, (exit.edge + 2u) & 3u);
        } else {
          exit = next;
          if (is_loop && all(exit.cell == first.cell) && exit.edge == first.edge) {
            kind = NODE_NONE;
          }
        }
      }
    }
    var best = 1u;
    // Turns: 9 * TILE_NODES in all.
    for (var last = 2u; last < count && last <= best + TRIES; last++) {
      if (segment_fits(last)) {
        best = last;
      }
    }
    add_segment_walls(best);
    if (LISTS) {
      move_crossings(best);
    }
    window_start = ring_index(best);
    count -= best;
    if (count == 1u && kind == NODE_NONE) {
      break;
    }
  }
}

// The edges of a cell at which a walk may begin. A junction has all its marked edges. Another cell has those on the tile's
// border, or its right edge if it may be the first cell of a loop.
fn start_edges(cell: vec2<i32>) -> u32 {
  let edge_code = load_edge_code(cell);
  let edge_count = countOneBits(edge_code);
  let top_and_bottom = select(0u, 1u, cell.y % TILE == 0) | select(0u, 4u, (cell.y + 1) % TILE == 0);
  let left_and_right = select(0u, 8u, cell.x % TILE == 0) | select(0u, 2u, (cell.x + 1) % TILE == 0);
  let on_border = edge_code & (top_and_bottom | left_and_right);
  // The first cell of a loop has marked edges at the right and bottom only.
  let of_passing = select(on_border, 2u, edge_code == 6u && on_border == 0u);
  return select(edge_code, of_passing, edge_count == 2u);
}

// Adds the walls of the walk that begins in a cell at one of its edges, unless it is traced from its other end.
fn trace_walk_once(cell: vec2<i32>, edge: u32) {
  let edge_code = load_edge_code(cell);
  let start_exit = CellExit(cell, edge);
  let is_from_junction = is_junction(cell);
  let other_exit = CellExit(cell, countTrailingZeros(edge_code & ~(1u << edge)) & 3u);
  // In a cell that is no junction a walk begins at the tile's border, or it may be a loop.
  let may_be_loop = !is_from_junction && !is_on_tile_border(start_exit);
  var first = other_exit;
  if (is_from_junction || may_be_loop) {
    first = start_exit;
  }
  let end = find_walk_end(first, may_be_loop);
  let begin = end_rank(cell, edge, is_from_junction);
  // Invocations find a walk from both ends; it is traced from the end of lower rank. A walk from a junction to the tile's
  // border over one edge is traced from the junction.
  let ends_at_start_edge = is_from_junction && end + 1u == begin;
  if (select(begin <= end || ends_at_start_edge, end == 0u, may_be_loop)) {
    var kind = NODE_JUNCTION_START;
    var start = start_exit;
    if (!is_from_junction) {
      kind = NODE_EDGE;
    }
    if (may_be_loop) {
      first = next_exit(start_exit);
    } else if (!is_from_junction) {
      // The same edge, as the exit of the neighbour into this cell.
      start = CellExit(cell + step_across(edge), (edge + 2u) & 3u);
    }
    trace_walk(kind, start, first, may_be_loop);
  }
}

@compute @workgroup_size(WALKERS)
fn contour_walls_trace(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) dispatch_size: vec3<u32>,
  @builtin(local_invocation_index) lane: u32,
) {
  let cells = vec2<i32>(depth_map.size) + 1;
  let tiles = contour.tiles.y;
  // Offset of the list of tiles.
  let list = tiles * (1u + WALKERS);
  let count = counts[list + tiles];
  // Turns: WALKER_TILES.
  for (var index = workgroup.x + dispatch_size.x * workgroup.y; index < count; index += dispatch_size.x * dispatch_size.y) {
    let tile = counts[list + index];
    next_wall = 0u;
    let lane_counts = tiles + index * WALKERS;
    if (LISTS) {
      next_wall = counts[index];
      // Turns: WALKERS.
      for (var lane_before = 0u; lane_before < lane; lane_before++) {
        next_wall += counts[lane_counts + lane_before];
      }
    }
    let corner = vec2<i32>(vec2<u32>(tile % contour.tiles.x, tile / contour.tiles.x)) * TILE;
    // Four cells of a row.
    let first = lane * WALKER_CELLS;
    let start = corner + vec2<i32>(vec2<u32>(first % u32(TILE), first / u32(TILE)));
    var remaining = 0u;
    for (var column = 0; column < i32(WALKER_CELLS); column++) {
      let cell = start + vec2<i32>(column, 0);
      if (all(cell < cells)) {
        remaining |= start_edges(cell) << u32(4 * column);
      }
    }
    // Turns: 4 * WALKER_CELLS.
    for (; remaining != 0u; remaining &= remaining - 1u) {
      let bit = countTrailingZeros(remaining);
      trace_walk_once(start + vec2<i32>(i32(bit / 4u), 0), bit & 3u);
    }
    if (!LISTS) {
      counts[lane_counts + lane] = next_wall;
    }
  }
}

// One workgroup. Each invocation takes a range of tiles: it adds up their counts, the sums are scanned, and it writes prefix
// sums.
@compute @workgroup_size(SCAN_LANES)
fn contour_walls_scan(@builtin(local_invocation_index) lane: u32) {
  let tiles = contour.tiles.y;
  let count = counts[tiles * (2u + WALKERS)];
  let range_length = (count + SCAN_LANES - 1u) / SCAN_LANES;
  let begin = min(lane * range_length, count);
  let end = min(begin + range_length, count);
  var lane_sum = 0u;
  // Turns: MAP_TILES / SCAN_LANES.
  for (var index = begin; index < end; index++) {
    var tile_sum = 0u;
    for (var walker = 0u; walker < WALKERS; walker += 8u) {
      let offset = tiles + index * WALKERS + walker;
      tile_sum += counts[offset] + counts[offset + 1u] + counts[offset + 2u] + counts[offset + 3u];
      tile_sum += counts[offset + 4u] + counts[offset + 5u] + counts[offset + 6u] + counts[offset + 7u];
    }
    counts[index] = tile_sum;
    lane_sum += tile_sum;
  }
  var walls_before = sum_before(lane, lane_sum);
  // Turns: MAP_TILES / SCAN_LANES.
  for (var index = begin; index < end; index++) {
    let tile_sum = counts[index];
    counts[index] = walls_before;
    walls_before += tile_sum;
  }
  // The last invocation has the sum over all tiles.
  if (lane == SCAN_LANES - 1u) {
    walls[0] = walls_before;
    // Walls of a list that overflowed are not drawn, but the triangles of all cells.
    let overflows = walls_before > contour.capacity;
    draws[0] = 6u * select(walls_before, 0u, overflows);
    draws[1] = 1u;
    draws[2] = 0u;
    draws[3] = 0u;
    draws[4] = 6u * select(0u, depth_map.cells, overflows);
    draws[5] = 1u;
    draws[6] = 0u;
    draws[7] = 0u;
  }
}
