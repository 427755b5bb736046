// Cut edges: the border of what L-twisted polygons darken, in pieces of their edges. A workgroup takes an entry, as in
// outline.wgsl. NUMERICS.md, "Shadows of twisted polygons".

@group(0) @binding(8) var<storage, read> faces: array<u32>;
// For each light of the batch the number of its pieces; then lists of pieces, of as many words each.
@group(0) @binding(9) var<storage, read_write> pieces: array<atomic<u32>>;

const PIECE_COUNTS: u32 = 32u;
// Words of a piece: where it begins, where it ends, and the first corner of its polygon.
const PIECE_WORDS: u32 = 9u;
// The end of an edge, in the place of an edge that cuts it.
const CORNER: u32 = 0xffffffffu;

// How far along its edge each edge cuts it: 32 words for each invocation of a small outline, and all for a large one.
var<workgroup> cut_places: array<f32, 2048>;
// The edges that cut it, a bit for each. A large outline has a word for each invocation, which took every 64th edge.
var<workgroup> cutting: array<u32, 64>;
var<workgroup> odd: array<atomic<u32>, 64>;

// Whether two edges on one line have the same direction.
fn runs_alike(p: vec3<u32>, q: vec3<u32>, a: vec3<u32>, b: vec3<u32>) -> bool {
  let up = ordered(p) < ordered(q);
  return any((p != q) & (a != b) & (up == (ordered(a) < ordered(b))));
}

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
  return select(0.5, at, at >= 0.0 && at <= 1.0);
}

// Finds what cuts the edge, and whether an odd number of triangles have the directions next to its end, on its left. Both are
// in one loop, so that turns are compiled once.
fn take_cuts(outline: OutlineRange, work: Work, lane: u32) {
  let slot = select(lane, 0u, work.is_large);
  let step = select(1u, OUTLINE_LANES, work.is_large);
  let e = work.edge;
  var own = 0u;
  let triangles = outline.end_triangle - outline.first_triangle;
  let end = select(0u, outline.count + triangles, work.exists);
  for (var item = select(0u, lane, work.is_large); item < end; item += step) {
    let is_edge = item < outline.count;
    var corners: array<vec3<u32>, 3>;
    if (is_edge) {
      let f = edge_at(outline.first + item);
      if (item == work.index || !f.has_length) {
        continue;
      }
      corners[0] = f.a;
      corners[1] = f.b;
    } else {
      let face = 3u * (outline.first_triangle + item - outline.count);
      corners = array<vec3<u32>, 3>(place_of(faces[face]), place_of(faces[face + 1u]), place_of(faces[face + 2u]));
    }
    // Of an edge, the sides of a and b, and those of its ends. Of a triangle its own turn, and the sides of b and a at its edges.
    var signs: array<i32, 7>;
    for (var test = 0u; test < select(7u, 4u, is_edge); test++) {
      var p = corners[0];
      var q = corners[1];
      var r = e.a;
      if (is_edge) {
        if (test >= 2u) {
          p = e.a;
          q = e.b;
          r = corners[test - 2u];
        } else if (test == 1u) {
          r = e.b;
        }
      } else if (test == 0u) {
        r = corners[2];
      } else {
        let side = (test - 1u) / 2u;
        if (test % 2u == 0u && signs[test - 1u] != 0) {
          continue;
        }
        p = corners[side];
        q = corners[(side + 1u) % 3u];
        r = e.b;
        if (test % 2u == 0u) {
          r = e.a;
        }
      }
      signs[test] = turn(p, q, r, work.place).moved;
    }
    if (is_edge) {
      let crosses = signs[0] * signs[1] < 0 && (signs[2] > 0) != (signs[3] > 0);
      if (crosses && (signs[2] == 0 || signs[3] == 0 || signs[2] == signs[1])) {
        own |= 1u << select(item, item / OUTLINE_LANES, work.is_large);
        let at = select(SMALL_OUTLINE * lane, 0u, work.is_large) + item;
        cut_places[at] = cut_at(edge_at(outline.first + item), e, work.place);
      }
      continue;
    }
    var holds = signs[0] != 0;
    for (var side = 0u; side < 3u; side++) {
      var sign = signs[2u * side + 1u];
      if (sign == 0) {
        sign = signs[2u * side + 2u];
      }
      if (sign == 0) {
        sign = select(-1, 1, runs_alike(corners[side], corners[(side + 1u) % 3u], e.a, e.b));
      }
      holds = holds && sign == signs[0];
    }
    if (holds) {
      atomicXor(&odd[slot], 1u);
    }
  }
  cutting[lane] = own;
}

