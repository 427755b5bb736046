// Vertex shaders of the sides and caps of pieces, in the caller's render pass. A piece is a segment of the border
// between the lit and dark parts of a twisted polygon (shadow/draw_lists.wgsl).
// The indirect draws of `piece_arguments` have an instance for each piece that `cut_edges` or `cut_quads` listed for the
// only caster of the group. A piece and the middle of its polygon make a front-facing triangle, whose caps are drawn.
// At its two other edges a triangle meets the triangles of other pieces, which count there with the opposite sign. So
// positions must be used as listed, bit for bit. docs/numerics/twisted-polygons.md, "Volumes of pieces".

#import common/casters
#import shadow/caster
#import shadow/choices
#import shadow/draw_lists
#import shadow/shadow
#import shadow/vertices

@group(0) @binding(0) var<uniform> shape: ShadowShape;
@group(0) @binding(1) var<uniform> draw: ShadowDraw;
@group(0) @binding(2) var<storage, read> view_light: ViewLight; // The light and view of the draw.
@group(0) @binding(3) var<storage, read> table: array<vec4<u32>>;
@group(1) @binding(0) var<storage, read> pieces: array<u32>;

// The piece of an instance, and view and light for its caster.
struct PieceInstance {
  is_drawn: bool,
  view: ShadowView,
  light: ShadowLight,
  face: CapFace, // a: the middle of the polygon. b, c: the begin and end of the piece.
}

fn load_piece(instance: u32) -> PieceInstance {
  let bit = draw.light - draw.first_light;
  let offset = PIECE_COUNTS + PIECE_WORDS * (bit * shape.piece_capacity + instance);
  let begin = vec3<u32>(pieces[offset], pieces[offset + 1u], pieces[offset + 2u]);
  let end = vec3<u32>(pieces[offset + 3u], pieces[offset + 4u], pieces[offset + 5u]);
  let middle = vec3<u32>(pieces[offset + 6u], pieces[offset + 7u], pieces[offset + 8u]);
  let caster = shape.first_caster;
  // A matrix that mirrors exchanges the ends, so that the triangle stays front-facing.
  let is_mirrored = (caster_flags(caster) & MIRRORED) != 0u;
  let b = select(begin, end, is_mirrored);
  let c = select(end, begin, is_mirrored);
  var result: PieceInstance;
  result.is_drawn = is_in_count_batch(caster, draw.count_batch);
  result.view = view_for_caster(caster, view_light.view);
  result.light = with_stored_choices(caster, light_for_caster(caster, view_light.light, draw.light), draw.light, draw.view);
  result.face = CapFace(bitcast<vec3<f32>>(middle), bitcast<vec3<f32>>(b), bitcast<vec3<f32>>(c), vec3<u32>(0u, 1u, 2u));
  return result;
}

// From outside the volume, a side is counter-clockwise if it begins at the end of a front-facing face's edge.
@vertex fn piece_side(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> VolumeVertex {
  let piece = load_piece(instance);
  if (!piece.is_drawn) {
    return VolumeVertex(NOT_DRAWN);
  }
  return drawn_side(piece.view, piece.light, piece.face.c, piece.face.b, vertex);
}

// The side begins at corner c, which has the higher rank in `face`, so its ends are not in order.
@vertex fn piece_side_clipped(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> VolumeVertex {
  let piece = load_piece(instance);
  if (!piece.is_drawn) {
    return VolumeVertex(NOT_DRAWN);
  }
  return drawn_clipped_side(piece.view, piece.light, piece.face.c, piece.face.b, false, vertex);
}

@vertex fn piece_near_cap(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> VolumeVertex {
  let piece = load_piece(instance);
  if (!piece.is_drawn) {
    return VolumeVertex(NOT_DRAWN);
  }
  return drawn_near_cap(piece.view, piece.light, piece.face, vertex);
}

@vertex fn piece_light_cap(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> VolumeVertex {
  let piece = load_piece(instance);
  if (!piece.is_drawn) {
    return VolumeVertex(NOT_DRAWN);
  }
  return drawn_light_cap(piece.view, piece.light, piece.face, piece.light.counting == COUNT_ZP_PLUS, vertex);
}

@vertex fn piece_dark_cap(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> VolumeVertex {
  let piece = load_piece(instance);
  if (!piece.is_drawn) {
    return VolumeVertex(NOT_DRAWN);
  }
  return drawn_dark_cap(piece.view, piece.light, piece.face, vertex);
}

// For passes with colour attachments, which stay as they are.
@fragment fn nothing() {}
