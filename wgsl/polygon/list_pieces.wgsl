// Lists pieces of L-twisted polygons, and finds where edges cross as seen from a light.

// For each light of the batch the number of its pieces; then lists of pieces, of as many words each.
@group(0) @binding(9) var<storage, read_write> pieces: array<atomic<u32>>;

const PIECE_COUNTS: u32 = 32u;
// Words of a piece: where it begins, where it ends, and the middle of its polygon.
const PIECE_WORDS: u32 = 9u;

// How far along (a, b) the plane through the light and (c, d) is.
fn cut_at(f: Edge, e: Edge, place: u32) -> f32 {
  let a = bitcast<vec3<f32>>(e.a);
  let b = bitcast<vec3<f32>>(e.b);
  let c = bitcast<vec3<f32>>(f.a);
  let light = scaled_light(place);
  let normal = cross_product(bitcast<vec3<f32>>(f.b) - c, light.xyz - light.w * c);
  let ends = vec2<f32>(dot(normal, a - c), dot(normal, b - c));
  let at = ends.x / (ends.x - ends.y);
  // The signs of both are exactly opposite, but here they are rounded.
  return select(clamp(at, 0.0, 1.0), 0.5, ends.x == ends.y);
}

// The point at which two edges of an outline cross, as seen from the light: on the earlier of them. Pieces of both end here, so
// both take this point.
fn crossing_point(outline: OutlineRange, i: u32, j: u32, place: u32) -> vec3<u32> {
  let e = edge_at(outline.first + min(i, j));
  let f = edge_at(outline.first + max(i, j));
  let a = bitcast<vec3<f32>>(e.a);
  return bitcast<vec3<u32>>(a + cut_at(f, e, place) * (bitcast<vec3<f32>>(e.b) - a));
}

// A point amid the corners of a polygon. It is in no triangle of its surface as a rule, so faces from there are in no plane with
// these. Nothing here can be fused, so it has the same bits for all pieces.
fn middle_of(outline: OutlineRange) -> vec3<f32> {
  var corners: array<vec3<f32>, 4>;
  for (var quarter = 0u; quarter < 4u; quarter++) {
    corners[quarter] = bitcast<vec3<f32>>(place_of(outlines[outline.first + quarter * outline.count / 4u].x));
  }
  return ((corners[0] + corners[1]) + (corners[2] + corners[3])) * 0.25;
}

// Lists a piece from one place to another, or the other way round, so that what is dark is on its left.
fn list_piece(outline: OutlineRange, light: u32, from_end: vec3<u32>, to_end: vec3<u32>, is_turned: bool) {
  let place = atomicAdd(&pieces[light], 1u);
  if (place >= chunk.capacity) {
    return;
  }
  let at = PIECE_COUNTS + PIECE_WORDS * (light * chunk.capacity + place);
  let first = select(from_end, to_end, is_turned);
  let second = select(to_end, from_end, is_turned);
  let middle = bitcast<vec3<u32>>(middle_of(outline));
  for (var axis = 0u; axis < 3u; axis++) {
    atomicStore(&pieces[at + axis], first[axis]);
    atomicStore(&pieces[at + 3u + axis], second[axis]);
    atomicStore(&pieces[at + 6u + axis], middle[axis]);
  }
}
