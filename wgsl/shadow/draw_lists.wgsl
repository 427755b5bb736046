// Lists of what is drawn for each light of a batch (up to 32 lights): faces with caps and edges with sides for a view,
// pieces for all views. Pieces are parts of the boundaries of twisted polygons. As seen from light L, the boundary of a
// twisted polygon crosses itself or goes around the light, or a hole is outside.
// `caps` and `list_sides` write the lists of faces and edges, `cut_edges` and `cut_quads` those of pieces. Stages that
// make draw arguments or bound counts read them, and so do vertex shaders. The order in a list is arbitrary. Two lists of
// a light may share a range: one grows from its front, one from its back. If they overflow, the sum of their counts
// exceeds the capacity. Vertex shaders then go over all edges or faces, and decide by the functions of this file;
// `stencil_crossings` takes every edge at its largest weight. But pieces without room are lost: draws have the listed ones,
// and `lost_pieces` counts the others.
// These stages, `relist`, and sizes.rs and pipelines.rs in src/gpu/shadow have the layout of counts and the kinds as numbers,
// polygon/list_pieces.wgsl and src/gpu/extract/polygon_buffers.rs the layout of pieces. No test compares them: change all.
// `is_casting_face` and `side_of_edge` must agree, or volumes are not closed. While no face is excluded, only silhouettes of
// `edges` may have sides, since `list_sides` then reads no other edges. docs/numerics/watertight.md.
//
// Expects: `shape`, and, as far as functions are used, `edge_faces`, and by slots `facing_masks` and `excluded_masks`.

#import common/casters
#import common/extraction
#import shadow/caster
#import shadow/shadow

// Whether a face casts if it is not excluded.
fn is_casting_face(light: ShadowLight, is_front_facing: bool) -> bool {
  return light.casting == CAST_EVERY || (light.casting == CAST_BACK_FACING && !is_front_facing);
}

// Whether the volume may have near caps. If so, sides are clipped at the near plane, or are those of ZP+ as published.
fn has_near_cap(light: ShadowLight) -> bool {
  return light.counting == COUNT_ZP_PLUS || light.counting == COUNT_ZP_PLUS_2005;
}

// Whether the volume has light or dark caps: with z-fail, if it ends at the range, or if the caster is not in the depth
// buffer, so that the eye sees through its faces. A volume that ends behind all receivers needs no dark cap, but has one if
// `end_at_range` is set, because `end` does not tell the two apart.
fn has_far_caps(light: ShadowLight, flags: u32) -> bool {
  return light.counting == COUNT_Z_FAIL || (light.end > 0.0 && shape.end_at_range != 0u) || (flags & PROXY) != 0u;
}

// A light has four lists of cap faces, by their kind. Kinds 0 and 1 are near caps, kinds 2 and 3 are light and dark caps.
// Near and light caps of kinds 0 and 2 are the front of the volume where the camera sees the face's front, those of kinds 1
// and 3 where it sees its back. Dark caps are the other way round. z-fail counts fronts of volumes down, other methods up.
const CAP_COUNTS: u32 = 128u; // Words before the lists: 4 * bit + kind is the count of a list.
const FAR_CAPS: u32 = 2u; // The first kind of light and dark caps.

// The kind of the near cap of a face. On the near plane the camera sees the front of a front-facing face if the light is on
// the eye's side. A matrix that mirrors exchanges front and back.
fn near_cap_kind(light: ShadowLight, is_front_facing: bool, is_mirrored: bool) -> u32 {
  let is_light_beyond = light_side(light) > 0.0;
  return select(0u, 1u, (is_front_facing == is_light_beyond) != is_mirrored);
}

fn far_cap_kind(is_front_facing: bool, is_mirrored: bool) -> u32 {
  return FAR_CAPS + select(0u, 1u, is_front_facing == is_mirrored);
}

// The capacity of the range that holds the list of a kind and one other list.
fn cap_capacity(kind: u32) -> u32 { return select(shape.near_capacity, shape.far_capacity, kind >= FAR_CAPS); }

