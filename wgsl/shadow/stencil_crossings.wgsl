// Crossings: two compute stages that add the sides of shadow volumes to the bins of half planes that they cross
// (shadow/pencil.wgsl), for `stencil_bound`. Dispatched after `stencil_pencil`, if the caller asks for a bound:
// `stencil_crossings` for each group of casters, batch of up to 32 lights and view, and after it `piece_crossings` for a group
// whose only caster is a mesh of polygons; a row of workgroups shares the lists of a light. Where lists overflowed, more is added than
// crosses: bounds are then larger, never too small. Rows are sums of integers, so the order of invocations does not matter.
// docs/numerics/receivers.md, "Bound on counts".

#import common/extraction
#import shadow/caster
#import shadow/choices
#import shadow/lists
#import shadow/pencil
#import shadow/shadow

// Stage `stencil_crossings`: adds sides, the quads from edges away from the light. Where their lists overflowed, it goes over
// all edges, with the largest weight that each may have.

@group(0) @binding(0) var<uniform> shape: ShadowShape;
@group(0) @binding(1) var<uniform> draw: ShadowDraw;
@group(0) @binding(2) var<storage, read> table: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> boxes: array<u32>;
@group(0) @binding(4) var<storage, read> positions: array<u32>;
@group(0) @binding(5) var<storage, read> edge_vertices: array<vec2<u32>>;
@group(0) @binding(6) var<storage, read> sides: array<u32>;
@group(0) @binding(7) var<storage, read> pencils: array<StencilPencil>;
@group(0) @binding(8) var<storage, read_write> crossings: array<atomic<u32>>; // The rows of the pencils.

// How often the sides of a caster's edge may count at most, for a light.
fn largest_weight(caster: u32, number: u32) -> u32 {
  let words = choice_part(caster, number / 32u, draw.view, 0u);
  let casts = (words[CASTS] >> (number % 32u)) & 1u;
  return casts * (1u + ((words[EVERY] >> (number % 32u)) & 1u));
}

// Adds the side of the edge in a slot, for an entry of a list with the weight 1, since a side of weight 2 is listed twice. A
// caster that the line of the pencil may meet is counted by its faces instead (`stencil_pencil`).
fn cross_slot(by: StencilPencil, number: u32, slot: u32, is_listed: bool) {
  let caster = caster_of(shape.edge_chunks_at, slot);
  let run = edge_run(caster);
  let edge = slot - run.x;
  if (edge >= run.y) {
    return;
  }
  let weight = select(largest_weight(caster, number), 1u, is_listed);
  if (weight == 0u) {
    return;
  }
  if (by.kind == AROUND) {
    let own = world_box(caster);
    if (axis_meets(by.place, axis_of(by), own.low, own.high)) {
      return;
    }
  }
  let ends = edge_vertices[run.z + edge];
  let a = in_world(caster, vertex_position(caster, ends.x));
  let b = in_world(caster, vertex_position(caster, ends.y));
  if (is_finite(a) && is_finite(b)) {
    cross_edge(by, row_of(draw.view, number, caster % shape.count_batches), a, b, weight);
  }
}

// A workgroup takes a share of one light's sides.
@compute @workgroup_size(64)
fn stencil_crossings(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(num_workgroups) groups: vec3<u32>,
  @builtin(local_invocation_index) thread: u32,
) {
  let bit = group.y;
  let number = draw.first_light + bit;
  let by = pencils[draw.view * shape.lights + number];
  let plain = sides[2u * bit];
  let clipped = sides[2u * bit + 1u];
  let is_listed = plain + clipped <= shape.side_capacity;
  let items = select(shape.edges, plain + clipped, is_listed);
  // Turns: LISTED_ITEMS.
  for (var item = group.x * 64u + thread; item < items; item += 64u * groups.x) {
    var slot = item;
    if (is_listed) {
      let is_plain = item < plain;
      slot = sides[side_place(bit, select(CLIPPED, PLAIN, is_plain), select(item - plain, item, is_plain))] & ~WINDING;
    }
    cross_slot(by, number, slot, is_listed);
  }
}

// Stage `piece_crossings`: adds the sides of pieces of L-twisted polygons (see shadow/lists.wgsl), each with the weight 1.
// Where a list of pieces overflowed, all of them cross every half plane.

@group(0) @binding(4) var<storage, read> pieces: array<u32>;

fn place_at(word: u32) -> vec3<f32> {
  return bitcast<vec3<f32>>(vec3<u32>(pieces[word], pieces[word + 1u], pieces[word + 2u]));
}

// A workgroup takes a share of one light's pieces.
@compute @workgroup_size(64)
fn piece_crossings(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(num_workgroups) groups: vec3<u32>,
  @builtin(local_invocation_index) thread: u32,
) {
  let bit = group.y;
  let number = draw.first_light + bit;
  let caster = shape.first_caster;
  let casts = (choice_part(caster, number / 32u, draw.view, 0u)[CASTS] >> (number % 32u)) & 1u;
  if (casts == 0u) {
    return;
  }
  let by = pencils[draw.view * shape.lights + number];
  if (by.kind == AROUND) {
    let own = world_box(caster);
    if (axis_meets(by.place, axis_of(by), own.low, own.high)) {
      return;
    }
  }
  let row = row_of(draw.view, number, caster % shape.count_batches);
  let capacity = shape.piece_capacity;
  if (pieces[bit] > capacity) {
    if (group.x == 0u && thread == 0u) {
      cross_bins(row, 0u, BINS - 1u, pieces[bit]);
    }
    return;
  }
  // Turns: LISTED_ITEMS.
  for (var piece = group.x * 64u + thread; piece < pieces[bit]; piece += 64u * groups.x) {
    let at = PIECE_COUNTS + PIECE_WORDS * (bit * capacity + piece);
    cross_edge(by, row, in_world(caster, place_at(at)), in_world(caster, place_at(at + 3u)), 1u);
  }
}
