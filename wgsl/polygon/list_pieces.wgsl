// The lists of pieces of twisted polygons, and the points where edges cross, for `cut_edges` and `cut_quads`. As seen from
// light L, the boundary of a twisted polygon crosses itself or goes around the light, or a hole is outside. A piece is a
// part of a boundary edge, directed so that the shadow is on its left as seen from the light. All pieces of a polygon are
// the border of its shadow. The counts are cleared for each batch of up to 32 lights before `cut_edges`. `piece_crossings`,
// `piece_arguments` and the vertex shaders of shadow/piece_volumes.wgsl read the lists. A list has no particular order. The
// count of a full list still grows, so that readers notice the overflow, unless a light has 2^32 pieces or more. Points are
// rounded, but all pieces at a crossing must have the same bits: `crossing_point` does not depend on the order of its edges.
// Claims: docs/numerics/twisted-polygons.md.

#import common/determinant
#import extract/one_caster
#import polygon/boundaries

struct Pieces {
  // For each light of the batch the number of its pieces, including those without room.
  counts: array<atomic<u32>, 32>,
  // A list for each light, of `chunk.capacity` pieces.
  words: array<u32>,
}

@group(0) @binding(9) var<storage, read_write> pieces: Pieces;

// Words of a piece: its begin, its end, and the middle of its polygon, three floats each.
const PIECE_WORDS: u32 = 9u;

// About the sine of the angle between an edge and the ray to the light, up to which rounding decides the plane through both.
const LEAST_SINE: f32 = 0x1p-17;

// A finite vector scaled so that its largest absolute component is 1, or less if it is zero or subnormal. Products of such
// vectors do not overflow, and underflow only where others are far larger.
fn to_unit(v: vec3<f32>) -> vec3<f32> {
  return v / max(largest_of(v), 0x1p-126);
}

// The fraction of edge `e`, from 0 to 1, at which it meets the plane through a light and edge `f`, rounded. If the light
// looks along `f`, it is the point where the light sees the first end of `f`. `light` is scaled, or an axis.
fn cut_fraction(f: Edge, e: Edge, light: vec4<f32>) -> f32 {
  let a = bitcast<vec3<f32>>(e.a);
  let b = bitcast<vec3<f32>>(e.b);
  let c = bitcast<vec3<f32>>(f.a);
  let to_light = to_unit(light.xyz - light.w * c);
  var normal = cross_product(to_unit(bitcast<vec3<f32>>(f.b) - c), to_light);
  if (largest_of(normal) <= LEAST_SINE) {
    normal = cross_product(to_unit(cross_product(to_unit(b - a), to_unit(light.xyz - light.w * a))), to_light);
  }
  let scale = max(max(largest_of(a - c), largest_of(b - c)), 0x1p-126);
  let ends = vec2<f32>(dot(normal, (a - c) / scale), dot(normal, (b - c) / scale));
  let fraction = ends.x / (ends.x - ends.y);
  // The exact signs of both are opposite, but here they are rounded.
  return select(clamp(fraction, 0.0, 1.0), 0.5, ends.x == ends.y);
}

// The point on the edge of lower index at which edges i and j of a boundary cross as seen from the light. It is the same if
// i and j are exchanged, since pieces of both edges end here.
fn crossing_point(boundary: PolygonBoundary, i: u32, j: u32, light_index: u32) -> vec3<u32> {
  let e = load_edge(boundary.first + min(i, j));
  let f = load_edge(boundary.first + max(i, j));
  let a = bitcast<vec3<f32>>(e.a);
  return bitcast<vec3<u32>>(a + cut_fraction(f, e, scaled_light(light_index)) * (bitcast<vec3<f32>>(e.b) - a));
}

// The mean of four corners of a polygon. It is in the plane of all triangles if the polygon is flat, and else hardly ever in
// that of one. Faces that pieces make with it lie on the surface of a flat polygon, where rounding decides depth tests. No
// operation can be fused, so it has the same bits for all pieces.
fn middle_point(boundary: PolygonBoundary) -> vec3<u32> {
  var corners: array<vec3<f32>, 4>;
  for (var quarter = 0u; quarter < 4u; quarter++) {
    corners[quarter] = bitcast<vec3<f32>>(position_of(boundaries[boundary.first + quarter * boundary.count / 4u].x));
  }
  return bitcast<vec3<u32>>(((corners[0] + corners[1]) + (corners[2] + corners[3])) * 0.25);
}

