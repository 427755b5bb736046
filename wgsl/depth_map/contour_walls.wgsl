// Stage `contour_walls`: walks along the contours of each tile, fits segments, and lists a wall over each: a quadrilateral along
// rays of the light, from the nearer surface to the farther one. Flaps are listed, too: they join a wall's top to samples of the
// nearer one.
// After `contour_places`. `contour_walls_take` counts (a workgroup for up to two listed tiles, by the dispatch that
// `contour_tiles` wrote; four cells an invocation), `contour_walls_places` scans (one workgroup), `contour_walls_take` lists,
// with LISTS.
// Reads depths, marks, tiles, places. Writes `walls` and their `draws` for `depth_walls`; `counts` and moved `places` for its
// near cap.
// Both takes walk alike. The list is in order of tiles, invocations, cells and edges, the same on every device. Ends of segments
// do not depend on the walk, so walls close where they meet. Each marked edge is crossed by one wall, no other edge by any.

#import depth_map/contour
#import depth_map/contour_rim
#import depth_map/samples

// Where contours cross edges, from `contour_places`. Listing moves those between the ends of a segment onto it, after its walk
// has read them. Only one invocation has an edge within a tile, but edges of two tiles may share a word.
@group(0) @binding(3) var<storage, read_write> places: array<atomic<u32>>;
// For each listed tile its walls, then those of all tiles before it. After them the walls of each invocation of each tile; the
// list of tiles; its length.
@group(0) @binding(5) var<storage, read_write> counts: array<u32>;
// The number of walls, 3 times 0, then 12 words for each wall: four vertices of a place on the lattice and a distance.
@group(0) @binding(7) var<storage, read_write> walls: array<u32>;
// The indirect draw of the walls, and that of all cells.
@group(0) @binding(8) var<storage, read_write> draws: array<u32>;

// Whether walls are listed, and not only counted.
override LISTS: bool = false;

// Cells of each invocation of a tile.
const WALKER_CELLS: u32 = 4u;
const TILE_CELLS: u32 = 256u;
// Nodes that a segment may have. A power of two. A node is a marked edge of a walk, or the middle of a star at its end.
const WINDOW: u32 = 32u;
// Nodes that a segment is tried to reach beyond the last that it fits.
const TRIES: u32 = 8u;

// Texels whose slope the nearer surface goes away by at least, up to a wall: a side that is narrower than a texel has no sample.
const STEEP: i32 = 4;

// A step out of a cell over an edge: 0 top, 1 right, 2 bottom, 3 left.
struct Step {
  cell: vec2<i32>,
  bit: u32,
}

// Kinds of the next node of a walk.
const NOTHING: u32 = 0u; // There is none.
const EDGE: u32 = 1u; // A marked edge that a step goes over.
// The middle of a star, a cell in which contours end or meet: the walk begins there, or ends there.
const LEFT_STAR: u32 = 2u;
const ENTERED_STAR: u32 = 3u;

// The last nodes of a walk, in a ring. Points are on the lattice, in 256 parts of a texel. x and y: the point where the contour
// crosses the edge, or the middle of a star. z and w: the distances of the surfaces on the left and right of the walk, there.
var<private> ends: array<vec4<i32>, WINDOW>;
// Points of an edge between which a segment must pass. x and y: on the left. z and w: on the right.
var<private> limits: array<vec4<i32>, WINDOW>;
// The sample from which a flap goes to the wall: its point, its distance, and the side of the nearer surface, 0 for left, 1 for
// right. w = 2: none, at a star.
var<private> inners: array<vec4<i32>, WINDOW>;
// x and y: the first sample of an edge, z: its axis; w: the distance of the nearer surface, as it goes on. z = 2: a star's cell.
var<private> edges: array<vec4<i32>, WINDOW>;
// Where the first node of the window is.
var<private> head: u32;
// The next wall's index in the list, or walls counted so far.
var<private> next_wall: u32;

// The index of a node of the window in the ring.
fn slot(node: u32) -> u32 {
  return (head + node) & (WINDOW - 1u);
}

fn cross_product(a: vec2<i32>, b: vec2<i32>) -> i32 {
  return a.x * b.y - a.y * b.x;
}

