// Sides: vertex shaders that draw the quads from edges away from the light, in the caller's render pass, by the indirect draws
// that `shadow_arguments` made of the lists of `list_sides`. An instance is an entry of a list, drawn as a strip. `side` leaves
// clipping to the hardware. `side_clipped` clips at the near plane itself, so that the seam with the near cap (`cap_faces`) has
// equal bits. `zp_plus_2005_side` is the side as published in 2005. The first two may be trimmed (shadow/vertices.wgsl). If the
// light's lists overflowed, each edge of the group is two instances and is tested here. Ends must come to shadow/vertices.wgsl as
// the winding and the order of vertex indices have them: stencil counts and seams follow from these.
// docs/numerics/shadow-volumes.md.

#import common/casters
#import common/extraction
#import shadow/caster
#import shadow/choices
#import shadow/lists
#import shadow/shadow
#import shadow/vertices

@group(0) @binding(0) var<uniform> shape: ShadowShape;
@group(0) @binding(1) var<uniform> draw: ShadowDraw;
@group(0) @binding(2) var<storage, read> seen: SeenLight; // The light and view of the draw.
@group(0) @binding(3) var<storage, read> table: array<vec4<u32>>;
@group(1) @binding(0) var<storage, read> positions: array<u32>;
@group(1) @binding(1) var<storage, read> edge_vertices: array<vec2<u32>>;
@group(1) @binding(2) var<storage, read> edge_faces: array<vec2<u32>>;
@group(1) @binding(3) var<storage, read> facing_masks: array<u32>;
@group(1) @binding(4) var<storage, read> excluded_masks: array<u32>;
@group(1) @binding(5) var<storage, read> sides: array<u32>;

// A side: its edge, in the order in which the quad (first, second, second far, first far) is counter-clockwise from
// outside, and what its caster sees.
struct Side {
  valid: bool,
  ends: vec2<u32>,
  first: vec3<f32>,
  second: vec3<f32>,
  view: ShadowView,
  light: ShadowLight,
}

// The side that an instance of a draw of list `kind` (PLAIN or CLIPPED) draws. An instance is an entry of the list. If the lists
// overflowed, every edge is two instances, since its side may have weight 2; those above its weight are not valid.
fn side_of(instance: u32, kind: u32) -> Side {
  let bit = draw.light - draw.first_light;
  let overflowed = sides[2u * bit] + sides[2u * bit + 1u] > shape.side_capacity;
  var entry = instance >> 1u;
  if (!overflowed) {
    entry = sides[side_place(bit, kind, instance)];
  }
  let slot = entry & ~WINDING;
  let caster = caster_of(shape.edge_chunks_at, slot);
  let run = edge_run(caster);
  let record = run.z + slot - run.x;
  var own: Side;
  own.view = view_of(caster, seen.view);
  own.light = light_of(caster, seen.light, draw.light);
  own.valid = is_counted(caster, draw.count_batch);
  var winding = entry >= WINDING;
  if (overflowed || has_measures()) {
    own.light = chosen_light(caster, own.light, draw.light, draw.view);
  }
  if (overflowed) {
    // A slot beyond the edges of its caster has a record of another, or none.
    let is_there = slot - run.x < run.y;
    let side = side_at(caster, record, own.light, bit);
    own.valid = own.valid && is_there && side.weight > (instance & 1u) && side_kind(own.light) == kind;
    winding = side.winding;
  }
  let turned_over = (caster_flags(caster) & MIRRORED) != 0u;
  let ends = edge_vertices[record];
  own.ends = select(ends, ends.yx, winding != turned_over);
  own.first = vertex_position(caster, own.ends.x);
  own.second = vertex_position(caster, own.ends.y);
  return own;
}

@vertex fn side(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> VolumeVertex {
  let own = side_of(instance, PLAIN);
  if (!own.valid) {
    return VolumeVertex(NOTHING);
  }
  return drawn_side(own.view, own.light, own.first, own.second, vertex);
}

@vertex fn side_clipped(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> VolumeVertex {
  let own = side_of(instance, CLIPPED);
  if (!own.valid) {
    return VolumeVertex(NOTHING);
  }
  let is_ordered = own.ends.x < own.ends.y;
  return drawn_clipped_side(own.view, own.light, own.first, own.second, is_ordered, vertex);
}

// Three quads for each edge: the side, whose clipped vertices move to their counterparts in the near cap, and two quads
// that fill the gaps where the near plane cuts one finite edge of the side. In the paper's terms vertices are floating
// or nailed, and the corrective quads are those of its cases C1 and C2.
@vertex fn zp_plus_2005_side(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> VolumeVertex {
  let own = side_of(instance / 3u, CLIPPED);
  if (!own.valid) {
    return VolumeVertex(NOTHING);
  }
  let view = own.view;
  let light = own.light;
  let cuts_edge = is_cut(view, to_clip(view, own.first)) != is_cut(view, to_clip(view, own.second));
  let first_far = direction_to_clip(view, extrusion(view, light, own.first));
  let second_far = direction_to_clip(view, extrusion(view, light, own.second));
  let cuts_far = is_cut(view, first_far) != is_cut(view, second_far);
  let quad = instance % 3u;
  if ((quad == 1u && (!cuts_edge || cuts_far)) || (quad == 2u && (cuts_edge || !cuts_far))) {
    return VolumeVertex(NOTHING);
  }
  let position = select(own.first, own.second, (vertex & 1u) != 0u);
  let is_first_row = vertex < 2u;
  // Rows: near and far floating; near nailed, near floating; far floating, far nailed.
  let is_near = quad == 1u || (quad == 0u && is_first_row);
  let floats = quad == 0u || (quad == 1u) != is_first_row;
  var clip = direction_to_clip(view, extrusion(view, light, position));
  if (is_near) {
    clip = to_clip(view, position);
  }
  if (floats && is_cut(view, clip)) {
    clip = counterpart(view, light, position);
  }
  return VolumeVertex(clip);
}

// For passes with colour attachments, which are not changed.
@fragment fn nothing() {}
