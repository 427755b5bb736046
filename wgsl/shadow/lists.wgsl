// Lists of what is drawn for each light of a batch (up to 32 lights) in a view: which faces have caps, which edges have sides and
// how often, and where both lie in the lists; and the pieces of L-twisted polygons (whose outlines cross themselves as seen from
// light L). `caps` and `list_sides` write the lists of faces and edges, and `cut_edges` and `cut_quads` those of pieces; the
// stages that make arguments and bound counts, and the vertex shaders, read them. Lists are in no particular order. Two of a
// light share a run, one from its front and one from its back. If there is no room, counts say so, and readers go over all edges
// or faces, with the same tests from here: so `casts` and `side_of_edge` must agree, or volumes do not close.
// docs/numerics/watertight.md.
//
// Expects: `shape`, and as far as functions are used `edge_faces`, `facing_masks` and `excluded_masks`, by slots.

#import common/casters
#import common/extraction
#import shadow/caster
#import shadow/shadow

// Whether a face casts.
fn casts(light: ShadowLight, facing: bool) -> bool {
  return light.casting == CAST_EVERY || (light.casting == CAST_AVERTED && !facing);
}

// Whether the caster may have a near cap for the light, so that its sides are clipped at the near plane.
fn has_near_cap(light: ShadowLight) -> bool {
  return light.counting == COUNT_ZP_PLUS || light.counting == COUNT_ZP_PLUS_2005;
}

// Whether there are caps besides near caps: with z-fail, where the volume ends at the range, and where the caster is not in
// the depth buffer, so that the eye sees through its faces. A volume that ends behind all receivers needs no dark cap.
fn has_far_caps(light: ShadowLight, flags: u32) -> bool {
  return light.counting == COUNT_Z_FAIL || (light.end > 0.0 && shape.end_at_range != 0u) || (flags & PROXY) != 0u;
}

// A light has four lists of cap faces: near caps of both classes in one run, and other caps of both classes in another. Caps of
// the first class count up where their front is seen, those of the second where their back is. Matrices that mirror turn faces.
const CAP_COUNTS: u32 = 128u;
const FAR: u32 = 2u;

// On the near plane the front of a face that faces the light is seen if the light is on the eye's side.
fn near_kind(light: ShadowLight, facing: bool, mirrored: bool) -> u32 {
  let turned = light_side(light) > 0.0;
  return select(0u, 1u, (facing == turned) != mirrored);
}

fn far_kind(facing: bool, mirrored: bool) -> u32 { return FAR + select(0u, 1u, facing == mirrored); }
fn cap_capacity(kind: u32) -> u32 { return select(shape.near_capacity, shape.far_capacity, kind >= FAR); }

// The word of `caps_listed` at place `place` of a light's list of a kind. The second of two lists that share a run begins at its
// end and goes down.
fn cap_place(bit: u32, kind: u32, place: u32) -> u32 {
  let run = CAP_COUNTS + bit * (shape.near_capacity + shape.far_capacity) + select(0u, shape.near_capacity, kind >= FAR);
  return run + select(place, cap_capacity(kind) - 1u - place, (kind & 1u) != 0u);
}

// A light's two lists of sides: from the front those that are drawn plainly, from the back those that are clipped at the near
// plane. A side of weight 2 is there twice.
const PLAIN: u32 = 0u;
const CLIPPED: u32 = 1u;
const SIDE_COUNTS: u32 = 64u; // The counts of the batch, before the lists.

// The word of `sides` at place `place` of a light's list of a kind. The list of clipped sides begins at the end of the run.
fn side_place(bit: u32, kind: u32, place: u32) -> u32 {
  return SIDE_COUNTS + bit * shape.side_capacity + select(place, shape.side_capacity - 1u - place, kind == CLIPPED);
}

fn side_kind(light: ShadowLight) -> u32 { return select(PLAIN, CLIPPED, has_near_cap(light)); }

// How often an edge's side is drawn for a light, and which way it is wound: the multiplicity of the edge, from its faces that
// cast.
struct EdgeSide {
  weight: u32, // 0: none. Where every face casts, 2 is a silhouette, and 1 a boundary of what casts.
  winding: bool, // If set, (b, a, far a, far b) is counter-clockwise as seen from outside the volume.
}

// The sign of a face in multiplicities where every face casts. An excluded face counts nowhere.
fn face_sign(facing: bool, excluded: bool) -> i32 { return select(select(-1, 1, facing), 0, excluded); }

// `faces` is the packed record: face 0, with INCONSISTENT if both run the same way along the edge, and face 1, or NO_FACE. The
// other vectors tell of its two faces whether they face the light, and are excluded; for NO_FACE they mean nothing.
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

// The pieces of polygons that are L-twisted, so that they have lit and dark parts as seen from a light: for each light of the
// batch their number, then lists of pieces of nine words each. A piece begins at a place and ends at another, and its polygon has
// a middle, from which a fan is drawn where there are caps. The dark side is on the left of a piece as seen from the light.
const PIECE_COUNTS: u32 = 32u;
const PIECE_WORDS: u32 = 9u;