// Whether the edge of a step lies on the border of a tile, where walks end.
fn is_border(step: Step) -> bool {
  let at = first_sample_of_edge(step.cell, step.bit);
  return select(at.y, at.x, (step.bit & 1u) == 1u) % TILE == 0;
}

// Whether contours end or meet in a cell: one, three or four of its edges are marked.
fn is_star(cell: vec2<i32>) -> bool {
  let edges = countOneBits(load_edge_code(cell));
  return edges != 0u && edges != 2u;
}

// The cell that a step leads to, and the way out of it if a contour goes through.
fn followed(step: Step) -> Step {
  let there = step.cell + step_across(step.bit);
  let others = load_edge_code(there) & ~(1u << ((step.bit + 2u) & 3u));
  return Step(there, countTrailingZeros(others) & 3u);
}

// A step or star by a number, which grows with its row, its column and its edge.
fn number_of(cell: vec2<i32>, bit: u32, is_of_star: bool) -> u32 {
  let local = vec2<u32>(cell) % u32(TILE);
  return ((local.y * u32(TILE) + local.x) * 4u + bit) * 2u + select(0u, 1u, is_of_star);
}

const NO_END: u32 = 0xffffffffu;

// Walks to the next border or star, and gives the number of the step or star there, 0 for a loop. With `least`: 0 if the walk
// comes back to its cell and meets none of a minmod number before, else NO_END.
fn end_of(start: Step, least: bool) -> u32 {
  var step = start;
  // Turns: TILE_CELLS + 1.
  for (var steps = 0u; steps <= TILE_CELLS; steps++) {
    if (is_border(step)) {
      return select(number_of(step.cell, step.bit, false), NO_END, least);
    }
    let back = (step.bit + 2u) & 3u;
    step = followed(step);
    if (is_star(step.cell)) {
      return select(number_of(step.cell, back, true), NO_END, least);
    }
    if (all(step.cell == start.cell) && least) {
      return 0u;
    }
    if (least && number_of(step.cell, 0u, false) < number_of(start.cell, 0u, false)) {
      return NO_END;
    }
    if (all(step.cell == start.cell) && step.bit == start.bit) {
      return 0u;
    }
  }
  return 0u;
}

// Bits of corners of a cell, and of those next to one of them over an edge that is not marked, so of the same surface.
fn spread(samples: u32, code: u32) -> u32 {
  let after = ((samples & ~code) << 1u) & 15u;
  let first = select(0u, 1u, (samples & ~code & 8u) != 0u);
  let before = ((samples >> 1u) & ~code) & 7u;
  let last = select(0u, 8u, (samples & 1u) != 0u && (code & 8u) == 0u);
  return samples | after | first | before | last;
}

// `total` with the moved distance of a corner, shifted down, if its bit is in `samples`. FAR if either is.
fn with_corner(total: i32, cell: vec2<i32>, number: u32, samples: u32, shift: u32) -> i32 {
  if (((samples >> number) & 1u) == 0u) {
    return total;
  }
  let own = biased_distance(cell + corner_offset(number));
  return select(total + (own >> shift), FAR, total == FAR || own == FAR);
}

// The distance in the middle of a star, of the surface that has a corner of the cell: the mean of those of its samples. It has no
// loops, because their turns (src/turns.rs) would count for every node and segment.
fn middle_distance(cell: vec2<i32>, code: u32, corner: u32) -> i32 {
  let samples = spread(spread(spread(1u << (corner & 3u), code), code), code);
  let shift = countOneBits(samples) / 2u;
  let two = with_corner(with_corner(0, cell, 0u, samples, shift), cell, 1u, samples, shift);
  return with_corner(with_corner(two, cell, 2u, samples, shift), cell, 3u, samples, shift);
}

// In the middle of a star: `next`, or the distance of the surface of a corner, if that is strictly between `here` and `next`.
fn nearer_copy(cell: vec2<i32>, code: u32, corner: u32, here: i32, next: i32) -> i32 {
  let own = middle_distance(cell, code, corner);
  return select(next, own, min(here, next) < own && own < max(here, next));
}

