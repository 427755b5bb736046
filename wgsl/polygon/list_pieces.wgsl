// The lists of pieces of L-twisted polygons (whose outlines cross themselves as seen from light L), and the points where
// edges cross, for `cut_edges` and `cut_quads`. A piece is a part of an outline's edge, directed so that what the polygon
// darkens is on its left as seen from the light; all pieces of a polygon are the border of what it darkens. The counts are
// cleared for each batch of up to 32 lights before `cut_edges`. The stages `piece_crossings` and `piece_arguments` and the
// vertex shaders of shadow/pieces.wgsl read the lists. A list comes in no particular order; its count goes on where it has
// no room, so that readers can tell. Points are rounded, but all pieces that meet at a crossing must have its bits:
// `crossing_point` takes both edges in the same order, whoever asks. docs/numerics/twisted-polygons.md.

#import common/determinant
#import extract/one_caster
#import polygon/outlines

struct Pieces {
  // For each light of the batch the number of its pieces, also beyond its room.
  counts: array<atomic<u32>, 32>,
  // A list for each light, with room for `chunk.capacity` pieces each.
  words: array<u32>,
}

@group(0) @binding(9) var<storage, read_write> pieces: Pieces;

// Words of a piece: where it begins, where it ends, and the middle of its polygon.
const PIECE_WORDS: u32 = 9u;

// The sine of the angle between an edge and the ray to the light below which rounding decides more of their plane than they
// do.
const END_ON: f32 = 0x1p-17;

// A vector whose largest component is 1, so that products neither vanish nor overflow.
fn to_unit(v: vec3<f32>) -> vec3<f32> {
  return v / max(largest_of(v), 0x1p-126);
}

// How far along edge `e` it meets the plane through a light and edge `f`, from 0 to 1, rounded. If the light looks along
// `f`, it is where the light sees the first end of `f`.
fn cut_at(f: Edge, e: Edge, light: vec4<f32>) -> f32 {
  let a = bitcast<vec3<f32>>(e.a);
  let b = bitcast<vec3<f32>>(e.b);
  let c = bitcast<vec3<f32>>(f.a);
  let sight = to_unit(light.xyz - light.w * c);
  var normal = cross_product(to_unit(bitcast<vec3<f32>>(f.b) - c), sight);
  if (largest_of(normal) <= END_ON) {
    normal = cross_product(to_unit(cross_product(to_unit(b - a), to_unit(light.xyz - light.w * a))), sight);
  }
  let scale = max(max(largest_of(a - c), largest_of(b - c)), 0x1p-126);
  let ends = vec2<f32>(dot(normal, (a - c) / scale), dot(normal, (b - c) / scale));
  let at = ends.x / (ends.x - ends.y);
  // The signs of both are exactly opposite, but here they are rounded.
  return select(clamp(at, 0.0, 1.0), 0.5, ends.x == ends.y);
}

// The point at which edges i and j of an outline cross as seen from the light: on the one of lower number. Pieces of both
// end here, so both take this point, whichever is i.
fn crossing_point(outline: OutlineRange, i: u32, j: u32, place: u32) -> vec3<u32> {
  let e = edge_at(outline.first + min(i, j));
  let f = edge_at(outline.first + max(i, j));
  let a = bitcast<vec3<f32>>(e.a);
  return bitcast<vec3<u32>>(a + cut_at(f, e, scaled_light(place)) * (bitcast<vec3<f32>>(e.b) - a));
}

// A point amid the corners of a polygon, the mean of four. It is hardly ever in the plane of a triangle of its surface, so
// faces that pieces make with it do not lie on that. Nothing here can be fused, so it has the same bits for all pieces.
fn middle_of(outline: OutlineRange) -> vec3<u32> {
  var corners: array<vec3<f32>, 4>;
  for (var quarter = 0u; quarter < 4u; quarter++) {
    corners[quarter] = bitcast<vec3<f32>>(place_of(outlines[outline.first + quarter * outline.count / 4u].x));
  }
  return bitcast<vec3<u32>>(((corners[0] + corners[1]) + (corners[2] + corners[3])) * 0.25);
}