// Reserves pieces in a light's list, and returns the index of the first. It may be past the end (`write_piece`).
fn reserve_pieces(light: u32, count: u32) -> u32 {
  return atomicAdd(&pieces.counts[light], count);
}

// The offset of a piece's words.
fn piece_offset(light: u32, index: u32) -> u32 {
  return PIECE_WORDS * (light * chunk.capacity + index);
}

// Writes a piece from one point to another, or, if `is_reversed`, the other way round. Past the end of the list it writes
// nothing.
fn write_piece(light: u32, index: u32, from_end: vec3<u32>, to_end: vec3<u32>, is_reversed: bool, middle: vec3<u32>) {
  if (index >= chunk.capacity) {
    return;
  }
  let offset = piece_offset(light, index);
  let first = select(from_end, to_end, is_reversed);
  let second = select(to_end, from_end, is_reversed);
  for (var axis = 0u; axis < 3u; axis++) {
    pieces.words[offset + axis] = first[axis];
    pieces.words[offset + 3u + axis] = second[axis];
    pieces.words[offset + 6u + axis] = middle[axis];
  }
}

// Stage `cut_quads`: lists the pieces of twisted quadrilaterals that `polygon_turns` decided. Two neighbouring corners
// turn left and the others right, so the two edges between them cross. Each of the two lobes has the sense of its corners.
// Dispatched after the passes of `cut_edges`, an invocation a record of `undecided`. It appends six pieces for each light of
// TWISTED_QUAD. It must come last, because the passes of `cut_edges` read all listed pieces as their cuts. Both lobes share
// one crossing point, bit for bit.

// Lists the pieces of a quadrilateral for a light: two lobes of three pieces. `first`, 0 or 3, is a corner with the turn of
// the next corner. `is_positive`: corner 0, one of these two, turns left. Edges `first` + 1 and `first` + 3 cross.
fn cut_quad(boundary: PolygonBoundary, light: u32, first: u32, is_positive: bool) {
  var corners: array<vec3<u32>, 4>;
  for (var corner = 0u; corner < 4u; corner++) {
    corners[corner] = position_of(boundaries[boundary.first + (first + corner) % 4u].x);
  }
  let crossing = crossing_point(boundary, (first + 1u) % 4u, (first + 3u) % 4u, light);
  let middle = middle_point(boundary);
  let index = reserve_pieces(light, 6u);
  // The lobe of corners 0 and 1, then that of corners 2 and 3.
  for (var lobe = 0u; lobe < 2u; lobe++) {
    let a = corners[2u * lobe];
    let b = corners[2u * lobe + 1u];
    let is_reversed = is_positive == (lobe == 1u);
    write_piece(light, index + 3u * lobe, a, b, is_reversed, middle);
    write_piece(light, index + 3u * lobe + 1u, b, crossing, is_reversed, middle);
    write_piece(light, index + 3u * lobe + 2u, crossing, a, is_reversed, middle);
  }
}

@compute @workgroup_size(64)
fn cut_quads(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
  let record_count = atomicLoad(&undecided[RECORD_COUNT]);
  let row = BOUNDARY_LANES * groups.x;
  // Turns: 1.
  for (var index = id.y * row + id.x; index < record_count; index += groups.y * row) {
    let record = record_offset(index);
    let boundary = boundary_of(polygon_of(record));
    let turn_0 = atomicLoad(&undecided[record + TURN_0]);
    let turn_1 = atomicLoad(&undecided[record + TURN_1]);
    // Turns: 32.
    for (var remaining = atomicLoad(&undecided[record + TWISTED_QUAD]); remaining != 0u; remaining &= remaining - 1u) {
      let light = firstTrailingBit(remaining);
      let is_positive = ((turn_0 >> light) & 1u) != 0u;
      let has_next_same_turn = ((turn_1 >> light) & 1u) == select(0u, 1u, is_positive);
      // If corner 1 turns otherwise, corner 3, before corner 0, turns as corner 0 does.
      cut_quad(boundary, light, select(3u, 0u, has_next_same_turn), is_positive);
    }
  }
}