// The distance at a node where the wall from `here` to `to` is split: in a star the next one at which another surface ends on the
// way, else `to`.
fn next_copy(edge: vec3<i32>, here: i32, to: i32) -> i32 {
  if (edge.z != 2) {
    return to;
  }
  let code = load_edge_code(edge.xy);
  let one = nearer_copy(edge.xy, code, 0u, here, to);
  let two = nearer_copy(edge.xy, code, 1u, here, one);
  let three = nearer_copy(edge.xy, code, 2u, here, two);
  return nearer_copy(edge.xy, code, 3u, here, three);
}

// Puts a node at the end of the window: its place, the distances of both surfaces there, and the limits of segments that pass it.
fn add_node(count: u32, kind: u32, step: Step) {
  let at = slot(count);
  let is_edge = kind == EDGE;
  let first = first_sample_of_edge(step.cell, step.bit);
  let axis = step.bit & 1u;
  if (!is_edge) {
    let code = load_edge_code(step.cell);
    let own = vec2<i32>(
      middle_distance(step.cell, code, step.bit), middle_distance(step.cell, code, step.bit + 1u));
    ends[at] = vec4<i32>(step.cell * TEXEL + TEXEL / 2, select(own, own.yx, kind == ENTERED_STAR));
    edges[at] = vec4<i32>(step.cell, 2, 0);
    inners[at] = vec4<i32>(0, 0, 0, 2);
    return;
  }
  let lattice = i32(depth_map.size.x) + 2;
  let found = (atomicLoad(&places[u32(first.y * lattice + first.x)]) >> (16u * axis + 8u)) & 255u;
  let left = step.cell + corner_offset(step.bit);
  let right = step.cell + corner_offset(step.bit + 1u);
  let along = right - left;
  let of_left = select(TEXEL - i32(found), i32(found), all(left == first));
  // Walks to both sides take the same sample, of equal ones, too.
  let distances = vec2<i32>(load_distance(left), load_distance(right));
  let is_right = distances.y < distances.x || (distances.y == distances.x && all(right == first));
  var own = vec2<i32>();
  var goes_on = 0;
  for (var turn = 0u; turn < opaque(3u); turn++) {
    // The nearer surface twice: as it goes on, and as steep as it may be.
    let of_right = select(turn == 1u, is_right, turn == 2u);
    let found = surface_distance(
      select(left, right, of_right), select(along, -along, of_right), select(of_left, TEXEL - of_left, of_right),
      select(0, STEEP, turn == 2u));
    goes_on = select(goes_on, found, turn < 2u && of_right == is_right);
    own[u32(of_right)] = found;
  }
  // It ends before the other one.
  let nearer = u32(is_right);
  own[nearer] = min(own[nearer], own[1u - nearer]);
  ends[at] = vec4<i32>(left * TEXEL + along * of_left, own);
  let near = clamp(of_left - contour.sideways, CROSSING_MARGIN, TEXEL - CROSSING_MARGIN);
  let far = clamp(of_left + contour.sideways, CROSSING_MARGIN, TEXEL - CROSSING_MARGIN);
  limits[at] = vec4<i32>(left * TEXEL + along * near, left * TEXEL + along * far);
  edges[at] = vec4<i32>(first, i32(axis), goes_on);
  var sample = select(left, right, is_right);
  // The surface goes on to the sample before.
  let out = select(along, -along, is_right);
  let before = sample - out;
  if (((load_marks(min(sample, before)) >> axis) & 1u) == 0u) {
    sample = before;
  }
  inners[at] = vec4<i32>(sample * TEXEL, biased_distance(sample), select(0, 1, is_right));
}

// Whether the second of three distances is on the line between the others, at `gone` of its `length`, but for the tolerance.
fn is_near(first: i32, own: i32, last: i32, gone: i32, length: i32) -> bool {
  if (first == FAR || own == FAR || last == FAR) {
    return first == own && own == last;
  }
  let to_own = (own - first) >> contour.shift;
  let to_last = (last - first) >> contour.shift;
  return abs(to_own) <= 65536 && abs(to_last) <= 65536
    && abs(to_own * length - to_last * gone) <= contour.tolerance * length;
}