// Takes room for pieces of a light, and returns the place of the first in its list; the others follow it. It may be past the
// end: see `write_piece`.
fn take_room(light: u32, count: u32) -> u32 {
  return atomicAdd(&pieces.counts[light], count);
}

// Where the words of a piece are.
fn piece_at(light: u32, place: u32) -> u32 {
  return PIECE_WORDS * (light * chunk.capacity + place);
}

// Writes a piece from one point to another, or, if `is_turned`, the other way round, to a place of a light's list. If that
// is past the end, nothing is written.
fn write_piece(light: u32, place: u32, from_end: vec3<u32>, to_end: vec3<u32>, is_turned: bool, middle: vec3<u32>) {
  if (place >= chunk.capacity) {
    return;
  }
  let at = piece_at(light, place);
  let first = select(from_end, to_end, is_turned);
  let second = select(to_end, from_end, is_turned);
  for (var axis = 0u; axis < 3u; axis++) {
    pieces.words[at + axis] = first[axis];
    pieces.words[at + 3u + axis] = second[axis];
    pieces.words[at + 6u + axis] = middle[axis];
  }
}

// Stage `cut_quads`: lists the pieces of L-twisted quadrilaterals that `polygon_turns` decided. Two neighbouring corners
// turn to the left and the others to the right, so the two edges between them cross, and each of the two lobes has the sense
// of its corners. Dispatched after the passes of `cut_edges`, if the extractor has lists, one invocation a record of
// `undecided`. It appends six pieces for each light behind those of `cut_edges`. It must come last: the passes of
// `cut_edges` take all that is listed for their cuts. Both lobes share one crossing point, bit for bit.

// Lists the pieces of a quadrilateral for a light: two lobes of three. `first` is a corner that turns as the one after it
// does, 0 or 3; `is_positive` says that corner 0, which is one of these two, turns to the left. Edges `first` + 1 and
// `first` + 3 cross.
fn cut_quad(outline: OutlineRange, light: u32, first: u32, is_positive: bool) {
  var corners: array<vec3<u32>, 4>;
  for (var corner = 0u; corner < 4u; corner++) {
    corners[corner] = place_of(outlines[outline.first + (first + corner) % 4u].x);
  }
  let crossing = crossing_point(outline, (first + 1u) % 4u, (first + 3u) % 4u, light);
  let middle = middle_of(outline);
  let place = take_room(light, 6u);
  // The lobe of corners 0 and 1, and that of corners 2 and 3.
  for (var lobe = 0u; lobe < 2u; lobe++) {
    let a = corners[2u * lobe];
    let b = corners[2u * lobe + 1u];
    let is_turned = is_positive == (lobe == 1u);
    write_piece(light, place + 3u * lobe, a, b, is_turned, middle);
    write_piece(light, place + 3u * lobe + 1u, b, crossing, is_turned, middle);
    write_piece(light, place + 3u * lobe + 2u, crossing, a, is_turned, middle);
  }
}

@compute @workgroup_size(64)
fn cut_quads(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
  let records = atomicLoad(&undecided[RECORD_COUNT]);
  let row = OUTLINE_LANES * groups.x;
  // Turns: 1.
  for (var number = id.y * row + id.x; number < records; number += groups.y * row) {
    let at = record_at(number);
    let outline = outline_of(polygon_of(at));
    let turn_0 = atomicLoad(&undecided[at + TURN_0]);
    let turn_1 = atomicLoad(&undecided[at + TURN_1]);
    // Turns: 32.
    for (var rest = atomicLoad(&undecided[at + TWISTED_QUAD]); rest != 0u; rest &= rest - 1u) {
      let light = firstTrailingBit(rest);
      let is_positive = ((turn_0 >> light) & 1u) != 0u;
      let is_next_alike = ((turn_1 >> light) & 1u) == select(0u, 1u, is_positive);
      // If corner 1 is not alike, corner 3 is, which comes before corner 0.
      cut_quad(outline, light, select(3u, 0u, is_next_alike), is_positive);
    }
  }
}
