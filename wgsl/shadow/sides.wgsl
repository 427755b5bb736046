// Sides: draws the quads from silhouette edges away from the light, by an indirect draw of their list. `side` leaves
// clipping to the hardware. `side_clipped` clips at the near plane itself, so that the seam with the near cap has equal
// bits. `zp_plus_2005_side` is the side as published in 2005.

@group(0) @binding(0) var<uniform> shape: ShadowShape;
@group(0) @binding(1) var<storage, read> view: ShadowView;
@group(0) @binding(2) var<uniform> draw: ShadowDraw;
@group(0) @binding(3) var<storage, read> shadow_lights: array<ShadowLight>;

struct SideVertex {
  @invariant @builtin(position) clip: vec4<f32>,
}

// The ends of a side's edge. The quad (first, second, second far, first far) is counter-clockwise from outside.
struct SideEdge {
  valid: bool,
  first: u32,
  second: u32,
}

fn side_edge(light: ShadowLight, instance: u32) -> SideEdge {
  // Weight 2: every edge is drawn twice, except boundaries.
  let doubled = light.casting == CAST_EVERY;
  let edge = rimline_silhouette(draw.light - draw.first_light, select(instance, instance >> 1u, doubled));
  let again = doubled && (instance & 1u) != 0u && edge.kind == 2u;
  return SideEdge(
    edge.valid && !again, select(edge.a, edge.b, edge.winding), select(edge.b, edge.a, edge.winding));
}

@vertex fn side(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> SideVertex {
  let light = shadow_lights[draw.light];
  let edge = side_edge(light, instance);
  let first = rimline_position(edge.first);
  let second = rimline_position(edge.second);
  if (!edge.valid || !is_finite(first) || !is_finite(second) || !spans_side(light, first, second)) {
    return SideVertex(NOTHING);
  }
  return SideVertex(side_vertex(light, first, second, vertex));
}

@vertex fn side_clipped(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> SideVertex {
  let light = shadow_lights[draw.light];
  let edge = side_edge(light, instance);
  let first = rimline_position(edge.first);
  let second = rimline_position(edge.second);
  if (!edge.valid || !is_finite(first) || !is_finite(second) || !spans_side(light, first, second)) {
    return SideVertex(NOTHING);
  }
  return SideVertex(clipped_side_vertex(light, first, second, edge.first < edge.second, vertex));
}

// Three quads for each edge: the side, whose clipped vertices move to their counterparts in the near cap, and two quads
// that fill the gaps where the near plane cuts one finite edge of the side. In the paper's terms vertices are floating
// or nailed, and the corrective quads are those of its cases C1 and C2.
@vertex fn zp_plus_2005_side(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> SideVertex {
  let light = shadow_lights[draw.light];
  let edge = side_edge(light, instance / 3u);
  let first = rimline_position(edge.first);
  let second = rimline_position(edge.second);
  if (!edge.valid || !is_finite(first) || !is_finite(second)) {
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
