// Cut edges: the border of what L-twisted polygons darken, in pieces of their edges. A workgroup takes an entry, as in
// outline.wgsl. NUMERICS.md, "Shadows of twisted polygons".

@group(0) @binding(8) var<storage, read> faces: array<u32>;
// The end of an edge, in the place of an edge that cuts it.
const CORNER: u32 = 0xffffffffu;

// The places in order of what cuts an edge: 32 words for each invocation of a small outline, and all for a large one.
var<workgroup> ranks: array<u32, 2048>;
// Whether some places in order are those of two.
var<workgroup> is_tangled: array<atomic<u32>, 64>;
var<workgroup> cut_counts: array<atomic<u32>, 64>;
// The edges that cut it, a bit for each. A large outline has a word for each invocation, which took every 64th edge.
var<workgroup> cutting: array<u32, 64>;
var<workgroup> odd: array<atomic<u32>, 64>;

// Whether two edges on one line have the same direction.
fn runs_alike(p: vec3<u32>, q: vec3<u32>, a: vec3<u32>, b: vec3<u32>) -> bool {
  let up = ordered(p) < ordered(q);
  return any((p != q) & (a != b) & (up == (ordered(a) < ordered(b))));
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
        atomicAdd(&cut_counts[slot], 1u);
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

// With more cuts, those of an edge are ordered by how far along they are, which is rounded.
const MOST_ORDERED: u32 = 256u;

// The sides of an edge's plane on which two points are: their own if it is one, or 0 if they are apart.
fn common_side(signs: vec2<i32>) -> i32 {
  return select(select(signs.x, signs.y, signs.x == 0), 0, signs.x * signs.y < 0);
}

// Whether edge j cuts edge e before edge i does. Turns decide where the one cut is on one side of the other edge. Otherwise all
// three may cross each other. How far along the earliest of the three the others cut it decides for all three, so that what
// is found for them fits together. NUMERICS.md, "Shadows of twisted polygons", "Order".
fn is_before(outline: OutlineRange, work: Work, j: u32, i: u32, by_turns: bool) -> bool {
  let e = work.edge;
  let f = edge_at(outline.first + i);
  let g = edge_at(outline.first + j);
  var earliest = select(work.index, min(work.index, min(i, j)), by_turns);
  let k = edge_at(outline.first + earliest);
  // The sides of the end of e at f and g; those of the ends of g at f, and of f at g; those of the end of k at both of the others.
  var signs: array<i32, 8>;
  for (var test = 0u; test < select(0u, 8u, by_turns); test++) {
    var p = f;
    if (test == 1u || test == 4u || test == 5u) {
      p = g;
    }
    var r = e.b;
    switch (test) {
      case 2u: { r = g.a; }
      case 3u: { r = g.b; }
      case 4u: { r = f.a; }
      case 5u: { r = f.b; }
      case 6u, 7u: {
        if (earliest == work.index) {
          continue;
        }
        r = k.b;
        p = e;
        if (test == 7u) {
          if (earliest == i) {
            p = g;
          } else {
            p = f;
          }
        }
      }
      default: {}
    }
    signs[test] = turn(p.a, p.b, r, work.place).moved;
  }
  if (by_turns) {
    // The cut of g is on this side of f, or that of f on this side of g.
    let of_g = common_side(vec2<i32>(signs[2], signs[3]));
    if (of_g != 0) {
      return of_g != signs[0];
    }
    let of_f = common_side(vec2<i32>(signs[4], signs[5]));
    if (of_f != 0) {
      return of_f == signs[1];
    }
    // Where they cross each other's opposite directions, nothing has to fit.
    if (signs[2] != signs[5]) {
      earliest = work.index;
    }
  }
  let along = edge_at(outline.first + earliest);
  // How far along the earliest: f and g, or e and the other one.
  var places = vec2<f32>(0.0);
  for (var other = 0u; other < 2u; other++) {
    var cutting = select(i, j, other == 1u);
    if (earliest != work.index) {
      cutting = select(work.index, select(i, j, earliest == i), other == 1u);
    }
    places[other] = cut_at(edge_at(outline.first + cutting), along, work.place);
  }
  if (earliest == work.index) {
    return places.y < places.x || (places.y == places.x && j < i);
  }
  // The sign of the product of what the earliest tells, and of the sides here.
  var sense = signs[0] * signs[1] * signs[6] * signs[7] * select(-1, 1, places.x > places.y);
  if (earliest == i) {
    sense = -sense;
  }
  return sense > 0;
}

// The edge of a bit of a word of `cutting`.
fn cutting_edge(work: Work, word: u32, bit: u32) -> u32 {
  return select(bit, OUTLINE_LANES * bit + word, work.is_large);
}

// Finds the places in order of the cuts of an invocation.
fn rank_cuts(outline: OutlineRange, work: Work, lane: u32, by_turns: bool) {
  let ranks_at = select(SMALL_OUTLINE * lane, 0u, work.is_large);
  for (var own = select(0u, cutting[lane], work.exists); own != 0u; own &= own - 1u) {
    let i = cutting_edge(work, lane, firstTrailingBit(own));
    var rank = 0u;
    for (var word = 0u; word < select(1u, OUTLINE_LANES, work.is_large); word++) {
      for (var rest = cutting[select(lane, word, work.is_large)]; rest != 0u; rest &= rest - 1u) {
        let j = cutting_edge(work, word, firstTrailingBit(rest));
        if (j != i && is_before(outline, work, j, i, by_turns)) {
          rank++;
        }
      }
    }
    ranks[ranks_at + i] = rank;
  }
}

// Finds whether two cuts have one place.
fn note_tangles(work: Work, lane: u32) {
  let ranks_at = select(SMALL_OUTLINE * lane, 0u, work.is_large);
  for (var own = select(0u, cutting[lane], work.exists); own != 0u; own &= own - 1u) {
    let i = cutting_edge(work, lane, firstTrailingBit(own));
    for (var word = 0u; word < select(1u, OUTLINE_LANES, work.is_large); word++) {
      for (var rest = cutting[select(lane, word, work.is_large)]; rest != 0u; rest &= rest - 1u) {
        let j = cutting_edge(work, word, firstTrailingBit(rest));
        if (j != i && ranks[ranks_at + j] == ranks[ranks_at + i]) {
          atomicOr(&is_tangled[select(lane, 0u, work.is_large)], 1u);
        }
      }
    }
  }
}

// Lists the piece that ends at a cut, or at the end of the edge. `last` is the edge that cuts.
fn list_before(outline: OutlineRange, work: Work, lane: u32, last: u32) {
  let slot = select(lane, 0u, work.is_large);
  let ranks_at = select(SMALL_OUTLINE * lane, 0u, work.is_large);
  let cuts = atomicLoad(&cut_counts[slot]);
  var earlier = cuts;
  if (last != CORNER) {
    earlier = ranks[ranks_at + last];
  }
  var before = CORNER;
  for (var word = 0u; word < select(1u, OUTLINE_LANES, work.is_large); word++) {
    for (var rest = cutting[select(lane, word, work.is_large)]; rest != 0u; rest &= rest - 1u) {
      let edge = cutting_edge(work, word, firstTrailingBit(rest));
      if (ranks[ranks_at + edge] + 1u == earlier) {
        before = edge;
      }
    }
  }
  // The last piece ends at the end of the edge, and each cut exchanges the sides.
  let is_odd_at_end = (atomicLoad(&odd[slot]) & 1u) != 0u;
  let is_odd = is_odd_at_end == ((cuts - earlier) % 2u == 0u);
  var ends = array<vec3<u32>, 2>(work.edge.a, work.edge.b);
  for (var end = 0u; end < 2u; end++) {
    let other = select(last, before, end == 0u);
    if (other != CORNER) {
      ends[end] = crossing_point(outline, work.index, other, work.place);
    }
  }
  list_piece(outline, work.place, ends[0], ends[1], !is_odd);
}

@compute @workgroup_size(64)
fn cut_edges(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(local_invocation_index) lane: u32,
) {
  let number = group.y * ENTRY_ROW + group.x;
  var work: Work;
  var own: OutlineRange;
  if (number < atomicLoad(&undecided[CUT_COUNT])) {
    let record = record_at(atomicLoad(&undecided[entry_at(number)]));
    own = outline_of(polygon_of(record));
    // Its lights are those for which it is cut by now.
    work = work_of(own, atomicLoad(&undecided[entry_at(number) + 1u]), atomicLoad(&undecided[record + LIGHTS]), lane);
  }
  take_cuts(own, work, lane);
  workgroupBarrier();
  let slot = select(lane, 0u, work.is_large);
  // By turns first, then by rounded places where these do not fit together.
  for (var attempt = 0u; attempt < 2u; attempt++) {
    let by_turns = attempt == 0u && atomicLoad(&cut_counts[slot]) <= MOST_ORDERED;
    if (attempt == 0u || atomicLoad(&is_tangled[slot]) != 0u) {
      rank_cuts(own, work, lane, by_turns);
    }
    workgroupBarrier();
    if (attempt == 0u) {
      note_tangles(work, lane);
    }
    workgroupBarrier();
  }
  if (!work.exists) {
    return;
  }
  // Each of its cuts ends a piece, and so does the end of the edge.
  var rest = cutting[lane];
  for (var left = countOneBits(rest) + select(0u, 1u, !work.is_large || lane == 0u); left > 0u; left--) {
    var last = CORNER;
    if (rest != 0u) {
      last = cutting_edge(work, lane, firstTrailingBit(rest));
      rest &= rest - 1u;
    }
    list_before(own, work, lane, last);
  }
}
