// Sides: draws the quads from edges away from the light, by an indirect draw of the list that `list_sides` made. `side`
// leaves clipping to the hardware. `side_clipped` clips at the near plane itself, so that the seam with the near cap has
// equal bits. `zp_plus_2005_side` is the side as published in 2005.

@group(0) @binding(0) var<uniform> shape: ShadowShape;
@group(0) @binding(1) var<storage, read> view: ShadowView;
@group(0) @binding(2) var<uniform> draw: ShadowDraw;
@group(0) @binding(3) var<storage, read> shadow_lights: array<ShadowLight>;
@group(1) @binding(0) var<storage, read> positions: array<u32>;
@group(1) @binding(1) var<storage, read> edge_vertices: array<vec2<u32>>;
@group(1) @binding(2) var<storage, read> edge_faces: array<vec2<u32>>;
@group(1) @binding(3) var<storage, read> facing_masks: array<u32>;
@group(1) @binding(4) var<storage, read> excluded_masks: array<u32>;
@group(1) @binding(5) var<storage, read> sides: array<u32>;

struct SideVertex {
  @invariant @builtin(position) clip: vec4<f32>,
}

// The ends of a side's edge. The quad (first, second, second far, first far) is counter-clockwise from outside.
struct SideEdge {
  valid: bool,
  ends: vec2<u32>,
}

// An instance is a side. Those of weight 2 are two instances each, after all of weight 1. If the list overflowed, every
// edge is two instances.
fn side_edge(light: ShadowLight, instance: u32) -> SideEdge {
  let bit = draw.light - draw.first_light;
  let singles = sides[2u * bit];
  let overflowed = singles + sides[2u * bit + 1u] > shape.side_capacity;
  var entry = 0u;
  var valid = true;
  if (overflowed) {
    entry = instance >> 1u;
    let side = side_at(light, bit, entry);
    valid = side.weight > (instance & 1u);
    entry |= select(0u, WINDING, side.winding);
  } else {
    let place = select(shape.side_capacity - 1u - ((instance - singles) >> 1u), instance, instance < singles);
    entry = sides[side_begin(bit, shape.side_capacity) + place];
  }
  let ends = edge_vertices[entry & ~WINDING];
  return SideEdge(valid, select(ends, ends.yx, entry >= WINDING));
}

@vertex fn side(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> SideVertex {
  let light = shadow_lights[draw.light];
  let edge = side_edge(light, instance);
  let first = caster_position(edge.ends.x);
  let second = caster_position(edge.ends.y);
  if (!edge.valid) {
    return SideVertex(NOTHING);
  }
  return SideVertex(side_vertex(light, first, second, vertex));
}

@vertex fn side_clipped(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> SideVertex {
  let light = shadow_lights[draw.light];
  let edge = side_edge(light, instance);
  let first = caster_position(edge.ends.x);
  let second = caster_position(edge.ends.y);
  if (!edge.valid) {
    return SideVertex(NOTHING);
  }
  return SideVertex(clipped_side_vertex(light, first, second, edge.ends.x < edge.ends.y, vertex));
}

// Three quads for each edge: the side, whose clipped vertices move to their counterparts in the near cap, and two quads
// that fill the gaps where the near plane cuts one finite edge of the side. In the paper's terms vertices are floating
// or nailed, and the corrective quads are those of its cases C1 and C2.
@vertex fn zp_plus_2005_side(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> SideVertex {
  let light = shadow_lights[draw.light];
  let edge = side_edge(light, instance / 3u);
  let first = caster_position(edge.ends.x);
  let second = caster_position(edge.ends.y);
  if (!edge.valid) {
    return SideVertex(NOTHING);
  }
  let cuts_edge = is_cut(view, to_clip(view, first)) != is_cut(view, to_clip(view, second));
  let first_far = direction_to_clip(view, extrusion(light, first));
  let second_far = direction_to_clip(view, extrusion(light, second));
  let cuts_far = is_cut(view, first_far) != is_cut(view, second_far);
  let quad = instance % 3u;
  if ((quad == 1u && (!cuts_edge || cuts_far)) || (quad == 2u && (cuts_edge || !cuts_far))) {
    return SideVertex(NOTHING);
  }
  let position = select(first, second, (vertex & 1u) != 0u);
  let is_first_row = vertex < 2u;
  // Rows: near and far floating; near nailed, near floating; far floating, far nailed.
  let is_near = quad == 1u || (quad == 0u && is_first_row);
  let floats = quad == 0u || (quad == 1u) != is_first_row;
  var clip = direction_to_clip(view, extrusion(light, position));
  if (is_near) {
    clip = to_clip(view, position);
  }
  if (floats && is_cut(view, clip)) {
    clip = counterpart(view, light, position);
  }
  return SideVertex(clip);
}

// For passes with colour attachments, which are not changed.
@fragment fn nothing() {}
