// Lists of sides: where they are, and which a side belongs to.
//
// Expects: `shape`, and for the number of copies of a side `edge_faces`, `facing_masks` and `excluded_masks`.

#import common/extraction
#import shadow/caster
#import shadow/shadow

// A light has two lists of sides in one run: from the front those that are drawn plainly, from the back those that are
// clipped at the near plane. A side of weight 2 is there twice.
const PLAIN: u32 = 0u;
const CLIPPED: u32 = 1u;
// The counts of the batch, before the lists.
const SIDE_COUNTS: u32 = 64u;

fn side_place(bit: u32, kind: u32, place: u32) -> u32 {
  return SIDE_COUNTS + bit * shape.side_capacity + select(place, shape.side_capacity - 1u - place, kind == CLIPPED);
}

fn side_kind(light: ShadowLight) -> u32 {
  return select(PLAIN, CLIPPED, light.counting == COUNT_ZP_PLUS || light.counting == COUNT_ZP_PLUS_2005);
}

// ==== shadow/multiplicity
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
fn side_of_edge(casting: u32, faces: vec2<u32>, facing: vec2<bool>, excluded: vec2<bool>) -> EdgeSide {
  if (casting == CAST_NOTHING) {
    return EdgeSide(0u, false);
  }
  let is_boundary = faces.y == NO_FACE;
  if (casting == CAST_AVERTED) {
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

// The side of an edge record of a caster, for the light of a bit. The masks are as the stage binds them.
fn side_at(caster: u32, record: u32, light: ShadowLight, bit: u32) -> EdgeSide {
  let faces = edge_faces[record];
  let slots = vec2<u32>(face_run(caster).x) + vec2<u32>(faces.x & ~INCONSISTENT, select(faces.y, 0u, faces.y == NO_FACE));
  let facing = (vec2<u32>(facing_masks[slots.x], facing_masks[slots.y]) >> vec2<u32>(bit)) & vec2<u32>(1u);
  var excluded = vec2<u32>(0u);
  if (light.excludes != 0u) {
    excluded = (vec2<u32>(excluded_masks[slots.x], excluded_masks[slots.y]) >> vec2<u32>(bit)) & vec2<u32>(1u);
  }
  return side_of_edge(light.casting, faces, facing != vec2<u32>(0u), excluded != vec2<u32>(0u));
}
