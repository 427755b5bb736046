// Pieces: vertex shaders that draw the sides and caps of pieces of L-twisted polygons (their outlines cross themselves as seen
// from light L), in the caller's render pass, by the indirect draws of `piece_arguments`; an instance is a piece, which
// `cut_edges` and `cut_quads` listed (shadow/lists.wgsl) for the only caster of a group. A piece is an edge of the face that it makes with the middle of its
// polygon, and that face faces the light. Faces of other pieces meet it at its other edges, and count there with the contrary
// sign: so positions must be taken as listed, bit for bit. docs/numerics/twisted-polygons.md.

#import common/casters
#import shadow/caster
#import shadow/choices
#import shadow/lists
#import shadow/shadow
#import shadow/vertices

@group(0) @binding(0) var<uniform> shape: ShadowShape;
@group(0) @binding(1) var<uniform> draw: ShadowDraw;
@group(0) @binding(2) var<storage, read> seen: SeenLight; // The light and view of the draw.
@group(0) @binding(3) var<storage, read> table: array<vec4<u32>>;
@group(1) @binding(0) var<storage, read> pieces: array<u32>;

struct Piece {
  valid: bool,
  view: ShadowView,
  light: ShadowLight,
  face: CapFace, // The middle of the polygon, and the ends of the piece, in this order.
}

fn piece_of(instance: u32) -> Piece {
  let bit = draw.light - draw.first_light;
  let at = PIECE_COUNTS + PIECE_WORDS * (bit * shape.piece_capacity + instance);
  let from_end = vec3<u32>(pieces[at], pieces[at + 1u], pieces[at + 2u]);
  let to_end = vec3<u32>(pieces[at + 3u], pieces[at + 4u], pieces[at + 5u]);
  let middle = vec3<u32>(pieces[at + 6u], pieces[at + 7u], pieces[at + 8u]);
  let caster = shape.first_caster;
  // Matrices that mirror turn pieces.
  let turned_over = (caster_flags(caster) & MIRRORED) != 0u;
  let b = select(from_end, to_end, turned_over);
  let c = select(to_end, from_end, turned_over);
  var own: Piece;
  own.valid = is_counted(caster, draw.count_batch);
  own.view = view_of(caster, seen.view);
  own.light = chosen_light(caster, light_of(caster, seen.light, draw.light), draw.light, draw.view);
  own.face = CapFace(bitcast<vec3<f32>>(middle), bitcast<vec3<f32>>(b), bitcast<vec3<f32>>(c), vec3<u32>(0u, 1u, 2u));
  return own;
}

// Seen from outside, a side is counter-clockwise from the end of a lit face's edge on.
@vertex fn piece_side(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> VolumeVertex {
  let own = piece_of(instance);
  if (!own.valid) {
    return VolumeVertex(NOTHING);
  }
  return drawn_side(own.view, own.light, own.face.c, own.face.b, vertex);
}

// The order is that of `face`, whose later corner the side begins with.
@vertex fn piece_side_clipped(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> VolumeVertex {
  let own = piece_of(instance);
  if (!own.valid) {
    return VolumeVertex(NOTHING);
  }
  return drawn_clipped_side(own.view, own.light, own.face.c, own.face.b, false, vertex);
}

@vertex fn piece_near_cap(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> VolumeVertex {
  let own = piece_of(instance);
  if (!own.valid) {
    return VolumeVertex(NOTHING);
  }
  return drawn_near_cap(own.view, own.light, own.face, vertex);
}

@vertex fn piece_light_cap(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> VolumeVertex {
  let own = piece_of(instance);
  if (!own.valid) {
    return VolumeVertex(NOTHING);
  }
  return drawn_light_cap(own.view, own.light, own.face, own.light.counting == COUNT_ZP_PLUS, vertex);
}

@vertex fn piece_dark_cap(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> VolumeVertex {
  let own = piece_of(instance);
  if (!own.valid) {
    return VolumeVertex(NOTHING);
  }
  return drawn_dark_cap(own.view, own.light, own.face, vertex);
}

// For passes with colour attachments, which are not changed.
@fragment fn nothing() {}
