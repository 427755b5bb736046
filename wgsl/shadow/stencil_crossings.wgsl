// Stages `stencil_crossings` and `piece_crossings`: add the sides of shadow volumes to the bins of half planes that they
// may cross (shadow/half_plane_bins.wgsl), for `stencil_bound`.
// Dispatched after `stencil_pencil`, if the caller asks for a bound, for each group of casters, light batch (up to 32
// lights) and view. `piece_crossings` follows for groups whose only caster is a mesh of polygons. A row of workgroups
// shares the lists of a light.
// Reads: pencils, lists of sides or pieces, positions, boxes, choices. Writes: `bin_rows`.
// If a list overflowed, more is added than crosses: bounds may be too large, never too small. Rows are sums of integers,
// so the result does not depend on the order of invocations. docs/numerics/receivers.md, "Bound on counts".

#import common/extraction
#import shadow/caster
#import shadow/choices
#import shadow/draw_lists
#import shadow/half_plane_bins
#import shadow/shadow

// Stage `stencil_crossings`: adds the sides of edges, from the lists of `list_sides`. If the lists of a light overflowed, it
// adds all edges, each with the largest weight that it may have.

@group(0) @binding(0) var<uniform> shape: ShadowShape;
@group(0) @binding(1) var<uniform> draw: ShadowDraw;
@group(0) @binding(2) var<storage, read> table: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> boxes: array<u32>;
@group(0) @binding(4) var<storage, read> positions: array<u32>;
@group(0) @binding(5) var<storage, read> edge_vertices: array<vec2<u32>>;
@group(0) @binding(6) var<storage, read> sides: array<u32>;
@group(0) @binding(7) var<storage, read> pencils: array<StencilPencil>;
@group(0) @binding(8) var<storage, read_write> bin_rows: array<atomic<u32>>; // The rows of all pencils.

// The largest weight that the side of an edge may have, for a caster and a light.
fn largest_weight(caster: u32, light_index: u32) -> u32 {
  let words = choice_part(caster, light_index / 32u, draw.view, 0u);
  let casts = (words[CHOICE_CASTS] >> (light_index % 32u)) & 1u;
  return casts * (1u + ((words[CHOICE_EVERY_FACE] >> (light_index % 32u)) & 1u));
}

// Adds the side of the edge in a slot. An entry of a list has the weight 1, since a side of weight 2 has two entries.
// Casters that the axis of the pencil may meet are left out: `stencil_pencil` counts all their faces instead.
fn add_slot(pencil: StencilPencil, light_index: u32, slot: u32, is_listed: bool) {
  let caster = caster_of_slot(shape.edge_chunks_offset, slot);
  let range = edge_range(caster);
  let edge = slot - range.x;
  if (edge >= range.y) {
    return;
  }
  let weight = select(largest_weight(caster, light_index), 1u, is_listed);
  if (weight == 0u) {
    return;
  }
  if (pencil.kind == PENCIL_AROUND) {
    let world_box = caster_world_box(caster);
    if (can_axis_meet_box(pencil.light_position, axis_of_pencil(pencil), world_box.low, world_box.high)) {
      return;
    }
  }
  let ends = edge_vertices[range.z + edge];
  let a = to_world(caster, vertex_position(caster, ends.x));
  let b = to_world(caster, vertex_position(caster, ends.y));
  if (is_finite(a) && is_finite(b)) {
    add_edge(pencil, row_offset(draw.view, light_index, caster % shape.count_batches), a, b, weight);
  }
}

@compute @workgroup_size(64)
fn stencil_crossings(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(num_workgroups) groups: vec3<u32>,
  @builtin(local_invocation_index) thread: u32,
) {
  let bit = group.y;
  let light_index = draw.first_light + bit;
  let pencil = pencils[draw.view * shape.lights + light_index];
  let plain = sides[2u * bit];
  let clipped = sides[2u * bit + 1u];
  let is_listed = plain + clipped <= shape.side_capacity;
  let items = select(shape.edges, plain + clipped, is_listed);
  // Turns: LISTED_ITEMS.
  for (var item = group.x * 64u + thread; item < items; item += 64u * groups.x) {
    var slot = item;
    if (is_listed) {
      let is_plain = item < plain;
      let kind = select(CLIPPED, PLAIN, is_plain);
      slot = sides[side_entry_offset(bit, kind, select(item - plain, item, is_plain))] & ~WINDING;
    }
    add_slot(pencil, light_index, slot, is_listed);
  }
}

// Stage `piece_crossings`: adds the sides of pieces of twisted polygons (shadow/draw_lists.wgsl), each with the weight 1.
// If the list of a light overflowed, all its pieces count in every bin.

@group(0) @binding(4) var<storage, read> pieces: array<u32>;

fn load_position(offset: u32) -> vec3<f32> {
  return bitcast<vec3<f32>>(vec3<u32>(pieces[offset], pieces[offset + 1u], pieces[offset + 2u]));
}

@compute @workgroup_size(64)
fn piece_crossings(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(num_workgroups) groups: vec3<u32>,
  @builtin(local_invocation_index) thread: u32,
) {
  let bit = group.y;
  let light_index = draw.first_light + bit;
  let caster = shape.first_caster;
  let casts = (choice_part(caster, light_index / 32u, draw.view, 0u)[CHOICE_CASTS] >> (light_index % 32u)) & 1u;
  if (casts == 0u) {
    return;
  }
  let pencil = pencils[draw.view * shape.lights + light_index];
  if (pencil.kind == PENCIL_AROUND) {
    let world_box = caster_world_box(caster);
    if (can_axis_meet_box(pencil.light_position, axis_of_pencil(pencil), world_box.low, world_box.high)) {
      return;
    }
  }
  let row = row_offset(draw.view, light_index, caster % shape.count_batches);
  let capacity = shape.piece_capacity;
  if (pieces[bit] > capacity) {
    if (group.x == 0u && thread == 0u) {
      add_to_bins(row, BinRange(0u, BINS - 1u), pieces[bit]);
    }
    return;
  }
  // Turns: LISTED_ITEMS.
  for (var piece = group.x * 64u + thread; piece < pieces[bit]; piece += 64u * groups.x) {
    let offset = PIECE_COUNTS + PIECE_WORDS * (bit * capacity + piece);
    let begin = to_world(caster, load_position(offset));
    let end = to_world(caster, load_position(offset + 3u));
    add_edge(pencil, row, begin, end, 1u);
  }
}
