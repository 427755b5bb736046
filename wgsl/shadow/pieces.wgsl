// Pieces: draws the sides and caps of pieces of L-twisted polygons, by indirect draws of the lists that `cut_edges` made. A piece is
// an edge of the face that it makes with the middle of its polygon, and that face faces the light. Faces of other pieces
// meet it at its other edges, and count there with the contrary sign.

#import shadow/caster
#import shadow/choices
#import shadow/piece_lists
#import shadow/polygon
#import shadow/shadow

@group(0) @binding(0) var<uniform> shape: ShadowShape;
@group(0) @binding(1) var<uniform> draw: ShadowDraw;
// Those of the draw.
@group(0) @binding(2) var<storage, read> seen: SeenLight;
@group(0) @binding(3) var<storage, read> table: array<vec4<u32>>;
@group(1) @binding(0) var<storage, read> pieces: array<u32>;

struct PieceVertex {
  @invariant @builtin(position) clip: vec4<f32>,
}

struct Piece {
  view: ShadowView,
  light: ShadowLight,
  // The middle of the polygon, and the ends of the piece.
  face: CapFace,
}

fn piece_of(instance: u32) -> Piece {
  let bit = draw.light - draw.first_light;
  let at = PIECE_COUNTS + PIECE_WORDS * (bit * piece_capacity() + instance);
  let from_end = vec3<u32>(pieces[at], pieces[at + 1u], pieces[at + 2u]);
  let to_end = vec3<u32>(pieces[at + 3u], pieces[at + 4u], pieces[at + 5u]);
  let middle = vec3<u32>(pieces[at + 6u], pieces[at + 7u], pieces[at + 8u]);
  var own: Piece;
  own.view = view_of(0u, seen.view);
  own.light = chosen_light(0u, light_of(0u, seen.light, draw.light), draw.light, draw.view);
  own.face = CapFace(bitcast<vec3<f32>>(middle), bitcast<vec3<f32>>(from_end), bitcast<vec3<f32>>(to_end), vec3<u32>(0u, 1u, 2u));
  return own;
}

// Seen from outside, a side is counter-clockwise from the end of a lit face's edge on.
@vertex fn piece_side(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> PieceVertex {
  let own = piece_of(instance);
  if (TRIM) {
    var outline: Outline;
    for (var corner = 0u; corner < 4u; corner++) {
      let place = corner ^ (corner >> 1u);
      outline = with_corner(outline, side_vertex(own.view, own.light, own.face.c, own.face.b, place));
    }
    return PieceVertex(vertex_of_part(trimmed(outline), false, vertex));
  }
  return PieceVertex(side_vertex(own.view, own.light, own.face.c, own.face.b, vertex));
}

@vertex fn piece_side_clipped(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> PieceVertex {
  let own = piece_of(instance);
  if (TRIM) {
    var outline: Outline;
    for (var corner = 0u; corner < 5u; corner++) {
      outline = with_corner(outline, clipped_side_vertex(own.view, own.light, own.face.c, own.face.b, false, strip_place(corner)));
    }
    return PieceVertex(vertex_of_part(trimmed(outline), false, vertex));
  }
  return PieceVertex(clipped_side_vertex(own.view, own.light, own.face.c, own.face.b, false, vertex));
}

@vertex fn piece_near_cap(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> PieceVertex {
  let own = piece_of(instance);
  if (TRIM) {
    var outline: Outline;
    for (var corner = 0u; corner < 5u; corner++) {
      outline = with_corner(outline, near_cap_vertex(own.view, own.light, own.face, strip_place(corner)));
    }
    return PieceVertex(vertex_of_part(trimmed(outline), false, vertex));
  }
  return PieceVertex(near_cap_vertex(own.view, own.light, own.face, vertex));
}

@vertex fn piece_light_cap(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> PieceVertex {
  let own = piece_of(instance);
  if (TRIM) {
    var outline: Outline;
    for (var corner = 0u; corner < 5u; corner++) {
      outline = with_corner(outline, seen_light_cap_vertex(own.view, own.light, own.face, own.light.counting == COUNT_ZP_PLUS, strip_place(corner)));
    }
    return PieceVertex(vertex_of_part(trimmed(outline), false, vertex));
  }
  return PieceVertex(seen_light_cap_vertex(own.view, own.light, own.face, own.light.counting == COUNT_ZP_PLUS, vertex));
}

@vertex fn piece_dark_cap(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> PieceVertex {
  let own = piece_of(instance);
  if (TRIM) {
    var outline: Outline;
    for (var corner = 0u; corner < 3u; corner++) {
      outline = with_corner(outline, dark_cap_vertex(own.view, own.light, own.face, corner));
    }
    return PieceVertex(vertex_of_part(trimmed(outline), true, vertex));
  }
  return PieceVertex(dark_cap_vertex(own.view, own.light, own.face, vertex));
}

// For passes with colour attachments, which are not changed.
@fragment fn nothing() {}