// The offset in `caps_listed` of an entry of a light's list of a kind. The second list of a range grows down from its end.
fn cap_entry_offset(bit: u32, kind: u32, entry: u32) -> u32 {
  let range = CAP_COUNTS + bit * (shape.near_capacity + shape.far_capacity) +
    select(0u, shape.near_capacity, kind >= FAR_CAPS);
  return range + select(entry, cap_capacity(kind) - 1u - entry, (kind & 1u) != 0u);
}

// A light has two lists of sides, by their kind: sides that the hardware clips, and sides that the vertex shader clips at
// the near plane, or those of ZP+ as published. A side of weight 2 has two entries.
const PLAIN: u32 = 0u;
const CLIPPED: u32 = 1u;
const SIDE_COUNTS: u32 = 64u; // Words before the lists: 2 * bit + kind is the count of a list.

// The offset in `sides` of an entry of a light's list of a kind. The list of clipped sides grows down from the end of the
// range.
fn side_entry_offset(bit: u32, kind: u32, entry: u32) -> u32 {
  return SIDE_COUNTS + bit * shape.side_capacity + select(entry, shape.side_capacity - 1u - entry, kind == CLIPPED);
}

fn side_kind(light: ShadowLight) -> u32 { return select(PLAIN, CLIPPED, has_near_cap(light)); }

// The side of an edge: its weight and winding are size and sign of the edge's multiplicity over the faces that cast.
struct EdgeSide {
  // How often the side is drawn, 0 to 2. Where every face casts and none is excluded, a silhouette has 2 and a boundary 1.
  weight: u32,
  // If set, (b, a, far a, far b) is counter-clockwise as seen from outside the volume, else (a, b, far b, far a). A matrix
  // that mirrors exchanges them. Without a meaning if the weight is 0.
  winding: bool,
}

// The summand of a face in the multiplicities of its edges, in the direction in which it traverses them, where every face
// casts. It is 0 for an excluded face.
fn face_sign(is_front_facing: bool, is_excluded: bool) -> i32 {
  return select(select(-1, 1, is_front_facing), 0, is_excluded);
}

// The side of an edge record. `faces` is the packed record: x is face 0, with INCONSISTENT if both faces traverse the edge
// in the same direction, and y is face 1, or NO_FACE. `facing` and `excluded` have a component for each of the two faces:
// whether it is front-facing, and whether it is excluded. For NO_FACE they have no meaning. Outlines of scenes call this,
// too, for CAST_EVERY: a weight above 0 is a silhouette.
fn side_of_edge(casting: u32, faces: vec2<u32>, facing: vec2<bool>, excluded: vec2<bool>) -> EdgeSide {
  if (casting == CAST_NOTHING) {
    return EdgeSide(0u, false);
  }
  let is_boundary = faces.y == NO_FACE;
  if (casting == CAST_BACK_FACING) {
    // Only for closed casters, so no record has INCONSISTENT.
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

// The side of a caster's edge record for the light of a bit, by the bound masks. `record` is its index in the page. Its
// faces are counted from the caster's first. `light` has the choices for the caster.
fn edge_side(caster: u32, record: u32, light: ShadowLight, bit: u32) -> EdgeSide {
  let faces = edge_faces[record];
  let slots = vec2<u32>(face_range(caster).x) +
    vec2<u32>(faces.x & ~INCONSISTENT, select(faces.y, 0u, faces.y == NO_FACE));
  let facing = (vec2<u32>(facing_masks[slots.x], facing_masks[slots.y]) >> vec2<u32>(bit)) & vec2<u32>(1u);
  var excluded = vec2<u32>(0u);
  if (light.excludes != 0u) {
    excluded = (vec2<u32>(excluded_masks[slots.x], excluded_masks[slots.y]) >> vec2<u32>(bit)) & vec2<u32>(1u);
  }
  return side_of_edge(light.casting, faces, facing != vec2<u32>(0u), excluded != vec2<u32>(0u));
}

// Pieces of twisted polygons. A piece is a segment of the border between lit and dark parts of a polygon, as seen from
// light L, with the dark part on its left. `pieces` has a count for each of 32 lights, with the pieces that were lost, then a
// list for each light. A piece is nine words: the positions of its begin, of its end, and of the middle of its polygon. Caps
// are fans of triangles around the middle.
const PIECE_COUNTS: u32 = 32u;
const PIECE_WORDS: u32 = 9u;