// The point at which two edges of an outline cross, as seen from the light: on the earlier of them. Pieces of both end here, so
// both take this point.
fn crossing_point(outline: OutlineRange, i: u32, j: u32, place: u32) -> vec3<u32> {
  let e = edge_at(outline.first + min(i, j));
  let f = edge_at(outline.first + max(i, j));
  let a = bitcast<vec3<f32>>(e.a);
  return bitcast<vec3<u32>>(a + cut_at(f, e, place) * (bitcast<vec3<f32>>(e.b) - a));
}

// A crossing of an edge: the other edge, and how far along. They are ordered by both.
struct Cut {
  edge: u32,
  at: f32,
}

fn is_before(p: Cut, q: Cut) -> bool {
  return p.at < q.at || (p.at == q.at && p.edge < q.edge);
}

// Lists the piece that ends at a cut, or at the end of the edge.
fn list_piece(outline: OutlineRange, work: Work, lane: u32, last: Cut) {
  var before = Cut(CORNER, -1.0);
  var earlier = 0u;
  var cuts = 0u;
  for (var word = 0u; word < select(1u, OUTLINE_LANES, work.is_large); word++) {
    for (var rest = cutting[select(lane, word, work.is_large)]; rest != 0u; rest &= rest - 1u) {
      let bit = firstTrailingBit(rest);
      let edge = select(bit, OUTLINE_LANES * bit + word, work.is_large);
      let cut = Cut(edge, cut_places[select(SMALL_OUTLINE * lane, 0u, work.is_large) + edge]);
      cuts++;
      if (is_before(cut, last)) {
        earlier++;
        if (before.edge == CORNER || is_before(before, cut)) {
          before = cut;
        }
      }
    }
  }
  // The last piece ends at the end of the edge, and each cut exchanges the sides.
  let is_odd_at_end = (atomicLoad(&odd[select(lane, 0u, work.is_large)]) & 1u) != 0u;
  let is_odd = is_odd_at_end == ((cuts - earlier) % 2u == 0u);
  var ends = array<vec3<u32>, 2>(work.edge.a, work.edge.b);
  for (var end = 0u; end < 2u; end++) {
    let other = select(last.edge, before.edge, end == 0u);
    if (other != CORNER) {
      ends[end] = crossing_point(outline, work.index, other, work.place);
    }
  }
  let place = atomicAdd(&pieces[work.place], 1u);
  if (place >= chunk.capacity) {
    return;
  }
  let at = PIECE_COUNTS + PIECE_WORDS * (work.place * chunk.capacity + place);
  let apex = place_of(outlines[outline.first].x);
  for (var axis = 0u; axis < 3u; axis++) {
    atomicStore(&pieces[at + axis], select(ends[1][axis], ends[0][axis], is_odd));
    atomicStore(&pieces[at + 3u + axis], select(ends[0][axis], ends[1][axis], is_odd));
    atomicStore(&pieces[at + 6u + axis], apex[axis]);
  }
}

@compute @workgroup_size(64)
fn cut_edges(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(local_invocation_index) lane: u32,
) {
  let number = group.y * ENTRY_ROW + group.x;
  var work: Work;
  var own: OutlineRange;
  if (number < atomicLoad(&undecided[ENTRY_COUNT])) {
    let record = record_at(atomicLoad(&undecided[entry_at(number)]));
    own = outline_of(atomicLoad(&undecided[record + POLYGON]));
    // Its lights are those for which it is twisted by now.
    work = work_of(own, atomicLoad(&undecided[entry_at(number) + 1u]), atomicLoad(&undecided[record + LIGHTS]), lane);
  }
  take_cuts(own, work, lane);
  workgroupBarrier();
  if (!work.exists) {
    return;
  }
  // Each of its cuts ends a piece, and so does the end of the edge.
  let ends_edge = !work.is_large || lane == 0u;
  var rest = cutting[lane];
  for (var left = countOneBits(rest) + select(0u, 1u, ends_edge); left > 0u; left--) {
    var last = Cut(CORNER, 2.0);
    if (rest != 0u) {
      let bit = firstTrailingBit(rest);
      rest &= rest - 1u;
      last.edge = select(bit, OUTLINE_LANES * bit + lane, work.is_large);
      last.at = cut_places[select(SMALL_OUTLINE * lane, 0u, work.is_large) + last.edge];
    }
    list_piece(own, work, lane, last);
  }
}