// The distances of the surfaces on the left and right of a node, as they go on.
fn surfaces_of(node: u32) -> vec2<i32> {
  let at = slot(node);
  var own = ends[at].zw;
  if (inners[at].w < 2) {
    own[inners[at].w] = edges[at].w;
  }
  return own;
}

// Whether a segment from the first node of the window to another is near enough to those between them.
fn fits(last: u32) -> bool {
  let start = ends[head];
  let way = ends[slot(last)].xy - start.xy;
  let axis = select(0u, 1u, abs(way.y) > abs(way.x));
  let length = abs(way[axis]);
  let first_surfaces = surfaces_of(0u);
  let last_surfaces = surfaces_of(last);
  // Turns: 36 * TILE_NODES in all.
  for (var node = 1u; node < last; node++) {
    let at = slot(node);
    let left = limits[at].xy - start.xy;
    let right = limits[at].zw - start.xy;
    let passes = cross_product(left, right) > 0 && cross_product(left, way) >= 0 && cross_product(way, right) >= 0
      && cross_product(left - way, right - way) <= 0;
    let own = surfaces_of(node);
    let gone = clamp((ends[at][axis] - start[axis]) * sign(way[axis]), 0, length);
    if (!passes || !is_near(first_surfaces.x, own.x, last_surfaces.x, gone, length)
      || !is_near(first_surfaces.y, own.y, last_surfaces.y, gone, length)) {
      return false;
    }
  }
  return true;
}

fn write_vertex(word: u32, vertex: vec3<i32>) {
  walls[word] = bitcast<u32>(vertex.x);
  walls[word + 1u] = bitcast<u32>(vertex.y);
  walls[word + 2u] = bitcast<u32>(vertex.z);
}

// Takes a wall or flap: lists it, if there is room, and counts it.
fn add_wall(p: vec3<i32>, q: vec3<i32>, r: vec3<i32>, s: vec3<i32>) {
  if (LISTS && next_wall < contour.capacity) {
    let word = 4u + 12u * next_wall;
    write_vertex(word, p);
    write_vertex(word + 3u, q);
    write_vertex(word + 6u, r);
    write_vertex(word + 9u, s);
  }
  next_wall++;
}

// Takes the walls over the segment from the first node of the window to another. Where surfaces meet in a star, it has a wall
// between each two that follow each other. Then the flaps that join its tops to samples of the nearer surfaces, one a side.
fn add_walls(last: u32) {
  let end = slot(last);
  let a = ends[head];
  let b = ends[end];
  // The pairs of distances at both ends that a wall has: the first of both, then those of one end with the other's last.
  var at_a = vec2<i32>(a.z, a.z);
  var at_b = vec2<i32>(b.z, b.z);
  // More than one only where a walk ends in a star: at both ends of 32 walks that the lanes begin together.
  // Turns: TILE_NODES + 5 * 64 in all.
  for (var number = 0u; number < 6u; number++) {
    let is_first = number == 0u;
    let moves_a = is_first || at_a.y != a.w;
    let moves_b = is_first || !moves_a;
    if (!is_first && moves_b && at_b.y == b.w) {
      break;
    }
    at_a = select(at_a.yy, vec2<i32>(at_a.y, next_copy(edges[head].xyz, at_a.y, a.w)), moves_a);
    at_b = select(at_b.yy, vec2<i32>(at_b.y, next_copy(edges[end].xyz, at_b.y, b.w)), moves_b);
    add_wall(vec3<i32>(a.xy, at_a.x), vec3<i32>(a.xy, at_a.y), vec3<i32>(b.xy, at_b.y), vec3<i32>(b.xy, at_b.x));
  }
  for (var side = 0; side < 2; side++) {
    let has_a = inners[head].w == side;
    let has_b = inners[end].w == side;
    if (has_a || has_b) {
      let of_a = vec3<i32>(a.xy, a[2 + side]);
      let of_b = vec3<i32>(b.xy, b[2 + side]);
      add_wall(select(of_a, inners[head].xyz, has_a), of_a, of_b, select(of_b, inners[end].xyz, has_b));
    }
  }
}

