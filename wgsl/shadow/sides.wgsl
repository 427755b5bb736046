// Vertex shaders of sides, in the caller's render pass. A side is the quad from an edge away from the light.
// The indirect draws of `shadow_arguments` have an instance for each entry of a list of `list_sides`, drawn as a strip.
// If the light's lists overflowed, each edge slot of the group has two instances, and the shader decides whether they are
// drawn. `side` leaves clipping to the hardware. `side_clipped` clips at the near plane itself, so that the seam with near
// caps (`cap_faces`) has equal bits. Both may be trimmed (shadow/vertices.wgsl). `zp_plus_2005_side` is the side as published
// in 2005, with three instances for each of these.
// Stencil counts depend on the order of a side's ends, seams on the order of their vertex indices.
// docs/numerics/shadow-volumes.md, "Closed volumes".

#import common/casters
#import common/extraction
#import shadow/caster
#import shadow/choices
#import shadow/draw_lists
#import shadow/shadow
#import shadow/vertices

@group(0) @binding(0) var<uniform> shape: ShadowShape;
@group(0) @binding(1) var<uniform> draw: ShadowDraw;
@group(0) @binding(2) var<storage, read> view_light: ViewLight; // The light and view of the draw.
@group(0) @binding(3) var<storage, read> table: array<vec4<u32>>;
@group(1) @binding(0) var<storage, read> positions: array<u32>;
@group(1) @binding(1) var<storage, read> edge_vertices: array<vec2<u32>>;
@group(1) @binding(2) var<storage, read> edge_faces: array<vec2<u32>>;
@group(1) @binding(3) var<storage, read> facing_masks: array<u32>;
@group(1) @binding(4) var<storage, read> excluded_masks: array<u32>;
@group(1) @binding(5) var<storage, read> sides: array<u32>;

// The side of an instance: its edge, in the order in which the quad (first, second, second far, first far) is
// counter-clockwise as seen from outside the volume; and view and light for its caster.
struct SideInstance {
  is_drawn: bool,
  ends: vec2<u32>, // Vertex indices.
  first: vec3<f32>, // The position of ends.x.
  second: vec3<f32>, // The position of ends.y.
  view: ShadowView,
  light: ShadowLight,
}

// The side of an instance of the draw of a list, `kind` PLAIN or CLIPPED. If the lists overflowed, every edge has two
// instances, since its side may have the weight 2. Instances above the weight are not drawn.
fn load_side(instance: u32, kind: u32) -> SideInstance {
  let bit = draw.light - draw.first_light;
  let is_overflowed = sides[2u * bit] + sides[2u * bit + 1u] > shape.side_capacity;
  var entry = instance >> 1u;
  if (!is_overflowed) {
    entry = sides[side_entry_offset(bit, kind, instance)];
  }
  let slot = entry & ~WINDING;
  let caster = caster_of_slot(shape.edge_chunks_offset, slot);
  let range = edge_range(caster);
  let record = range.z + slot - range.x;
  var result: SideInstance;
  result.view = view_for_caster(caster, view_light.view);
  result.light = light_for_caster(caster, view_light.light, draw.light);
  result.is_drawn = is_in_count_batch(caster, draw.count_batch);
  var winding = entry >= WINDING;
  // A side of a list needs only the measures among the choices: the stage that listed it applied the others.
  if (is_overflowed || has_measures()) {
    result.light = with_stored_choices(caster, result.light, draw.light, draw.view);
  }
  if (is_overflowed) {
    // A slot past the edges of its caster has the record of another caster, or none.
    let is_in_caster = slot - range.x < range.y;
    let in_masks = edge_side(caster, record, result.light, bit);
    result.is_drawn = result.is_drawn && is_in_caster && in_masks.weight > (instance & 1u) &&
      side_kind(result.light) == kind;
    winding = in_masks.winding;
  }
  let is_mirrored = (caster_flags(caster) & MIRRORED) != 0u;
  let ends = edge_vertices[record];
  result.ends = select(ends, ends.yx, winding != is_mirrored);
  result.first = vertex_position(caster, result.ends.x);
  result.second = vertex_position(caster, result.ends.y);
  return result;
}

@vertex fn side(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> VolumeVertex {
  let edge = load_side(instance, PLAIN);
  if (!edge.is_drawn) {
    return VolumeVertex(NOT_DRAWN);
  }
  return drawn_side(edge.view, edge.light, edge.first, edge.second, vertex);
}

@vertex fn side_clipped(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> VolumeVertex {
  let edge = load_side(instance, CLIPPED);
  if (!edge.is_drawn) {
    return VolumeVertex(NOT_DRAWN);
  }
  let is_ordered = edge.ends.x < edge.ends.y;
  return drawn_clipped_side(edge.view, edge.light, edge.first, edge.second, is_ordered, vertex);
}

// Three quads for each edge: the side, whose vertices before the near plane move to their counterparts in the near cap; and
// two corrective quads, which fill gaps where the near plane cuts only one of the two finite edges of the side. The paper
// calls vertices that move floating and all others nailed, and the corrective quads are its cases C1 and C2.
@vertex fn zp_plus_2005_side(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> VolumeVertex {
  let edge = load_side(instance / 3u, CLIPPED);
  if (!edge.is_drawn) {
    return VolumeVertex(NOT_DRAWN);
  }
  let view = edge.view;
  let light = edge.light;
  let is_edge_cut = is_before_near_plane(view, to_clip(view, edge.first)) !=
    is_before_near_plane(view, to_clip(view, edge.second));
  let first_far = direction_to_clip(view, extrusion(view, light, edge.first));
  let second_far = direction_to_clip(view, extrusion(view, light, edge.second));
  let is_far_edge_cut = is_before_near_plane(view, first_far) != is_before_near_plane(view, second_far);
  let quad = instance % 3u;
  if ((quad == 1u && (!is_edge_cut || is_far_edge_cut)) || (quad == 2u && (is_edge_cut || !is_far_edge_cut))) {
    return VolumeVertex(NOT_DRAWN);
  }
  let position = select(edge.first, edge.second, (vertex & 1u) != 0u);
  // Each quad has two rows of two vertices. Quad 0: near floating, far floating. Quad 1: near nailed, near floating. Quad 2:
  // far floating, far nailed.
  let is_first_row = vertex < 2u;
  let is_near = quad == 1u || (quad == 0u && is_first_row);
  let is_floating = quad == 0u || (quad == 1u) != is_first_row;
  var clip = direction_to_clip(view, extrusion(view, light, position));
  if (is_near) {
    clip = to_clip(view, position);
  }
  if (is_floating && is_before_near_plane(view, clip)) {
    clip = counterpart_in_near_cap(view, light, position);
  }
  return VolumeVertex(clip);
}

// For passes with colour attachments, which stay as they are.
@fragment fn nothing() {}
