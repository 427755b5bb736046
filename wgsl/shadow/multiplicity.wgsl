// How often an edge's side is drawn for a light, and which way it is wound: the multiplicity of the edge, from the faces at
// the edge that cast. NUMERICS.md, "Watertight".

struct EdgeSide {
  // 0: none. Where every face casts, 2 is a silhouette, and 1 a boundary of what casts.
  weight: u32,
  // If set, (b, a, far a, far b) is counter-clockwise as seen from outside the volume.
  winding: bool,
}

// The sign of a face in multiplicities where every face casts. An excluded face counts nowhere.
fn face_sign(facing: bool, excluded: bool) -> i32 {
  return select(select(-1, 1, facing), 0, excluded);
}

// `faces` is the packed record. The other vectors tell of its two faces whether they face the light, and are excluded.
fn side_of_edge(light: ShadowLight, faces: vec2<u32>, facing: vec2<bool>, excluded: vec2<bool>) -> EdgeSide {
  if (light.casting == CAST_NOTHING) {
    return EdgeSide(0u, false);
  }
  let is_boundary = faces.y == NO_FACE;
  if (light.casting == CAST_AVERTED) {
    let casts = !facing & !excluded;
    return EdgeSide(select(0u, 1u, casts.x != (casts.y && !is_boundary)), !casts.x);
  }
  var multiplicity = face_sign(facing.x, excluded.x);
  if (!is_boundary) {
    let second = face_sign(facing.y, excluded.y);
    multiplicity += select(-second, second, (faces.x & INCONSISTENT) != 0u);
  }
  return EdgeSide(u32(abs(multiplicity)), multiplicity > 0);
}

// The side of an edge record for a light, the bit of whose batch is `bit`. The masks are as the stage binds them.
fn side_at(light: ShadowLight, bit: u32, edge: u32) -> EdgeSide {
  let faces = edge_faces[edge];
  let first = faces.x & ~INCONSISTENT;
  let second = select(faces.y, first, faces.y == NO_FACE);
  let facing = (vec2<u32>(facing_masks[first], facing_masks[second]) >> vec2<u32>(bit)) & vec2<u32>(1u);
  var excluded = vec2<u32>(0u);
  if (light.excludes != 0u) {
    excluded = (vec2<u32>(excluded_masks[first], excluded_masks[second]) >> vec2<u32>(bit)) & vec2<u32>(1u);
  }
  return side_of_edge(light, faces, facing != vec2<u32>(0u), excluded != vec2<u32>(0u));
}

// The first entry of a light's list of sides, behind the counts of the batch. Sides of weight 1 are listed from the front
// on, those of weight 2 from the back.
const SIDE_COUNTS: u32 = 64u;

fn side_begin(light: u32, capacity: u32) -> u32 {
  return SIDE_COUNTS + light * capacity;
}