// Moves the places on edges between the ends of a segment onto it.
fn move_places(last: u32) {
  let start = ends[head].xy;
  let end = ends[slot(last)].xy;
  // Turns: TILE_NODES in all.
  for (var node = 1u; node < last; node++) {
    let edge = edges[slot(node)];
    let first = edge.xy;
    let axis = u32(edge.z);
    var way = end - start;
    way = select(way, -way, way[1u - axis] < 0);
    let by = max(way[1u - axis], 1);
    let number = way[axis] * (first[1u - axis] * TEXEL - start[1u - axis]);
    let whole = select(number, number - by + 1, number < 0) / by;
    let rest = number - whole * by;
    let found = clamp((start[axis] + whole - first[axis] * TEXEL) * 256 + rest * 256 / by, 1, 65535);
    let lattice = i32(depth_map.size.x) + 2;
    let word = u32(first.y * lattice + first.x);
    // No other invocation changes these bits.
    atomicAnd(&places[word], ~(0xffffu << (16u * axis)));
    atomicOr(&places[word], u32(found) << (16u * axis));
  }
}

// Walks from a node to the end of its contour in the tile, and takes the walls of each segment: the longest that fits is found
// among those up to TRIES nodes beyond the last that did.
fn trace(start_kind: u32, start: Step, first: Step, is_loop: bool) {
  var kind = start_kind;
  var step = start;
  var is_start = true;
  var count = 0u;
  // A walk has at most as many nodes as a tile has cells, and two.
  // Turns: TILE_NODES in all.
  for (var segments = 0u; segments < TILE_CELLS + 2u; segments++) {
    // Turns: TILE_NODES in all.
    while (count < WINDOW && kind != NOTHING) {
      add_node(count, kind, step);
      count++;
      if (is_start) {
        is_start = false;
        kind = EDGE;
        step = first;
      } else if (kind == ENTERED_STAR || is_border(step)) {
        kind = NOTHING;
      } else {
        let next = followed(step);
        if (is_star(next.cell)) {
          kind = ENTERED_STAR;
          step = Step(next.cell, (step.bit + 2u) & 3u);
        } else {
          step = next;
          if (is_loop && all(step.cell == first.cell) && step.bit == first.bit) {
            kind = NOTHING;
          }
        }
      }
    }
    var best = 1u;
    // Turns: 9 * TILE_NODES in all.
    for (var last = 2u; last < count && last <= best + TRIES; last++) {
      if (fits(last)) {
        best = last;
      }
    }
    add_walls(best);
    if (LISTS) {
      move_places(best);
    }
    head = slot(best);
    count -= best;
    if (count == 1u && kind == NOTHING) {
      break;
    }
  }
}

// The edges of a cell at which a contour may begin: all of a star, those on the tile's border, and the right one of a cell that
// may be the first of a loop.
fn begins_at(cell: vec2<i32>) -> u32 {
  let code = load_edge_code(cell);
  let edges = countOneBits(code);
  let at_top = select(0u, 1u, cell.y % TILE == 0) | select(0u, 4u, (cell.y + 1) % TILE == 0);
  let at_left = select(0u, 8u, cell.x % TILE == 0) | select(0u, 2u, (cell.x + 1) % TILE == 0);
  let at_border = code & (at_top | at_left);
  let of_through = select(at_border, 2u, code == 6u && at_border == 0u);
  return select(code, of_through, edges == 2u);
}

// Takes the walls that begin in a cell at one of its edges.
fn take(cell: vec2<i32>, bit: u32) {
  let code = load_edge_code(cell);
  let own = Step(cell, bit);
  let of_star = is_star(cell);
  let other = Step(cell, countTrailingZeros(code & ~(1u << bit)) & 3u);
  // A contour that goes through begins at a border, or is a loop, which its first cell takes.
  let is_loop = !of_star && !is_border(own);
  var way = other;
  if (of_star || is_loop) {
    way = own;
  }
  let end = end_of(way, is_loop);
  let begin = number_of(cell, bit, of_star);
  // Both ends of a walk find it. The one with the minmod number takes it, and a star what ends at its own edge.
  let is_own = of_star && end + 1u == begin;
  if (select(begin <= end || is_own, end == 0u, is_loop)) {
    var kind = LEFT_STAR;
    var start = own;
    if (!of_star) {
      kind = EDGE;
    }
    if (is_loop) {
      way = followed(own);
    } else if (!of_star) {
      start = Step(cell + step_across(bit), (bit + 2u) & 3u);
    }
    trace(kind, start, way, is_loop);
  }
}

@compute @workgroup_size(WALKERS)
fn contour_walls_take(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(num_workgroups) groups: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let cells = vec2<i32>(depth_map.size) + 1;
  let tiles = contour.tiles.y;
  let list = tiles * (1u + WALKERS);
  let count = counts[list + tiles];
  // Turns: WALKER_TILES.
  for (var number = group.x + groups.x * group.y; number < count; number += groups.x * groups.y) {
    let tile = counts[list + number];
    next_wall = 0u;
    let own = tiles + number * WALKERS;
    if (LISTS) {
      next_wall = counts[number];
      // Turns: WALKERS.
      for (var walker = 0u; walker < local; walker++) {
        next_wall += counts[own + walker];
      }
    }
    let corner = vec2<i32>(vec2<u32>(tile % contour.tiles.x, tile / contour.tiles.x)) * TILE;
    // Cells of a row.
    let first = local * WALKER_CELLS;
    let start = corner + vec2<i32>(vec2<u32>(first % u32(TILE), first / u32(TILE)));
    var begins = 0u;
    for (var at = 0; at < i32(WALKER_CELLS); at++) {
      let cell = start + vec2<i32>(at, 0);
      if (all(cell < cells)) {
        begins |= begins_at(cell) << u32(4 * at);
      }
    }
    // Turns: 4 * WALKER_CELLS.
    for (; begins != 0u; begins &= begins - 1u) {
      let at = countTrailingZeros(begins);
      take(start + vec2<i32>(i32(at / 4u), 0), at & 3u);
    }
    if (!LISTS) {
      counts[own + local] = next_wall;
    }
  }
}

const SCANNERS: u32 = 256u;
var<workgroup> sums: array<u32, SCANNERS>;

// One workgroup. Each invocation takes a run of tiles. The sums of the runs are scanned, and then the runs are filled in.
@compute @workgroup_size(SCANNERS)
fn contour_walls_places(@builtin(local_invocation_index) local: u32) {
  let tiles = contour.tiles.y;
  let count = counts[tiles * (2u + WALKERS)];
  let run = (count + SCANNERS - 1u) / SCANNERS;
  let begin = min(local * run, count);
  let end = min(begin + run, count);
  var total = 0u;
  // Turns: MAP_TILES / SCANNERS.
  for (var tile = begin; tile < end; tile++) {
    var own = 0u;
    for (var walker = 0u; walker < WALKERS; walker += 8u) {
      let at = tiles + tile * WALKERS + walker;
      own += counts[at] + counts[at + 1u] + counts[at + 2u] + counts[at + 3u];
      own += counts[at + 4u] + counts[at + 5u] + counts[at + 6u] + counts[at + 7u];
    }
    counts[tile] = own;
    total += own;
  }
  sums[local] = total;
  for (var reach = 1u; reach < SCANNERS; reach *= 2u) {
    workgroupBarrier();
    var before = 0u;
    if (local >= reach) {
      before = sums[local - reach];
    }
    workgroupBarrier();
    sums[local] += before;
  }
  var before = sums[local] - total;
  // Turns: MAP_TILES / SCANNERS.
  for (var tile = begin; tile < end; tile++) {
    let own = counts[tile];
    counts[tile] = before;
    before += own;
  }
  if (local == SCANNERS - 1u) {
    walls[0] = before;
    // A list that overflowed is not read: every cell is drawn by its triangles.
    let overflows = before > contour.capacity;
    draws[0] = 6u * select(before, 0u, overflows);
    draws[1] = 1u;
    draws[2] = 0u;
    draws[3] = 0u;
    draws[4] = 6u * select(0u, depth_map.cells, overflows);
    draws[5] = 1u;
    draws[6] = 0u;
    draws[7] = 0u;
  }
}
